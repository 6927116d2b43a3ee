//! Rays exactly through vertices and edges, and scenes with corners, cameras and lights that coincide exactly.

use glam::{DVec2, Vec3};
use umbrage_rays::{Camera, LightSource, Projection};
use umbrage_verify::lights::{point, sun};
use umbrage_verify::views::view;
use umbrage_verify::{Case, Random, Sheet, SheetShape, TestMesh};

use super::{FAR, through};
use crate::check::{Known, known};

pub(super) fn all() -> Vec<Known> {
    let mut all: Vec<_> = sheets();
    all.extend(known(turned()));
    all.extend(known(through_the_eye_plane()));
    all.extend(known(vec![floors(DVec2::ZERO), floors(DVec2::splat(0.5)), floors(DVec2::ONE)]));
    all.extend(known(coincident()));
    all
}

/// Sheets with vertices exactly on rays: no ray may slip through, and they must not shadow themselves from the camera.
fn sheets() -> Vec<Known> {
    let mut random = Random::new(21);
    let sizes = [(16, 1), (16, 2), (16, 4)].into_iter().flat_map(|size| [false, true].map(|shell| (size, shell)));
    let shapes = sizes.flat_map(|((side, step), shell)| {
        SheetShape::PLACES.into_iter().enumerate().map(move |(number, (position, scale))| {
            let has_shell = shell && position == Vec3::ZERO;
            SheetShape {
                side,
                step,
                position,
                scale,
                is_orthographic: (number + step as usize).is_multiple_of(2),
                has_shell,
            }
        })
    });
    let sheets = shapes.map(|shape| {
        let sheet = Sheet::new(shape, &mut random);
        let camera = sheet.view.camera;
        let beside = shape.position + camera.right * (3.0 * shape.scale) + camera.forward * (2.0 * shape.scale);
        let in_vertex = sheet.mesh.positions[sheet.mesh.positions.len() / 3];
        let lights = [sheet.light, point(beside), point(in_vertex)];
        let case = Case::new(format!("{shape:?}"), sheet.mesh, sheet.view, &lights);
        let case = Case { offset_pixels: sheet.offset_pixels, ..case };
        let truth = case.truth();
        assert!(truth.triangle.iter().all(|&id| id < sheet.front), "{shape:?}: the oracle sees through");
        assert!(truth.lit[0].iter().all(|&lit| lit), "{shape:?}: the oracle has shadows");
        Known::with_truth(case, truth)
    });
    sheets.collect()
}

/// Parallel rays in a plane through the world's upward axis, in which two triangles share an edge without roundings.
fn turned() -> Vec<Case> {
    let mut random = Random::new(33);
    let mut cases = Vec::new();
    for (scale, height) in
        [(1.0, 0.0), (1.0 / 1_048_576.0, 0.0), (1_048_576.0, 0.0), (4.0, 148_376.0), (0.125, -1_234.0)]
    {
        for _ in 0..4 {
            let (sin, cos) = (random.unit() * 6.0).sin_cos();
            let (forward, right) = (Vec3::new(sin, 0.0, cos), Vec3::new(cos, 0.0, -sin));
            let position = Vec3::Y * height;
            let at = |away: f32, up: f32| forward * (away * scale) + Vec3::Y * (height + up * scale);
            let beside = |side: f32| right * (side * scale) + at(5.0, 0.5);
            let mut mesh = TestMesh::default();
            mesh.push([at(4.0, 1.5), at(8.0, -1.5), beside(3.0)]);
            mesh.push([at(8.0, -1.5), at(4.0, 1.5), beside(-3.0)]);
            mesh.push([at(9.0, -9.0), at(9.0, 9.0), right * (-9.0 * scale) + at(9.0, 0.0)]);
            mesh.push([at(9.0, 9.0), at(9.0, -9.0), right * (9.0 * scale) + at(9.0, 0.0)]);
            let projection = Projection::Orthographic { half_height: 2.0 * scale };
            let camera = Camera { position, right, up: Vec3::Y, forward, projection };
            let lights = [LightSource::Directional { direction: forward }, point(at(2.0, 0.0))];
            for ids in [[0, 1, 2, 3], [1, 0, 3, 2]] {
                let mesh = TestMesh { indices: ids.map(|id: usize| mesh.indices[id]).into(), ..mesh.clone() };
                let name = format!("turned, × {scale}, height {height}, {forward}");
                cases.push(through(Case::new(name, mesh, view(camera, 16, 16), &lights), 0.0, 0.5));
            }
        }
    }
    cases
}

/// Rays exactly in the plane of the eye and an edge of triangles that go through the eye plane.
fn through_the_eye_plane() -> Vec<Case> {
    let mut random = Random::new(12);
    let mut cases = Vec::new();
    for _ in 0..25 {
        let (sin, cos) = (random.unit() * 6.0).sin_cos();
        let (forward, right) = (Vec3::new(sin, 0.0, cos), Vec3::new(cos, 0.0, -sin));
        let projection = Projection::Perspective { tan_half_height: 0.3 + random.unit() };
        let camera = Camera { position: Vec3::ZERO, right, up: Vec3::Y, forward, projection };
        // The rays of column 8 are in the plane of the eye, P and Q: they meet the edge PQ to the last bit.
        let (p, q) = (forward * 4.0, Vec3::new(0.0, -2.0, 0.0));
        let triangles = [[p, q, right * 5.0 - forward * 3.0 - Vec3::Y], [p, q, right * -5.0 - forward * 3.0 - Vec3::Y]];
        for ids in [[0, 1], [1, 0]] {
            let mesh = TestMesh::of(&ids.map(|id: usize| triangles[id]));
            let case = Case::new("through the eye plane", mesh, view(camera, 16, 16), &[point(Vec3::Y * 3.0)]);
            cases.push(through(case, 0.0, 0.5));
        }
    }
    cases
}

/// Floors one behind the other, with corners on rays and windings of both kinds.
fn floors(offset_pixels: DVec2) -> Case {
    // Pixels of unit size at distance one.
    let camera = Camera {
        position: Vec3::new(0.5, 0.5, 8.0),
        right: Vec3::X,
        up: Vec3::Y,
        forward: Vec3::NEG_Z,
        projection: Projection::Perspective { tan_half_height: 4.0 },
    };
    let mut mesh = TestMesh::default();
    for floor in [TestMesh::plane(8, 16.0), TestMesh::plane(12, 16.0), TestMesh::plane(2, 256.0)] {
        let upright = floor.positions.iter().map(|position| Vec3::new(position.x, position.z, position.y)).collect();
        mesh.append(&TestMesh { positions: upright, indices: floor.indices });
    }
    mesh.indices.iter_mut().step_by(3).for_each(|triangle| triangle.swap(0, 2));
    let lights = [sun(0.2, 0.1, -1.0), point(Vec3::new(4.0, 4.0, 2.0))];
    Case { offset_pixels, ..Case::new("floors in one plane", mesh, view(camera, 32, 32), &lights) }
}

/// The same floor three times, cut along different diagonals, near and far; and triangles with permuted copies, like
/// pieces that come apart.
fn coincident() -> Vec<Case> {
    let mut cases = Vec::new();
    for offset in [Vec3::ZERO, FAR] {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, z]| offset + Vec3::new(x, 0.0, z));
        let orders = [[0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3], [2, 1, 0], [3, 2, 0]];
        let floor = TestMesh::of(&orders.map(|ids| ids.map(|id: usize| corners[id])));
        let camera = Camera::look_at(offset + Vec3::new(0.3, 2.0, 1.0), offset, Vec3::Y, 0.9);
        let lights = [point(offset + Vec3::new(0.2, 0.01, 0.1)), point(offset + Vec3::Y), sun(0.0, -1.0, 0.0)];
        cases.push(Case::new("one floor three times", floor, view(camera, 24, 20), &lights));
    }
    let mut random = Random::new(34);
    let soup = TestMesh::soup(&mut random, 30, 0.3);
    let mut copies = TestMesh::default();
    for order in [[0, 1, 2], [1, 2, 0], [2, 1, 0], [0, 2, 1]] {
        let turned = soup.indices.iter().map(|triangle| order.map(|corner: usize| triangle[corner])).collect();
        copies.append(&TestMesh { indices: turned, ..soup.clone() });
        copies.indices.reverse();
    }
    for camera in [umbrage_verify::views::camera(), umbrage_verify::views::parallel_camera()] {
        let lights = [point(Vec3::new(0.5, 3.0, 1.0)), sun(0.2, -1.0, 0.1)];
        cases.push(Case::new("permuted copies", copies.clone(), view(camera, 33, 25), &lights));
    }
    cases
}

/// Corners, cameras and lights on lattices, with seeds at which bounds of zero fail.
pub(super) fn lattices() -> Vec<Case> {
    let mut cases = Vec::new();
    for seed in 1030..1038 {
        let mut random = Random::new(seed);
        let mut mesh = TestMesh::default();
        let quantum = [0.0, 0.25, 0.5, 0.01][(random.bits() % 4) as usize];
        let snap = |point: Vec3| if quantum > 0.0 { (point / quantum).round() * quantum } else { point };
        for _ in 0..1 + random.bits() % 150 {
            let stretch = 10.0_f32.powf(random.unit() * 4.0 - 3.0);
            let center = random.point();
            let corners = [(); 3].map(|()| snap(center + random.point() * stretch));
            mesh.push(corners);
        }
        if random.bits().is_multiple_of(2) {
            let (center, radius) = (random.point(), random.unit());
            let rings = 2 + (random.bits() % 8) as u32;
            mesh.append(&TestMesh::bumpy_ball(radius, rings).placed(1.0, center));
        }
        if random.bits().is_multiple_of(2) {
            mesh.quad([(-4.0, -4.0), (4.0, -4.0), (4.0, 4.0), (-4.0, 4.0)].map(|(x, z)| Vec3::new(x, -1.0, z)));
        }
        let (from, to) = (snap(random.point() * 3.0), snap(random.point()));
        let mut camera = Camera::look_at(from, to, Vec3::Y, 0.3 + random.unit());
        let scale = [1.0, 1.0, 1e-6, 1e6, 77.0][(random.bits() % 5) as usize];
        let offset = if random.bits().is_multiple_of(4) { FAR } else { Vec3::ZERO };
        let mut lights = Vec::new();
        for kind in 0..6 {
            let position = match kind % 3 {
                0 => snap(random.point() * 2.0),
                1 => mesh.positions[random.bits() as usize % mesh.positions.len()],
                _ => random.point() * 10.0_f32.powf(random.unit() * 6.0 - 2.0),
            };
            lights.push(point(position * scale + offset));
            let direction = snap(random.point() * 2.0).try_normalize().unwrap_or(Vec3::X);
            lights.push(LightSource::Directional { direction });
        }
        camera.position = camera.position * scale + offset;
        let (width, height) = (1 + (random.bits() % 40) as u32, 1 + (random.bits() % 30) as u32);
        let case = Case::new(format!("seed {seed}"), mesh.placed(scale, offset), view(camera, width, height), &lights);
        cases.push(through(case, 0.5, 0.4375));
    }
    cases
}
