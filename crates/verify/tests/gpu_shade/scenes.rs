//! The gallery and real scenes.

use std::path::{Path, PathBuf};

use umbrage::scene::DEMOS;
use umbrage::{Scene, Settings};
use umbrage_verify::real_scene;

use crate::compare::{render, trial};

#[test]
fn the_gallery_looks_the_same() {
    let Some(mut trial) = trial() else { return };
    for demo in DEMOS {
        let scene = Scene::open(format!("demo:{}?triangles=20000", demo.name)).expect("a scene of the gallery");
        let settings = Settings { width: 250, height: 170, ..Settings::default() };
        let (_, difference) = render(&mut trial, &scene, 0.4 * scene.duration_seconds(), &settings);
        difference.expect_alike(demo.name);
    }
}

#[test]
fn real_scenes_look_the_same() {
    let Some(mut trial) = trial() else { return };
    let names = [
        "sibenik.obj",
        "stanford_bunny.obj",
        "country_kitchen.glb",
        "dream_apartment.glb",
        "issum.glb",
        "chess_board.glb",
        "elephant_gallop.glb",
        "horse_gallop_obj_sequence",
        "robot_arm.glb",
        "vintage_fan.glb",
        "robot_expressive.glb",
        "cesium_man.glb",
        "dispersion_test.glb",
        "tree_alphamask.glb",
    ];
    let conformance = real_scene("conformance").map(|folder| files_in(&folder)).unwrap_or_default();
    for path in names.into_iter().filter_map(real_scene).chain(conformance) {
        let scene = Scene::open(&path).unwrap_or_else(|error| panic!("{error}"));
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        for (part, side) in [(0.0, 150), (0.37, 120)] {
            let settings = Settings { width: side, height: side, ..Settings::default() };
            let (_, difference) = render(&mut trial, &scene, part * scene.duration_seconds(), &settings);
            difference.expect_alike(&format!("{name} at {part}"));
        }
    }
}

fn files_in(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a readable folder").flatten() {
        let path = entry.path();
        let is_scene = path.extension().is_some_and(|extension| extension == "glb" || extension == "gltf");
        match path.is_dir() {
            true => found.extend(files_in(&path)),
            false if is_scene => found.push(path),
            false => {}
        }
    }
    found.sort();
    found
}
