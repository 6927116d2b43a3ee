//! A frame of the GPU engine uploads matrices and weights, and no vertices.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use glam::Vec3;
use serde_json::json;
use umbrage::rays::Camera;
use umbrage::{CameraChoice, Renderer, Scene, Settings, Sides};
use umbrage_gpu::Buffer;

use crate::builder::{self, Builder};
use crate::common::{gpu, renderer};

/// A skinned and morphed strip of `vertices` vertices beside a still one, with two triangles that no ray can hit.
fn strips(vertices: u16) -> Scene {
    let mut file = Builder::new();
    let count = usize::from(vertices);
    let positions: Vec<_> =
        (0..vertices).map(|vertex| [f32::from(vertex / 2) / f32::from(vertices), f32::from(vertex % 2), 0.0]).collect();
    let positions = file.floats(&positions);
    let normals = file.floats(&vec![[0.0, 0.0, 1.0]; count]);
    let tangents = file.floats(&vec![[1.0, 0.0, 0.0, 1.0]; count]);
    let weights = file.floats(&vec![[0.25, 0.75, 0.0, 0.0]; count]);
    let joints = file.accessor(builder::U8, "VEC4", count, &[0, 1, 0, 0].repeat(count));
    let still = json!({ "POSITION": positions, "NORMAL": normals, "TANGENT": tangents });
    let mut moving = still.clone();
    moving["JOINTS_0"] = json!(joints);
    moving["WEIGHTS_0"] = json!(weights);
    let targets = json!([{ "POSITION": normals, "NORMAL": normals, "TANGENT": normals }]);
    let moving = file.mesh(moving, json!({ "mode": 5, "targets": targets }));
    let still = file.mesh(still, json!({ "mode": 5 }));
    let broken = file.floats(&[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 0.0], [f32::NAN, 0.0, 0.0]]);
    let indices = file.indices(&[0, 1, 2, 0, 1, 3]);
    let broken = file.mesh(json!({ "POSITION": broken }), json!({ "indices": indices }));
    file.json["nodes"] = json!([
        { "mesh": moving, "skin": 0 },
        { "children": [2] },
        {},
        { "mesh": still, "translation": [0, 0, -0.5] },
        { "mesh": broken },
    ]);
    file.json["skins"] = json!([{ "joints": [1, 2] }]);
    file.animate(1, "rotation", "LINEAR", &[0.0, 1.0], &[[0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]]);
    file.animate(2, "translation", "LINEAR", &[0.0, 1.0], &[[0.0; 3], [0.0, 0.4, 0.1]]);
    file.animate(0, "weights", "LINEAR", &[0.0, 1.0], &[[0.0], [1.0]]);
    file.open().expect("a scene")
}

fn settings() -> Settings {
    let camera = Camera::look_at(Vec3::new(0.4, 0.8, 3.0), Vec3::new(0.2, 0.5, 0.0), Vec3::Y, 0.8);
    // Turning triangles show their backs, too.
    Settings { width: 40, height: 30, camera: camera.into(), sides: Sides::Both, ..Settings::default() }
}

#[test]
fn uploads_do_not_grow_with_the_vertices() {
    let Some(mut renderer) = renderer() else { return };
    let mut uploads = |vertices: u16, settings: &Settings| {
        let scene = strips(vertices);
        let uploads = [0.1, 0.2, 0.3].map(|seconds| {
            renderer.render(&scene, seconds, settings).expect("a frame");
            renderer.stats().uploaded_bytes
        });
        println!("{vertices}: {uploads:?}");
        uploads
    };
    let framed = Settings { camera: CameraChoice::Default, ..settings() };
    for settings in [settings(), framed] {
        let [small, large] = [1_000, 20_000].map(|vertices| uploads(vertices, &settings));
        // Everything once, then only matrices and weights, for any number of vertices.
        assert!(large[0] > small[0] + 19_000 * 60);
        assert_eq!(large[1..], small[1..]);
        assert!(large[2] < 8_000, "{large:?}");
    }
}

#[test]
fn uploads_of_others_on_the_device_are_not_counted() {
    let (Some(mut renderer), Some(gpu)) = (renderer(), gpu()) else { return };
    let scene = strips(200);
    let mut uploads = |seconds: f64| {
        renderer.render(&scene, seconds, &settings()).expect("a frame");
        renderer.stats().uploaded_bytes
    };
    uploads(0.1);
    let alone = uploads(0.2);
    let (is_done, mut words) = (AtomicBool::new(false), Buffer::storage(&gpu, "words"));
    thread::scope(|scope| {
        scope.spawn(|| {
            while !is_done.load(Ordering::Relaxed) {
                words.write(&gpu, &[0_u32; 99]).expect("room");
                thread::yield_now();
            }
        });
        let beside_others = [0.3, 0.4].map(&mut uploads);
        is_done.store(true, Ordering::Relaxed);
        assert_eq!(beside_others, [alone; 2]);
    });
}

fn triangles(renderer: &Renderer) -> Vec<u32> {
    let pixels = (0..30).flat_map(|y| (0..40).map(move |x| (x, y)));
    pixels.map(|(x, y)| renderer.seen().triangle_at(x, y)).collect()
}

#[test]
fn rigs_and_frames_with_vertices_take_turns() {
    let (Some(mut gpu), mut cpu) = (renderer(), Renderer::default()) else { return };
    let scene = strips(200);
    let framed = Settings { camera: CameraChoice::Default, ..settings() };
    for settings in [settings(), framed] {
        for seconds in [0.1, 0.6] {
            for renderer in [&mut cpu, &mut *gpu] {
                renderer.render(&scene, seconds, &settings).expect("a frame");
            }
            assert_eq!(triangles(&cpu), triangles(&gpu), "the rig at {seconds}");
            let of_rig = triangles(&cpu);
            let posed = scene.at(seconds + 0.3).expect("a frame");
            for renderer in [&mut cpu, &mut *gpu] {
                renderer.render_frame(&posed, &settings).expect("a frame");
            }
            assert_eq!(triangles(&cpu), triangles(&gpu), "the frame of {seconds}");
            assert_ne!(triangles(&cpu), of_rig, "{seconds}");
            assert!(gpu.frame().positions.is_empty(), "{seconds}");
            assert_eq!(gpu.stats().vertices, posed.positions.len(), "{seconds}");
        }
    }
}

#[test]
fn frames_are_those_of_the_cpu() {
    let (Some(mut gpu), mut cpu) = (renderer(), Renderer::default()) else { return };
    let scenes =
        [strips(200), strips(3_000), umbrage::open("demo:cloth?triangles=500").expect("a scene of the gallery")];
    let framed = Settings { camera: CameraChoice::Default, ..settings() };
    // Scenes replace each other, with and without a camera that is made from vertices.
    for (place, seconds, settings) in [
        (0, 0.0, settings()),
        (0, 0.7, settings()),
        (1, 0.7, framed.clone()),
        (1, 0.2, settings()),
        (2, 0.2, settings()),
        (0, 0.3, framed),
        (1, 0.2, settings()),
        (1, 0.2, settings()),
    ] {
        let name = format!("scene {place} at {seconds}");
        for renderer in [&mut cpu, &mut *gpu] {
            renderer.render(&scenes[place], seconds, &settings).expect("a frame");
        }
        assert_eq!(triangles(&cpu), triangles(&gpu), "{name}");
        let [of_cpu, of_gpu] = [cpu.frame(), gpu.frame()];
        assert!(
            of_cpu.positions.iter().zip(&of_gpu.positions).all(|(one, other)| one == other || one.is_nan()),
            "{name}"
        );
        assert_eq!((&of_cpu.normals, &of_cpu.tangents), (&of_gpu.normals, &of_gpu.tangents), "{name}");
        assert_eq!(cpu.stats().vertices, gpu.stats().vertices, "{name}");
        let omitted = |renderer: &Renderer| {
            let omitted = renderer.stats().omitted.iter();
            omitted.map(|of| (of.reason, of.count, of.first_ids.clone())).collect::<Vec<_>>()
        };
        assert_eq!(omitted(&cpu), omitted(&gpu), "{name}");
        assert_eq!(omitted(&gpu).len(), if place == 2 { 0 } else { 2 }, "{name}");
    }
}
