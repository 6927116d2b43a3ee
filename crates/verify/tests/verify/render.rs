//! Whole frames: every pixel's triangle and every light's mask are the oracle's, on any number of threads.

use std::path::Path;

use umbrage::rays::predicate::{HitPoint, ShadowRay, crossing};
use umbrage::rays::{self, Hit, Opacity as _, View};
use umbrage::scene::Frame;
use umbrage::{Film, Renderer, Scene, Settings, Sides, Structure};
use umbrage_papers::structures;
use umbrage_verify::{Oracle, real_scene, stops_light};

const SIDE: u32 = 40;

fn settings(structure: Structure) -> Settings {
    Settings { width: SIDE, height: SIDE - 1, structure, ..Settings::default() }
}

/// Compares a frame through every structure with the oracle; returns the number of pixels with a triangle.
fn compare(scene: &Scene, seconds: f64, name: &str) -> usize {
    compare_with(scene, seconds, name, Sides::File)
}

/// Does the same with a choice of sides.
fn compare_with(scene: &Scene, seconds: f64, name: &str, sides: Sides) -> usize {
    let mut truth = None;
    for structure in structures().iter() {
        let settings = Settings { sides, ..settings(structure.clone()) };
        let mut renderer = Renderer::default();
        renderer.render(scene, seconds, &settings).unwrap_or_else(|error| panic!("{name}: {error}"));
        let truth = truth.get_or_insert_with(|| oracle(renderer.frame(), &settings));
        for (pixel, truth) in (0..).zip(&*truth) {
            let (x, y) = (pixel % settings.width, pixel / settings.width);
            let place = format!("{name} at {seconds} s through {structure:?}, pixel ({x}, {y})");
            assert_eq!(renderer.seen().triangle_at(x, y), truth.triangle, "{place}");
            assert_eq!(renderer.light_masks().len(), truth.lit.len());
            for (light, (mask, &lit)) in renderer.light_masks().iter().zip(&truth.lit).enumerate() {
                assert_eq!(mask.is_lit(x, y), lit, "{place}, light {}", renderer.frame().lights[light].name);
            }
        }
    }
    truth.into_iter().flatten().filter(|pixel| pixel.triangle != Film::NO_TRIANGLE).count()
}

/// The true triangle of a pixel, and whether each light reaches it.
struct Truth {
    triangle: u32,
    lit: Vec<bool>,
}

/// The truth about each pixel, row by row.
fn oracle(frame: &Frame, settings: &Settings) -> Vec<Truth> {
    let camera = frame.camera(settings.width as f32 / settings.height as f32);
    let view = View { camera, width: settings.width, height: settings.height };
    let oracle = Oracle::new(frame.triangles());
    let has_back = |id: u32| match settings.sides {
        Sides::File => frame.material(id).double_sided,
        Sides::Both => true,
        Sides::Front => false,
    };
    let pixels = (0..settings.height).flat_map(|y| (0..settings.width).map(move |x| (x, y)));
    let truth = pixels.map(|(x, y)| {
        let ray = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let counts = |hit: &Hit| {
            let corners = frame.triangles().corners(hit.triangle);
            let is_front = crossing(&ray, corners).is_some_and(|crossing| crossing.front);
            let is_there = is_front || has_back(hit.triangle);
            is_there && frame.camera_opacity().stops(hit.triangle, hit.barycentric)
        };
        let hit = oracle.nearest(&ray, counts);
        let lit = frame.lights.iter().map(|light| {
            hit.is_some_and(|hit| {
                let shadow_ray = ShadowRay::new(&light.source, HitPoint::new(&ray, hit.t));
                let casts = |id, barycentric| {
                    let sides = if has_back(id) { rays::Sides::Both } else { rays::Sides::Front };
                    stops_light(sides, &light.source, &shadow_ray, id, frame.triangles().corners(id))
                        && frame.shadow_opacity().stops(id, barycentric)
                };
                !oracle.blocked(&shadow_ray, hit.triangle, casts)
            })
        });
        Truth { triangle: hit.map_or(Film::NO_TRIANGLE, |hit| hit.triangle), lit: lit.collect() }
    });
    truth.collect()
}

#[test]
fn procedural_scenes_are_the_oracles() {
    for name in ["cloth", "marbles", "forest", "hall", "shatter", "stadium", "statue", "glass", "gears"] {
        let scene = umbrage::open(format!("demo:{name}?triangles=1500")).expect("a scene of the gallery");
        let seen = compare(&scene, 0.4 * scene.duration_seconds(), name);
        assert!(seen > 200, "{name} shows {seen} pixels");
    }
}

#[test]
fn culled_back_faces_are_the_oracles() {
    for name in ["cloth", "marbles", "forest", "shatter", "glass"] {
        let scene = umbrage::open(format!("demo:{name}?triangles=1500")).expect("a scene of the gallery");
        let seconds = 0.4 * scene.duration_seconds();
        let [all, fronts] = [Sides::Both, Sides::Front].map(|sides| compare_with(&scene, seconds, name, sides));
        assert!(fronts > 100 && fronts <= all, "{name} shows {fronts} pixels of {all}");
    }
}

#[test]
fn small_real_scenes_are_the_oracles() {
    let conformance = real_scene("conformance").map(|folder| files_in(&folder)).unwrap_or_default();
    let others = ["cesium_man.glb", "robot_expressive.glb", "tree_alphamask.glb", "robot_arm.glb"];
    let others = others.into_iter().filter_map(real_scene);
    for path in conformance.into_iter().chain(others) {
        let scene = umbrage::open(&path).unwrap_or_else(|error| panic!("{error}"));
        let name = path.display().to_string();
        if scene.at(0.0).is_ok_and(|frame| frame.triangles().len() < 12_000) {
            compare(&scene, 0.3 * scene.duration_seconds(), &name);
        }
    }
}

fn files_in(folder: &Path) -> Vec<std::path::PathBuf> {
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

#[test]
fn the_number_of_threads_changes_nothing() {
    let scene = umbrage::open("demo:forest?triangles=4000").expect("a scene of the gallery");
    let settings = Settings { samples: 3, ..settings(Structure::default()) };
    let on_threads = |count: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("a thread pool");
        pool.install(|| {
            let mut renderer = Renderer::default();
            let film = renderer.render(&scene, 1.0, &settings).expect("a frame").clone();
            (film, renderer.seen().clone(), renderer.light_masks().to_vec())
        })
    };
    let (film, seen, masks) = on_threads(1);
    for count in [2, 3, 7] {
        let (other_film, other_seen, other_masks) = on_threads(count);
        assert_eq!(film.color, other_film.color);
        assert_eq!(film.triangle, other_film.triangle);
        assert_eq!(seen.triangle, other_seen.triangle);
        assert_eq!(masks, other_masks);
    }
}

#[test]
fn a_renderer_used_again_gives_what_a_new_one_gives() {
    let scenes =
        ["demo:cloth?triangles=3000", "demo:glass?triangles=500"].map(|name| umbrage::open(name).expect("one"));
    let mut used = Renderer::default();
    for (scene, side) in [(&scenes[0], 32), (&scenes[1], 16), (&scenes[0], 24)] {
        let settings = Settings { width: side, height: side, ..Settings::default() };
        let again = used.render(scene, 0.7, &settings).expect("a frame").color.clone();
        let fresh = Renderer::default().render(scene, 0.7, &settings).expect("a frame").color.clone();
        assert_eq!(again, fresh);
    }
}

#[test]
fn what_stays_of_a_scene_that_stays_is_as_good_as_new() {
    let scene = umbrage::open("demo:glass?triangles=500").expect("a scene");
    let settings = Settings { width: 40, height: 30, bounces: 2, ..Settings::default() };
    let mut used = Renderer::default();
    for (number, moment) in [0.7, 0.7, 0.7, 0.7, 0.9, 0.9, 0.7, 0.7, 0.7].into_iter().enumerate() {
        let again = used.render(&scene, moment, &settings).expect("a frame").color.clone();
        let fresh = Renderer::default().render(&scene, moment, &settings).expect("a frame").color.clone();
        assert!(again == fresh, "frame {number}");
    }
}
