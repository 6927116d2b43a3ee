//! Sends rays at the edges and corners that triangles share: none may slip through, and nothing may shadow itself.
#![forbid(unsafe_code)]

use std::slice;
use std::time::Instant;

use anyhow::{Result, ensure};
use clap::Parser;
use glam::Vec3;
use indicatif::ProgressBar;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{
    Bvh, DirectGrids, KdTree, KdTreeOptions, LightMask, LightSource, ListedGrids, SeenPixels, Shot, SingleRays as _,
    Structure, UniformGrid,
};
use umbrage_verify::{Random, Seams, Sheet, SheetShape};

/// Aims rays at shared edges and vertices, through all grids, and counts leaks and self-shadowing.
#[derive(Debug, Parser)]
#[command(name = "watertight", after_help = EXAMPLES)]
struct Flags {
    /// How many camera rays exactly through shared vertices and edges; each sends shadow rays too, and so do others
    /// that are between them
    #[arg(long, value_name = "N", default_value = "1e7", value_parser = count)]
    rays: u64,
    /// Which random sheets
    #[arg(long, value_name = "N", default_value = "1")]
    seed: u64,
}

const EXAMPLES: &str = "Examples:
  cargo run --release -p umbrage-verify --bin watertight
      Ten million rays at seams, as every check of the repository does
  cargo run --release -p umbrage-verify --bin watertight -- --rays 1e9 --seed 7
      A thousand million others";

fn count(text: &str) -> Result<u64, String> {
    let number: f64 = text.parse().map_err(|_| "a number is needed, such as 1e7")?;
    if (1.0..=1e15).contains(&number) { Ok(number as u64) } else { Err("from 1 to 1e15".to_owned()) }
}

fn main() -> Result<()> {
    let flags = Flags::parse();
    let (mut random, started) = (Random::new(flags.seed), Instant::now());
    let progress = ProgressBar::new(flags.rays);
    let mut trial = Trial::new()?;
    for round in 0.. {
        let at_seams = trial.seams.vertices + trial.seams.edges;
        progress.set_position(at_seams.min(flags.rays));
        if at_seams >= flags.rays {
            break;
        }
        let (position, scale) = SheetShape::PLACES[round % SheetShape::PLACES.len()];
        let has_shell = position == Vec3::ZERO && random.below(3) == 0;
        let side = if has_shell { 128 } else { 512 };
        let (step, is_orthographic) = ([1, 2, 2, 4][random.below(4)], random.below(4) == 0);
        trial.run(SheetShape { side, step, position, scale, is_orthographic, has_shell }, &mut random)?;
    }
    progress.finish_and_clear();
    let Trial { seams: Seams { vertices, edges }, between, beside, by_others, undecided, .. } = trial;
    println!(
        "{} camera rays exactly at seams, {vertices} at vertices and {edges} at edges, and {between} between them; from \
         each point a shadow ray to a light at the camera, and from {beside} one to a light at the side; {by_others} of \
         the latter through the listed grids and the uniform grid as well.",
        vertices + edges
    );
    println!(
        "No leak, no self-shadowing; {undecided} tests went to the predicate; {:.1} s",
        started.elapsed().as_secs_f64()
    );
    Ok(())
}

/// The structures, used again and again, and what they were asked.
struct Trial {
    grids: DirectGrids,
    /// Whoever answers whole images in another way, by name.
    others: [(&'static str, Box<dyn Structure>); 2],
    kd_tree: KdTree,
    bvh: Bvh,
    seen: SeenPixels,
    /// For a light at the camera, and for one at the side.
    masks: [LightMask; 2],
    /// What the others find.
    other_seen: SeenPixels,
    other_masks: [LightMask; 2],
    /// Rays through vertices and edges, and others.
    seams: Seams,
    between: u64,
    /// Points that were lit from the side as well.
    beside: u64,
    /// Camera rays through the others.
    by_others: u64,
    undecided: u64,
}

impl Trial {
    fn new() -> Result<Self> {
        let mut kd_tree = KdTree::default();
        kd_tree.set_options(KdTreeOptions::FAST)?;
        Ok(Self {
            grids: DirectGrids::default(),
            others: [
                ("the listed grids", Box::<ListedGrids>::default()),
                ("the uniform grid", Box::<UniformGrid>::default()),
            ],
            kd_tree,
            bvh: Bvh::default(),
            seen: SeenPixels::default(),
            masks: Default::default(),
            other_seen: SeenPixels::default(),
            other_masks: Default::default(),
            seams: Seams::default(),
            between: 0,
            beside: 0,
            by_others: 0,
            undecided: 0,
        })
    }

    /// Looks at one sheet.
    fn run(&mut self, shape: SheetShape, random: &mut Random) -> Result<()> {
        let sheet = Sheet::new(shape, random);
        let shot = Shot { offset_pixels: sheet.offset_pixels, ..Shot::new(sheet.mesh.triangles(), sheet.view) };
        let Self { grids, seen, masks: [at_camera, _], .. } = self;
        let of_camera = grids.see(&shot, seen)?;
        for (x, y) in pixels(shape) {
            let id = seen.triangle_at(x, y);
            ensure!(id != SeenPixels::NONE, "the ray of pixel ({x}, {y}) leaks: {shape:?}");
            ensure!(id < sheet.front, "pixel ({x}, {y}) shows triangle {id} of the sheet behind: {shape:?}");
        }
        let of_light = grids.shadow(&shot, seen, &[sheet.light], slice::from_mut(at_camera));
        self.undecided += of_camera.counts.settled + of_light.counts.undecided;
        are_all_lit(&self.masks[0], shape, "the direct grids")?;

        let seams = sheet.seams();
        self.seams.vertices += seams.vertices;
        self.seams.edges += seams.edges;
        self.between += points(shape) - seams.vertices - seams.edges;
        // What needs several times as long isn't done for every sheet.
        if shape.has_shell || random.below(3) == 0 {
            let light = self.run_beside(&shot, shape, random)?;
            if shape.has_shell || random.below(4) == 0 {
                self.run_others(&shot, shape, [sheet.light, light])?;
            }
        }
        Ok(())
    }

    /// Lights the sheet from the side, where it does shadow itself: some pixels against the hierarchy and the kd-tree.
    /// Returns the light.
    fn run_beside(&mut self, shot: &Shot<'_>, shape: SheetShape, random: &mut Random) -> Result<LightSource> {
        let (triangles, camera) = (shot.triangles, shot.view.camera);
        let Self { grids, bvh, kd_tree, seen, masks: [_, mask], .. } = self;
        let beside = camera.right * (3.0 * shape.scale) + camera.forward * (2.0 * shape.scale);
        let light = LightSource::Point { position: shape.position + beside };
        self.undecided += grids.shadow(shot, seen, &[light], slice::from_mut(mask)).counts.undecided;
        self.beside += points(shape);
        bvh.build(triangles);
        kd_tree.build(triangles);
        for _ in 0..200 {
            let (x, y) = (random.below(shape.side as usize) as u32, random.below(shape.side as usize) as u32);
            let ray = shot.ray(x, y);
            let hit = bvh.nearest(triangles, &ray, &|_| true);
            let Some(hit) = hit.filter(|hit| hit.triangle == seen.triangle_at(x, y)) else {
                anyhow::bail!("pixel ({x}, {y}) shows the wrong triangle: {shape:?}");
            };
            let shadow_ray = ShadowRay::new(&light, HitPoint::new(&ray, hit.t));
            let blocked = bvh.blocked(triangles, &shadow_ray, hit.triangle, &|_, _| true);
            ensure!(self.masks[1].is_lit(x, y) != blocked, "the shadow at pixel ({x}, {y}) is wrong: {shape:?}");
            let is_seen = kd_tree.nearest(triangles, &ray, &|_| true) == Some(hit);
            ensure!(is_seen, "the kd-tree's ray of pixel ({x}, {y}) hits something else: {shape:?}");
            let is_shadowed = kd_tree.blocked(triangles, &shadow_ray, hit.triangle, &|_, _| true);
            ensure!(is_shadowed == blocked, "the kd-tree's shadow at pixel ({x}, {y}) is wrong: {shape:?}");
        }
        Ok(light)
    }

    /// Looks at the same sheet, and its lights, in other ways.
    fn run_others(&mut self, shot: &Shot<'_>, shape: SheetShape, lights: [LightSource; 2]) -> Result<()> {
        let Self { others, seen, masks, other_seen, other_masks, .. } = self;
        for (name, structure) in others {
            structure.build(shot.triangles);
            structure.see(shot, other_seen)?;
            ensure!(other_seen.triangle == seen.triangle, "{name} see other triangles: {shape:?}");
            structure.shadow(shot, other_seen, &lights, other_masks);
            ensure!(other_masks[1] == masks[1], "{name} find other shadows: {shape:?}");
            are_all_lit(&other_masks[0], shape, name)?;
        }
        self.by_others += points(shape);
        Ok(())
    }
}

/// Whether a light at the camera lights every pixel.
fn are_all_lit(mask: &LightMask, shape: SheetShape, how: &str) -> Result<()> {
    for (x, y) in pixels(shape) {
        ensure!(mask.is_lit(x, y), "pixel ({x}, {y}) shadows itself, through {how}: {shape:?}");
    }
    Ok(())
}

/// How many pixels, and so points, a sheet has.
fn points(shape: SheetShape) -> u64 {
    u64::from(shape.side).pow(2)
}

fn pixels(shape: SheetShape) -> impl Iterator<Item = (u32, u32)> {
    (0..shape.side).flat_map(move |y| (0..shape.side).map(move |x| (x, y)))
}
