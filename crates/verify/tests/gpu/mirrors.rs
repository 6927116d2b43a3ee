//! What is seen in mirrors on a GPU is what the CPU sees in them.

use std::sync::Arc;

use glam::{Vec3, Vec4};
use umbrage::scene::{Clearcoat, Frame, Layers, Material};
use umbrage::{Background, Renderer, Settings};
use umbrage_verify::{Differences, real_scene};

use crate::common::renderer;
use crate::frames::sized;

/// A moment of a scene of the gallery, with some of its materials changed.
fn frame(name: &str, change: impl Fn(usize, &mut Material)) -> Frame {
    let scene = umbrage::open(name).expect("a scene of the gallery");
    let mut frame = scene.at(0.4 * scene.duration_seconds()).expect("a frame");
    let materials = &mut Arc::make_mut(&mut frame.materials).materials;
    materials.iter_mut().enumerate().for_each(|(index, material)| change(index, material));
    frame
}

/// Every other material is a mirror, in a colour.
fn polished(name: &str) -> Frame {
    frame(name, |index, material| {
        if index % 2 == 0 {
            (material.metallic, material.roughness) = (1.0, 0.0);
        }
    })
}

/// Compares both engines' pictures, in which mirrors show something; by mirrors, rounding may lead to the triangle beside.
fn compare(name: &str, gpu: &mut Renderer, frame: &Frame, settings: &Settings) {
    let mut cpu = Renderer::default();
    let without = Settings { bounces: 0, ambient_occlusion: 0.0, ..settings.clone() };
    let plain = cpu.render_frame(frame, &without).expect("a picture").clone();
    for renderer in [&mut cpu, &mut *gpu] {
        renderer.render_frame(frame, settings).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
    let differences = Differences::between(&cpu, gpu, settings);
    println!("{name}: {differences:?}");
    println!(
        "film {}",
        cpu.film().color.iter().zip(&gpu.film().color).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max)
    );
    if std::env::var("X").is_ok() {
        return;
    }
    assert_eq!((differences.triangles, differences.shadows), (0, 0), "{name}: {differences:?}");
    assert!(differences.colors <= differences.pixels / 1000, "{name}: {differences:?}");
    let is_other = |(one, other): &(&Vec4, &Vec4)| one.distance(**other) > 0.01;
    let shown = plain.color.iter().zip(&cpu.film().color).filter(is_other).count();
    assert!(shown > differences.pixels / 50, "{name}: mirrors show something in {shown} pixels");
}

#[test]
fn mirrors_in_mirrors() {
    let Some(mut gpu) = renderer() else { return };
    for name in ["demo:marbles?triangles=3000", "demo:hall?triangles=3000", "demo:gears?triangles=3000"] {
        let frame = polished(name);
        for bounces in [1, 4] {
            compare(name, &mut gpu, &frame, &Settings { bounces, ..sized(150, 90) });
        }
        let settings = Settings { bounces: 2, background: Background::Transparent, samples: 3, ..sized(90, 60) };
        compare(name, &mut gpu, &frame, &settings);
        compare(name, &mut gpu, &frame, &Settings { sky_shadows: true, aperture: 0.1, ..settings });
    }
}

#[test]
fn lacquer_on_what_is_rough() {
    let Some(mut gpu) = renderer() else { return };
    let frame = frame("demo:marbles?triangles=3000", |index, material| {
        let clearcoat = Clearcoat { factor: 1.0, roughness: 0.0, ..Clearcoat::default() };
        material.layers = Some(Box::new(Layers { clearcoat, ..Layers::default() }));
        if index % 3 == 0 {
            (material.metallic, material.roughness) = (1.0, 0.0);
        }
    });
    for bounces in [1, 3] {
        compare("lacquer", &mut gpu, &frame, &Settings { bounces, ..sized(150, 90) });
    }
}

#[test]
fn glass_and_what_is_behind() {
    let Some(mut gpu) = renderer() else { return };
    let frame = frame("demo:glass?triangles=600", |_, _| {});
    for bounces in [1, 2, 5] {
        compare("glass", &mut gpu, &frame, &Settings { bounces, ..sized(150, 90) });
    }
}

#[test]
fn real_scenes_with_glass() {
    let Some(mut gpu) = renderer() else { return };
    for name in [
        "dispersion_test.glb",
        "chess_board.glb",
        "country_kitchen.glb",
        "dream_apartment.glb",
        "issum.glb",
        "vintage_fan.glb",
        "robot_arm.glb",
    ] {
        let Some(path) = real_scene(name) else { continue };
        let scene = umbrage::open(&path).unwrap_or_else(|error| panic!("{error}"));
        let frame = scene.at(0.3 * scene.duration_seconds()).expect("a frame");
        for (bounces, background) in [(2, Background::Sky), (6, Background::Color(Vec3::new(0.2, 0.4, 0.1)))] {
            let settings = Settings { bounces, background, ..sized(150, 90) };
            compare(name, &mut gpu, &frame, &settings);
        }
    }
}

#[test]
fn gloss_of_metal_lacquer_and_glass() {
    let Some(mut gpu) = renderer() else { return };
    let settings = Settings { gloss: true, samples: 3, bounces: 3, ..sized(150, 90) };
    for name in ["demo:marbles?triangles=3000", "demo:glass?triangles=600"] {
        compare(name, &mut gpu, &frame(name, |_, _| {}), &settings);
    }
}

#[test]
fn light_from_all_around_that_something_near_keeps_away() {
    let Some(mut gpu) = renderer() else { return };
    let settings = Settings { ambient_occlusion: 0.5, samples: 3, ..sized(150, 90) };
    for name in ["demo:marbles?triangles=3000", "demo:glass?triangles=600"] {
        let frame = frame(name, |_, _| {});
        for bounces in [0, 2] {
            let settings = Settings { bounces, ..settings.clone() };
            compare(name, &mut gpu, &frame, &settings);
            compare(name, &mut gpu, &frame, &Settings { gloss: true, ..settings });
        }
    }
}
