use super::samples::{BLOCKS, Doubt};
use super::trace::TileTrace;
use crate::Hit;
use crate::camera_grid::depth;
use crate::camera_grid::lanes::LANES;
use crate::predicate::crossing;
use crate::shot::work::Kind;
use crate::shot::{SeenPixels, TileOrder};

impl<const N: usize> TileTrace<'_, N> {
    pub(super) fn settle_if_many(&mut self) {
        const MANY: usize = 1 << 14;
        if self.samples.doubts.len() >= MANY {
            self.settle();
        }
    }

    /// Has the predicate decide whatever is still in doubt.
    pub(super) fn settle(&mut self) {
        if self.samples.doubts.is_empty() {
            return;
        }
        self.tally.undecided += self.samples.doubts.len() as u64;
        let mut doubts = std::mem::take(&mut self.samples.doubts);
        for doubt in doubts.drain(..) {
            let place = doubt.place as usize;
            self.work.add(Kind::Undecided, place..place + 1, 1);
            if doubt.high >= self.samples.low[place] {
                self.refer(doubt);
            }
        }
        self.samples.doubts = doubts;
    }

    #[cold]
    #[inline(never)]
    fn refer(&mut self, doubt: Doubt) {
        let place = doubt.place as usize;
        let (x, y) = self.pixel(place);
        let (width, height) = self.space.size();
        if x >= width || y >= height {
            return;
        }
        let best = self.samples.triangle[place];
        let corners = |id: u32| self.triangles.corners(id);
        // A copy of the best with a higher id never wins.
        if best < doubt.triangle && corners(best) == corners(doubt.triangle) {
            return;
        }
        self.tally.referred += 1;
        let ray = self.space.ray(x, y);
        let hit = |id: u32| {
            let crossing = crossing(&ray, corners(id))?;
            let is_there = crossing.front || !self.grid.options.culls_back_faces;
            let hit = Hit { t: crossing.t, triangle: id, barycentric: crossing.barycentric };
            (is_there && ray.t_min < hit.t && hit.t < ray.t_max).then_some(hit)
        };
        let Some(new) = hit(doubt.triangle).filter(|hit| self.mask.is_solid(hit)) else { return };
        let old = if best == SeenPixels::NONE { None } else { hit(best) };
        let nearest = match old {
            Some(old) if (old.t, old.triangle) < (new.t, new.triangle) => old,
            _ => new,
        };
        let inverse = (1.0 / nearest.t) as f32;
        (self.samples.low[place], self.samples.high[place]) = (inverse.next_down(), inverse.next_up());
        self.samples.triangle[place] = nearest.triangle;
    }

    /// Fills in the inverse depths that the filter left out, in f64 or by the predicate.
    pub(super) fn refine(&mut self, inverse_depth: &mut [f32]) {
        for (place, inverse_depth) in inverse_depth.iter_mut().enumerate() {
            let id = self.samples.triangle[place];
            if inverse_depth.is_nan() && id != SeenPixels::NONE {
                self.tally.refined += 1;
                let (x, y) = self.pixel(place);
                let (ray, corners) = (self.space.ray(x, y), self.triangles.corners(id));
                let of_predicate = || crossing(&ray, corners).map(|crossing| SeenPixels::inverse_of(crossing.t));
                let refined = depth::inverse_depth(&ray, corners).or_else(of_predicate);
                *inverse_depth = refined.unwrap_or(f32::NAN);
            }
        }
    }

    /// Column and row in the image of a place in the tile.
    pub(super) fn pixel(&self, place: usize) -> (u32, u32) {
        let (block, sample) = (place / LANES, place % LANES);
        let side = TileOrder::BLOCK as usize;
        let x = self.corner.x as u32 + (block % BLOCKS * side + sample % side) as u32;
        let y = self.corner.y as u32 + (block / BLOCKS * side + sample / side) as u32;
        (x, y)
    }
}
