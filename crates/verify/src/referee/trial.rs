//! Compares every structure with the referee.

use rayon::{ThreadPool, ThreadPoolBuilder};
use umbrage_rays::{LightMask, SeenPixels, SimdLevel, Structure};

use crate::structures::STRUCTURES;
use crate::{Case, Truth};

/// All structures, each with every SIMD level of the machine, on one, two and five threads.
pub struct Trial {
    structures: Vec<(&'static str, SimdLevel, Box<dyn Structure>)>,
    pools: [ThreadPool; 3],
    seen: SeenPixels,
    masks: Vec<LightMask>,
    /// Number of answers so far: for a pixel, or for a point and a light.
    pub answers: u64,
}

impl Trial {
    /// Empty structures.
    ///
    /// # Panics
    /// If the machine can't start threads.
    #[must_use]
    pub fn new() -> Self {
        let levels = SimdLevel::available();
        let structures =
            STRUCTURES.iter().flat_map(|&(name, make)| levels.iter().map(move |&level| (name, level, make(level))));
        let pool = |threads: usize| ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        Self {
            structures: structures.collect(),
            pools: [1, 2, 5].map(pool),
            seen: SeenPixels::default(),
            masks: Vec::new(),
            answers: 0,
        }
    }

    /// Compares all structures with a case's truth; returns the disagreements.
    pub fn disagreements(&mut self, case: &Case, truth: &Truth) -> Vec<String> {
        let Self { structures, pools, seen, masks, answers } = self;
        let mut wrong = Vec::new();
        for (number, (name, level, structure)) in structures.iter_mut().enumerate() {
            let pool = &pools[number % pools.len()];
            let found = pool.install(|| answer(&mut **structure, case, seen, masks));
            *answers += ((1 + case.lights.len()) * truth.triangle.len()) as u64;
            let threads = pool.current_num_threads();
            if let Err(how) = found.and_then(|()| compare(case, truth, seen, masks)) {
                wrong.push(format!("{name}, {level}, {threads} threads: {how}"));
            }
        }
        wrong
    }
}

impl Default for Trial {
    fn default() -> Self {
        Self::new()
    }
}

fn answer(
    structure: &mut dyn Structure,
    case: &Case,
    seen: &mut SeenPixels,
    masks: &mut Vec<LightMask>,
) -> Result<(), String> {
    let shot = case.shot();
    structure.build(shot.triangles);
    structure.see(&shot, seen).map_err(|error| error.to_string())?;
    masks.resize_with(case.lights.len(), LightMask::default);
    structure.shadow(&shot, seen, &case.lights, masks);
    Ok(())
}

/// Compares the triangle of each pixel, and the lights that reach it, with the truth.
///
/// # Errors
/// With the first pixel that differs.
pub fn compare(case: &Case, truth: &Truth, seen: &SeenPixels, masks: &[LightMask]) -> Result<(), String> {
    for ((x, y), &expected) in case.pixels().zip(&truth.triangle) {
        let found = seen.triangle_at(x, y);
        if found != expected {
            return Err(format!("pixel ({x}, {y}) shows {} instead of {}", Shown(found), Shown(expected)));
        }
    }
    for ((light, mask), lit) in case.lights.iter().zip(masks).zip(&truth.lit) {
        for ((x, y), &expected) in case.pixels().zip(lit) {
            if mask.is_lit(x, y) != expected {
                let light_reaches = if expected { "doesn't reach" } else { "reaches" };
                return Err(format!("pixel ({x}, {y}): {light:?} {light_reaches} it"));
            }
        }
    }
    Ok(())
}

/// A pixel's triangle, for messages.
struct Shown(u32);

impl std::fmt::Display for Shown {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0 == SeenPixels::NONE { f.write_str("nothing") } else { write!(f, "triangle {}", self.0) }
    }
}
