//! The GPU engine shows the CPU engine's triangles and shadows, pixel for pixel.

use std::sync::{Mutex, OnceLock};

use umbrage::scene::DEMOS;
use umbrage::{Renderer, Scene, Settings};
use umbrage_gpu::{DeviceLimits, Gpu};
use umbrage_verify::real_scene;

/// One for all tests: kernels take seconds to compile on software adapters. `None`, and a line that says so, where there
/// is no adapter.
fn renderer() -> Option<&'static Mutex<Renderer>> {
    static RENDERER: OnceLock<Option<Mutex<Renderer>>> = OnceLock::new();
    RENDERER
        .get_or_init(|| match Gpu::open("", DeviceLimits::Portable) {
            Ok(gpu) => Some(Mutex::new(Renderer::with_gpu(gpu).expect("fixed tables"))),
            Err(error) => {
                eprintln!("skipped-gpu: {error}");
                None
            }
        })
        .as_ref()
}

/// How many pixels show another triangle, and how many bits of light masks are others.
fn differences(name: &str, gpu: &mut Renderer, scene: &Scene, moment: f64, [width, height]: [u32; 2]) -> [usize; 2] {
    let seconds = moment * scene.duration_seconds();
    let settings = Settings { width, height, ..Settings::default() };
    let mut cpu = Renderer::default();
    cpu.render(scene, seconds, &settings).unwrap_or_else(|error| panic!("{name}: {error}"));
    let start = std::time::Instant::now();
    gpu.render(scene, seconds, &settings).unwrap_or_else(|error| panic!("{name}: {error}"));
    let elapsed = start.elapsed();
    let pixels = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let triangles = pixels()
        .filter(|&(x, y)| {
            let is_other = cpu.seen().triangle_at(x, y) != gpu.seen().triangle_at(x, y);
            if is_other {
                println!("{name}: ({x}, {y}) {} {}", cpu.seen().triangle_at(x, y), gpu.seen().triangle_at(x, y));
            }
            is_other
        })
        .count();
    let lights = cpu.light_masks().iter().zip(gpu.light_masks());
    let shadows = lights.map(|(cpu, gpu)| pixels().filter(|&(x, y)| cpu.is_lit(x, y) != gpu.is_lit(x, y)).count());
    let shadows = shadows.sum();
    let (film, truth) = (
        gpu.render(scene, seconds, &settings).expect("a frame").develop(&settings),
        cpu.render(scene, seconds, &settings).expect("a frame").develop(&settings),
    );
    let off = film
        .pixels
        .iter()
        .zip(&truth.pixels)
        .filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 300))
        .count();
    println!(
        "{name}: {triangles} of {} triangles and {shadows} shadows differ; {off} colours; {elapsed:?}",
        width * height
    );
    println!(
        "{name}: {}",
        gpu.stats().stages.iter().map(|s| format!("{} {:.1}", s.name, s.milliseconds)).collect::<Vec<_>>().join(", ")
    );
    [triangles, shadows]
}

#[test]
fn gallery_scenes() {
    let Some(renderer) = renderer() else { return };
    let mut renderer = renderer.lock().expect("no other test has failed");
    for demo in DEMOS.iter().filter(|d| std::env::var("ONLY").map_or(true, |o| o == d.name)) {
        let scene = Scene::open(format!("demo:{}?triangles=5000", demo.name)).expect("a scene of the gallery");
        let differences = differences(demo.name, &mut renderer, &scene, 0.4, [150, 70]);
        assert_eq!(differences, [0, 0], "{}", demo.name);
    }
}

#[test]
fn real_scenes() {
    let Some(renderer) = renderer() else { return };
    let mut renderer = renderer.lock().expect("no other test has failed");
    let names = [
        "cesium_man.glb",
        "robot_expressive.glb",
        "robot_arm.glb",
        "tree_alphamask.glb",
        "vintage_fan.glb",
        "elephant_gallop.glb",
        "horse_gallop_obj_sequence",
        "stanford_bunny.obj",
        "sibenik.obj",
        "chess_board.glb",
        "dispersion_test.glb",
        "country_kitchen.glb",
        "dream_apartment.glb",
    ];
    for name in names {
        if let Some(path) = real_scene(name) {
            let scene = Scene::open(&path).unwrap_or_else(|error| panic!("{error}"));
            for moment in [0.0, 0.3] {
                differences(name, &mut renderer, &scene, moment, [250, 130]);
            }
        }
    }
}
