//! More frames of the GPU engine.

use glam::Vec3;
use umbrage::gallery::DEMOS;
use umbrage::rays::{Camera, LightSource, Projection};
use umbrage::scene::{Ground, GroundSurface, Light, LightShape};
use umbrage::{Background, Settings, Structure};
use umbrage_verify::real_scene;

use crate::common::{renderer, small_renderer};
use crate::frames::{compare, sized};

#[test]
fn real_scenes() {
    let Some(mut gpu) = renderer() else { return };
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
        "issum.glb",
        "chess_board.glb",
        "dispersion_test.glb",
        "country_kitchen.glb",
        "dream_apartment.glb",
    ];
    for name in names {
        if let Some(path) = real_scene(name) {
            let scene = umbrage::open(&path).unwrap_or_else(|error| panic!("{error}"));
            compare(name, &mut gpu, &scene, 0.3, &sized(250, 130)).expect_none(name);
        }
    }
}

#[test]
fn seven_million_triangles() {
    let Some(mut gpu) = renderer() else { return };
    let Some(path) = real_scene("teapots_galore/TeapotsGalore.gltf") else { return };
    let scene = umbrage::open(&path).unwrap_or_else(|error| panic!("{error}"));
    compare("teapots", &mut gpu, &scene, 0.0, &sized(130, 70)).expect_none("teapots");
}

#[test]
fn samples_back_faces_and_parallel_views() {
    let Some(mut gpu) = renderer() else { return };
    let scene = umbrage::open("demo:shatter?triangles=3000").expect("a scene of the gallery");
    let camera = scene.at(0.5).expect("a frame").framing_camera(1.5);
    let parallel = Camera { projection: Projection::Orthographic { half_height: 1.5 }, ..camera };
    for (name, settings) in [
        ("three samples", Settings { samples: 3, ..sized(90, 60) }),
        ("front faces alone", Settings { sides: umbrage::Sides::Front, ..sized(90, 60) }),
        ("a parallel view", Settings { camera: parallel.into(), ..sized(90, 60) }),
        ("one pixel", sized(1, 1)),
        ("one row", sized(131, 1)),
    ] {
        compare(name, &mut gpu, &scene, 0.5, &settings).expect_none(name);
    }
}

#[test]
fn points_of_a_lens_of_time_of_lights_and_of_the_sky() {
    let Some(mut gpu) = renderer() else { return };
    let source = LightSource::to_one_side(Vec3::new(0.4, 2.5, 1.0), Vec3::new(-0.6, -0.8, 0.0));
    let panels = [LightShape::Rectangle { width: 1.5, height: 0.5 }, LightShape::Disk(0.5)]
        .map(|shape| Light { shape, ..light(source) })
        .to_vec();
    for name in ["demo:cloth?triangles=3000", "demo:hall?triangles=3000"] {
        let scene = umbrage::open(name).expect("a scene of the gallery");
        let sharp = Settings { samples: 3, ..sized(90, 60) };
        for settings in [
            Settings { aperture: 0.3, ..sharp.clone() },
            Settings { light_radius: 0.5, ..sharp.clone() },
            Settings { lights: Some(panels.clone()), ..sharp.clone() },
            Settings { lights: Some(panels.clone()), samples: 1, ..sharp.clone() },
            Settings { shutter_seconds: 0.1, ..sharp.clone() },
            Settings { sky_shadows: true, ..sharp.clone() },
            Settings { aperture: 0.2, focus: Some(1.0), light_radius: 0.5, shutter_seconds: 0.1, ..sharp },
        ] {
            compare(name, &mut gpu, &scene, 0.5, &settings).expect_none(name);
        }
    }
}

#[test]
fn grounds_under_what_moves_and_what_doesnt() {
    let Some(mut gpu) = renderer() else { return };
    for name in ["demo:marbles?triangles=3000", "demo:glass?triangles=600"] {
        let mut scene = umbrage::open(name).expect("a scene of the gallery");
        for surface in [GroundSurface::Shadow, GroundSurface::Matte] {
            scene.set_ground(Some(Ground { surface, height: None }));
            for background in [Background::Sky, Background::Transparent] {
                let settings = Settings { background, ..sized(90, 60) };
                compare(name, &mut gpu, &scene, 0.5, &settings).expect_none(name);
            }
        }
        let settings = Settings { samples: 3, sky_shadows: true, ..sized(90, 60) };
        compare(name, &mut gpu, &scene, 0.5, &settings).expect_none(name);
    }
}

/// The first attempt has too little room for the camera's lists, so it has no points: lights mustn't make room for them.
#[test]
fn large_pictures() {
    let Some(mut gpu) = renderer() else { return };
    let scene = umbrage::open("demo:hall").expect("a scene of the gallery");
    compare("hall", &mut gpu, &scene, 0.0, &sized(320, 320)).expect_none("hall");
    let bytes = gpu.stats().structure_bytes;
    assert!(bytes < 48 << 20, "{bytes} bytes");
    compare("hall", &mut gpu, &scene, 0.4, &sized(1024, 1024)).expect_none("hall");
    let scene = umbrage::open("demo:cloth").expect("a scene of the gallery");
    compare("cloth", &mut gpu, &scene, 0.4, &sized(640, 640)).expect_none("cloth");
}

#[test]
fn grids_are_cut_into_the_cells_that_are_asked_for() {
    let scene = umbrage::open("demo:hall?triangles=3000").expect("a scene of the gallery");
    let Some(mut gpu) = renderer() else { return };
    for options in ["sorting-tile=8", "slices=1", "sorting-tile=8,tracing-tiles=2,slices=32", "light-slices=8"] {
        let settings = Settings { structure: listed(options), ..sized(90, 60) };
        compare(options, &mut gpu, &scene, 0.0, &settings).expect_none(options);
    }
    for options in ["sorting-tile=64", "tracing-tiles=2", "whole-tiles=true", "light-cells=64"] {
        let settings = Settings { structure: listed(options), ..sized(20, 20) };
        assert!(gpu.render(&scene, 0.0, &settings).is_err_and(|error| error.is_of_settings()), "{options}");
    }
}

fn listed(options: &str) -> Structure {
    umbrage_papers::structures().parse(&format!("listed:{options}")).expect("a structure")
}

fn light(source: LightSource) -> Light {
    Light::new(source, 20.0)
}

#[test]
fn lights_that_see_by_angles() {
    let Some(mut gpu) = renderer() else { return };
    for demo in DEMOS {
        let scene = umbrage::open(format!("demo:{}?triangles=5000", demo.name)).expect("a scene of the gallery");
        let settings = Settings { structure: listed("light-map=spherical"), ..sized(150, 70) };
        compare(demo.name, &mut gpu, &scene, 0.6, &settings).expect_none(demo.name);
    }
    for name in ["tree_alphamask.glb", "cesium_man.glb", "sibenik.obj"] {
        if let Some(path) = real_scene(name) {
            let scene = umbrage::open(&path).unwrap_or_else(|error| panic!("{error}"));
            let settings = Settings { structure: listed("light-map=spherical"), ..sized(150, 100) };
            compare(name, &mut gpu, &scene, 0.3, &settings).expect_none(name);
        }
    }
}

#[test]
fn lights_that_see_by_angles_in_the_middle_of_a_hall() {
    let Some(mut gpu) = renderer() else { return };
    let scene = umbrage::open("demo:hall?triangles=5000").expect("a scene of the gallery");
    let positions = scene.at(0.0).expect("a frame").positions;
    let low = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let middle = low.lerp(high, 0.5);
    let direction = Vec3::new(0.3, -1.0, 0.2);
    let lights = vec![
        light(LightSource::Point { position: middle }),
        light(LightSource::Point { position: low.lerp(high, 0.3) }),
        light(LightSource::Spot { position: middle, direction, inner_radians: 0.5, outer_radians: 0.9 }),
        light(LightSource::Directional { direction }),
    ];
    for options in ["light-map=spherical", "light-map=spherical,light-clamp=-40:20:5:170,sorting-tile=8"] {
        for samples in [1, 2] {
            let structure = listed(options);
            let settings = Settings { structure, lights: Some(lights.clone()), samples, ..sized(90, 60) };
            compare(options, &mut gpu, &scene, 0.3, &settings).expect_none(options);
        }
    }
}

#[test]
fn large_images_are_rendered_in_bands() {
    // 200 columns make 256 · 48 bytes for each row: bands of 64 rows.
    let Some(mut gpu) = small_renderer() else { return };
    for name in ["shatter", "glass"] {
        let scene = umbrage::open(format!("demo:{name}?triangles=2000")).expect("a scene of the gallery");
        let settings = Settings { samples: 2, ..sized(200, 150) };
        compare(name, &mut gpu, &scene, 0.3, &settings).expect_none(name);
    }
}
