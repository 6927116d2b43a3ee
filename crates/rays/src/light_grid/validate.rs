use std::collections::HashMap;

use fearless_simd::{Simd, dispatch};

use super::LightGrid;
use super::boxes::SplatBox;
use super::candidates::Batch;
use super::points::TILE_BLOCKS;
use super::set_up::{Record, SetUp};
use super::settle::Settler;
use super::test::{PartPoints, QUEUE, enqueue, may_touch};
use super::trace::Tracer;
use super::worker::{Tile, Worker};
use crate::LightSource;
use crate::patches::Patches;
use crate::predicate::ShadowRay;
use crate::shot::{Cone, SeenImage, SeenPixels, Shot};
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
    patches: &Patches,
    seen: &SeenPixels,
    light: &LightSource,
) -> Result<(), String> {
    let slots = seen.triangle.len();
    let mut found = vec![false; slots];
    let survey = std::mem::take(&mut grid.survey);
    let (settler, tiles) = (grid.settler(SeenImage { shot, seen }, &survey, light), &survey.tiles);
    let rays: Vec<_> = (0..slots).map(|index| shot.shadow_ray(seen, index, light)).collect();
    let (mut result, mut number) = (Ok(()), 0);
    let mut outliers = Vec::new();
    let is_light = grid.visit_faces(patches, &settler, tiles, |grid, face| {
        if result.is_ok() {
            let tracer = Tracer::new(face, patches, &grid.on_face, &settler);
            let mut worker = Worker::default();
            let tiles = (0..tiles.len()).filter(|&tile| face.may_own(&tiles[tile]));
            result = tiles
                .into_iter()
                .try_for_each(|tile| tracer.validate_tile(&settler, &mut worker, tile, &rays, &mut found))
                .map_err(|broken| format!("face {number}: {broken}"));
            outliers.extend_from_slice(&worker.outliers);
            number += 1;
        }
    });
    outliers.extend_from_slice(&survey.unknown);
    grid.survey = survey;
    result?;
    for &index in &outliers {
        found[index as usize] = true;
    }
    let cone = Cone::of(light);
    let is_reached = |ray: &ShadowRay| cone.is_none_or(|cone| cone.contains(ray.point()));
    let is_lost = |&index: &usize| !found[index] && rays[index].as_ref().is_some_and(is_reached);
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
        let triangles = settler.opacity.triangles;
        let slots = self.slots_of_triangles();
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
                    let own = settler.points.own()[index];
                    for id in (0..triangles.len() as u32).filter(|&id| id != own && settler.opacity.is_there(id)) {
                        let Ok(corners) = triangles.usable_corners(id) else { continue };
                        let is_shadowed = ray.blocked_by(corners).is_some();
                        let slot_of_triangle = slots.get(&id).copied();
                        let verdict = dispatch!(settler.level.0, simd =>
                            self.verdict(simd, worker, part, slot, lane, id, slot_of_triangle));
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

/// What the filter alone says about a point and a triangle, for `validate`.
enum Verdict {
    /// The triangle shadows the point for certain.
    Shadowed,
    /// It doesn't, for this reason.
    NotShadowed(&'static str),
    /// The predicate has to say.
    Undecided,
}

impl Tracer<'_> {
    /// The patch of each triangle, and its slot in that.
    fn slots_of_triangles(&self) -> HashMap<u32, (usize, usize)> {
        let patches = 0..self.patches.len();
        let of_patch = |number| {
            let patch = self.patches.get(number);
            patch.ids[..patch.count].iter().enumerate().map(move |(slot, &id)| (id, (number, slot)))
        };
        patches.flat_map(of_patch).collect()
    }

    /// Forgets what was set up for another tile's [`verdict`](Self::verdict).
    fn forget(&self, worker: &mut Worker) {
        worker.batch.set_ups.clear();
    }

    /// What the filter says about a triangle, which is in this slot of a patch, and the point in a lane of a slot of a
    /// part; after candidates were found for this part alone.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "a point and a triangle, each by the slots that it is in")]
    fn verdict<S: Simd>(
        &self,
        simd: S,
        worker: &mut Worker,
        part: usize,
        slot: usize,
        lane: usize,
        id: u32,
        slot_of_triangle: Option<(usize, usize)>,
    ) -> Verdict {
        let Worker { tile, parts, batch, .. } = worker;
        let Tile { first, extent, blocks, .. } = tile;
        let part = &parts.parts[part];
        let points = PartPoints::new(part, *first, blocks, &[0; TILE_BLOCKS], self.settler.points.own());
        let of_record = |record: &Record| {
            let [a, b, c] = &record.quads;
            let found = points.test(simd, [a, b, c], record.id, slot);
            if may_touch(simd, &record.quads, &part.boxes) >> slot & 1 == 0 || found.possible >> lane & 1 == 0 {
                Verdict::NotShadowed("the filter says that it doesn't")
            } else if found.certain(simd, record.errors) >> lane & 1 == 1 {
                Verdict::Shadowed
            } else {
                Verdict::Undecided
            }
        };
        let mut large = batch.large.iter().filter(|(record, _)| record.id == id);
        if let Some((first, _)) = large.next() {
            // Of two planes one may be turned the wrong way.
            return match (of_record(first), large.next()) {
                (Verdict::NotShadowed(_), Some((second, _))) => of_record(second),
                (verdict, _) => verdict,
            };
        }
        let Some((number, triangle)) = slot_of_triangle else { return Verdict::NotShadowed("it is in no patch") };
        if !batch.candidates.iter().any(|candidate| candidate.number as usize == number) {
            return Verdict::NotShadowed("it is in no candidate");
        }
        let Batch { set_ups, queue, .. } = batch;
        // Most that are asked about in a row are of the same patch.
        if set_ups.first().is_none_or(|set_up| set_up.number as usize != number) {
            set_ups.resize(1, SetUp::EMPTY);
            self.set_up(simd, &mut set_ups[0], number as u32, extent);
        }
        let set_up = &set_ups[0];
        let whole = SplatBox::new(simd, &part.whole);
        queue.resize(QUEUE, 0);
        let end = enqueue(simd, set_up, part, &whole, 1 << slot, queue);
        if !queue[..end].contains(&((triangle * LANES + slot) as u32)) {
            return Verdict::NotShadowed("its bounds are elsewhere");
        }
        of_record(&set_up.record(triangle, id))
    }
}
