//! Scenes far from the origin of their coordinates look as they do at the origin.

use std::fmt::Write as _;

use glam::{DVec3, Vec3};
use serde_json::json;
use umbrage::spec::{CameraSpec, LightSpec};
use umbrage::{Film, Renderer, Scene, Settings};
use umbrage_verify::TestMesh;

/// Whole, so that coordinates from there are those at the origin, bit for bit.
const AWAY: DVec3 = DVec3::new(500_000.0, 5_000_000.0, -128.0);
const SIZE: [u32; 2] = [64, 48];

/// A ball whose coordinates have few digits.
fn ball() -> TestMesh {
    let mut ball = TestMesh::ball(3);
    ball.positions.iter_mut().for_each(|position| *position = (*position * 1024.0).round() / 1024.0);
    ball
}

fn obj(away: DVec3) -> (&'static str, Vec<u8>) {
    let TestMesh { positions, indices } = ball();
    let mut text = String::new();
    for position in positions.iter().map(|position| position.as_dvec3() + away) {
        writeln!(text, "v {} {} {}", position.x, position.y, position.z).expect("room");
    }
    for [a, b, c] in indices {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).expect("room");
    }
    ("ball.obj", text.into_bytes())
}

fn ply(away: DVec3) -> (&'static str, Vec<u8>) {
    let TestMesh { positions, indices } = ball();
    let mut bytes = format!(
        "ply\nformat binary_big_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        positions.len(),
        indices.len()
    )
    .into_bytes();
    bytes.extend(positions.iter().flat_map(|at| (at.as_dvec3() + away).to_array()).flat_map(f64::to_be_bytes));
    for corners in indices {
        bytes.push(3);
        bytes.extend(corners.into_iter().flat_map(u32::to_be_bytes));
    }
    ("ball.ply", bytes)
}

fn gltf(away: DVec3) -> (&'static str, Vec<u8>) {
    let TestMesh { positions, indices } = ball();
    let numbers = positions.iter().flat_map(Vec3::to_array).flat_map(f32::to_le_bytes);
    let bytes: Vec<u8> = numbers.chain(indices.as_flattened().iter().flat_map(|index| index.to_le_bytes())).collect();
    let uri = bytes.iter().fold("data:application/octet-stream,".to_owned(), |uri, byte| uri + &format!("%{byte:02x}"));
    let (vertices, first_index) = (positions.len(), 12 * positions.len());
    let file = json!({
        "asset": { "version": "2.0" },
        "nodes": [{ "children": [1], "translation": away.to_array() }, { "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": vertices },
            { "bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": 3 * indices.len() },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": first_index },
            { "buffer": 0, "byteOffset": first_index, "byteLength": bytes.len() - first_index },
        ],
        "buffers": [{ "byteLength": bytes.len(), "uri": uri }],
    });
    ("ball.gltf", file.to_string().into_bytes())
}

/// A picture by a camera and lights of the world, which say where they are in words.
fn film(scene: &Scene, away: DVec3) -> Film {
    let at = |x: f64, y: f64, z: f64| {
        let [x, y, z] = (away + DVec3::new(x, y, z)).to_array();
        format!("{x},{y},{z}")
    };
    let camera = format!("{}:{}:50", at(1.5, 0.75, 2.5), at(0.125, 0.0, 0.25)).parse();
    let Ok(CameraSpec::LookAt(camera)) = camera else { panic!("{camera:?}") };
    let center = scene.at(0.0).expect("a frame").animation_bounds.center();
    let lights =
        [format!("point:{}", at(2.0, 3.0, 1.0)), format!("spot:{}:{}:40", at(-2.0, 2.5, 1.0), at(0.0, 0.5, 0.0))];
    let light =
        |text: String| text.parse::<LightSpec>().expect("a light").local(scene.origin()).light(center, scene.size());
    let [width, height] = SIZE;
    let settings = Settings {
        width,
        height,
        camera: camera.local(scene.origin()).camera().into(),
        lights: Some(lights.map(light).into()),
        ..Settings::default()
    };
    let mut renderer = Renderer::default();
    renderer.render(scene, 0.0, &settings).expect("a picture");
    renderer.film().clone()
}

#[test]
fn far_files_are_seen_and_lit_as_at_the_origin() {
    for file in [obj, ply, gltf] {
        let [near, far] = [DVec3::ZERO, AWAY].map(|away| {
            let (name, bytes) = file(away);
            (umbrage::open_bytes(name, bytes).expect("a scene"), away)
        });
        assert_eq!((near.0.origin(), far.0.origin()), ([0.0; 3], AWAY.to_array()));
        let bounds = far.0.at(0.0).expect("a frame").triangles().bounds();
        assert!((bounds.size() - Vec3::splat(2.0)).abs().max_element() < 0.01, "{bounds:?}");
        let [near, far] = [near, far].map(|(scene, away)| film(&scene, away));
        assert!(near.triangle.iter().filter(|&&triangle| triangle != Film::NO_TRIANGLE).count() > 500);
        assert_eq!(far.triangle, near.triangle);
        assert_eq!((far.color, far.depth), (near.color, near.depth));
        assert_eq!((far.origin, near.origin), (AWAY.to_array(), [0.0; 3]));
    }
}

#[test]
fn far_files_have_the_default_picture_of_near_ones() {
    for file in [obj, ply, gltf] {
        let [near, far] = [DVec3::ZERO, AWAY].map(|away| {
            let (name, bytes) = file(away);
            let [width, height] = SIZE;
            let settings = Settings { width, height, ..Settings::default() };
            let mut renderer = Renderer::default();
            let scene = umbrage::open_bytes(name, bytes).expect("a scene");
            renderer.render(&scene, 0.0, &settings).expect("a picture").clone()
        });
        assert_eq!((far.triangle, far.color), (near.triangle, near.color));
    }
}
