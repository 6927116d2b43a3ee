use std::collections::HashMap;

use fearless_simd::dispatch;

use super::LightGrid;
use super::settle::Settler;
use super::trace::{Tracer, Verdict};
use super::worker::Worker;
use crate::LightSource;
use crate::predicate::ShadowRay;
use crate::shot::{SeenImage, SeenPixels, Shot};
use crate::simd::vectors::LANES;

/// Brings what the pixels of `shot` have `seen` to each face of a light, and checks it. All triangles are taken to be opaque.
///
/// It asks the predicate about every triangle and point, so it takes long for large images.
///
/// # Errors
/// Names the first point or triangle that breaks a rule. Every point is mapped to a face or known as an outlier, and in one
/// slot of one part. A triangle that shadows a point of a part is among its candidates, and isn't ruled out by its bounds
/// or by the filter; one that doesn't isn't found to shadow it for certain.
///
/// # Panics
/// If `survey` wasn't called for `seen`.
pub(super) fn validate(
    grid: &mut LightGrid,
    shot: &Shot<'_>,
    seen: &SeenPixels,
    light: &LightSource,
) -> Result<(), String> {
    let slots = seen.triangle.len();
    let mut found = vec![false; slots];
    let settler = grid.settler(SeenImage { shot, seen }, light);
    let rays: Vec<_> = (0..slots).map(|index| shot.shadow_ray(seen, index, light)).collect();
    let (mut result, mut number) = (Ok(()), 0);
    let mut outliers = Vec::new();
    let is_light = grid.visit_faces(&settler, |grid, face| {
        if result.is_ok() {
            let tracer = Tracer::new(face, &grid.survey, &grid.patches, &grid.on_face, &settler);
            let mut worker = Worker::default();
            let tiles = (0..grid.survey.tiles.len()).filter(|&tile| face.may_own(&grid.survey.tiles[tile]));
            result = tiles
                .into_iter()
                .try_for_each(|tile| tracer.validate_tile(&settler, &mut worker, tile, &rays, &mut found))
                .map_err(|broken| format!("face {number}: {broken}"));
            outliers.extend_from_slice(&worker.outliers);
            number += 1;
        }
    });
    result?;
    for &index in outliers.iter().chain(&grid.survey.unknown) {
        found[index as usize] = true;
    }
    let is_lost = |&index: &usize| seen.triangle[index] != SeenPixels::NONE && !found[index];
    match (0..slots).filter(|_| is_light).find(is_lost) {
        Some(index) => Err(format!("the point of pixel {index} is on no face")),
        None => Ok(()),
    }
}

impl Tracer<'_> {
    fn validate_tile(
        &self,
        settler: &Settler<'_>,
        worker: &mut Worker,
        tile: usize,
        rays: &[Option<ShadowRay>],
        found: &mut [bool],
    ) -> Result<(), String> {
        let triangles = settler.image.shot.triangles;
        let places = self.slots_of_triangles();
        dispatch!(settler.level.0, simd => self.begin(simd, worker, tile));
        self.forget(worker);
        let mut in_tile = HashMap::new();
        for part in 0..worker.parts.parts.len() {
            dispatch!(settler.level.0, simd => self.find_candidates(simd, worker, part..part + 1));
            for slot in 0..LANES {
                let (block, points) = (worker.parts.parts[part].blocks[slot], worker.parts.parts[part].points[slot]);
                for lane in (0..LANES).filter(|lane| points >> lane & 1 == 1) {
                    let index = worker.tile.first + usize::from(block) * LANES + lane;
                    if let Some(other) = in_tile.insert(index, (part, slot)) {
                        return Err(format!("the point of pixel {index} is in {other:?} and {:?}", (part, slot)));
                    }
                    found[index] = true;
                    let Some(ray) = &rays[index] else { continue };
                    let own = settler.image.seen.triangle[index];
                    for id in (0..triangles.len() as u32).filter(|&id| id != own) {
                        let Ok(corners) = triangles.usable_corners(id) else { continue };
                        let is_shadowed = ray.blocked_by(corners).is_some();
                        let place = places.get(&id).copied();
                        let verdict = dispatch!(settler.level.0, simd =>
                            self.verdict(simd, worker, part, slot, lane, id, place));
                        match (is_shadowed, verdict) {
                            (true, Verdict::NotShadowed(why)) => {
                                return Err(format!("triangle {id} shadows the point of pixel {index}, but {why}"));
                            }
                            (false, Verdict::Shadowed) => {
                                return Err(format!("triangle {id} doesn't shadow the point of pixel {index}"));
                            }
                            _ => {}
                        }
                    }
                }
            }
        }
        Ok(())
    }
}
