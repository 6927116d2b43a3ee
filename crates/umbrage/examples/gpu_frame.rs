//! A frame on a GPU, through wgpu.
//!
//! `cargo run --release --example gpu_frame`

use std::error::Error;

use umbrage::gpu::{Adapter, DeviceLimits, Gpu};
use umbrage::output::{BitDepth, write_png};
use umbrage::{Film, Renderer, Settings};

fn main() -> Result<(), Box<dyn Error>> {
    if Adapter::all().is_empty() {
        println!("there is no GPU here, nor a driver that stands in for one");
        return Ok(());
    }
    // The first adapter; a part of its name chooses another.
    let gpu = Gpu::open("", DeviceLimits::Adapter)?;
    println!("on {}", gpu.adapter().name);

    let scene = umbrage::open("demo:cloth?triangles=5000")?;
    let settings = Settings { width: 320, height: 180, ..Settings::default() };
    let mut renderer = Renderer::with_gpu(gpu)?;
    // `render_to_texture` leaves the picture on the device instead.
    let film = renderer.render(&scene, 0.5, &settings)?;
    let shown = film.triangle.iter().filter(|&&triangle| triangle != Film::NO_TRIANGLE).count();
    println!("{shown} of {} pixels show a triangle", film.triangle.len());
    let path = std::env::temp_dir().join("umbrage-gpu-frame.png");
    write_png(&film.develop(&settings), &path, BitDepth::Eight)?;
    println!("{}", path.display());
    for stage in &renderer.stats().stages {
        println!("{:<12} {:8.3} ms", stage.name, stage.milliseconds);
    }
    Ok(())
}
