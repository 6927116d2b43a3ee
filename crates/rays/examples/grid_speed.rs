//! Times of the perspective grid beside those of the BVH, over the same triangles, camera and threads.
//!
//! `cargo run --release -p umbrage-rays --example grid_speed -- [TRIANGLES | FILE.obj]... [--size PIXELS] [--grid-only]`

use std::time::Instant;

use glam::{DVec2, Vec3};
use rayon::prelude::*;
use umbrage_rays::{Bounds, Bvh, Camera, GridCounts, PerspectiveGrid, SeenPixels, Triangles, View};

const ROUNDS: usize = 15;
const OFFSET: DVec2 = DVec2::splat(0.5);

/// A triangle mesh and what it is called.
struct Scene {
    name: String,
    positions: Vec<Vec3>,
    indices: Vec<[u32; 3]>,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut side = 1024;
    let mut with_bvh = true;
    let mut names: Vec<String> = Vec::new();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        if argument == "--size" {
            side = arguments.next().ok_or("--size needs a number of pixels")?.parse()?;
        } else if argument == "--grid-only" {
            with_bvh = false;
        } else {
            names.push(argument);
        }
    }
    if names.is_empty() {
        names = ["70000", "278000", "1110000"].map(String::from).to_vec();
    }
    println!("{} threads, {side}² pixels, median of {ROUNDS}, milliseconds", rayon::current_num_threads());
    println!(
        "scene | grid: build trace sum | bvh: build trace sum | ratio | listed fragments undecided referred | B/triangle"
    );
    for name in names {
        let scene = match name.parse::<usize>() {
            Ok(triangles) => Scene::balls(triangles),
            Err(_) => Scene::read_obj(&name)?,
        };
        scene.measure(side, with_bvh)?;
    }
    Ok(())
}

impl Scene {
    fn measure(&self, side: u32, with_bvh: bool) -> Result<(), Box<dyn std::error::Error>> {
        let triangles = Triangles { positions: &self.positions, indices: &self.indices };
        let forward = Vec3::new(-0.4, -0.5, -1.0).normalize();
        let bounds = Bounds::of_points(self.positions.iter().copied());
        let camera = Camera::framing(bounds.corners(), forward, 1.0, 0.7);
        let view = View { camera, width: side, height: side };

        let mut grid = PerspectiveGrid::default();
        let mut seen = SeenPixels::default();
        let mut bvh = Bvh::default();
        let mut times = [const { Vec::new() }; 4];
        let mut counts = GridCounts::default();
        let mut hits: Vec<u32> = Vec::new();
        for _ in 0..ROUNDS {
            let start = Instant::now();
            grid.build(triangles, &view, OFFSET, |_| false)?;
            let built = Instant::now();
            counts = grid.trace(triangles, |_| true, &mut seen);
            let traced = Instant::now();
            times[0].push((built - start).as_secs_f64());
            times[1].push((traced - built).as_secs_f64());

            if !with_bvh {
                continue;
            }
            let start = Instant::now();
            bvh.build(triangles);
            let built = Instant::now();
            hits.resize((side * side) as usize, 0);
            hits.par_iter_mut().enumerate().for_each(|(pixel, hit)| {
                let (x, y) = (pixel % side as usize, pixel / side as usize);
                let ray = view.ray(x as f64 + OFFSET.x, y as f64 + OFFSET.y);
                *hit = bvh.nearest(triangles, &ray, |_| true).map_or(SeenPixels::NONE, |hit| hit.triangle);
            });
            let traced = Instant::now();
            times[2].push((built - start).as_secs_f64());
            times[3].push((traced - built).as_secs_f64());
        }
        let different = hits.iter().zip(&seen.triangle).filter(|(bvh, grid)| bvh != grid).count();
        let [build, trace, bvh_build, bvh_trace] = times.map(median_milliseconds);
        let GridCounts { fragments, listed, undecided, referred } = counts;
        println!(
            "{} ({}) | {build:.2} {trace:.2} {:.2} | {bvh_build:.1} {bvh_trace:.1} {:.1} | {:.1} | {listed} {fragments} {undecided} {referred} | {:.1}",
            self.name,
            triangles.len(),
            build + trace,
            bvh_build + bvh_trace,
            (bvh_build + bvh_trace) / (build + trace),
            grid.bytes() as f64 / triangles.len().max(1) as f64,
        );
        if different > 0 {
            println!("{different} pixels differ");
        }
        Ok(())
    }

    /// Sixteen bumpy balls on a floor, about `triangles` in all.
    fn balls(triangles: usize) -> Self {
        let mut scene = Self { name: "balls".into(), positions: Vec::new(), indices: Vec::new() };
        let rings = ((triangles as f32 / 64.0).sqrt() as u32).max(3);
        for ball in 0..16 {
            let center = Vec3::new((ball % 4) as f32 * 2.5, 1.0, (ball / 4) as f32 * 2.5);
            scene.push_sheet(rings, 2 * rings, |latitude, longitude| {
                let (latitude, longitude) = (latitude * std::f32::consts::PI, longitude * std::f32::consts::TAU);
                let bump = 1.0 + 0.1 * (9.0 * longitude).sin() * (7.0 * latitude).sin();
                let ring = latitude.sin();
                center + Vec3::new(ring * longitude.cos(), latitude.cos(), ring * longitude.sin()) * bump
            });
        }
        scene.push_sheet(2, 2, |x, z| Vec3::new(x * 20.0 - 6.0, -0.1, z * 20.0 - 6.0));
        scene
    }

    /// A grid of 2 × `rows` × `columns` triangles over the unit square, placed by `position`.
    fn push_sheet(&mut self, rows: u32, columns: u32, position: impl Fn(f32, f32) -> Vec3) {
        let first = self.positions.len() as u32;
        for row in 0..=rows {
            for column in 0..=columns {
                self.positions.push(position(row as f32 / rows as f32, column as f32 / columns as f32));
            }
        }
        for row in 0..rows {
            for column in 0..columns {
                let a = first + row * (columns + 1) + column;
                let (b, c, d) = (a + 1, a + columns + 1, a + columns + 2);
                self.indices.extend([[a, b, d], [a, d, c]]);
            }
        }
    }

    /// The vertices and faces of an OBJ file, and nothing else of it.
    fn read_obj(path: &str) -> Result<Self, Box<dyn std::error::Error>> {
        let mut scene =
            Self { name: path.rsplit('/').next().unwrap_or(path).into(), positions: vec![], indices: vec![] };
        for line in std::fs::read_to_string(path)?.lines() {
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => {
                    let numbers = words.map(str::parse).collect::<Result<Vec<f32>, _>>()?;
                    scene.positions.push(Vec3::from_slice(numbers.get(..3).ok_or("a vertex needs three numbers")?));
                }
                Some("f") => {
                    let count = scene.positions.len() as i64;
                    let vertex = |word: &str| -> Result<u32, std::num::ParseIntError> {
                        let place: i64 = word.split('/').next().unwrap_or(word).parse()?;
                        Ok((if place < 0 { count + place } else { place - 1 }) as u32)
                    };
                    let corners = words.map(vertex).collect::<Result<Vec<u32>, _>>()?;
                    scene.indices.extend(corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]));
                }
                _ => {}
            }
        }
        Ok(scene)
    }
}

/// NaN for none.
fn median_milliseconds(mut seconds: Vec<f64>) -> f64 {
    seconds.sort_by(f64::total_cmp);
    seconds.get(seconds.len() / 2).map_or(f64::NAN, |median| median * 1e3)
}
