use super::worker::{HitCandidate, ScanWorker};
use super::{Asked, Job};
use crate::predicate::hits;
use crate::{Hit, Ray};

/// Memory for settling a tile.
#[derive(Debug, Default)]
pub(super) struct Settle {
    rays: Vec<Ray>,
    pairs: Vec<(u32, u32)>,
    hits: Vec<Option<Hit>>,
    best: Vec<Option<Hit>>,
    all: Vec<(u32, Hit)>,
}

impl ScanWorker {
    /// Settles all candidates of the tile's lines by the predicate.
    pub(super) fn settle(&mut self, job: &Job<'_>) {
        let Self { slots, candidates, settle, hits: to, met, .. } = self;
        let Settle { rays, pairs, hits: found, best, all } = settle;
        rays.clear();
        rays.extend(slots.line.iter().map(|&line| job.lines.ray(line as usize)));
        pairs.clear();
        let is_left = |of: &&HitCandidate| of.earliest <= slots.far[of.slot as usize];
        pairs.extend(candidates.iter().filter(is_left).map(|of| (of.slot, of.id)));
        found.clear();
        found.resize(pairs.len(), None);
        hits(job.level, job.triangles, rays, pairs, found);
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
            // A line may appear more than once.
            Asked::Any => met.extend(found.map(|(slot, _)| slots.line[slot as usize])),
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
