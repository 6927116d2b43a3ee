//! Sends rays at the edges and corners that triangles share: none may slip through, and nothing may shadow itself.
#![forbid(unsafe_code)]

use std::time::Instant;

use anyhow::{Result, ensure};
use clap::Parser;
use glam::Vec3;
use indicatif::ProgressBar;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{
    Bvh, KdTree, KdTreeOptions, LightGrid, LightSource, ListedGrid, ListedLightGrid, ListedOptions, PerspectiveGrid,
    SeenImage, SeenPixels, TileOrder, UniformGrid, Unmasked,
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
    let mut trial = Trial::default();
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
    let Trial { seams: Seams { vertices, edges }, between, beside, listed, undecided, .. } = trial;
    println!(
        "{} camera rays exactly at seams, {vertices} at vertices and {edges} at edges, and {between} between them; from \
         each point a shadow ray to a light at the camera, and from {beside} one to a light at the side; {listed} of \
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
#[derive(Default)]
struct Trial {
    camera_grid: PerspectiveGrid,
    light_grid: LightGrid,
    listed_grid: ListedGrid,
    listed_light_grid: ListedLightGrid,
    uniform_grid: UniformGrid,
    kd_tree: KdTree,
    bvh: Bvh,
    seen: SeenPixels,
    lit: Vec<u16>,
    /// What grids of other forms find.
    other_seen: SeenPixels,
    other_lit: Vec<u16>,
    /// Rays through vertices and edges, and others.
    seams: Seams,
    between: u64,
    /// Points that were lit from the side as well.
    beside: u64,
    /// Camera rays through the listed grid.
    listed: u64,
    undecided: u64,
}

impl Trial {
    /// Looks at one sheet.
    fn run(&mut self, shape: SheetShape, random: &mut Random) -> Result<()> {
        let sheet = Sheet::new(shape, random);
        let (triangles, view, offset_pixels) = (sheet.mesh.triangles(), sheet.view, sheet.offset_pixels);
        let Self { camera_grid, light_grid, seen, lit, .. } = self;
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
        self.undecided += counts.referred + light_grid.counts().undecided;
        for (x, y) in pixels() {
            ensure!(is_lit(lit, order.place(x, y)), "pixel ({x}, {y}) shadows itself: {shape:?}");
        }

        let seams = sheet.seams();
        self.seams.vertices += seams.vertices;
        self.seams.edges += seams.edges;
        self.between += points(shape) - seams.vertices - seams.edges;
        // What needs several times as long isn't done for every sheet.
        if shape.has_shell || random.below(3) == 0 {
            let light = self.run_beside(&sheet, shape, random)?;
            if shape.has_shell || random.below(4) == 0 {
                self.run_listed(&sheet, shape, &light)?;
                self.run_uniform(&sheet, shape, &light)?;
            }
        }
        Ok(())
    }

    /// Lights the sheet from the side, where it does shadow itself: some pixels against the hierarchy and the kd-tree.
    /// Returns the light.
    fn run_beside(&mut self, sheet: &Sheet, shape: SheetShape, random: &mut Random) -> Result<LightSource> {
        let (triangles, view, offset_pixels) = (sheet.mesh.triangles(), sheet.view, sheet.offset_pixels);
        let Self { light_grid, bvh, kd_tree, seen, lit, .. } = self;
        let beside = view.camera.right * (3.0 * shape.scale) + view.camera.forward * (2.0 * shape.scale);
        let light = LightSource::Point { position: shape.position + beside };
        let image = SeenImage { triangles, view, offset_pixels, seen };
        light_grid.shadow(&image, &light, |_| true, &Unmasked, lit);
        self.undecided += light_grid.counts().undecided;
        self.beside += points(shape);
        bvh.build(triangles);
        kd_tree.set_options(KdTreeOptions::FAST)?;
        kd_tree.build(triangles);
        for _ in 0..200 {
            let (x, y) = (random.below(shape.side as usize) as u32, random.below(shape.side as usize) as u32);
            let ray = view.ray(f64::from(x) + offset_pixels.x, f64::from(y) + offset_pixels.y);
            let hit = bvh.nearest(triangles, &ray, |_| true);
            let Some(hit) = hit.filter(|hit| hit.triangle == seen.triangle_at(x, y)) else {
                anyhow::bail!("pixel ({x}, {y}) shows the wrong triangle: {shape:?}");
            };
            let shadow_ray = ShadowRay::new(&light, HitPoint::new(&ray, hit.t));
            let blocked = bvh.blocked(triangles, &shadow_ray, hit.triangle, |_, _| true);
            let is_right = is_lit(lit, seen.order().place(x, y)) != blocked;
            ensure!(is_right, "the shadow at pixel ({x}, {y}) is wrong: {shape:?}");
            let is_seen = kd_tree.nearest(triangles, &ray, |_| true) == Some(hit);
            ensure!(is_seen, "the kd-tree's ray of pixel ({x}, {y}) hits something else: {shape:?}");
            let is_shadowed = kd_tree.blocked(triangles, &shadow_ray, hit.triangle, |_, _| true);
            ensure!(is_shadowed == blocked, "the kd-tree's shadow at pixel ({x}, {y}) is wrong: {shape:?}");
        }
        Ok(light)
    }

    /// Looks at the same sheet, and the light at its side, through the listed forms.
    fn run_listed(&mut self, sheet: &Sheet, shape: SheetShape, side_light: &LightSource) -> Result<()> {
        let (triangles, view, offset_pixels) = (sheet.mesh.triangles(), sheet.view, sheet.offset_pixels);
        let Self { listed_grid, listed_light_grid, seen, lit, other_seen, other_lit, .. } = self;
        listed_grid.build(triangles, &view, offset_pixels, ListedOptions::DEFAULT, |_| false)?;
        listed_grid.trace(triangles, Unmasked, other_seen);
        ensure!(other_seen.triangle == seen.triangle, "the listed grid sees other triangles: {shape:?}");
        let image = SeenImage { triangles, view, offset_pixels, seen: other_seen };
        other_lit.resize(lit.len(), 0);
        listed_light_grid.survey(&image);
        listed_light_grid.shadow(&image, side_light, |_| true, &Unmasked, other_lit);
        ensure!(other_lit == lit, "the listed light grid finds other shadows: {shape:?}");
        listed_light_grid.shadow(&image, &sheet.light, |_| true, &Unmasked, other_lit);
        self.listed += points(shape);
        self.are_all_lit(shape, "through lists")
    }

    /// Does the same through the uniform grid.
    fn run_uniform(&mut self, sheet: &Sheet, shape: SheetShape, side_light: &LightSource) -> Result<()> {
        let (triangles, view, offset_pixels) = (sheet.mesh.triangles(), sheet.view, sheet.offset_pixels);
        let Self { uniform_grid, seen, lit, other_seen, other_lit, .. } = self;
        uniform_grid.build(triangles);
        uniform_grid.see(triangles, &view, offset_pixels, |_| true, Unmasked, other_seen);
        ensure!(other_seen.triangle == seen.triangle, "the uniform grid sees other triangles: {shape:?}");
        let image = SeenImage { triangles, view, offset_pixels, seen: other_seen };
        other_lit.resize(lit.len(), 0);
        uniform_grid.shadow(&image, side_light, |_| true, &Unmasked, other_lit);
        ensure!(other_lit == lit, "the uniform grid finds other shadows: {shape:?}");
        uniform_grid.shadow(&image, &sheet.light, |_| true, &Unmasked, other_lit);
        self.are_all_lit(shape, "through the uniform grid")
    }

    /// Whether the light at the camera lit every pixel when another form was asked last.
    fn are_all_lit(&self, shape: SheetShape, how: &str) -> Result<()> {
        let order = self.seen.order();
        for (x, y) in (0..shape.side).flat_map(|y| (0..shape.side).map(move |x| (x, y))) {
            ensure!(is_lit(&self.other_lit, order.place(x, y)), "pixel ({x}, {y}) shadows itself, {how}: {shape:?}");
        }
        Ok(())
    }
}

/// How many pixels, and so points, a sheet has.
fn points(shape: SheetShape) -> u64 {
    u64::from(shape.side).pow(2)
}

fn is_lit(lit: &[u16], place: usize) -> bool {
    lit[place / TileOrder::BLOCK_PLACES] >> (place % TileOrder::BLOCK_PLACES) & 1 == 1
}
