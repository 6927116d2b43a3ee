//! The GPU engine shows the CPU engine's triangles and shadows, pixel for pixel, and pictures that agree.

use std::path::PathBuf;

use umbrage::gallery::DEMOS;
use umbrage::scene::{Light, Scene};
use umbrage::{Film, Renderer, Settings, Structure};
use umbrage_papers::Listed;
use umbrage_verify::{Differences, real_scene};

use crate::common::{renderer, small_renderer};

pub(crate) fn compare(name: &str, gpu: &mut Renderer, scene: &Scene, moment: f64, settings: &Settings) -> Differences {
    let seconds = moment * scene.duration_seconds();
    let mut cpu = Renderer::default();
    for renderer in [&mut cpu, gpu] {
        renderer.render(scene, seconds, settings).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
    Differences::between(&cpu, gpu, settings)
}

pub(crate) fn sized(width: u32, height: u32) -> Settings {
    Settings { width, height, ..Settings::default() }
}

#[test]
fn gallery_scenes() {
    let Some(mut gpu) = renderer() else { return };
    for demo in DEMOS {
        let scene = umbrage::open(format!("demo:{}?triangles=5000", demo.name)).expect("a scene of the gallery");
        for moment in [0.0, 0.6] {
            compare(demo.name, &mut gpu, &scene, moment, &sized(100, 60)).expect_none(demo.name);
        }
    }
}

#[test]
fn small_scenes_of_every_kind() {
    let Some(mut gpu) = renderer() else { return };
    let Some(folder) = real_scene("conformance") else { return };
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let in_folders = entries.flat_map(|path| match std::fs::read_dir(&path) {
        Ok(entries) => entries.map(|entry| entry.expect("an entry").path()).collect(),
        Err(_) => vec![path],
    });
    let is_scene = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "glb" || extension == "gltf");
    let mut scenes: Vec<_> = in_folders.filter(is_scene).collect();
    scenes.sort();
    for path in scenes {
        let scene = umbrage::open(&path).unwrap_or_else(|error| panic!("{error}"));
        for moment in [0.0, 0.6] {
            let name = path.display().to_string();
            compare(&name, &mut gpu, &scene, moment, &sized(90, 60)).expect_none(&name);
        }
    }
}

#[test]
fn lights_without_shadows_reach_everything() {
    let scene = umbrage::open("demo:hall?triangles=3000").expect("a scene of the gallery");
    let own = scene.at(0.0).expect("a frame").lights;
    let lights: Vec<_> =
        own.iter().zip(0..).map(|(light, number)| Light { casts_shadow: number == 1, ..light.clone() }).collect();
    let settings = Settings { lights: Some(lights), ..sized(90, 60) };
    for structure in [Structure::default(), Structure::of::<Listed>(), Structure::bvh()] {
        let settings = Settings { structure, ..settings.clone() };
        let mut cpu = Renderer::default();
        cpu.render(&scene, 0.0, &settings).expect("a frame");
        let pixels = || (0..60).flat_map(|y| (0..90).map(move |x| (x, y)));
        let shown = pixels().filter(|&(x, y)| cpu.seen().triangle_at(x, y) != Film::NO_TRIANGLE).count();
        let lit = cpu.light_masks().iter().map(|mask| pixels().filter(|&(x, y)| mask.is_lit(x, y)).count());
        let lit: Vec<usize> = lit.collect();
        assert!(lit[0] == shown && lit[1] < shown && lit[2] == shown, "{lit:?} of {shown}");
        assert_eq!(cpu.stats().shadow_rays, shown as u64);
    }
    let Some(mut gpu) = renderer() else { return };
    compare("no shadows", &mut gpu, &scene, 0.0, &settings).expect_none("no shadows");
}

#[test]
fn an_empty_scene_shows_its_surroundings() {
    let Some(mut gpu) = renderer() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("nothing.obj");
    std::fs::write(&path, "# nothing\n").expect("a file");
    let scene = umbrage::open(&path).expect("a scene");
    compare("nothing", &mut gpu, &scene, 0.0, &sized(70, 40)).expect_none("nothing");
}

#[test]
fn too_large_a_scene_is_an_error() {
    let Some(mut gpu) = small_renderer() else { return };
    let scene = umbrage::open("demo:cloth?triangles=200000").expect("a scene of the gallery");
    let error = gpu.render(&scene, 0.0, &sized(64, 64)).expect_err("too large").to_string();
    assert!(error.contains(" needs ") && error.ends_with("this GPU allows 1048576"), "{error}");
}

#[test]
fn comparisons_fail_where_they_should() {
    let scene = umbrage::open("demo:cloth?triangles=2000").expect("a scene of the gallery");
    let settings = sized(60, 40);
    let [mut one, mut other] = [Renderer::default(), Renderer::default()];
    one.render(&scene, 0.0, &settings).expect("a frame");
    other.render(&scene, 0.1, &settings).expect("a frame");
    let Differences { triangles, shadows, colors, .. } = Differences::between(&one, &other, &settings);
    assert!(triangles > 0 && shadows > 0 && colors > 0);
}
