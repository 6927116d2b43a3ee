//! Surfaces that are hard to divide into patches, or to cull as one.

use std::f32::consts::{PI, TAU};

use glam::Vec3;
use umbrage_rays::{Camera, LightSource};
use umbrage_verify::lights::{point, sun};
use umbrage_verify::views::{camera, parallel_camera, placed, view};
use umbrage_verify::{Case, Random, TestMesh};

use super::FAR;

/// A sheet of `columns` by `rows` squares with shared vertices; `at` gives the position for u and v from 0 to 1.
fn sheet(columns: u32, rows: u32, at: impl Fn(f32, f32) -> Vec3) -> TestMesh {
    let vertices = (0..=rows).flat_map(|row| (0..=columns).map(move |column| (column, row)));
    let positions =
        vertices.map(|(column, row)| at(column as f32 / columns as f32, row as f32 / rows as f32)).collect();
    let squares = (0..rows).flat_map(|row| (0..columns).map(move |column| row * (columns + 1) + column));
    let indices = squares.flat_map(|a| [[a, a + 1, a + columns + 2], [a, a + columns + 2, a + columns + 1]]).collect();
    TestMesh { positions, indices }
}

/// Over a floor.
fn over_floor(mut mesh: TestMesh) -> TestMesh {
    mesh.append(&TestMesh::plane(3, 3.0).placed(1.0, Vec3::NEG_Y));
    mesh
}

fn spot(position: Vec3, at: Vec3, outer_radians: f32) -> LightSource {
    let direction = (at - position).normalize();
    LightSource::Spot { position, direction, inner_radians: 0.5 * outer_radians, outer_radians }
}

/// A sheet folded back and forth, with layers `apart` units apart.
fn folded(apart: f32) -> TestMesh {
    sheet(32, 4, |u, v| {
        let (fold, within) = ((8.0 * u).floor(), (8.0 * u).fract());
        let x = if fold % 2.0 == 0.0 { within } else { 1.0 - within };
        Vec3::new(1.6 * x - 0.8, apart * 8.0 * u, 1.6 * v - 0.8)
    })
}

fn spiral() -> TestMesh {
    sheet(72, 3, |u, v| {
        let (sin, cos) = (3.0 * TAU * u).sin_cos();
        Vec3::new((0.1 + 0.8 * u) * cos, 1.2 * v - 0.6, (0.1 + 0.8 * u) * sin)
    })
}

/// The vertices join its ends, turned over.
fn moebius_strip() -> TestMesh {
    const AROUND: u32 = 48;
    const ACROSS: u32 = 3;
    let mut strip = sheet(AROUND, ACROSS, |u, v| {
        let ((sin, cos), (half_sin, half_cos)) = ((TAU * u).sin_cos(), (PI * u).sin_cos());
        let across = 0.7 * (v - 0.5);
        Vec3::new((0.8 + across * half_cos) * cos, across * half_sin, (0.8 + across * half_cos) * sin)
    });
    for vertex in strip.indices.as_flattened_mut() {
        let (column, row) = (*vertex % (AROUND + 1), *vertex / (AROUND + 1));
        if column == AROUND {
            *vertex = (ACROSS - row) * (AROUND + 1);
        }
    }
    strip
}

/// Ninety triangles on one edge, and as many on one vertex.
fn fans() -> TestMesh {
    let mut random = Random::new(91);
    let mut mesh = TestMesh { positions: vec![Vec3::new(-0.5, -0.6, 0.0), Vec3::new(-0.5, 0.6, 0.0)], indices: vec![] };
    for spoke in 0..90 {
        let (sin, cos) = (TAU * spoke as f32 / 90.0).sin_cos();
        mesh.positions.push(Vec3::new(-0.5 + 0.5 * cos, 0.2 * sin, 0.5 * sin));
        mesh.indices.push([0, 1, spoke + 2]);
    }
    for _ in 0..90 {
        let [center, a, b] = [Vec3::new(0.6, 0.0, 0.0), random.point() * 0.6, random.point() * 0.2];
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([center + a, center + a + b]);
        mesh.indices.push([1, first, first + 1]);
    }
    mesh
}

/// Each triangle of a ball three times, and three times reversed.
fn doubled() -> TestMesh {
    let mut ball = TestMesh::bumpy_ball(0.8, 6);
    let turned: Vec<[u32; 3]> = ball.indices.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let once = ball.indices.clone();
    ball.indices.extend_from_slice(&turned);
    ball.indices.extend_from_slice(&once);
    ball
}

/// Squares of reversed triangles in a chessboard's pattern.
fn chessboard() -> TestMesh {
    let mut board = sheet(12, 12, |u, v| Vec3::new(2.0 * u - 1.0, 0.2 * (5.0 * u).sin(), 2.0 * v - 1.0));
    for (number, triangle) in board.indices.iter_mut().enumerate() {
        if (number / 2 % 12 + number / 24) % 2 == 0 {
            triangle.swap(1, 2);
        }
    }
    board
}

/// A sheet with a rim of triangles without an area: two corners are one vertex, two have one position, or all are on a line.
fn zero_area_rim() -> TestMesh {
    const SIDE: u32 = 10;
    let mut mesh = sheet(SIDE, SIDE, |u, v| Vec3::new(1.8 * u - 0.9, 0.1 * (7.0 * u * v).sin(), 1.8 * v - 0.9));
    for step in 0..SIDE {
        let along_bottom = [step, step + 1];
        let along_left = [step, step + 1].map(|row| row * (SIDE + 1));
        for [a, b] in [along_bottom, along_left] {
            let first = mesh.positions.len() as u32;
            let (from, to) = (mesh.positions[a as usize], mesh.positions[b as usize]);
            mesh.positions.extend([from, from.midpoint(to)]);
            mesh.indices.extend([[a, b, b], [a, first, b], [a, first + 1, b]]);
        }
    }
    mesh
}

/// A figure eight that turns around while it goes around: it intersects itself along a circle (a Klein bottle).
fn through_itself() -> TestMesh {
    sheet(24, 12, |u, v| {
        let ((sin, cos), (half_sin, half_cos)) = ((TAU * u).sin_cos(), (PI * u).sin_cos());
        let (across, up) = ((TAU * v).sin(), (2.0 * TAU * v).sin());
        let radius = 0.7 + 0.3 * (half_cos * across - half_sin * up);
        Vec3::new(radius * cos, 0.3 * (half_sin * across + half_cos * up), radius * sin)
    })
}

/// Triangles that are far apart.
fn apart() -> TestMesh {
    let mut random = Random::new(92);
    let mut mesh = TestMesh::default();
    for _ in 0..80 {
        let center = random.point() * 40.0;
        let size = 0.1 + 8.0 * random.unit();
        mesh.push([(); 3].map(|()| center + random.point() * size));
    }
    mesh
}

/// A sheet with vertices of NaN and infinity in its midst.
fn with_holes() -> TestMesh {
    let mut mesh = sheet(14, 14, |u, v| Vec3::new(2.0 * u - 1.0, 0.3 * (4.0 * v).cos(), 2.0 * v - 1.0));
    for (vertex, bad) in [(40, f32::NAN), (112, f32::INFINITY), (113, f32::NEG_INFINITY), (180, f32::NAN)] {
        mesh.positions[vertex][vertex % 3] = bad;
    }
    mesh
}

/// Large squares, and in the midst of them a ball of less than a pixel and one of some pixels.
fn large_and_small() -> TestMesh {
    let mut mesh = sheet(3, 3, |u, v| Vec3::new(400.0 * u - 190.0, -1.0 - 3.0 * u, 400.0 * v - 210.0));
    mesh.append(&TestMesh::bumpy_ball(2e-3, 6).placed(1.0, Vec3::new(0.1, -0.2, 0.3)));
    mesh.append(&TestMesh::bumpy_ball(0.1, 7).placed(1.0, Vec3::new(-0.3, 0.1, 0.0)));
    mesh.append(&sheet(2, 2, |u, v| Vec3::new(60.0 * u - 30.0, 40.0 * v - 9.0, -4.0 - 8.0 * u)));
    mesh
}

pub(super) fn of_bad_shapes() -> Vec<Case> {
    let high = Vec3::new(1.5, 3.0, 1.0);
    let lights =
        [point(high), spot(Vec3::new(-1.0, 1.3, 0.6), Vec3::ZERO, 0.7), sun(0.3, -1.0, -0.2), sun(1.0, 0.0, 0.1)];
    let mut shapes = vec![
        ("folded", folded(0.0)),
        ("folded loosely", folded(1e-4)),
        ("spiral", spiral()),
        ("Möbius strip", moebius_strip()),
        ("fans", fans()),
        ("doubled", doubled()),
        ("chessboard", chessboard()),
        ("a rim without an area", zero_area_rim()),
        ("through itself", through_itself()),
        ("vertices that are none", with_holes()),
    ];
    let mut cases = Vec::new();
    for (number, (name, mesh)) in shapes.iter().enumerate() {
        let camera = if number % 2 == 0 { camera() } else { parallel_camera() };
        cases.push(Case::new(*name, over_floor(mesh.clone()), view(camera, 20, 15), &lights));
    }
    // More tiles than one.
    let wide = over_floor(moebius_strip());
    cases.push(Case::new("in two tiles", wide, view(camera(), 80, 6), &lights));
    // In other worlds.
    let worlds = [(1e-6, Vec3::ZERO), (1e6, Vec3::ZERO), (300.0, Vec3::new(1e6, -1e6, 1e6)), (1.0, FAR)];
    for (number, (scale, offset)) in worlds.into_iter().enumerate() {
        let (name, mesh) = shapes.swap_remove(3 - number);
        let lights = [point(high * scale + offset), lights[2], sun(-0.5, -0.2, 0.4)];
        let view = view(placed(camera(), scale, offset), 21, 15);
        cases.push(Case::new(format!("{name} × {scale}"), over_floor(mesh).placed(scale, offset), view, &lights));
    }

    let far = Camera::look_at(Vec3::new(20.0, 30.0, 90.0), Vec3::ZERO, Vec3::Y, 0.6);
    let above = [point(Vec3::new(5.0, 70.0, 10.0)), point(Vec3::ZERO), sun(0.2, -1.0, 0.4)];
    cases.push(Case::new("one triangle a patch", apart(), view(far, 30, 24), &above));

    let above = [point(Vec3::new(0.5, 2.0, 1.0)), point(Vec3::new(0.2, 0.1, 0.4)), sun(0.2, -1.0, 0.1)];
    cases.push(Case::new("far larger and smaller than a tile", large_and_small(), view(camera(), 70, 20), &above));

    // Lights inside a ball, at a vertex, on an edge, and inside and beside a triangle of it: patches are on both sides
    // of them.
    let ball = over_floor(TestMesh::bumpy_ball(1.0, 9));
    let [a, b, c] = ball.triangles().corners(150);
    let inside = a + ((b - a) + (c - a)) * 0.25;
    let mut within = vec![point(Vec3::ZERO), point(Vec3::new(0.3, 0.2, -0.1)), point(a), point(a.midpoint(b))];
    within.extend([point(inside), point(a + 3.0 * (b - a)), spot(Vec3::ZERO, b, 1.2), spot(inside, Vec3::ZERO, 0.9)]);
    let in_ball = Camera::look_at(Vec3::new(0.2, 0.3, 0.5), Vec3::new(0.0, -0.2, -0.3), Vec3::Y, 1.2);
    for (name, camera) in [("lights in a ball", in_ball), ("lights in a ball, from outside", camera())] {
        cases.push(Case::new(name, ball.clone(), view(camera, 20, 15), &within));
    }

    // A sheet from far behind a light to far before it, that passes beside, through and barely below the light.
    let long = sheet(6, 60, |u, v| Vec3::new(0.8 * u - 0.4, 0.1 * (30.0 * v).sin(), 12.0 * v - 6.0));
    let lights = [
        spot(Vec3::new(0.1, 0.4, 0.3), Vec3::new(0.0, -0.5, -3.0), 1.0),
        spot(Vec3::new(-0.6, -0.3, 0.5), Vec3::new(0.4, 1.5, -1.0), 1.4),
        point(Vec3::new(0.0, 0.05, 0.0)),
        sun(0.0, -0.05, -1.0),
    ];
    cases.push(Case::new("half behind the light", over_floor(long), view(camera(), 26, 20), &lights));
    cases
}
