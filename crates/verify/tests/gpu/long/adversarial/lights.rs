//! Lights at difficult positions.

use glam::Vec3;
use umbrage_rays::LightSource;
use umbrage_verify::TestMesh;
use umbrage_verify::lights::{in_bad_places, point, sun};
use umbrage_verify::views::{camera, parallel_camera, placed, telescope, view};

use super::grids::{WORLDS, case, grids};

#[test]
fn lights_on_behind_and_grazing_surfaces() {
    let Some(mut grids) = grids() else { return };
    let room = TestMesh::room();
    for (world, (scale, offset)) in WORLDS.into_iter().enumerate() {
        let mesh = room.clone().placed(scale, offset);
        let lights = in_bad_places(&[0, 37, 130, 300], scale, offset);
        // Each camera has half of the lights in this world, and the other half in the next.
        for (number, camera) in [camera(), parallel_camera()].into_iter().enumerate() {
            let half: Vec<_> = lights.iter().copied().skip((world + number) % 2).step_by(2).collect();
            let view = view(placed(camera, scale, offset), 17, 13);
            grids.check(&format!("scale {scale} at {offset}, {:?}", camera.projection), &case(&mesh, view, &half));
        }
    }
}

#[test]
fn spots_in_the_middle_have_a_face_around_their_cone() {
    let Some(mut grids) = grids() else { return };
    let room = TestMesh::room();
    for (scale, offset) in WORLDS {
        let mesh = room.clone().placed(scale, offset);
        let position = offset + Vec3::new(0.3, 0.4, 0.2) * scale;
        let spot = |outer_radians: f32, direction: Vec3| {
            let inner_radians = 0.5 * outer_radians;
            LightSource::Spot { position, direction, inner_radians, outer_radians }
        };
        // The last two are too wide for one face, or shine away from all seen points.
        let lights = [
            spot(0.01, Vec3::new(-0.3, -1.0, -0.2)),
            spot(0.2, Vec3::NEG_Y),
            spot(0.7, Vec3::new(1e6, -2e6, 5e5)),
            spot(1.2, Vec3::new(-1e-6, -1e-6, 0.0)),
            spot(1.5, Vec3::NEG_Y),
            spot(0.3, camera().forward * -1.0),
        ];
        let case = case(&mesh, view(placed(camera(), scale, offset), 40, 30), &lights);
        grids.check(&format!("spots at scale {scale} and {offset}"), &case);
        let faces = grids.faces(&case);
        assert_eq!(faces[..4], [1; 4], "scale {scale} at {offset}");
        assert_eq!(faces[4], 6, "scale {scale} at {offset}");
    }
}

#[test]
fn a_telescope_far_away() {
    let Some(mut grids) = grids() else { return };
    for far in [2e6_f32, 2e9, 2e12] {
        let lights = [point(Vec3::new(0.5, -0.9999, 0.5)), point(Vec3::new(0.3, 0.4, 0.2)), sun(0.3, -1.0, 0.1)];
        let mesh = TestMesh::room();
        grids.check(&format!("from {far}"), &case(&mesh, view(telescope(far), 23, 17), &lights));
    }
}

#[test]
fn many_lights_and_none() {
    let Some(mut grids) = grids() else { return };
    let mesh = TestMesh::room();
    let all: Vec<_> = (0..40).map(|number| (number as f32 * 0.7).sin_cos()).collect();
    let lights: Vec<_> = all.iter().map(|(x, z)| point(Vec3::new(2.0 * x, 1.5, 2.0 * z))).collect();
    for count in [0, 1, 40] {
        grids.check(&format!("{count} lights"), &case(&mesh, view(camera(), 30, 20), &lights[..count]));
    }
}
