use super::job::{Asked, Job};
use super::lines::Lines;
use super::worker::{Candidate, Worker};
use crate::predicate::{ShadowRay, hits};
use crate::{Hit, Ray};

/// Room for what is settled at once.
#[derive(Debug, Default)]
pub(super) struct Settle {
    rays: Vec<Ray>,
    pairs: Vec<(u32, u32)>,
    hits: Vec<Option<Hit>>,
    best: Vec<Option<Hit>>,
    all: Vec<(u32, Hit)>,
}

impl Worker {
    /// Asks the predicate about all triangles that lines may hit.
    pub(super) fn settle(&mut self, job: &Job<'_>) {
        if matches!(job.lines, Lines::Points { .. }) {
            self.settle_points(job);
        } else {
            self.settle_rays(job);
        }
    }

    fn settle_rays(&mut self, job: &Job<'_>) {
        let Self { slots, candidates, settle, hits: to, met, .. } = self;
        let Settle { rays, pairs, hits: found, best, all } = settle;
        rays.clear();
        rays.extend(slots.line.iter().map(|&line| job.lines.ray(line as usize)));
        pairs.clear();
        let is_left = |of: &&Candidate| of.earliest <= slots.far[of.slot as usize];
        pairs.extend(candidates.iter().filter(is_left).map(|of| (of.slot, of.id)));
        found.clear();
        found.resize(pairs.len(), None);
        hits(job.level.0, job.triangles, rays, pairs, found);
        let found = pairs.iter().zip(found.iter()).filter_map(|(&(slot, id), hit)| {
            hit.filter(|hit| job.stops(&rays[slot as usize], id, hit.barycentric)).map(|hit| (slot, hit))
        });
        match job.asked {
            Asked::Nearest => {
                best.clear();
                best.resize(slots.len(), None);
                for (slot, hit) in found {
                    let best = &mut best[slot as usize];
                    if best.is_none_or(|best| (hit.t, hit.triangle) < (best.t, best.triangle)) {
                        *best = Some(hit);
                    }
                }
                to.extend(slots.line.iter().zip(best).filter_map(|(&line, best)| best.map(|hit| (line, hit))));
            }
            Asked::All => {
                all.clear();
                all.extend(found);
                all.sort_unstable_by(|(a, x), (b, y)| {
                    a.cmp(b).then(x.t.total_cmp(&y.t)).then(x.triangle.cmp(&y.triangle))
                });
                to.extend(all.iter().map(|&(slot, hit)| (slots.line[slot as usize], hit)));
            }
            // Some lines come more than once.
            Asked::Any => met.extend(found.map(|(slot, _)| slots.line[slot as usize])),
        }
    }

    fn settle_points(&mut self, job: &Job<'_>) {
        let Lines::Points { light, points, .. } = &job.lines else { return };
        let Self { slots, candidates, met, .. } = self;
        candidates.sort_unstable_by_key(|of| of.slot);
        for of_slot in candidates.chunk_by(|a, b| a.slot == b.slot) {
            let slot = of_slot[0].slot as usize;
            if slots.far[slot] == f32::NEG_INFINITY {
                continue;
            }
            let line = slots.line[slot];
            let ray = ShadowRay::new(light, points[line as usize].point);
            let is_blocked = of_slot.iter().any(|of| {
                let Ok(corners) = job.triangles.usable_corners(of.id) else { return false };
                let is_there = || job.all_stop || job.sides.stop_light(light, of.id, corners);
                ray.blocked_by(corners)
                    .is_some_and(|at| is_there() && (job.all_stop || job.opacity.is_stopped_at(of.id, at)))
            });
            if is_blocked {
                met.push(line);
            }
        }
    }
}

impl Settle {
    pub(super) fn bytes(&self) -> usize {
        self.rays.capacity() * size_of::<Ray>()
            + self.pairs.capacity() * size_of::<(u32, u32)>()
            + (self.hits.capacity() + self.best.capacity()) * size_of::<Option<Hit>>()
            + self.all.capacity() * size_of::<(u32, Hit)>()
    }
}
