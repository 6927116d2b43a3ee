//! Compares structures with the oracle.

use rayon::prelude::*;
use umbrage_rays::predicate::{HitPoint, ShadowRay, crossing};
use umbrage_rays::{
    Cone, Hit, LightCells, LightMask, PixelWork, SeenPixels, SimdLevel, SingleRays, Specialised, Structure, TileOrder,
};
use umbrage_verify::{Case, Truth, referee};

use crate::frames::on_threads;
use umbrage_verify::structures::Make;

/// A case with the oracle's answer, which all structures share.
pub(crate) struct Known {
    case: Case,
    truth: Truth,
    /// Minimum number of points of each light that are tested against all triangles, for a structure that counts them;
    /// empty if it doesn't matter.
    least_outliers: Vec<u64>,
}

impl Known {
    pub(crate) fn new(case: Case) -> Self {
        let truth = case.truth();
        // The referee doesn't support holes, and is slow.
        const EVERY: u32 = 13;
        let ids = 0..case.mesh.indices.len() as u32;
        if ids.len() < 3000 && ids.into_iter().all(|id| case.opacity.is_opaque(id) && case.shadow_opacity.is_opaque(id))
        {
            let some = |all: &[bool]| all.iter().step_by(EVERY as usize).copied().collect();
            let triangle = truth.triangle.iter().step_by(EVERY as usize).copied().collect();
            let some = Truth { triangle, lit: truth.lit.iter().map(|lit| some(lit)).collect() };
            assert!(some == referee::truth_of_some(&case, EVERY), "{}: the oracle is wrong", case.name);
        }
        Self { case, truth, least_outliers: Vec::new() }
    }

    /// With a truth from another source.
    pub(crate) fn with_truth(case: Case, truth: Truth) -> Self {
        Self { case, truth, least_outliers: Vec::new() }
    }

    pub(crate) fn with_outliers(self, least_outliers: &[u64]) -> Self {
        Self { least_outliers: least_outliers.into(), ..self }
    }
}

/// Finds the truth of some cases by the oracle.
pub(crate) fn known(cases: Vec<Case>) -> Vec<Known> {
    cases.into_par_iter().map(Known::new).collect()
}

/// Compares a structure's answers in some cases with the truth.
///
/// One structure of a SIMD level answers all its cases one after the other, so that leftovers of one case meet the
/// next; levels take turns.
pub(crate) fn check(make: Make, cases: &[Known]) {
    let levels = SimdLevel::available();
    let mut structures: Vec<_> = levels.iter().map(|&level| Asked::new(make(level))).collect();
    for (number, known) in cases.iter().enumerate() {
        let which = number % levels.len();
        if let Err(wrong) = structures[which].compare(known) {
            panic!("{}, number {number}, with {}: {wrong}", known.case.name, levels[which]);
        }
    }
}

/// Compares frame after frame with the truth, at every SIMD level with one structure.
pub(crate) fn check_sequence(make: Make, frames: &[Known]) {
    for level in SimdLevel::available() {
        let mut asked = Asked::new(make(level));
        for known in frames {
            if let Err(wrong) = asked.compare(known) {
                panic!("{}, with {level}: {wrong}", known.case.name);
            }
        }
    }
}

/// Compares two frames of each case with the truth, for every SIMD level and on one and several threads: in the second
/// frame, a structure may have built other patches.
pub(crate) fn check_frames(make: Make, cases: &[Known]) {
    for (number, level) in SimdLevel::available().into_iter().enumerate() {
        let mut asked = Asked::new(make(level));
        let threads = [1, 3][number % 2];
        on_threads(threads, || {
            for (known, frame) in cases.iter().flat_map(|known| [1, 2].map(|frame| (known, frame))) {
                asked.structure.build_parts(known.case.mesh.triangles(), known.case.parts());
                if let Err(wrong) = asked.compare_images(known) {
                    panic!("{}, frame {frame}, with {level} on {threads} threads: {wrong}", known.case.name);
                }
            }
        });
    }
}

/// A structure and its last answers.
struct Asked {
    structure: Box<dyn Structure>,
    seen: SeenPixels,
    masks: Vec<LightMask>,
    other_seen: SeenPixels,
    work: PixelWork,
    cells: LightCells,
}

impl Asked {
    fn new(structure: Box<dyn Structure>) -> Self {
        let (seen, other_seen) = (SeenPixels::default(), SeenPixels::default());
        Self {
            structure,
            seen,
            masks: Vec::new(),
            other_seen,
            work: PixelWork::default(),
            cells: LightCells::default(),
        }
    }

    /// Checks each pixel, and all other answers of a structure.
    fn compare(&mut self, known: &Known) -> Result<(), String> {
        let Known { case, truth, .. } = known;
        // In a second frame of the same triangles a structure may be built differently; every second case has one.
        for _ in 0..=case.mesh.indices.len() % 2 {
            self.structure.build_parts(case.mesh.triangles(), case.parts());
        }
        self.compare_images(known)?;
        self.validate(case)?;
        self.compare_specialised(case)?;
        self.structure.single_rays().map_or(Ok(()), |rays| compare_single_rays(case, truth, rays))
    }

    /// Checks the seen triangles and the masks of a structure that is built.
    fn compare_images(&mut self, known: &Known) -> Result<(), String> {
        let Known { case, truth, least_outliers } = known;
        let Self { structure, seen, masks, .. } = self;
        let shot = case.shot();
        structure.see(&shot, seen).map_err(|error| error.to_string())?;
        compare_seen(case, truth, seen)?;
        ensure(*structure.omitted() == shot.triangles.omitted(), || format!("omitted {:?}", structure.omitted()))?;

        // Old contents of masks must not show through.
        masks.resize_with(case.lights.len(), LightMask::default);
        for mask in masks.iter_mut() {
            mask.resize(seen.order());
            mask.blocks_mut().fill(u16::MAX);
        }
        let all = structure.shadow(&shot, seen, &case.lights, masks);
        for ((light, mask), lit) in case.lights.iter().zip(&*masks).zip(&truth.lit) {
            let wrong = case.pixels().zip(lit).find(|&((x, y), &lit)| mask.is_lit(x, y) != lit);
            ensure(wrong.is_none(), || format!("{light:?}: pixel {wrong:?} by the oracle"))?;
            let beyond = mask.count() - lit.iter().filter(|&&lit| lit).count();
            ensure(beyond == 0, || format!("{light:?}: {beyond} bits beyond the image"))?;
        }
        let of_lights = structure.work_of_lights();
        if !of_lights.is_empty() {
            ensure(of_lights.len() == case.lights.len(), || format!("the work of {} lights", of_lights.len()))?;
            let outliers: Vec<u64> = of_lights.iter().map(|work| work.counts.outliers).collect();
            ensure(all.counts.outliers == outliers.iter().sum::<u64>(), || {
                format!("{} outliers", all.counts.outliers)
            })?;
            let enough = outliers.iter().zip(least_outliers).all(|(found, least)| found >= least);
            ensure(enough, || format!("{outliers:?} outliers"))?;
        }
        Ok(())
    }

    fn validate(&mut self, case: &Case) -> Result<(), String> {
        self.structure.validate(&case.shot(), &self.seen, &case.lights).map_err(|broken| format!("invalid: {broken}"))
    }

    /// Checks that counting changes no answer, and that points are in the cells that count them.
    fn compare_specialised(&mut self, case: &Case) -> Result<(), String> {
        let Self { structure, seen, other_seen, work, cells, .. } = self;
        let Some(specialised) = structure.specialised() else { return Ok(()) };
        let shot = case.shot();
        let specialised: &mut dyn Specialised = specialised;
        specialised.see_counting(&shot, other_seen, work).map_err(|error| error.to_string())?;
        ensure(is_same(seen, other_seen), || "counting changes what is seen".to_owned())?;
        let Some(light) = case.lights.first() else { return Ok(()) };
        specialised.locate(&shot, seen, light, cells);
        let wrong = case.pixels().find(|&(x, y)| {
            let is_located = cells.at(x, y).is_some();
            is_located != (cells.points_at(x, y) > 0) || (is_located && seen.triangle_at(x, y) == SeenPixels::NONE)
        });
        ensure(wrong.is_none(), || format!("{light:?}: pixel {wrong:?} is in a cell that doesn't count it"))
    }
}

fn ensure(holds: bool, otherwise: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(otherwise()) }
}

fn compare_seen(case: &Case, truth: &Truth, seen: &SeenPixels) -> Result<(), String> {
    let (shot, order) = (case.shot(), seen.order());
    ensure(order.size() == (case.view.width, case.view.height), || format!("an image of {:?}", order.size()))?;
    for ((x, y), &expected) in case.pixels().zip(&truth.triangle) {
        let found = seen.triangle_at(x, y);
        ensure(found == expected, || format!("pixel ({x}, {y}) shows {found} instead of {expected}"))?;
        let inverse_depth = seen.inverse_depth[order.index(x, y)];
        if expected == SeenPixels::NONE {
            ensure(inverse_depth.is_nan(), || format!("pixel ({x}, {y}) of nothing has the depth {inverse_depth}"))?;
            continue;
        }
        let crossing = crossing(&shot.ray(x, y), shot.triangles.corners(expected)).expect("what is seen is hit");
        let truth = 1.0 / crossing.t;
        let off = (f64::from(inverse_depth) - truth).abs() / truth;
        let is_known = (1e-30..1e30).contains(&crossing.t);
        let is_right =
            if is_known { off <= f64::from(SeenPixels::RELATIVE_ERROR) } else { off.is_nan() || off <= 1e-5 };
        ensure(is_right, || format!("pixel ({x}, {y}) has 1/t {inverse_depth} instead of {truth}"))?;
    }
    let beyond =
        (0..order.slots()).find(|&slot| order.pixel(slot).is_none() && seen.triangle[slot] != SeenPixels::NONE);
    ensure(beyond.is_none(), || format!("slot {beyond:?} beyond the image shows something"))
}

/// Some of the pixels as single rays.
fn compare_single_rays(case: &Case, truth: &Truth, rays: &dyn SingleRays) -> Result<(), String> {
    const EVERY: usize = 5;
    let (shot, triangles) = (case.shot(), case.mesh.triangles());
    for (index, (x, y)) in case.pixels().enumerate().step_by(EVERY) {
        let ray = shot.ray(x, y);
        let stops = |hit: &Hit| {
            let is_there = case.sides.stop(&ray, hit.triangle, triangles.corners(hit.triangle));
            let opacity = shot.opacity;
            is_there && (opacity.is_opaque(hit.triangle) || opacity.stops(hit.triangle, hit.barycentric))
        };
        let hit = rays.nearest(triangles, &ray, &stops);
        let (found, expected) = (hit.map_or(SeenPixels::NONE, |hit| hit.triangle), truth.triangle[index]);
        ensure(found == expected, || format!("the ray of ({x}, {y}) hits {found} instead of {expected}"))?;
        let Some(hit) = hit else { continue };
        for (light, lit) in case.lights.iter().zip(&truth.lit) {
            let shadow_ray = ShadowRay::new(light, HitPoint::new(&ray, hit.t));
            let opacity = shot.shadow_opacity;
            let stops = |id: u32, at: [f32; 2]| {
                let is_there = case.sides.stop_light(light, id, triangles.corners(id));
                is_there && (opacity.is_opaque(id) || opacity.stops(id, at))
            };
            let is_blocked = rays.blocked(triangles, &shadow_ray, hit.triangle, &stops);
            let is_in_cone = Cone::of(light).is_none_or(|cone| cone.contains(shadow_ray.point()));
            ensure((is_in_cone && !is_blocked) == lit[index], || {
                format!("{light:?}: the shadow ray of ({x}, {y}) is {is_blocked}")
            })?;
        }
    }
    Ok(())
}

/// Equal to the last bit; NaN equals itself.
pub(crate) fn is_same(a: &SeenPixels, b: &SeenPixels) -> bool {
    let bits = |seen: &SeenPixels| seen.inverse_depth.iter().map(|depth| depth.to_bits()).collect::<Vec<_>>();
    a.order() == b.order() && a.triangle == b.triangle && bits(a) == bits(b)
}

/// Wrong answers are noticed.
mod tests {
    use super::*;
    use umbrage_verify::lights::point;
    use umbrage_verify::views::{camera, view};
    use umbrage_verify::{Case, TestMesh};

    #[test]
    fn comparisons_fail_where_they_should() {
        let lights = [point(glam::Vec3::new(0.5, 3.0, 1.0))];
        let known = || Known::new(Case::new("room", TestMesh::room(), view(camera(), 20, 10), &lights));
        let mut direct = Asked::new(Box::new(umbrage_rays::DirectGrids::default()));
        assert_eq!(direct.compare(&known()), Ok(()));
        let mut other = known();
        other.truth.triangle[31] ^= 1;
        assert!(direct.compare(&other).is_err_and(|wrong| wrong.starts_with("pixel (11, 1) shows")));
        let mut other = known();
        other.truth.lit[0][47] ^= true;
        assert!(direct.compare(&other).is_err_and(|wrong| wrong.contains("pixel Some(((7, 2)")));
        let other = known().with_outliers(&[1]);
        assert!(direct.compare(&other).is_err_and(|wrong| wrong.contains("[0] outliers")));
        assert_eq!(direct.seen.order(), TileOrder::new(20, 10));
    }
}
