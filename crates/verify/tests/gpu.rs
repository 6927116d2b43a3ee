//! The GPU's grids show the CPU's triangles and shadows, pixel for pixel.

use glam::DVec2;
use umbrage::rays::View;
use umbrage::scene::DEMOS;
use umbrage::{Renderer, Scene, Settings};
use umbrage_gpu::{CameraGrid, CameraOptions, DeviceLimits, Geometry, Gpu, Recorder};
use umbrage_verify::real_scene;

fn gpu() -> Option<Gpu> {
    match Gpu::open("", DeviceLimits::Portable) {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            eprintln!("skipped: {error}");
            None
        }
    }
}

fn check(gpu: &Gpu, grid: &mut CameraGrid, name: &str, scene: &Scene, moment: f64, size: [u32; 2]) {
    let seconds = moment * scene.duration_seconds();
    let [width, height] = size;
    let settings = Settings { width, height, ..Settings::default() };
    let mut renderer = Renderer::default();
    renderer.render(scene, seconds, &settings).expect("a frame");
    let frame = renderer.frame();
    if frame.materials.materials.iter().any(|m| m.alpha != umbrage::scene::Alpha::Opaque) {
        println!("{name}: masked");
        return;
    }
    let view = View { camera: frame.camera(width as f32 / height as f32), width, height };
    let mut geometry = Geometry::new(gpu);
    geometry.write(gpu, frame.triangles(), |_| 0).expect("room");
    loop {
        let start = std::time::Instant::now();
        grid.prepare(gpu, &geometry, &view, DVec2::splat(0.5)).expect("room");
        let mut recorder = Recorder::new(gpu);
        grid.record(gpu, &mut recorder, &geometry);
        let times = recorder.submit()().expect("a frame");
        let fits = grid.finish(gpu).expect("a frame");
        let text: Vec<_> = times.iter().map(|t| format!("{} {:.2}", t.name, t.milliseconds)).collect();
        println!(
            "{name}: {} triangles {:?} {:?} {}",
            frame.triangles().len(),
            grid.work(),
            start.elapsed(),
            text.join(" ")
        );
        if fits {
            break;
        }
    }
    let order = renderer.seen().order();
    let seen: Vec<u32> = grid.seen().read(gpu, order.places()).expect("a frame");
    let mut different = 0;
    for y in 0..height {
        for x in 0..width {
            let (cpu, gpu) = (renderer.seen().triangle_at(x, y), seen[order.place(x, y)]);
            if cpu != gpu {
                different += 1;
                if different < 5 {
                    println!("{name}: pixel ({x}, {y}): {cpu} on the CPU, {gpu} on the GPU");
                }
            }
        }
    }
    println!("{name}: {different} pixels differ");
}

#[test]
fn gallery_scenes() {
    let Some(gpu) = gpu() else { return };
    let mut grid = CameraGrid::new(&gpu, CameraOptions::default());
    for demo in DEMOS {
        let scene = Scene::open(format!("demo:{}?triangles=5000", demo.name)).expect("a scene of the gallery");
        check(&gpu, &mut grid, demo.name, &scene, 0.4, [150, 70]);
    }
    for name in ["cesium_man.glb", "robot_arm.glb", "elephant_gallop.glb", "sibenik.obj", "stanford_bunny.obj"] {
        if let Some(path) = real_scene(name) {
            let scene = Scene::open(&path).unwrap_or_else(|error| panic!("{error}"));
            check(&gpu, &mut grid, name, &scene, 0.3, [512, 512]);
        }
    }
}
