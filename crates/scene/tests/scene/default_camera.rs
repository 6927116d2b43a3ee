//! The default camera, and the size of scenes.

use glam::Vec3;
use umbrage_rays::Camera;
use umbrage_scene::{Animated, Error, Frame, Ground, NamedCamera, Scene};

/// A triangle that moves by 10 along +X in a second, with or without a camera of its own.
#[derive(Debug)]
struct Sliding {
    camera: Option<Camera>,
}

impl Animated for Sliding {
    fn duration_seconds(&self) -> f64 {
        1.0
    }

    fn pose(&self, seconds: f64, frame: &mut Frame) -> Result<(), Error> {
        let offset = Vec3::X * (10.0 * seconds) as f32;
        let corners = [Vec3::ZERO, Vec3::new(3.0, 0.0, 0.0), Vec3::new(0.0, 4.0, 0.0)];
        let posed = Frame::from_triangles(corners.map(|corner| corner + offset).to_vec(), vec![[0, 1, 2]]);
        frame.copy_surfaces(&posed);
        frame.cameras.extend(self.camera.map(|camera| NamedCamera { name: "own".into(), camera }));
        Ok(())
    }
}

fn sliding(camera: Option<Camera>) -> Scene {
    Scene::new(Box::new(Sliding { camera })).unwrap()
}

/// Larger distance of a point from a square picture's middle, relative to half of its side.
fn off_middle(camera: &Camera, point: Vec3) -> f32 {
    let [x, y, z] = [camera.right, camera.up, camera.forward].map(|axis| (point - camera.position).dot(axis));
    assert!(z > 0.0, "{point} is behind {camera:?}");
    // The vertical field of view is 0.7 radians.
    x.abs().max(y.abs()) / (z * 0.35_f32.tan())
}

#[test]
fn the_default_camera_sees_the_whole_animation_from_the_front_one_side_and_above() {
    let scene = sliding(None);
    let cameras = [0.0, 0.3, 0.9].map(|seconds| scene.at(seconds).unwrap().camera(1.0));
    assert!(cameras[1..].iter().all(|camera| *camera == cameras[0]), "it stays where it is");
    let forward = cameras[0].forward;
    assert!(forward.z < -0.8 && (-0.6..-0.3).contains(&forward.x) && (-0.4..-0.2).contains(&forward.y), "{forward}");
    // It is posed at 0, 0.2, 0.4, 0.6 and 0.8 seconds.
    let bounds = scene.at(0.0).unwrap().animation_bounds;
    assert_eq!((bounds.min, bounds.max), (Vec3::ZERO, Vec3::new(11.0, 4.0, 0.0)));
    let farthest = bounds.corners().into_iter().map(|corner| off_middle(&cameras[0], corner)).fold(0.0, f32::max);
    assert!((farthest - 0.8).abs() < 1e-3, "four fifths of a side: {farthest}");
}

#[test]
fn what_stays_is_framed_by_its_triangles_and_without_its_ground() {
    // An octahedron, whose box is wider from everywhere.
    let octahedron = "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\nf 1 3 5\nf 2 4 6\n";
    let mut scene = Scene::from_bytes("a.obj", octahedron).unwrap();
    let framed = |scene: &Scene| {
        let frame = scene.at(0.0).unwrap();
        let camera = frame.camera(1.0);
        (camera, frame.positions[..6].iter().map(|point| off_middle(&camera, *point)).fold(0.0, f32::max))
    };
    let (camera, farthest) = framed(&scene);
    assert!((farthest - 0.8).abs() < 1e-3, "{farthest}");
    scene.set_ground(Some(Ground::default()));
    assert_eq!(framed(&scene).0, camera);
}

#[test]
fn a_camera_of_the_scene_comes_first() {
    let own = Camera::look_at(Vec3::Z * 9.0, Vec3::ZERO, Vec3::Y, 1.0);
    assert_eq!(sliding(Some(own)).at(0.5).unwrap().camera(2.0), own);
}

#[test]
fn the_size_is_that_of_the_first_moment_without_a_ground() {
    let mut scene = sliding(None);
    assert_eq!(scene.size(), 5.0);
    scene.set_ground(Some(Ground::default()));
    assert_eq!(scene.size(), 5.0);
    let empty = Scene::from_bytes("a.obj", "v 0 0 0\n").unwrap();
    assert_eq!(empty.size(), 0.0);
}
