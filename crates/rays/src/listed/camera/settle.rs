use super::samples::BLOCKS;
use super::trace::TileTrace;
use crate::camera_grid::depth;
use crate::camera_grid::lanes::LANES;
use crate::predicate::{crossing, settle};
use crate::shot::{Kind, SeenPixels, TileOrder};

impl<const N: usize> TileTrace<'_, N> {
    pub(super) fn settle_if_many(&mut self) {
        const MANY: usize = 1 << 14;
        if self.samples.doubts.len() >= MANY {
            self.settle();
        }
    }

    /// Settles whatever is still undecided.
    pub(super) fn settle(&mut self) {
        if self.samples.doubts.is_empty() {
            return;
        }
        self.tally.undecided += self.samples.doubts.len() as u64;
        let mut doubts = std::mem::take(&mut self.samples.doubts);
        for doubt in doubts.drain(..) {
            let index = doubt.place as usize;
            self.work.add(Kind::Undecided, index..index + 1, 1);
            let (x, y) = self.pixel(index);
            let (width, height) = self.space.size();
            if doubt.high < self.samples.low[index] || x >= width || y >= height {
                continue;
            }
            let best = self.samples.triangle[index];
            let settled = settle::nearest(self.shot, (x, y), best, doubt.triangle, &mut self.tally.settled);
            if let Some(nearest) = settled {
                let inverse = (1.0 / nearest.t) as f32;
                (self.samples.low[index], self.samples.high[index]) = (inverse.next_down(), inverse.next_up());
                self.samples.triangle[index] = nearest.triangle;
            }
        }
        self.samples.doubts = doubts;
    }

    /// Fills in the inverse depths that the filter left out, in f64 or by the predicate.
    pub(super) fn refine(&mut self, inverse_depth: &mut [f32]) {
        for (place, inverse_depth) in inverse_depth.iter_mut().enumerate() {
            let id = self.samples.triangle[place];
            if inverse_depth.is_nan() && id != SeenPixels::NONE {
                self.tally.refined += 1;
                let (x, y) = self.pixel(place);
                let (ray, corners) = (self.space.ray(x, y), self.shot.triangles.corners(id));
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
