use glam::DVec3;

use super::lines::Lines;
use super::spread::TILE_LINES;
use super::worker::{HitCandidate, ScanWorker};
use super::{Asked, Job, NearestAt, Scanned};
use crate::predicate::{RayList, hits_of};
use crate::{Hit, Ray};

/// Memory for settling a tile.
#[derive(Debug, Default)]
pub(super) struct Settle {
    pairs: Vec<(u32, u32)>,
    hits: Vec<Option<Hit>>,
    all: Vec<(u32, Hit)>,
}

/// A tile's lines, given by their slots.
struct TileLines<'a> {
    lines: &'a Lines<'a>,
    /// The index of the line in each slot.
    order: &'a [u32],
}

impl RayList for TileLines<'_> {
    #[inline(always)]
    fn ray(&self, slot: u32) -> Ray {
        self.lines.ray(self.order[slot as usize] as usize)
    }

    #[inline(always)]
    fn origin(&self, _: u32) -> DVec3 {
        self.lines.origin
    }

    #[inline(always)]
    fn direction(&self, slot: u32) -> DVec3 {
        self.lines.get(self.order[slot as usize] as usize)
    }

    #[inline(always)]
    fn interval(&self, _: u32) -> [f64; 2] {
        [self.lines.t_min, self.lines.t_max]
    }
}

impl ScanWorker {
    /// Settles the candidates of a tile's lines, by the predicate where f32 doesn't tell; the nearest hits come to
    /// `nearest`, a slot each.
    pub(super) fn settle(&mut self, job: &Job<'_>, lines: &Lines<'_>, order: &[u32], nearest: NearestAt<'_>) {
        let Self { slots, candidates, settle, hits: to, met, met_slots, .. } = self;
        let NearestAt { hits: nearest, ids: nearest_ids } = nearest;
        let Settle { pairs, hits: found, all } = settle;
        let rays = TileLines { lines, order };
        pairs.clear();
        candidates.retain(|of| of.earliest <= slots.far[usize::from(of.slot)]);
        if job.asked == Asked::NearestIds {
            settle_single(candidates, nearest_ids);
        }
        pairs.extend(candidates.iter().map(|of| (u32::from(of.slot), of.id)));
        found.clear();
        found.resize(pairs.len(), None);
        hits_of(job.level, job.scan.triangles, &rays, pairs, found);
        let found = pairs.iter().zip(found.iter()).filter_map(|(&(slot, id), hit)| {
            hit.filter(|hit| job.all_stop || job.stops(&rays.ray(slot), id, hit.barycentric)).map(|hit| (slot, hit))
        });
        let number = |slot: u32| lines.before + order[slot as usize] as usize;
        match job.asked {
            Asked::Nearest => {
                nearest.fill(Scanned::MISS);
                for (slot, hit) in found {
                    let nearest = &mut nearest[slot as usize];
                    // A miss has the largest t and the largest id.
                    if (hit.t, hit.triangle) < (nearest.t, nearest.triangle) {
                        *nearest = hit;
                    }
                }
            }
            Asked::NearestIds => {
                let mut nearest = [f64::INFINITY; TILE_LINES];
                for (slot, hit) in found {
                    let (t, id) = (&mut nearest[slot as usize], &mut nearest_ids[slot as usize]);
                    if (hit.t, hit.triangle) < (*t, *id) {
                        (*t, *id) = (hit.t, hit.triangle);
                    }
                }
            }
            Asked::All => {
                all.clear();
                all.extend(found);
                all.sort_unstable_by(|(a, x), (b, y)| {
                    a.cmp(b).then(x.t.total_cmp(&y.t)).then(x.triangle.cmp(&y.triangle))
                });
                to.extend(all.iter().map(|&(slot, hit)| (number(slot), hit)));
            }
            Asked::Any => {
                met.extend(met_slots.iter().map(|&slot| number(slot)));
                // A line may appear more than once.
                met.extend(found.map(|(slot, _)| number(slot)));
            }
        }
    }
}

/// Takes out each candidate that is certainly hit, and the only one of its line: its triangle is the nearest, and comes to
/// `nearest_ids`; the triangle of all other lines is none. So a scan for ids takes
/// 0.6 of the time of one for everything (a lidar in `demo:cloth` and `demo:statue`, two threads, AVX-512).
fn settle_single(candidates: &mut Vec<HitCandidate>, nearest_ids: &mut [u32]) {
    let mut counts = [0_u8; TILE_LINES];
    for of in candidates.iter() {
        let count = &mut counts[usize::from(of.slot)];
        *count = count.saturating_add(1);
    }
    nearest_ids.fill(Scanned::NONE);
    candidates.retain(|of| {
        let slot = usize::from(of.slot);
        let is_single = of.is_certain && counts[slot] == 1;
        if is_single {
            nearest_ids[slot] = of.id;
        }
        !is_single
    });
}

impl Settle {
    pub(super) fn bytes(&self) -> usize {
        self.pairs.capacity() * size_of::<(u32, u32)>()
            + self.hits.capacity() * size_of::<Option<Hit>>()
            + self.all.capacity() * size_of::<(u32, Hit)>()
    }
}
