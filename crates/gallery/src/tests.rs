//! Promises of every demo.

use glam::Vec3;

use umbrage_scene::{Animated, Error, Frame};

use super::{DEMOS, Demo, DemoScene, make};

/// Few enough triangles that every demo is quick to open without optimisation.
const FEW: usize = 6_000;

fn posed(demo: &Demo, seconds: f64) -> Frame {
    let mut frame = Frame::default();
    demo.pose(seconds, &mut frame).expect("demos can always be posed");
    frame
}

fn open(demo: &DemoScene, triangles: usize) -> Demo {
    make(&format!("demo:{}?triangles={triangles}", demo.name)).expect("the demo opens")
}

/// The bits of everything in a frame that moves.
fn bits(frame: &Frame) -> Vec<[u32; 3]> {
    let camera = frame.cameras[0].camera;
    let lights = frame.lights.iter().map(|light| match light.source {
        umbrage_rays::LightSource::Point { position } | umbrage_rays::LightSource::Spot { position, .. } => position,
        umbrage_rays::LightSource::Directional { direction } => direction,
    });
    let vectors = frame.positions.iter().chain(&frame.normals).copied().chain(lights);
    let vectors = vectors.chain([camera.position, camera.right, camera.up, camera.forward]);
    vectors.map(|vector| vector.to_array().map(f32::to_bits)).collect()
}

fn assert_sound(name: &str, frame: &Frame) {
    let mesh = &frame.mesh;
    assert_eq!(frame.normals.len(), frame.positions.len(), "{name}");
    assert_eq!(mesh.material_of_triangle.len(), mesh.triangles.len(), "{name}");
    assert!(frame.positions.iter().all(|position| position.is_finite()), "{name}");
    assert!(frame.normals.iter().all(|normal| *normal == Vec3::ZERO || (normal.length() - 1.0).abs() < 1e-3), "{name}");
    let vertices = frame.positions.len();
    assert!(mesh.triangles.iter().flatten().all(|&vertex| (vertex as usize) < vertices), "{name}");
    let materials = frame.materials.materials.len();
    assert!(mesh.material_of_triangle.iter().all(|&material| (material as usize) < materials), "{name}");
    for coords in mesh.tex_coords.iter().filter(|coords| !coords.is_empty()) {
        assert_eq!(coords.len(), vertices, "{name}");
        assert!(coords.iter().all(|coords| coords.is_finite()), "{name}");
    }
    for (triangle, &material) in mesh.material_of_triangle.iter().enumerate() {
        let object = mesh.objects.of_triangle(triangle as u32).expect("every triangle is of an object");
        let (object, material) =
            (&mesh.objects.names()[object as usize], &frame.materials.materials[material as usize]);
        assert!(!material.name.is_empty() && object.starts_with(&material.name), "{name}: {object}");
    }
    assert!(mesh.colors.is_empty() || mesh.colors.len() == vertices, "{name}");
    assert!((1..=3).contains(&frame.lights.len()), "{name} has {} lights", frame.lights.len());
    assert!(!frame.cameras.is_empty(), "{name}");
    let omitted = frame.triangles().omitted().total() as usize;
    assert!(omitted * 200 <= mesh.triangles.len(), "{name} has {omitted} triangles that can't be hit");
}

#[test]
fn demos_are_sound_from_start_to_end() {
    for scene in DEMOS {
        let demo = open(scene, FEW);
        let duration = demo.duration_seconds();
        assert!(duration > 0.0 && (0.0..duration).contains(&demo.still_seconds()), "{}", scene.name);
        for part in [0.0, 0.31, 0.5, 0.77, 1.0] {
            assert_sound(scene.name, &posed(&demo, part * duration));
        }
    }
}

#[test]
fn demos_move() {
    for scene in DEMOS {
        let demo = open(scene, FEW);
        let [start, later] = [0.0, 0.4].map(|part| bits(&posed(&demo, part * demo.duration_seconds())));
        assert!(start != later, "{}", scene.name);
    }
}

#[test]
fn demos_have_the_same_bits_for_any_number_of_threads_and_in_used_frames() {
    for scene in DEMOS {
        let pose = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool");
            pool.install(|| {
                let demo = open(scene, FEW);
                (bits(&posed(&demo, 0.37 * demo.duration_seconds())), demo)
            })
        };
        let ((once, _), (again, demo)) = (pose(1), pose(3));
        assert!(once == again, "{}", scene.name);
        let mut used = posed(&demo, 0.8 * demo.duration_seconds());
        used.lights.clear();
        used.cameras.clear();
        demo.pose(0.37 * demo.duration_seconds(), &mut used).expect("demos can always be posed");
        assert!(once == bits(&used), "{} in a used frame", scene.name);
    }
}

#[test]
fn demos_have_about_as_many_triangles_as_were_asked_for() {
    for scene in DEMOS {
        for wanted in [4_000, 30_000] {
            let count = posed(&open(scene, wanted), 0.0).mesh.triangles.len();
            assert!(count.abs_diff(wanted) * 10 <= wanted, "{}: {count}, not {wanted}", scene.name);
        }
        let fewest = posed(&open(scene, 1), 0.0);
        assert_sound(scene.name, &fewest);
        assert!(fewest.mesh.triangles.len() <= 2_000, "{}: {}", scene.name, fewest.mesh.triangles.len());
    }
}

#[test]
fn demos_have_their_own_numbers_of_triangles() {
    // The statue is too slow to mesh without optimisation; its count is put together like that of the others.
    for scene in DEMOS.iter().filter(|scene| scene.triangles < 300_000) {
        let count = posed(&make(&format!("demo:{}", scene.name)).expect("it opens"), 0.0).mesh.triangles.len();
        assert!(count.abs_diff(scene.triangles) * 50 <= scene.triangles, "{}: {count}", scene.name);
    }
}

#[test]
fn wrong_addresses_say_what_is_right() {
    let cause = |address: &str| match make(&format!("demo:{address}")) {
        Err(Error::Address { address: named, cause }) => {
            assert_eq!(named, format!("demo:{address}"));
            cause
        }
        other => panic!("{address}: {other:?}"),
    };
    for demo in DEMOS {
        assert!(cause("clothes").contains(demo.name));
    }
    assert!(cause("").contains("cloth"));
    assert!(cause("cloth?triangle=5").contains("triangles=N"));
    assert!(cause("cloth?").contains("triangles=N"));
    for number in ["", "0", "-3", "many", "1e5", "99999999999999999999999"] {
        assert!(cause(&format!("cloth?triangles={number}")).contains("whole number"), "{number}");
    }
}
