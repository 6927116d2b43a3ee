//! Devices that fail in the middle of a render: clear errors, never a hang, and the next frame is right.

use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use umbrage::gpu::{DeviceLimits, GpuError};
use umbrage::scene::Scene;
use umbrage::{Error, Renderer, Settings};

use crate::common::{open, renderer};

/// Far longer than a frame takes on a software adapter, including its kernels' compilation.
const A_HANG: Duration = Duration::from_secs(300);

fn sized(side: u32) -> Settings {
    Settings { width: side, height: side, ..Settings::default() }
}

fn expect_same_triangles(renderer: &mut Renderer, scene: &Scene, settings: &Settings) {
    let mut cpu = Renderer::default();
    for renderer in [&mut cpu, &mut *renderer] {
        renderer.render(scene, 0.0, settings).expect("a frame");
    }
    assert!(cpu.film().triangle == renderer.film().triangle);
}

#[test]
fn a_device_lost_while_frames_are_rendered_is_an_error() {
    let Some(mut others) = renderer() else { return };
    let scene = umbrage::open("demo:shatter?triangles=2000").expect("a scene of the gallery");
    // The first frame compiles the kernels.
    others.render(&scene, 0.0, &sized(96)).expect("a frame");
    let start = Instant::now();
    others.render(&scene, 0.1, &sized(96)).expect("a frame");
    let frame = start.elapsed();
    drop(others);

    // At another moment of a frame each time, while its stages run or are being recorded. Each device compiles all kernels.
    for quarter in [0, 3] {
        let gpu = open(DeviceLimits::Portable).expect("there was one before");
        let mut renderer = Renderer::with_gpu(gpu.clone()).expect("room for fixed tables");
        renderer.render(&scene, 0.0, &sized(96)).expect("a frame");
        let (tell, told) = mpsc::channel();
        let frames = thread::spawn(move || {
            let scene = umbrage::open("demo:shatter?triangles=2000").expect("a scene of the gallery");
            let errors = (0..).find_map(|k| renderer.render(&scene, f64::from(k) * 0.01, &sized(96)).err());
            // It stays lost.
            let again = renderer.render(&scene, 0.0, &sized(96)).err();
            tell.send((errors, again)).expect("someone waits");
        });
        thread::sleep(frame * (4 + quarter) / 4);
        gpu.close();
        let (error, again) = told.recv_timeout(A_HANG).expect("an error in time");
        frames.join().expect("no panic");
        for error in [error, again] {
            let error = error.expect("a lost device");
            assert!(matches!(error, Error::Gpu(GpuError::Lost(_))), "{error:?}");
        }
    }

    // Other devices go on.
    expect_same_triangles(&mut renderer().expect("there was one before"), &scene, &sized(64));
}

#[test]
fn too_little_memory_is_an_error_and_smaller_frames_go_on() {
    let Some(gpu) = open(DeviceLimits::Memory(24 << 20)) else { return };
    let mut renderer = Renderer::with_gpu(gpu).expect("room for fixed tables");
    let scene = umbrage::open("demo:cloth?triangles=3000").expect("a scene of the gallery");
    let large = umbrage::open("demo:cloth?triangles=1000000").expect("a scene of the gallery");
    // Twice, since a failed buffer must not count as present.
    for _ in 0..2 {
        for (scene, settings) in [(&scene, sized(1024)), (&large, sized(64))] {
            let error = renderer.render(scene, 0.0, &settings).map(drop).expect_err("too little memory");
            assert!(matches!(error, Error::Gpu(GpuError::OutOfMemory(_))), "{error:?}");
            println!("{error}");
        }
        expect_same_triangles(&mut renderer, &scene, &sized(64));
    }
}
