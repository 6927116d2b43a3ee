//! Times of a scan, of any rays and of lights, query by query: `python -m umbrage.bench --overhead` sets Python's times
//! beside these.
//!
//! `cargo run --release --example timed_questions` makes each query once. With `-- SCENE RAYS THREADS`, RAYS being a file of
//! six f32 a ray, it reads their names from standard input, a line each, and prints milliseconds.

use std::error::Error;
use std::hint::black_box;
use std::io::BufRead as _;
use std::time::Instant;

use rayon::prelude::*;
use umbrage::glam::{DVec3, Vec3};
use umbrage::rays::{LightSource, Lit, LitBits, Rays, Receivers, Scan, Scanned, Sweep, Trace, Tracer, Triangles};

/// Rays, and their directions alone.
struct Questions {
    rays: Vec<[f32; 6]>,
    directions: Vec<Vec3>,
    suns: Vec<LightSource>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let ([address, threads], rays) = match &arguments[..] {
        [address, path, threads] => {
            let bytes = std::fs::read(path)?;
            let numbers = bytes.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect::<Vec<_>>();
            ([address.as_str(), threads], numbers.as_chunks().0.to_vec())
        }
        _ => (["demo:cloth?triangles=2000", "1"], (0..1000_u16).map(made_ray).collect()),
    };
    let frame = umbrage::open(address)?.at(0.5)?;
    let directions = rays.iter().map(|&[.., x, y, z]| Vec3::new(x, y, z)).collect();
    let suns = (0..8_u8).map(|sun| Vec3::new(f32::from(sun) * 0.1 - 0.4, -1.0, 0.2).normalize());
    let suns = suns.map(|direction| LightSource::Directional { direction }).collect();
    let questions = Questions { rays, directions, suns };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.parse()?).build()?;
    let mut tracer = Tracer::default();
    let mut answer = |name: &str| {
        let start = Instant::now();
        pool.install(|| questions.ask(name, frame.triangles(), &mut tracer));
        start.elapsed().as_secs_f64() * 1e3
    };
    if arguments.is_empty() {
        ["scan", "cast_rays", "lit"].iter().for_each(|name| println!("{name}: {:.2} ms", answer(name)));
        return Ok(());
    }
    for line in std::io::stdin().lock().lines() {
        println!("{}", answer(&line?));
    }
    Ok(())
}

impl Questions {
    /// Makes a query with results in fresh memory and with normals, as from Python.
    fn ask(&self, name: &str, triangles: Triangles<'_>, tracer: &mut Tracer) {
        let mut scanned = Scanned::default();
        match name {
            "scan" => {
                let sweeps = [Sweep { origin: DVec3::Y, directions: &self.directions }];
                tracer.scanner(triangles).scan(&Scan::new(triangles, &sweeps), 1, &mut scanned);
            }
            "cast_rays" => {
                tracer.trace(&Trace::new(triangles, Rays::Single(&self.rays)), &mut scanned);
            }
            _ => {
                let mut bits = LitBits::default();
                tracer.scanner(triangles).lit(&Lit::new(triangles, Receivers::Faces), &self.suns, &mut bits);
                black_box(bits);
            }
        }
        let indices = (0..scanned.len()).into_par_iter();
        let normals: Vec<Vec3> = indices.map(|index| scanned.normal(triangles, index)).collect();
        black_box((scanned, normals));
    }
}

/// A ray from above a scene, towards its surroundings.
fn made_ray(number: u16) -> [f32; 6] {
    let turn = f32::from(number) * 2.4;
    [turn.sin(), 3.0, turn.cos(), (3.0 * turn).cos(), -1.0, (3.0 * turn).sin()]
}
