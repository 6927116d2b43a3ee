//! Reflections in mirrors on a GPU are those of the CPU.

use std::sync::Arc;

use glam::{Vec3, Vec4};
use umbrage::rays::Camera;
use umbrage::scene::{Alpha, Clearcoat, Frame, Ground, GroundSurface, Layers, Material};
use umbrage::{Background, Error, Renderer, Settings, Structure};
use umbrage_papers::KdTrees;
use umbrage_verify::{Differences, real_scene};

use crate::common::{renderer, small_renderer};
use crate::frames::{self, sized};

/// A moment of a scene of the gallery, with some of its materials changed.
fn frame(name: &str, change: impl Fn(usize, &mut Material)) -> Frame {
    let scene = umbrage::open(name).expect("a scene of the gallery");
    let mut frame = scene.at(0.4 * scene.duration_seconds()).expect("a frame");
    let materials = &mut Arc::make_mut(&mut frame.materials).materials;
    materials.iter_mut().enumerate().for_each(|(index, material)| change(index, material));
    frame
}

/// A frame with every other material a coloured mirror.
fn polished(name: &str) -> Frame {
    frame(name, |index, material| {
        if index % 2 == 0 {
            (material.metallic, material.roughness) = (1.0, 0.0);
        }
    })
}

/// Compares both engines' pictures; by mirrors, rounding may lead to the neighbouring triangle. Returns the number of
/// pixels that mirrors change.
fn compare(name: &str, gpu: &mut Renderer, frame: &Frame, settings: &Settings) -> usize {
    let mut cpu = Renderer::default();
    let without = Settings { bounces: 0, ambient_occlusion: 0.0, ..settings.clone() };
    let plain = cpu.render_frame(frame, &without).expect("a picture").clone();
    for renderer in [&mut cpu, gpu] {
        renderer.render_frame(frame, settings).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
    let differences = Differences::between(&cpu, gpu, settings);
    println!("{name}: {differences:?}");
    assert_eq!((differences.triangles, differences.shadows), (0, 0), "{name}: {differences:?}");
    assert!(differences.colors <= differences.pixels / 1000, "{name}: {differences:?}");
    let is_other = |(one, other): &(&Vec4, &Vec4)| one.distance(**other) > 0.01;
    plain.color.iter().zip(&cpu.film().color).filter(is_other).count()
}

#[test]
fn mirrors_in_mirrors() {
    let Some(mut gpu) = renderer() else { return };
    for name in ["demo:marbles?triangles=3000", "demo:hall?triangles=3000", "demo:gears?triangles=3000"] {
        let frame = polished(name);
        for bounces in [1, 4] {
            assert!(compare(name, &mut gpu, &frame, &Settings { bounces, ..sized(150, 90) }) > 0);
        }
        let settings = Settings { bounces: 2, background: Background::Transparent, samples: 3, ..sized(90, 60) };
        assert!(compare(name, &mut gpu, &frame, &settings) > 0);
        assert!(compare(name, &mut gpu, &frame, &Settings { sky_shadows: true, aperture: 0.1, ..settings }) > 0);
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
        assert!(compare("lacquer", &mut gpu, &frame, &Settings { bounces, ..sized(150, 90) }) > 0);
    }
}

#[test]
fn glass_and_what_is_behind() {
    let Some(mut gpu) = renderer() else { return };
    let frame = frame("demo:glass?triangles=600", |_, _| {});
    for bounces in [1, 2, 5] {
        assert!(compare("glass", &mut gpu, &frame, &Settings { bounces, ..sized(150, 90) }) > 0);
    }
}

#[test]
fn real_scenes_with_glass() {
    let Some(mut gpu) = renderer() else { return };
    let mut shown = 0;
    for name in [
        "dispersion_test.glb",
        "chess_board.glb",
        "country_kitchen.glb",
        "issum.glb",
        "vintage_fan.glb",
        "robot_arm.glb",
    ] {
        let Some(path) = real_scene(name) else { continue };
        let scene = umbrage::open(&path).unwrap_or_else(|error| panic!("{error}"));
        let frame = scene.at(0.3 * scene.duration_seconds()).expect("a frame");
        for (bounces, background) in [(2, Background::Sky), (6, Background::Color(Vec3::new(0.2, 0.4, 0.1)))] {
            let settings = Settings { bounces, background, ..sized(150, 90) };
            shown += compare(name, &mut gpu, &frame, &settings);
        }
    }
    assert!(shown == 0 || shown > 500, "{shown} pixels");
}

#[test]
fn gloss_of_metal_lacquer_and_glass() {
    let Some(mut gpu) = renderer() else { return };
    let settings = Settings { gloss: true, samples: 3, bounces: 3, ..sized(150, 90) };
    for name in ["demo:marbles?triangles=3000", "demo:glass?triangles=600"] {
        assert!(compare(name, &mut gpu, &frame(name, |_, _| {}), &settings) > 0);
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
            assert!(compare(name, &mut gpu, &frame, &settings) > 0);
            assert!(compare(name, &mut gpu, &frame, &Settings { gloss: true, ..settings }) > 0);
        }
    }
}

#[test]
fn colors_that_are_shown_as_they_are() {
    let Some(mut gpu) = renderer() else { return };
    let mut scene = umbrage::open("demo:glass?triangles=600").expect("a scene of the gallery");
    for surface in [GroundSurface::Shadow, GroundSurface::Matte] {
        scene.set_ground(Some(Ground { surface, height: None }));
        let mut frame = scene.at(0.0).expect("a frame");
        let materials = &mut Arc::make_mut(&mut frame.materials).materials;
        materials[0].unlit = true;
        (materials[1].unlit, materials[1].alpha, materials[1].base_color.w) = (true, Alpha::Blend, 0.4);
        for background in [Background::Color(Vec3::new(0.3, 0.2, 0.7)), Background::Transparent] {
            let settings = Settings { background, bounces: 2, exposure_stops: 1.0, ..sized(150, 90) };
            assert!(compare("unlit", &mut gpu, &frame, &settings) > 0);
            let settings = Settings { ambient_occlusion: 0.5, samples: 2, bounces: 0, ..settings };
            assert!(compare("unlit", &mut gpu, &frame, &settings) > 0);
        }
    }
}

#[test]
fn moving_scenes_bands_and_the_tree() {
    let Some(mut gpu) = small_renderer() else { return };
    let scene = umbrage::open("demo:glass?triangles=600").expect("a scene of the gallery");
    let settings = Settings { bounces: 2, samples: 2, gloss: true, ambient_occlusion: 0.5, ..sized(60, 50) };
    for moment in [0.0, 0.5] {
        frames::compare("bands", &mut gpu, &scene, moment, &settings).expect_none("bands");
    }
    drop(gpu);
    let Some(mut gpu) = renderer() else { return };
    let settings = Settings { structure: Structure::of::<KdTrees>(), ..settings };
    frames::compare("kd-tree", &mut gpu, &scene, 0.5, &settings).expect_none("kd-tree");
    let Some(path) = real_scene("cesium_man.glb") else { return };
    let mut scene = umbrage::open(&path).unwrap_or_else(|error| panic!("{error}"));
    scene.set_ground(Some(Ground { surface: GroundSurface::Matte, height: None }));
    for (bounces, moment) in [(0, 0.2), (1, 0.4), (0, 0.6)] {
        let settings = Settings { bounces, structure: Structure::default(), ..settings.clone() };
        frames::compare("a rig", &mut gpu, &scene, moment, &settings).expect_none("a rig");
    }
}

#[test]
fn nothing_much_to_follow() {
    let Some(mut gpu) = renderer() else { return };
    let material = Material { metallic: 1.0, roughness: 0.0, ..Material::clay() };
    let glass = Material { transmission: 1.0, metallic: 0.0, ..material.clone() };
    let far = [f32::NAN, 0.0, 0.0].into();
    let soups: [&[Vec3]; 4] = [
        &[],
        &[Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)],
        // Two in one plane, one behind the camera, one through it, and one without an area.
        &[
            Vec3::new(-9.0, -9.0, 0.0),
            Vec3::new(9.0, -9.0, 0.0),
            Vec3::new(0.0, 9.0, 0.0),
            Vec3::new(-9.0, -9.0, 0.0),
            Vec3::new(9.0, -9.0, 0.0),
            Vec3::new(0.0, 9.0, 0.0),
            Vec3::new(-1.0, -1.0, 9.0),
            Vec3::new(1.0, -1.0, 9.0),
            Vec3::new(0.0, 1.0, 9.0),
            Vec3::new(-1.0, -0.5, -9.0),
            Vec3::new(1.0, -0.5, 9.0),
            Vec3::new(0.0, -0.5, 30.0),
            far,
            Vec3::ONE,
            Vec3::ZERO,
        ],
        &[far, far, far],
    ];
    let mut cpu = Renderer::default();
    for positions in soups {
        for material in [&material, &glass] {
            let triangles = (0..positions.len() as u32 / 3).map(|id| [3 * id, 3 * id + 1, 3 * id + 2]).collect();
            let mut frame = Frame::from_triangles(positions.to_vec(), triangles);
            Arc::make_mut(&mut frame.materials).materials[0] = material.clone();
            let camera = Camera::look_at(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, Vec3::Y, 0.8).into();
            let settings =
                Settings { bounces: 3, gloss: true, ambient_occlusion: 1.0, samples: 2, camera, ..sized(40, 30) };
            for renderer in [&mut cpu, &mut *gpu] {
                renderer.render_frame(&frame, &settings).unwrap_or_else(|error| panic!("{error}"));
            }
            Differences::between(&cpu, &gpu, &settings).expect_none("soup");
        }
    }
}

#[test]
fn as_many_samples_as_noise_takes() {
    let Some(mut gpu) = renderer() else { return };
    let scene = umbrage::open("demo:marbles?triangles=300").expect("a scene of the gallery");
    let settings = Settings { samples: 64, noise: 12.0, light_radius: 0.3, ..sized(40, 30) };
    frames::compare("noise", &mut gpu, &scene, 0.0, &settings).expect_none("noise");
    let mut cpu = Renderer::default();
    cpu.render(&scene, 0.0, &settings).expect("a picture");
    let taken = [&cpu, &gpu].map(|renderer| renderer.stats().samples);
    assert!(taken[0] == taken[1] && taken[0] < 64, "{taken:?}");
    let Some(mut gpu) = small_renderer() else { return };
    let error = gpu.render(&scene, 0.0, &Settings { width: 300, height: 200, ..settings });
    assert!(matches!(error, Err(Error::NoiseInBands)));
}

#[test]
fn layers_are_those_of_the_cpu() {
    let Some(mut gpu) = renderer() else { return };
    for (name, moment) in [("demo:marbles?triangles=3000", 0.2), ("demo:glass?triangles=600", 0.0)] {
        let scene = umbrage::open(name).expect("a scene of the gallery");
        let settings = Settings { layers: umbrage::Layers::all(), motion_seconds: 0.1, samples: 3, ..sized(90, 60) };
        let mut cpu = Renderer::default();
        frames::compare(name, &mut gpu, &scene, moment, &settings).expect_none(name);
        cpu.render(&scene, moment * scene.duration_seconds(), &settings).expect("a picture");
        let [one, other] = [&cpu, &*gpu].map(|renderer| format!("{:?}", renderer.film().layers));
        assert!(one == other && one.len() > 10_000, "{name}");
    }
}
