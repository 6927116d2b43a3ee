//! The default light of scenes without lights.

use std::sync::Arc;

use glam::Vec3;
use umbrage::rays::{Camera, LightSource};
use umbrage::scene::{Animated, Error, Frame, Material, Materials, Mesh, NamedCamera, Scene};
use umbrage::{Background, Renderer, Settings};
use umbrage_verify::TestMesh;

/// Walls all around the origin, with or without a camera of its own inside.
#[derive(Debug)]
struct Room {
    camera: Option<Camera>,
}

impl Animated for Room {
    fn duration_seconds(&self) -> f64 {
        0.0
    }

    fn pose(&self, _seconds: f64, frame: &mut Frame) -> Result<(), Error> {
        let TestMesh { positions, indices } = TestMesh::ball(3).placed(4.0, Vec3::ZERO);
        let material_of_triangle = vec![0; indices.len()];
        frame.positions = positions;
        frame.mesh = Arc::new(Mesh { triangles: indices, material_of_triangle, ..Mesh::default() });
        let clay = Material { double_sided: true, ..Material::clay() };
        frame.materials = Arc::new(Materials { materials: vec![clay], textures: Vec::new() });
        frame.cameras.extend(self.camera.map(|camera| NamedCamera { name: "own".into(), camera }));
        Ok(())
    }
}

fn camera(position: Vec3) -> Camera {
    Camera::look_at(position, Vec3::new(0.1, 0.2, 0.0), Vec3::Y, 1.0)
}

/// Number of pixels that the light reaches, and its position; `None` for a sun.
fn lit(room: Room, camera: Option<Camera>) -> (usize, Option<Vec3>) {
    let scene = Scene::new(Box::new(room)).expect("a scene");
    let mut settings =
        Settings { width: 40, height: 30, background: Background::Color(Vec3::ZERO), ..Settings::default() };
    if let Some(camera) = camera {
        settings.camera = camera.into();
    }
    let mut renderer = Renderer::default();
    renderer.render(&scene, 0.0, &settings).expect("a picture");
    let position = match renderer.frame().lights[0].source {
        LightSource::Point { position } => Some(position),
        _ => None,
    };
    (renderer.light_masks()[0].count(), position)
}

#[test]
fn a_room_is_lit_from_beside_the_camera_that_is_inside() {
    let (inside, outside) = (camera(Vec3::new(0.0, 0.0, 2.0)), camera(Vec3::new(0.0, 0.0, 20.0)));
    // The scene's own camera, a requested one, and a requested one in place of the scene's own.
    for (own, asked) in [(Some(inside), None), (None, Some(inside)), (Some(outside), Some(inside))] {
        let (pixels, position) = lit(Room { camera: own }, asked);
        let position = position.expect("a lamp");
        assert!(position.distance(inside.position) < 1.0, "{position}");
        assert!(pixels > 1000, "{pixels} pixels are lit");
    }
    for (own, asked) in [(None, None), (Some(inside), Some(outside))] {
        let (pixels, position) = lit(Room { camera: own }, asked);
        assert!(position.is_none() && pixels > 50, "{position:?}, {pixels} pixels");
    }
}
