//! Lights at difficult positions, and points outside of all faces of a light.

use std::f32::consts::FRAC_PI_2;

use glam::Vec3;
use umbrage_rays::{Camera, LightSource, View};
use umbrage_verify::lights::{around, in_bad_places, point, sun};
use umbrage_verify::views::{OFFSET_PIXELS, camera, parallel_camera, placed, telescope, view};
use umbrage_verify::{Case, Oracle, Random, Sheet, SheetShape, TestMesh};

use super::{FAR, room};
use crate::check::Known;

pub(super) fn of_all_kinds() -> Vec<Case> {
    let mut cases = Vec::new();
    for (size, camera) in [((29, 23), camera()), ((23, 21), parallel_camera())] {
        cases.push(Case::new("around", room(8), view(camera, size.0, size.1), &around(1.0, Vec3::ZERO)));
    }

    let worlds = [(1.0, Vec3::ZERO), (1e-6, Vec3::ZERO), (1e6, Vec3::ZERO), (1.0, FAR), (300.0, FAR)];
    for (world, (scale, offset)) in worlds.into_iter().enumerate() {
        let lights = in_bad_places(&[0, 37, 70, 130, 200, 300], scale, offset);
        // Each camera has a quarter of the lights in this world, and others in the next.
        for (number, camera) in [camera(), parallel_camera()].into_iter().enumerate() {
            let some: Vec<_> = lights.iter().copied().skip((world + 2 * number) % 4).step_by(4).collect();
            let name = format!("on, behind and along surfaces, × {scale}");
            let view = view(placed(camera, scale, offset), 13, 11);
            cases.push(Case::new(name, TestMesh::room().placed(scale, offset), view, &some));
        }
    }

    let none = [
        point(Vec3::new(f32::NAN, 0.0, 0.0)),
        point(Vec3::new(0.0, f32::INFINITY, 0.0)),
        LightSource::Directional { direction: Vec3::ZERO },
        LightSource::Directional { direction: Vec3::NAN },
    ];
    cases.push(Case::new("lights that are none", room(9), view(camera(), 20, 10), &none));
    cases.push(Case::new("no light", room(9), view(camera(), 20, 10), &[]));

    // A floor of small triangles, and others slightly above and below it: the light has to tell their nearness apart.
    // The camera sees their shadows from below the floor.
    let mut random = Random::new(11);
    let mut floor = TestMesh::plane(16, 1.44).placed(1.0, Vec3::Y * -0.5);
    for height in [1e-2, 1e-4, 1e-5, 3e-6, -1e-5, -1e-2] {
        for _ in 0..40 {
            let center = Vec3::new(random.unit() * 2.4 - 1.2, -0.5 + height, random.unit() * 2.4 - 1.2);
            floor.push([(); 3].map(|()| center + random.point() * 0.06 * Vec3::new(1.0, 0.0, 1.0)));
        }
    }
    let lights = [
        point(Vec3::new(0.2, 4.0, 0.1)),
        point(Vec3::new(0.0, -0.2, 0.0)),
        sun(0.0, -1.0, 0.0),
        LightSource::Directional { direction: Vec3::new(1.0, -0.2, 0.1) },
    ];
    let below = Camera::look_at(Vec3::new(0.3, -3.5, 1.0), Vec3::new(0.0, -0.5, 0.0), Vec3::X, 0.8);
    cases.push(Case::new("barely in front of what is seen", floor, view(below, 29, 21), &lights));
    for camera in [camera(), parallel_camera()] {
        cases.push(Case::new("cones", room(9), view(camera, 33, 29), &cones(&view(camera, 33, 29))));
    }
    cases
}

/// Spots of all widths: some whose cone ends at a pixel's point to the last bits, some around the whole scene and some
/// away from it.
fn cones(view: &View) -> Vec<LightSource> {
    let spot = |position: Vec3, direction: Vec3, outer_radians: f32| LightSource::Spot {
        position,
        direction,
        inner_radians: 0.5 * outer_radians,
        outer_radians,
    };
    let (above, aside) = (Vec3::new(2.0, 3.0, 1.0), Vec3::new(-0.2, 0.95, 0.3));
    let mut cones = vec![
        spot(above, -above.normalize(), 1e-4),
        spot(above, -above.normalize(), 0.03),
        spot(above, -above.normalize(), 1.3),
        spot(above, Vec3::Y, 0.7),
        spot(aside, Vec3::new(0.6, -0.8, 0.0), 0.9),
        spot(aside, Vec3::NEG_Y, FRAC_PI_2),
        spot(Vec3::new(0.1, -0.999, 0.2), Vec3::X, 0.2),
        spot(above, -3.0 * above, 0.2),
        spot(above, Vec3::ZERO, 0.2),
        spot(above, Vec3::NAN, 0.2),
        spot(Vec3::NAN, Vec3::X, 0.2),
    ];
    let mesh = room(9);
    let oracle = Oracle::new(mesh.triangles());
    for (x, y) in [(13.0, 20.0), (16.0, 22.0), (20.0, 14.0)] {
        let ray = view.ray(x + OFFSET_PIXELS.x, y + OFFSET_PIXELS.y);
        let Some(hit) = oracle.nearest(&ray, |_| true) else { continue };
        let axis = (Vec3::new(0.3, -0.9, -0.1) - above).normalize();
        let to = ray.origin + ray.direction * hit.t - above.as_dvec3();
        cones.push(spot(above, axis, to.angle_between(axis.as_dvec3()) as f32));
    }
    cones
}

pub(super) fn that_no_face_holds() -> Vec<Known> {
    let mut known = Vec::new();
    // Lights at vertices of a sheet that lie exactly on rays: those points are at their light.
    let mut random = Random::new(32);
    for (position, scale) in [(Vec3::ZERO, 1.0), (FAR, 4.0)] {
        for is_orthographic in [false, true] {
            let shape = SheetShape { side: 16, step: 1, position, scale, is_orthographic, has_shell: false };
            let sheet = Sheet::new(shape, &mut random);
            let inside = [60, 130, 200, 244].map(|vertex: usize| point(sheet.mesh.positions[vertex]));
            let case = Case::new(format!("{shape:?}"), sheet.mesh, sheet.view, &inside);
            let case = Case { offset_pixels: sheet.offset_pixels, ..case };
            known.push(Known::new(case).with_outliers(&[1; 4]));
        }
    }
    // Depths whose inverse is out of range.
    let scale = 1e32;
    let lights = [point(Vec3::new(1.0, 3.0, 1.0) * scale), sun(0.2, -1.0, 0.1)];
    let huge = TestMesh::room().placed(scale, Vec3::ZERO);
    let seen = view(placed(camera(), scale, Vec3::ZERO), 23, 17);
    known.push(Known::new(Case::new("huge", huge, seen, &lights)).with_outliers(&[201, 201]));
    // A telescope so far away that its points' errors are about as large as their distances from the light.
    let lights = [point(Vec3::new(0.5, -0.9999, 0.5)), point(Vec3::new(0.3, 0.4, 0.2))];
    let case = Case::new("telescope", TestMesh::room(), view(telescope(2e12), 23, 17), &lights);
    known.push(Known::new(case).with_outliers(&[1, 0]));
    known
}
