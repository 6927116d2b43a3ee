//! A scene's triangles and what answers questions about them, each brought up to date when it is asked.

use umbrage::rays::predicate;
use umbrage::rays::{
    Bvh, DirectGrids, ImageTooLarge, LightSource, Lit, LitBits, LitShare, Omitted, Receivers, Scan, Scanned, Scanner,
    SeenPixels, Shot, Structure, Sweep, Triangles, View,
};

use super::answers::Answers;
use super::meshes::Meshes;
use crate::camera::middle;

/// All of a scene.
#[derive(Debug, Default)]
pub(super) struct State {
    pub(super) meshes: Meshes,
    bvh: Built<Bvh>,
    scanner: Built<Scanner>,
    grids: Built<DirectGrids>,
}

/// A structure, and whether it is of the triangles as they are.
#[derive(Debug, Default)]
struct Built<S> {
    structure: S,
    is_current: bool,
}

impl<S> Built<S> {
    fn brought(&mut self, build: impl FnOnce(&mut S)) -> &mut S {
        if !self.is_current {
            build(&mut self.structure);
            self.is_current = true;
        }
        &mut self.structure
    }
}

impl State {
    /// The meshes, to change them.
    pub(super) fn change(&mut self) -> &mut Meshes {
        (self.bvh.is_current, self.scanner.is_current, self.grids.is_current) = (false, false, false);
        &mut self.meshes
    }

    /// The hierarchy and its triangles.
    pub(super) fn rays(&mut self) -> (&Bvh, Triangles<'_>) {
        let triangles = self.meshes.triangles();
        (self.bvh.brought(|bvh| bvh.build(triangles)), triangles)
    }

    fn scanner(&mut self) -> (&mut Scanner, Triangles<'_>) {
        let triangles = self.meshes.triangles();
        (self.scanner.brought(|scanner| scanner.build(triangles)), triangles)
    }

    /// The triangles that no ray can hit.
    pub(super) fn omitted(&self) -> Omitted {
        self.meshes.triangles().omitted()
    }

    /// What directions hit.
    pub(super) fn scan(&mut self, sweep: Sweep<'_>, [t_min, t_max]: [f64; 2], returns: usize) -> Scanned {
        let (scanner, triangles) = self.scanner();
        let mut scanned = Scanned::default();
        scanner.scan(&Scan { t_min, t_max, ..Scan::new(triangles, &[sweep]) }, returns, &mut scanned);
        scanned
    }

    /// Which directions hit anything.
    pub(super) fn scan_any(&mut self, sweep: Sweep<'_>, [t_min, t_max]: [f64; 2], hit: &mut Vec<bool>) {
        let (scanner, triangles) = self.scanner();
        let mut bits = Vec::new();
        scanner.hits_any(&Scan { t_min, t_max, ..Scan::new(triangles, &[sweep]) }, &mut bits);
        spread_bits(&bits, sweep.directions.len(), hit);
    }

    /// What the pixels of a view show.
    pub(super) fn see(&mut self, view: View) -> Result<Answers, ImageTooLarge> {
        let Self { meshes, grids, .. } = self;
        let triangles = meshes.triangles();
        let grids = grids.brought(|grids| grids.build(triangles));
        let mut seen = SeenPixels::default();
        grids.see(&Shot::new(triangles, view), &mut seen)?;
        let (width, count) = (view.width as usize, view.width as usize * view.height as usize);
        let mut answers = Answers::with_capacity(count);
        answers.find(count, |pixel| {
            let id = seen.triangle_at((pixel % width) as u32, (pixel / width) as u32);
            if id == SeenPixels::NONE { None } else { predicate::hit(&middle(&view, pixel), triangles, id) }
        });
        Ok(answers)
    }

    /// Which points lights reach: for the first light all points, then for the next one.
    pub(super) fn lit(&mut self, receivers: Receivers<'_>, lights: &[LightSource], lit: &mut Vec<bool>) {
        let (scanner, triangles) = self.scanner();
        let mut bits = LitBits::default();
        scanner.lit(&Lit::new(triangles, receivers), lights, &mut bits);
        for light in 0..bits.lights() {
            spread_bits(bits.of_light(light), bits.points(), lit);
        }
    }

    /// How much of each triangle's area lights reach.
    pub(super) fn lit_areas(&mut self, lights: &[LightSource], samples: u32, shares: &mut Vec<LitShare>) {
        let (scanner, triangles) = self.scanner();
        scanner.lit_areas(triangles, lights, samples, shares);
    }
}

/// Adds a value for each of so many bits.
fn spread_bits(words: &[u64], count: usize, values: &mut Vec<bool>) {
    let end = values.len() + count;
    values.reserve(words.len() * 64);
    for &word in words {
        values.extend((0..64).map(|bit| word >> bit & 1 == 1));
    }
    values.truncate(end);
}
