//! How long the light grid takes, stage by stage, beside a BVH.
//!
//! `cargo run --release -p umbrage-rays --example grid_speed -- [TRIANGLES | FILE.obj] [SIDE] [alone]`

use std::time::Instant;

use glam::{DVec2, Vec3};
use rayon::prelude::*;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Bvh, Camera, LightGrid, LightSource, SeenImage, Triangles, View};

struct Mesh {
    positions: Vec<Vec3>,
    indices: Vec<[u32; 3]>,
}

impl Mesh {
    /// Bumpy balls on a floor.
    fn balls(triangles: usize) -> Self {
        let mut mesh = Self { positions: Vec::new(), indices: Vec::new() };
        let rings = ((triangles / 9) as f32 / 4.0).sqrt().max(2.0) as u32;
        for ball in 0..9 {
            let center = Vec3::new((ball % 3) as f32 * 2.4 - 2.4, 0.0, (ball / 3) as f32 * 2.4 - 2.4);
            mesh.push_ball(center, rings);
        }
        mesh.push_floor(-1.05, 6.0);
        mesh
    }

    fn push_ball(&mut self, center: Vec3, rings: u32) {
        let (first, parts) = (self.positions.len() as u32, 2 * rings);
        for ring in 0..=rings {
            for part in 0..parts {
                let polar = std::f32::consts::PI * ring as f32 / rings as f32;
                let around = std::f32::consts::TAU * part as f32 / parts as f32;
                let radius = 1.0 + 0.05 * (13.0 * polar).sin() * (11.0 * around).cos();
                let (sin, cos) = polar.sin_cos();
                self.positions.push(center + Vec3::new(sin * around.cos(), cos, sin * around.sin()) * radius);
            }
        }
        for (ring, part) in (0..rings).flat_map(|ring| (0..parts).map(move |part| (ring, part))) {
            let at = |ring: u32, part: u32| first + ring * parts + part % parts;
            let [a, b, c, d] = [at(ring, part), at(ring, part + 1), at(ring + 1, part + 1), at(ring + 1, part)];
            self.indices.extend([[a, b, c], [a, c, d]]);
        }
    }

    fn push_floor(&mut self, height: f32, half: f32) {
        let first = self.positions.len() as u32;
        let corner = |x: f32, z: f32| Vec3::new(x * half, height, z * half);
        self.positions.extend([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
        self.indices.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }

    /// The triangles of an OBJ file that has nothing but plain vertices and faces, brought to size and put on a floor.
    fn read(path: &str) -> std::io::Result<Self> {
        let mut mesh = Self { positions: Vec::new(), indices: Vec::new() };
        for line in std::fs::read_to_string(path)?.lines() {
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => {
                    let numbers: Vec<f32> = words.filter_map(|word| word.parse().ok()).collect();
                    mesh.positions.extend(numbers.first_chunk().map(|&point| Vec3::from_array(point)));
                }
                Some("f") => {
                    let vertex = |word: &str| word.split('/').next().and_then(|number| number.parse::<u32>().ok());
                    let face: Vec<u32> = words.filter_map(vertex).map(|number| number.wrapping_sub(1)).collect();
                    mesh.indices.extend(face.windows(2).skip(1).map(|pair| [face[0], pair[0], pair[1]]));
                }
                _ => {}
            }
        }
        let bounds = Triangles { positions: &mesh.positions, indices: &mesh.indices }.bounds();
        let scale = 4.0 / bounds.size().max_element();
        mesh.positions.iter_mut().for_each(|position| *position = (*position - bounds.center()) * scale);
        mesh.push_floor(-0.5 * scale * bounds.size().y, 6.0);
        Ok(mesh)
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2] * 1e3
}

fn timed<R>(work: impl FnOnce() -> R) -> (R, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

fn main() -> std::io::Result<()> {
    let rounds = 15;
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let scene = arguments.first().map_or("70000", String::as_str);
    let mesh = scene.parse().map_or_else(|_| Mesh::read(scene), |triangles| Ok(Mesh::balls(triangles)))?;
    let side = arguments.get(1).and_then(|side| side.parse().ok()).unwrap_or(1024);
    let alone = arguments.get(2).is_some_and(|word| word == "alone");
    let triangles = Triangles { positions: &mesh.positions, indices: &mesh.indices };
    let camera = Camera::look_at(Vec3::new(2.0, 5.0, 8.0), Vec3::ZERO, Vec3::Y, 0.75);
    let view = View { camera, width: side, height: side };
    let offset_pixels = DVec2::splat(0.5);
    let pixels = (side * side) as usize;
    let ray = |pixel: usize| {
        let pixel = pixel as u32;
        view.ray(f64::from(pixel % side) + 0.5, f64::from(pixel / side) + 0.5)
    };

    let mut bvh = Bvh::default();
    bvh.build(triangles);
    let hits: Vec<_> = (0..pixels).into_par_iter().map(|pixel| bvh.nearest(triangles, &ray(pixel), |_| true)).collect();
    let seen: Vec<u32> = hits.iter().map(|hit| hit.map_or(SeenImage::NOTHING, |hit| hit.triangle)).collect();
    let image = SeenImage { triangles, view, offset_pixels, triangle_of_pixel: &seen };
    println!(
        "{} triangles, {} vertices, {side}², {} threads",
        triangles.len(),
        mesh.positions.len(),
        rayon::current_num_threads()
    );

    let lights = [
        ("outside", LightSource::Point { position: Vec3::new(5.0, 9.0, 4.0) }),
        ("inside", LightSource::Point { position: Vec3::new(1.2, 1.5, 1.2) }),
        ("sun", LightSource::Directional { direction: Vec3::new(-0.4, -1.0, -0.3).normalize() }),
    ];
    let mut grid = LightGrid::default();
    let mut lit = vec![0_u64; pixels.div_ceil(64)];
    for (name, light) in lights {
        let mut stages: [Vec<f64>; 9] = Default::default();
        let mut differing = 0;
        for _ in 0..rounds {
            let (_, locate) = timed(|| grid.locate(&image));
            let (_, shadow) = timed(|| grid.shadow(&image, &light, |_| true, |_, _| true, &mut lit));
            let seconds = grid.seconds();
            if alone {
                let new = [locate, seconds.map, seconds.sort, seconds.project, seconds.trace, seconds.decide, shadow];
                stages.iter_mut().zip(new.into_iter().chain([0.0; 2])).for_each(|(stage, time)| stage.push(time));
                continue;
            }
            let (_, build) = timed(|| bvh.build(triangles));
            let blocked = |pixel: usize| {
                let hit = hits[pixel]?;
                let shadow_ray = ShadowRay::new(&light, HitPoint::new(&ray(pixel), hit.t));
                Some(bvh.blocked(triangles, &shadow_ray, hit.triangle, |_, _| true))
            };
            let (truth, trace) = timed(|| (0..pixels).into_par_iter().map(blocked).collect::<Vec<_>>());
            differing = (0..pixels)
                .filter(|&pixel| (truth[pixel] == Some(false)) != (lit[pixel / 64] >> (pixel % 64) & 1 == 1))
                .count();
            let new = [
                locate,
                seconds.map,
                seconds.sort,
                seconds.project,
                seconds.trace,
                seconds.decide,
                shadow,
                build,
                trace,
            ];
            stages.iter_mut().zip(new).for_each(|(stage, time)| stage.push(time));
        }
        let [locate, map, sort, project, trace, decide, shadow, build, bvh_trace] = stages.map(median);
        let counts = grid.counts();
        println!(
            "{name}: locate {locate:.2} | map {map:.2} sort {sort:.2} project {project:.2} trace {trace:.2} decide \
             {decide:.2} = {shadow:.2} ms | bvh build {build:.1} shadow {bvh_trace:.1} ms | {differing} bits differ"
        );
        println!("  {counts:?}, {:.1} MB", grid.bytes() as f64 / 1e6);
    }
    Ok(())
}
