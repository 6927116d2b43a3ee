use std::collections::HashMap;

use crate::dispatch;
use fearless_simd::Simd;
use fearless_simd::prelude::*;

use super::LightGrid;
use super::boxes::{FaceBox, SplatBox};
use super::filter::{TilePoints, enqueue, may_touch};
use super::set_up::{GroupCorners, Record, SetUp};
use super::settle::Settler;
use super::trace::{QUEUE, Tracer};
use super::worker::{ShadowTile, ShadowWorker};
use crate::LightSource;
use crate::patches::Patches;
use crate::predicate::ShadowRay;
use crate::shot::{Cone, SeenImage};
use crate::simd::lanes::bits_of;
use crate::simd::vectors::LANES;

/// Maps the points that the pixels of `shot` have `seen` to each face of a light, and checks them. All triangles are taken
/// to be opaque.
///
/// It asks the predicate about every triangle and point, so it takes long for large images.
///
/// # Errors
/// Names the first point or triangle that breaks a rule. Every point is mapped to a face or known as an outlier, and in one
/// slot of one part. A triangle that shadows a point of a part is among its candidates, and isn't ruled out by its bounds or
/// by the filter. No other triangle is found to shadow it for certain.
///
/// # Panics
/// If `survey` wasn't called for `seen`.
pub(super) fn validate(
    grid: &mut LightGrid,
    image: SeenImage<'_>,
    patches: &Patches,
    light: &LightSource,
) -> Result<(), String> {
    let SeenImage { shot, seen } = image;
    let slots = seen.triangle.len();
    let mut found = vec![false; slots];
    let survey = std::mem::take(&mut grid.survey);
    let (settler, tiles) = (Settler::of_image(image, survey.rays, light, grid.level), &survey.tiles);
    let rays: Vec<_> = (0..slots).map(|index| shot.shadow_ray(seen, index, light)).collect();
    let (mut result, mut number) = (Ok(()), 0);
    let mut outliers = Vec::new();
    let is_light = grid.visit_faces(patches, &settler, tiles, |grid, face| {
        if result.is_ok() {
            let tracer = Tracer::new(face, patches, &grid.on_face, &settler);
            let mut worker = ShadowWorker::default();
            let tiles = (0..tiles.len()).filter(|&tile| face.may_own(&tiles[tile]));
            result = tiles
                .into_iter()
                .try_for_each(|tile| tracer.validate_tile(&mut worker, tile, &rays, &mut found))
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

/// The filter's verdicts on a triangle and the points of a slot.
#[derive(Clone, Copy)]
struct Verdicts {
    /// The points that it may shadow.
    possible: u16,
    /// The possible points that it certainly shadows; the predicate decides the others.
    certain: u16,
    /// The reason why it shadows none of the rest.
    why: &'static str,
}

impl Verdicts {
    const fn none(why: &'static str) -> Self {
        Self { possible: 0, certain: 0, why }
    }
}

impl Tracer<'_> {
    fn validate_tile(
        &self,
        worker: &mut ShadowWorker,
        tile: usize,
        rays: &[Option<ShadowRay>],
        found: &mut [bool],
    ) -> Result<(), String> {
        dispatch!(self.settler.level, simd => self.begin(simd, worker, tile));
        let mut in_tile = HashMap::new();
        for part in 0..worker.parts.parts.len() {
            for slot in 0..LANES {
                for (index, _) in points_of(worker, part, slot) {
                    if let Some(other) = in_tile.insert(index, (part, slot)) {
                        return Err(format!("the point of pixel {index} is in {other:?} and {:?}", (part, slot)));
                    }
                    found[index] = true;
                }
            }
            dispatch!(self.settler.level, simd => self.validate_part(simd, worker, part, rays))?;
        }
        Ok(())
    }

    /// Checks every triangle against the points of a part, patch by patch, since a patch is set up for all of them.
    #[inline(always)]
    fn validate_part<S: Simd>(
        &self,
        simd: S,
        worker: &mut ShadowWorker,
        part: usize,
        rays: &[Option<ShadowRay>],
    ) -> Result<(), String> {
        self.find_candidates(simd, worker, part..part + 1);
        let slots: Vec<_> = (0..LANES).filter(|&slot| worker.parts.parts[part].points[slot] != 0).collect();
        let mut is_in_patch = vec![false; self.settler.opacity.triangles.len()];
        let (mut set_up, mut queue) = (SetUp::EMPTY, [0; QUEUE]);
        for number in 0..self.patches.len() {
            let candidate =
                worker.batch.candidates.iter().find(|candidate| candidate.number as usize == number).copied();
            for group in self.groups(number) {
                let boxes = candidate.map(|candidate| {
                    let corners = GroupCorners::new(simd, &group);
                    let of_group = corners.bounds(simd, self.face, &worker.tile.extent);
                    self.set_up(simd, &mut set_up, &group, &corners, &worker.tile.extent);
                    [candidate.around, of_group]
                });
                for &slot in &slots {
                    let part_points = &worker.parts.parts[part];
                    let end = enqueue(simd, &set_up, part_points, 1 << slot, &mut queue);
                    let inside = boxes.map(|boxes| self.inside(simd, worker, (part, slot), boxes));
                    for triangle in bits_of(group.filled) {
                        let id = group.ids[triangle];
                        is_in_patch[id as usize] = true;
                        let of_patch = || match inside {
                            None => Verdicts::none("it is in no candidate"),
                            Some(0) => Verdicts::none("bounds of triangles around it are elsewhere"),
                            Some(_) if !queue[..end].contains(&((triangle * LANES + slot) as u32)) => {
                                Verdicts::none("its bounds are elsewhere")
                            }
                            Some(inside) => {
                                let verdicts = self.verdicts(simd, worker, (part, slot), &set_up.record(triangle, id));
                                Verdicts { possible: verdicts.possible & inside, ..verdicts }
                            }
                        };
                        let of_large = self.verdicts_of_large(simd, worker, (part, slot), id);
                        self.compare(worker, (part, slot), id, &of_large.unwrap_or_else(of_patch), rays)?;
                    }
                }
            }
        }
        for id in (0..is_in_patch.len()).filter(|&id| !is_in_patch[id]) {
            let id = id as u32;
            for &slot in &slots {
                let of_large = self.verdicts_of_large(simd, worker, (part, slot), id);
                let verdicts = of_large.unwrap_or(Verdicts::none("it is in no patch"));
                self.compare(worker, (part, slot), id, &verdicts, rays)?;
            }
        }
        Ok(())
    }

    /// Compares the verdicts on a triangle with the predicate.
    fn compare(
        &self,
        worker: &ShadowWorker,
        (part, slot): (usize, usize),
        id: u32,
        verdicts: &Verdicts,
        rays: &[Option<ShadowRay>],
    ) -> Result<(), String> {
        if !self.settler.opacity.is_there(id) {
            return Ok(());
        }
        let Ok(corners) = self.settler.opacity.triangles.usable_corners(id) else { return Ok(()) };
        for (index, lane) in points_of(worker, part, slot) {
            let Some(ray) = rays[index].as_ref().filter(|_| self.settler.points.own()[index] != id) else { continue };
            let (is_possible, is_certain) = (verdicts.possible >> lane & 1 == 1, verdicts.certain >> lane & 1 == 1);
            match ray.blocked_by(corners) {
                Some(_) if !is_possible => {
                    return Err(format!("triangle {id} shadows the point of pixel {index}, but {}", verdicts.why));
                }
                None if is_certain => {
                    return Err(format!("triangle {id} doesn't shadow the point of pixel {index}"));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The points of a slot that are in all of some boxes, as are some of the bounds of the slot.
    #[inline(always)]
    fn inside<S: Simd>(
        &self,
        simd: S,
        worker: &ShadowWorker,
        (part, slot): (usize, usize),
        boxes: [FaceBox; 2],
    ) -> u16 {
        let part = &worker.parts.parts[part];
        let points = TilePoints::new(worker.tile.first, &worker.tile.blocks, self.settler.points.own());
        boxes.iter().fold(u16::MAX, |inside, around| {
            let around = SplatBox::new(simd, around);
            let is_reached = part.boxes.reached(simd, &around).to_bitmask() >> slot & 1 == 1;
            inside & if is_reached { points.inside(simd, part.blocks[slot], &around) } else { 0 }
        })
    }

    /// The verdicts on a triangle that is tested as a large one.
    #[inline(always)]
    fn verdicts_of_large<S: Simd>(
        &self,
        simd: S,
        worker: &ShadowWorker,
        at: (usize, usize),
        id: u32,
    ) -> Option<Verdicts> {
        let records = worker.batch.large.iter().filter(|(record, _)| record.id == id);
        // Of two planes one may be turned the wrong way.
        let either = |one: Verdicts, other: Verdicts| Verdicts {
            possible: one.possible | other.possible,
            certain: one.certain | other.certain,
            why: one.why,
        };
        records.map(|(record, _)| self.verdicts(simd, worker, at, record)).reduce(either)
    }

    #[inline(always)]
    fn verdicts<S: Simd>(
        &self,
        simd: S,
        worker: &ShadowWorker,
        (part, slot): (usize, usize),
        record: &Record,
    ) -> Verdicts {
        let ShadowTile { first, blocks, .. } = &worker.tile;
        let part = &worker.parts.parts[part];
        if may_touch(simd, &record.quads, &part.boxes) >> slot & 1 == 0 {
            return Verdicts::none("the filter says that it touches none of the block's points");
        }
        let points = TilePoints::new(*first, blocks, self.settler.points.own());
        let found = points.test(simd, &record.quads, record.id, (part.blocks[slot], !part.points[slot]));
        let certain = found.certain(simd, record.errors);
        Verdicts { possible: found.possible, certain, why: "the filter says that it doesn't" }
    }
}

/// The points in a slot of a part: the indices of their pixels, and their lanes.
fn points_of(worker: &ShadowWorker, part: usize, slot: usize) -> impl Iterator<Item = (usize, usize)> {
    let part = &worker.parts.parts[part];
    let (block, points) = (usize::from(part.blocks[slot]), part.points[slot]);
    let first = worker.tile.first + block * LANES;
    (0..LANES).filter(move |lane| points >> lane & 1 == 1).map(move |lane| (first + lane, lane))
}
