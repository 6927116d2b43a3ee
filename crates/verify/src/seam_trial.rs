use std::fmt;
use std::slice;

use anyhow::{Result, ensure};
use glam::Vec3;
use umbrage_papers::{KdTree, KdTreeOptions, ListedGrids, UniformGrid};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Bvh, DirectGrids, LightMask, LightSource, SeenPixels, Shot, SingleRays as _, Structure};

use crate::{Random, Seams, Sheet, SheetShape};

/// Sends rays at the shared edges and corners of random sheets' triangles, through all grids, and counts them.
///
/// The structures are used again and again.
#[derive(Debug)]
pub struct SeamTrial {
    sheets: usize,
    others_every: usize,
    grids: DirectGrids,
    /// Structures that answer whole images in another way, by name.
    others: [(&'static str, Box<dyn Structure>); 2],
    kd_tree: KdTree,
    bvh: Bvh,
    seen: SeenPixels,
    /// Masks of a light at the camera, and of one at the side.
    masks: [LightMask; 2],
    /// Answers of the other structures.
    other_seen: SeenPixels,
    other_masks: [LightMask; 2],
    /// Number of rays through vertices and edges, and of others.
    seams: Seams,
    between: u64,
    /// Number of points that were also lit from the side.
    beside: u64,
    /// Number of camera rays through the other structures.
    by_others: u64,
    undecided: u64,
}

impl SeamTrial {
    /// Makes empty structures. One sheet in `others_every` is also lit from the side, and compared with the answers of
    /// other structures, which takes several times as long.
    ///
    /// # Errors
    /// Only if the kd-tree's options are impossible, which they aren't.
    pub fn new(others_every: usize) -> Result<Self> {
        let mut kd_tree = KdTree::default();
        kd_tree.set_options(KdTreeOptions::FAST)?;
        Ok(Self {
            sheets: 0,
            others_every,
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

    /// Number of camera rays so far exactly through vertices and edges.
    #[must_use]
    pub fn at_seams(&self) -> u64 {
        self.seams.vertices + self.seams.edges
    }

    /// Tests a random sheet, taking each kind of position in turn.
    ///
    /// # Errors
    /// With the first leak, or the first point that shadows itself.
    pub fn next(&mut self, random: &mut Random) -> Result<()> {
        let (position, scale) = SheetShape::PLACES[self.sheets % SheetShape::PLACES.len()];
        self.sheets += 1;
        let has_shell = position == Vec3::ZERO && random.below(3) == 0;
        let side = if has_shell { 128 } else { 512 };
        let (step, is_orthographic) = ([1, 2, 2, 4][random.below(4)], random.below(4) == 0);
        self.look_at(SheetShape { side, step, position, scale, is_orthographic, has_shell }, random)
    }

    /// Tests one sheet.
    fn look_at(&mut self, shape: SheetShape, random: &mut Random) -> Result<()> {
        let sheet = Sheet::new(shape, random);
        let shot = Shot { offset_pixels: sheet.offset_pixels, ..Shot::new(sheet.mesh.triangles(), sheet.view) };
        let Self { grids, seen, masks: [at_camera, _], .. } = self;
        grids.build(shot.triangles);
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
        if random.below(self.others_every) == 0 {
            let light = self.run_beside(&shot, shape, random)?;
            if shape.has_shell || random.below(4) == 0 {
                self.run_others(&shot, shape, [sheet.light, light])?;
            }
        }
        Ok(())
    }

    /// Lights the sheet from the side, from where it does shadow itself, and compares some pixels with the hierarchy
    /// and the kd-tree. Returns the light.
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

    /// Compares the same sheet, and its lights, with the other structures.
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

impl fmt::Display for SeamTrial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { seams: Seams { vertices, edges }, between, beside, by_others, undecided, .. } = self;
        write!(
            f,
            "{} camera rays exactly at seams, {vertices} at vertices and {edges} at edges, and {between} between them; from \
             each point a shadow ray to a light at the camera, and from {beside} one to a light at the side; {by_others} of \
             the latter through the listed grids and the uniform grid as well; {undecided} tests went to the predicate",
            vertices + edges
        )
    }
}

/// Checks that a light at the camera lights every pixel.
fn are_all_lit(mask: &LightMask, shape: SheetShape, how: &str) -> Result<()> {
    for (x, y) in pixels(shape) {
        ensure!(mask.is_lit(x, y), "pixel ({x}, {y}) shadows itself, through {how}: {shape:?}");
    }
    Ok(())
}

/// Number of pixels, and so of points, of a sheet.
fn points(shape: SheetShape) -> u64 {
    u64::from(shape.side).pow(2)
}

fn pixels(shape: SheetShape) -> impl Iterator<Item = (u32, u32)> {
    (0..shape.side).flat_map(move |y| (0..shape.side).map(move |x| (x, y)))
}
