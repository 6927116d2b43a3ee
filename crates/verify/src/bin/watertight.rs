//! Sends rays at the edges and corners that triangles share: none may slip through, and nothing may shadow itself.
#![forbid(unsafe_code)]

use std::time::Instant;

use anyhow::{Result, ensure};
use clap::Parser;
use glam::Vec3;
use indicatif::ProgressBar;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Bvh, LightGrid, LightSource, PerspectiveGrid, SeenImage, SeenPixels, TileOrder, Unmasked};
use umbrage_verify::{Random, Sheet, SheetShape};

/// Aims rays at shared edges and vertices, through both grids, and counts leaks and self-shadowing.
#[derive(Debug, Parser)]
#[command(name = "watertight", after_help = EXAMPLES)]
struct Flags {
    /// How many camera rays; each that hits sends a shadow ray too
    #[arg(long, value_name = "N", default_value = "1e7", value_parser = count)]
    rays: u64,
    /// Which random sheets
    #[arg(long, value_name = "N", default_value = "1")]
    seed: u64,
}

const EXAMPLES: &str = "Examples:
  cargo run --release -p umbrage-verify --bin watertight
      Ten million rays, as every check of the repository does
  cargo run --release -p umbrage-verify --bin watertight -- --rays 1e9 --seed 7
      A thousand million others";

fn count(text: &str) -> Result<u64, String> {
    let number: f64 = text.parse().map_err(|_| "a number is needed, such as 1e7")?;
    if (1.0..=1e15).contains(&number) { Ok(number as u64) } else { Err("from 1 to 1e15".to_owned()) }
}

/// Where cameras are and how large their worlds are.
const PLACES: [(Vec3, f32); 6] = [
    (Vec3::ZERO, 1.0),
    // 2⁻²⁰ and 2²⁰: about a millionth and a million.
    (Vec3::ZERO, 1.0 / (1 << 20) as f32),
    (Vec3::ZERO, (1 << 20) as f32),
    (Vec3::new(148_376.0, 1_234.0, -223_423.0), 4.0),
    (Vec3::new(-96.25, 0.015_625, 131.5), 8.0),
    (Vec3::new(148_376.0, -223_423.0, 1_234.0), 1024.0),
];

fn main() -> Result<()> {
    let flags = Flags::parse();
    let (mut random, started) = (Random::new(flags.seed), Instant::now());
    let progress = ProgressBar::new(flags.rays);
    let mut trial = Trial::default();
    for round in 0.. {
        if trial.rays >= flags.rays {
            break;
        }
        let (position, scale) = PLACES[round % PLACES.len()];
        // Orthographic views of what is tiny, huge or far away are exact too, but so far nearly all of their tests need the
        // predicate, which takes minutes a view.
        let is_near = position == Vec3::ZERO && (0.5..2.0).contains(&scale);
        let has_shell = position == Vec3::ZERO && random.below(3) == 0;
        let side = if has_shell { 128 } else { 512 };
        let (step, is_orthographic) = ([1, 2, 4][random.below(3)], is_near && random.below(4) == 0);
        trial.run(SheetShape { side, step, position, scale, is_orthographic, has_shell }, &mut random)?;
        progress.set_position(trial.rays.min(flags.rays));
    }
    progress.finish_and_clear();
    let Trial { rays, shadow_rays, undecided, .. } = trial;
    println!(
        "{rays} camera rays and {shadow_rays} shadow rays at seams: no leak, no self-shadowing; {undecided} went to the \
         predicate; {:.1} s",
        started.elapsed().as_secs_f64()
    );
    Ok(())
}

/// The structures, used again and again, and what they were asked.
#[derive(Default)]
struct Trial {
    camera_grid: PerspectiveGrid,
    light_grid: LightGrid,
    bvh: Bvh,
    seen: SeenPixels,
    lit: Vec<u16>,
    rays: u64,
    shadow_rays: u64,
    undecided: u64,
}

impl Trial {
    /// Looks at one sheet.
    fn run(&mut self, shape: SheetShape, random: &mut Random) -> Result<()> {
        let sheet = Sheet::new(shape, random);
        let (triangles, view, offset_pixels) = (sheet.mesh.triangles(), sheet.view, sheet.offset_pixels);
        let Self { camera_grid, light_grid, bvh, seen, lit, .. } = self;
        camera_grid.build(triangles, &view, offset_pixels, |_| false)?;
        let counts = camera_grid.trace(triangles, Unmasked, seen);
        let order = seen.order();
        let pixels = || (0..shape.side).flat_map(|y| (0..shape.side).map(move |x| (x, y)));
        for (x, y) in pixels() {
            let id = seen.triangle_at(x, y);
            ensure!(id != SeenPixels::NONE, "the ray of pixel ({x}, {y}) leaks: {shape:?}");
            ensure!(id < sheet.front, "pixel ({x}, {y}) shows triangle {id} of the sheet behind: {shape:?}");
        }
        let image = SeenImage { triangles, view, offset_pixels, seen };
        lit.resize(order.places() / TileOrder::BLOCK_PLACES, 0);
        light_grid.survey(&image);
        light_grid.shadow(&image, &sheet.light, |_| true, &Unmasked, lit);
        let undecided = light_grid.counts().undecided;
        for (x, y) in pixels() {
            ensure!(is_lit(lit, order.place(x, y)), "pixel ({x}, {y}) shadows itself: {shape:?}");
        }

        // A light to the side, where the sheet does shadow itself: some pixels against the hierarchy.
        let side = view.camera.right * (3.0 * shape.scale) + view.camera.forward * (2.0 * shape.scale);
        let light = LightSource::Point { position: shape.position + side };
        light_grid.shadow(&image, &light, |_| true, &Unmasked, lit);
        bvh.build(triangles);
        for _ in 0..200 {
            let (x, y) = (random.below(shape.side as usize) as u32, random.below(shape.side as usize) as u32);
            let ray = view.ray(f64::from(x) + offset_pixels.x, f64::from(y) + offset_pixels.y);
            let hit = bvh.nearest(triangles, &ray, |_| true);
            let Some(hit) = hit.filter(|hit| hit.triangle == seen.triangle_at(x, y)) else {
                anyhow::bail!("pixel ({x}, {y}) shows the wrong triangle: {shape:?}");
            };
            let shadow_ray = ShadowRay::new(&light, HitPoint::new(&ray, hit.t));
            let blocked = bvh.blocked(triangles, &shadow_ray, hit.triangle, |_, _| true);
            ensure!(is_lit(lit, order.place(x, y)) != blocked, "the shadow at pixel ({x}, {y}) is wrong: {shape:?}");
        }

        let pixels = u64::from(shape.side) * u64::from(shape.side);
        self.rays += pixels;
        self.shadow_rays += 2 * pixels;
        self.undecided += counts.referred + undecided + light_grid.counts().undecided;
        Ok(())
    }
}

fn is_lit(lit: &[u16], place: usize) -> bool {
    lit[place / TileOrder::BLOCK_PLACES] >> (place % TileOrder::BLOCK_PLACES) & 1 == 1
}
