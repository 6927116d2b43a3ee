//! Work of rays, in visits; not a test, since it compares traversals.

use glam::Vec3;
use umbrage_gpu::Gpu;
use umbrage_papers::gpu_kdtree::{KdMaterial, KdPrimary, KdScenery};
use umbrage_papers::{KdBuilder, KdTracerOptions, KdTraversal, KdTreeOptions};
use umbrage_rays::{Camera, Counts, LightSource, View};
use umbrage_verify::real_scene;

use super::frames::{SCENERY, render, triangle};
use super::support::Mesh;
use super::{Device, Scene, device};

const SIZE: u32 = 128;

/// Prints the tables of `crates/papers/docs/gpu.md`. Run with
/// `UMBRAGE_SCENES=… cargo test --release -p umbrage-verify --test gpu visits -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement"]
fn visits() {
    let Some(mut device) = device() else { return };
    let Device { gpu, frame } = &mut *device;
    let files = ["stanford_bunny.obj", "sibenik.obj", "country_kitchen.glb"].into_iter().filter_map(real_scene);
    for address in files.chain(["demo:hall".into()]) {
        let opened = umbrage::open(&address).unwrap_or_else(|error| panic!("{error}"));
        let address = address.display();
        let (scene, view, light) = made(gpu, &address.to_string(), &opened);
        println!("{address}, {} triangles", scene.mesh.indices.len());
        let scenery = KdScenery { light, ..SCENERY };
        for (name, options) in named() {
            frame.set_options(gpu, options);
            let scenery = KdScenery { bounces: 4, ..scenery };
            render(gpu, frame, &scene, &view, &scenery, &MATERIALS);
            println!("  {name}");
            for (place, work) in frame.tracer().work().iter().enumerate() {
                let kind = if work.is_shadow { "shadows" } else { "rays" };
                println!("    bounce {}: {} {kind}, {}", place / 2, work.visits.rays, per(work.visits));
            }
        }
        frame.set_options(gpu, KdTracerOptions::DEFAULT);
        let [traced, drawn] = [KdPrimary::Traced, KdPrimary::Rasterised].map(|primary| {
            let view = View { width: 512, height: 512, ..view };
            render(gpu, frame, &scene, &view, &KdScenery { primary, ..scenery }, &MATERIALS);
            let undecided = frame.tracer().work()[0].undecided_hits;
            let rays = frame.last_rays().read_rays(gpu).expect("read").len();
            (frame.tracer().read_hits(gpu, rays).expect("read"), undecided)
        });
        let differ = traced.0.iter().zip(&drawn.0).filter(|(traced, drawn)| triangle(traced) != triangle(drawn));
        println!(
            "  of 512² pixels {} show another triangle where rasterised; {} hits were undecided where traced",
            differ.count(),
            traced.1
        );
    }
}

const MATERIALS: [KdMaterial; 1] = [KdMaterial { color: [0.7; 3], mirror: 0.5 }];

/// Single rays and packets as in the paper's second table, and more.
fn named() -> Vec<(&'static str, KdTracerOptions)> {
    let with = |traversal, packet| KdTracerOptions { traversal, packet, counts: true, from_triangles: false };
    vec![
        ("stack", with(KdTraversal::Stack, None)),
        ("restart", with(KdTraversal::Restart, None)),
        ("push-down", with(KdTraversal::PushDown, None)),
        ("short stack of 1", with(KdTraversal::ShortStack(1), None)),
        ("short stack of 3", with(KdTraversal::ShortStack(3), None)),
        ("short stack of 4", with(KdTraversal::ShortStack(4), None)),
        ("packets of 4, restart", with(KdTraversal::Restart, Some(4))),
        ("packets of 4, push-down", with(KdTraversal::PushDown, Some(4))),
        ("packets of 4, short stack of 3", with(KdTraversal::ShortStack(3), Some(4))),
        ("packets of 64, short stack of 3", with(KdTraversal::ShortStack(3), Some(64))),
    ]
}

fn made(gpu: &Gpu, address: &str, opened: &umbrage::Scene) -> (Scene, View, LightSource) {
    let posed = opened.at(0.0).expect("a frame");
    let mesh = Mesh { positions: posed.positions.clone(), indices: posed.mesh.triangles.clone() };
    // Rooms from inside, as in the benchmarks.
    let inside = |eye: [f32; 3], target: [f32; 3], fov_degrees: f32, light: [f32; 3]| {
        let camera = Camera::look_at(eye.into(), target.into(), Vec3::Y, fov_degrees.to_radians());
        (camera, LightSource::Point { position: light.into() })
    };
    let (camera, light) = if address.contains("sibenik") {
        inside([14.0, 6.0, 2.0], [-10.0, 4.0, -1.0], 75.0, [3.0, 8.0, 0.0])
    } else if address.contains("kitchen") {
        inside([1.211, 1.8, 3.85], [0.0, 1.0, -1.0], 60.0, [1.0, 2.6, 1.0])
    } else {
        (posed.camera(1.0), posed.lights[0].source)
    };
    // Costs as in the paper: a test costs as much as a step.
    let mut options = KdTreeOptions { builder: KdBuilder::Binned, ..KdTreeOptions::DEFAULT };
    options.costs.test = options.costs.step;
    let scene = Scene::new(gpu, mesh, options);
    (scene, View { camera, width: SIZE, height: SIZE }, light)
}

fn per(visits: Counts) -> String {
    let [nodes, leaves, tests, restarts] = [visits.nodes, visits.leaves, visits.tests, visits.restarts]
        .map(|count| count as f64 / visits.rays.max(1) as f64);
    format!("{nodes:.1} nodes, {leaves:.1} leaves, {tests:.1} tests, {restarts:.2} restarts")
}
