//! The default camera, and the size of scenes.

use glam::Vec3;
use umbrage_rays::{Camera, LightSource};
use umbrage_scene::{Animated, Error, Frame, Ground, Light, NamedCamera, Scene};

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
    let corners = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let octahedron = Frame::from_triangles(corners.to_vec(), vec![[0, 2, 4], [1, 3, 5]]);
    let mut scene = Scene::new(Box::new(octahedron)).unwrap();
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
    let empty = Scene::new(Box::new(Frame::from_triangles(vec![Vec3::ONE], vec![]))).unwrap();
    assert_eq!(empty.size(), 0.0);
}

#[test]
fn a_frame_is_a_motionless_scene_with_its_own_lights_and_cameras() {
    let own = NamedCamera { name: "own".into(), camera: Camera::look_at(Vec3::Z * 9.0, Vec3::ZERO, Vec3::Y, 1.0) };
    let lamp = Light::new(LightSource::Point { position: Vec3::Y }, 7.0);
    let mut still = Frame::from_triangles(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]);
    (still.lights, still.cameras, still.origin) = (vec![lamp.clone()], vec![own.clone()], [1e6, 0.0, -2e6]);
    let scene = Scene::new(Box::new(still.clone())).unwrap();
    assert_eq!((scene.duration_seconds(), scene.origin()), (0.0, still.origin));
    let mut frame = scene.at(3.0).unwrap();
    for _ in 0..2 {
        assert_eq!(
            (&frame.positions, &frame.lights, &frame.cameras),
            (&still.positions, &vec![lamp.clone()], &vec![own.clone()])
        );
        scene.pose(0.5, &mut frame).unwrap();
    }
    // A light that was made is made anew.
    still.lights.clear();
    let made = Scene::new(Box::new(still)).unwrap().at(0.0).unwrap();
    let again = Scene::new(Box::new(made.clone())).unwrap().at(0.0).unwrap();
    assert!(made.light_is_made && again.light_is_made && again.lights == made.lights);
}
