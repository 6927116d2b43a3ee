//! Every number of threads and every SIMD level gives the same triangles and shadows, bit for bit, through both forms
//! of both grids. They are the hierarchy's in every pixel, and the oracle's in the compared ones.

use umbrage::gallery::DEMOS;
use umbrage::rays::predicate::{HitPoint, ShadowRay};
use umbrage::rays::{Opacity as _, SimdLevel, View};
use umbrage::scene::Frame;
use umbrage::{Film, LightMask, Renderer, Scene, Settings, Structure};
use umbrage_papers::structures;
use umbrage_verify::{Oracle, Random, real_scene};

/// More than one tile of the grids along each axis, none of them whole.
const SIZE: [u32; 2] = [150, 70];

const THREADS: [usize; 4] = [1, 2, 3, 7];

/// Answers of a frame: each pixel's triangle, and the masks of each light.
#[derive(Clone, Debug, Default, PartialEq)]
struct Shown {
    triangle: Vec<u32>,
    lit: Vec<LightMask>,
}

fn settings(structure: Structure) -> Settings {
    Settings { width: SIZE[0], height: SIZE[1], structure, ..Settings::default() }
}

/// Renders a frame with that many threads and those instructions.
fn render(scene: &Scene, seconds: f64, structure: Structure, threads: usize, level: SimdLevel) -> (Renderer, Shown) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool");
    pool.install(|| {
        let mut renderer = Renderer::with_simd_level(level);
        renderer.render(scene, seconds, &settings(structure)).expect("a frame");
        let seen = renderer.seen();
        let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
        let triangle = pixels.map(|(x, y)| seen.triangle_at(x, y)).collect();
        let lit = renderer.light_masks().to_vec();
        (renderer, Shown { triangle, lit })
    })
}

/// Compares all of `combinations` with each other, with the hierarchy and, for `questions` pixels, with the oracle.
fn check(name: &str, scene: &Scene, moment: f64, combinations: &[(usize, SimdLevel)], questions: usize) {
    let seconds = moment * scene.duration_seconds();
    let (renderer, truth) = render(scene, seconds, Structure::bvh(), 2, SimdLevel::default());
    ask_oracle(name, renderer.frame(), &truth, questions);
    for structure in structures().only(|structure| *structure != Structure::bvh()).iter() {
        for &(threads, level) in combinations {
            let (_, shown) = render(scene, seconds, structure.clone(), threads, level);
            let place = format!("{name} on {threads} threads with {level} through {structure:?}");
            assert!(shown.triangle == truth.triangle, "{place}: other triangles");
            assert!(shown.lit == truth.lit, "{place}: other shadows");
        }
    }
}

fn ask_oracle(name: &str, frame: &Frame, shown: &Shown, questions: usize) {
    let [width, height] = SIZE;
    let view = View { camera: frame.camera(width as f32 / height as f32), width, height };
    let (oracle, mut random) = (Oracle::new(frame.triangles()), Random::new(41));
    for _ in 0..questions {
        let (x, y) = (random.below(width as usize) as u32, random.below(height as usize) as u32);
        let ray = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let hit = oracle.nearest(&ray, |hit| frame.camera_opacity().stops(hit.triangle, hit.barycentric));
        let triangle = hit.map_or(Film::NO_TRIANGLE, |hit| hit.triangle);
        assert_eq!(shown.triangle[(y * width + x) as usize], triangle, "{name}, pixel ({x}, {y})");
        for (light, mask) in frame.lights.iter().zip(&shown.lit) {
            let lit = hit.is_some_and(|hit| {
                let shadow_ray = ShadowRay::new(&light.source, HitPoint::new(&ray, hit.t));
                !oracle
                    .blocked(&shadow_ray, hit.triangle, |id, barycentric| frame.shadow_opacity().stops(id, barycentric))
            });
            assert_eq!(mask.is_lit(x, y), lit, "{name}, pixel ({x}, {y}), light {}", light.name);
        }
    }
}

/// Tests that take long, which `cargo run -p ci` runs with `--all` alone.
mod long {
    use super::*;

    #[test]
    fn gallery_scenes() {
        let all: Vec<_> = SimdLevel::available().into_iter().flat_map(|level| THREADS.map(|n| (n, level))).collect();
        for demo in DEMOS {
            let scene = umbrage::open(format!("demo:{}?triangles=5000", demo.name)).expect("a scene of the gallery");
            check(demo.name, &scene, 0.4, &all, 60);
        }
    }

    #[test]
    fn real_scenes() {
        // Each number of threads and each level is used at least once.
        let levels = SimdLevel::available();
        let some: Vec<_> = THREADS.iter().enumerate().map(|(place, &n)| (n, levels[place % levels.len()])).collect();
        let names = [
            ("cesium_man.glb", 60),
            ("robot_expressive.glb", 60),
            ("robot_arm.glb", 60),
            ("tree_alphamask.glb", 60),
            ("vintage_fan.glb", 20),
            ("elephant_gallop.glb", 20),
            ("horse_gallop_obj_sequence", 60),
            ("stanford_bunny.obj", 20),
            ("sibenik.obj", 20),
            ("chess_board.glb", 10),
            ("dispersion_test.glb", 20),
            ("country_kitchen.glb", 4),
            ("dream_apartment.glb", 4),
        ];
        for (name, questions) in names {
            if let Some(path) = real_scene(name) {
                let scene = umbrage::open(&path).unwrap_or_else(|error| panic!("{error}"));
                check(name, &scene, 0.3, &some, questions);
            }
        }
    }
}
