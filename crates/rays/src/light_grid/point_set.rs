use std::mem;

use crate::parallel::Parallel;
use fearless_simd::Simd;
use glam::DVec3;
use rayon::prelude::*;

use super::face::Face;
use super::points::{TILE_BLOCKS, block_of};
use super::survey::SurveyedTile;
use crate::LightSource;
use crate::hilbert::along_hilbert_curve;
use crate::predicate::{HitPoint, ShadowRay};
use crate::shot::{CameraRays, EightPoints, SeenImage, SeenPixels, TileOrder};
use crate::simd::lanes::LANES;

/// The points that a light is tested for. Each has an index, and there are full tiles of them.
#[derive(Clone, Copy)]
pub enum PointSet<'a> {
    /// The points that an image's pixels show.
    Seen(SeenImage<'a>, CameraRays),
    /// Any points.
    Listed(&'a PointList),
}

impl<'a> PointSet<'a> {
    /// The triangles that points are on.
    pub fn own(&self) -> &'a [u32] {
        match self {
            Self::Seen(image, _) => &image.seen.triangle,
            Self::Listed(list) => &list.own,
        }
    }

    /// The direction of a face's X where that can be: the image's rows, else any direction.
    pub(crate) fn along(&self) -> DVec3 {
        match self {
            Self::Seen(_, rays) => rays.step_x,
            Self::Listed(_) => DVec3::X,
        }
    }

    /// The predicate's error of a point at `position`, in perspective in relation to its p.z.
    pub(crate) fn error_at(&self, face: &Face, position: DVec3, depth: f64) -> f64 {
        match self {
            Self::Seen(_, rays) => face.point_error_at(rays, rays.forward.dot(position - rays.position), depth),
            Self::Listed(list) if face.is_parallel => list.bounds.largest_error,
            Self::Listed(list) => list.bounds.largest_error / depth,
        }
    }

    /// Eight points in relation to a light.
    #[inline(always)]
    pub(crate) fn eight<S: Simd>(&self, simd: S, indices: [u32; 8], light: DVec3) -> EightPoints<S> {
        match self {
            Self::Seen(image, rays) => EightPoints::find(simd, image, rays, indices, light),
            Self::Listed(list) => {
                let at = |index: u32| list.points.get(index as usize).unwrap_or(&PointList::NOWHERE);
                EightPoints::new(simd, indices.map(|index| *at(index)), light)
            }
        }
    }

    /// Whether a point exists, at a known depth of its pixel.
    #[inline(always)]
    pub(crate) fn is_known(&self, index: usize) -> bool {
        match self {
            Self::Seen(SeenImage { seen, .. }, _) => {
                seen.triangle[index] != SeenPixels::NONE && !seen.inverse_depth[index].is_nan()
            }
            Self::Listed(list) => list.points[index].position.is_finite(),
        }
    }

    /// The segment between a light and a point; `None` if there is no such point.
    pub fn shadow_ray(&self, index: usize, light: &LightSource) -> Option<ShadowRay> {
        match self {
            Self::Seen(SeenImage { shot, seen }, _) => shot.shadow_ray(seen, index, light),
            Self::Listed(list) => {
                let point = list.points[index];
                point.position.is_finite().then(|| ShadowRay::new(light, point))
            }
        }
    }
}

/// Points in no image, or at other positions than the pixels show, in an order in which successive ones are near each other:
/// 4096 to a tile, and 16 to a block, of which 16 are a group. Slots beyond the last point are empty.
///
/// It takes 60 bytes a point. Keep it and fill it again: its memory is reused.
#[derive(Default)]
pub struct PointList {
    /// World positions.
    pub(super) points: Vec<HitPoint>,
    own: Vec<u32>,
    /// The caller's index of each point.
    numbers: Vec<u32>,
    /// x, y and z of each tile's points in relation to the middle of its bounds: NaN in empty slots.
    pub(super) offsets: Vec<[[f32; LANES]; 3]>,
    pub(crate) tiles: Vec<SurveyedTile>,
    /// Bounds of all points.
    bounds: Bounds,
    /// All points' positions along a curve when they were sorted, above their indices; missing points come last. Empty where
    /// points came in order.
    keys: Vec<u64>,
    /// Number of points that exist.
    listed: usize,
    /// The tiles' spread over the bounds when the points were sorted.
    sorted_spread: f64,
    /// The number of calls in a row in which the order couldn't stay, and the number of calls left that sort points without
    /// trying to keep it.
    failures: u32,
    rest: u32,
}

impl PointList {
    const NOWHERE: HitPoint = HitPoint { position: DVec3::NAN, error: 0.0 };

    /// The growth of the tiles' spread, since points were sorted, at which they are sorted again.
    const MOST_SPREAD: f64 = 1.2;

    /// Among points that fly apart, one call in this number, a power of two, tries whether their order may stay.
    const ONE_TRY_IN: u32 = 8;

    /// Replaces the points by the existing ones of `count`. Where the same ones exist as in the last call, and those of a
    /// tile are still about as near each other, their order stays.
    pub(crate) fn fill(&mut self, count: usize, point: impl Fn(usize) -> Option<(HitPoint, u32)> + Sync) {
        if !self.keys.is_empty() && self.keys.len() == count {
            if self.rest > 0 {
                self.rest -= 1;
            } else if self.fill_tiles(&point) && self.spread() <= Self::MOST_SPREAD * self.sorted_spread {
                self.failures = 0;
                return;
            } else {
                self.failures += 1;
                self.rest = (1 << self.failures.min(Self::ONE_TRY_IN.ilog2())) - 1;
            }
        }
        self.sort(count, &point);
        self.fill_tiles(&point);
        self.sorted_spread = self.spread();
    }

    /// Replaces the points by those of an image's `slots`, in their [`TileOrder`].
    pub(crate) fn fill_in_order(&mut self, slots: usize, point: impl Fn(usize) -> Option<(HitPoint, u32)> + Sync) {
        assert!(slots.is_multiple_of(TileOrder::TILE_PIXELS), "{slots} slots aren't full tiles");
        self.keys.clear();
        self.clear(slots);
        self.listed = self.each_tile(|tile, points| {
            let first = tile * TileOrder::TILE_PIXELS;
            points.fill((0..TileOrder::TILE_PIXELS).map(|slot| (slot, first + slot)), &point)
        });
    }

    /// Sorts `count` points along a curve through their bounds, with missing points behind them.
    fn sort(&mut self, count: usize, point: &(impl Fn(usize) -> Option<(HitPoint, u32)> + Sync)) {
        const CHUNK: usize = 1 << 12;
        const NOWHERE: u64 = u32::MAX as u64;
        let points = || (0..count).into_par_iter().with_min_len(CHUNK).map(|number| (number, point(number)));
        let bounds =
            points().fold(|| Bounds::EMPTY, |bounds, (_, point)| point.map_or(bounds, |(at, _)| bounds.with(at)));
        let bounds = bounds.reduce(|| Bounds::EMPTY, Bounds::union);
        let along = |(at, _): (HitPoint, u32)| u64::from(bounds.curve(at.position));
        let key = |(number, point): (usize, Option<_>)| point.map_or(NOWHERE, along) << 32 | number as u64;
        points().map(key).collect_into_vec(&mut self.keys);
        self.keys.par_sort_unstable();
        self.listed = self.keys.partition_point(|key| key >> 32 != NOWHERE);
    }

    /// Fills the tiles with the points in the order of their keys; whether the same points exist as when they were sorted.
    fn fill_tiles(&mut self, point: &(impl Fn(usize) -> Option<(HitPoint, u32)> + Sync)) -> bool {
        self.clear(self.listed.next_multiple_of(TileOrder::TILE_PIXELS));
        let all = mem::take(&mut self.keys);
        let (keys, nowhere) = all.split_at(self.listed);
        let found = self.each_tile(|tile, points| {
            let keys = keys[tile * TileOrder::TILE_PIXELS..].iter().take(TileOrder::TILE_PIXELS);
            points.fill(keys.enumerate().map(|(at, &key)| (slot_of(at), number_of(key))), point)
        });
        let are_the_same = found == self.listed && nowhere.par_iter().all(|key| point(number_of(*key)).is_none());
        self.keys = all;
        are_the_same
    }

    /// Makes `slots` empty slots.
    fn clear(&mut self, slots: usize) {
        let Self { points, own, numbers, offsets, tiles, .. } = self;
        points.clear();
        points.resize(slots, Self::NOWHERE);
        own.clear();
        own.resize(slots, SeenPixels::NONE);
        numbers.clear();
        numbers.resize(slots, u32::MAX);
        offsets.resize(slots / LANES, [[f32::NAN; LANES]; 3]);
        tiles.resize(slots / TileOrder::TILE_PIXELS, SurveyedTile::default());
    }

    /// Fills each tile with `fill`, which takes the tile's index and returns the bounds and the number of its points;
    /// returns the number of all.
    fn each_tile(&mut self, fill: impl Fn(usize, TilePoints<'_>) -> (Bounds, usize) + Sync) -> usize {
        let Self { points, own, numbers, offsets, tiles, .. } = self;
        let of_tile = points
            .par_chunks_mut(TileOrder::TILE_PIXELS)
            .zip(own.par_chunks_mut(TileOrder::TILE_PIXELS))
            .zip(numbers.par_chunks_mut(TileOrder::TILE_PIXELS))
            .zip(offsets.par_chunks_mut(TILE_BLOCKS));
        let found = of_tile.zip(tiles).enumerate().map(|(number, ((((points, own), numbers), offsets), tile))| {
            let (bounds, found) = fill(number, TilePoints { points, own, numbers, offsets });
            *tile = SurveyedTile { points: found as u32, has_unknown: false, corners: bounds.corners() };
            (bounds, found)
        });
        let (bounds, found) = found.merge(|a, b| (a.0.union(b.0), a.1 + b.1)).unwrap_or((Bounds::EMPTY, 0));
        self.bounds = bounds;
        found
    }

    /// The share of all points' bounds that a tile spans, in the mean along the three axes, summed over tiles.
    fn spread(&self) -> f64 {
        let size = |low: DVec3, high: DVec3| (high - low).element_sum();
        let of_tiles = self.tiles.iter().map(|tile| size(tile.corners[0], tile.corners[7]));
        of_tiles.sum::<f64>() / size(self.bounds.low, self.bounds.high)
    }

    /// The largest error of a point.
    pub(super) fn largest_error(&self) -> f64 {
        self.bounds.largest_error
    }

    /// The number of points.
    pub(crate) fn len(&self) -> usize {
        self.listed
    }

    /// The number of slots: full tiles.
    pub(crate) fn slots(&self) -> usize {
        self.points.len()
    }

    /// The middle of a tile's bounds, and half their extent along each axis.
    pub(super) fn middle(&self, tile: usize) -> (DVec3, DVec3) {
        let corners = &self.tiles[tile].corners;
        let bounds = Bounds { low: corners[0], high: corners[7], largest_error: 0.0 };
        (bounds.middle(), (bounds.high - bounds.low) * 0.5)
    }

    /// Calls `visit` with the index and the position of each point that isn't in `shadowed`, which has a word for each
    /// block.
    pub(crate) fn visit_lit(&self, shadowed: &[u16], mut visit: impl FnMut(usize, DVec3)) {
        let blocks = self.numbers.chunks_exact(LANES).zip(self.points.chunks_exact(LANES));
        for (word, (numbers, points)) in shadowed.iter().zip(blocks) {
            for (lane, (&number, point)) in numbers.iter().zip(points).enumerate() {
                if number != u32::MAX && word >> lane & 1 == 0 {
                    visit(number as usize, point.position);
                }
            }
        }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.points.capacity() * size_of::<HitPoint>()
            + (self.own.capacity() + self.numbers.capacity()) * size_of::<u32>()
            + self.offsets.capacity() * size_of::<[[f32; LANES]; 3]>()
            + self.tiles.capacity() * size_of::<SurveyedTile>()
            + self.keys.capacity() * size_of::<u64>()
    }
}

/// The slots of a tile, all still empty.
struct TilePoints<'a> {
    points: &'a mut [HitPoint],
    own: &'a mut [u32],
    numbers: &'a mut [u32],
    offsets: &'a mut [[[f32; LANES]; 3]],
}

impl TilePoints<'_> {
    /// Fills pairs of a slot and a point's index; returns the bounds and the number of the points that exist.
    fn fill(
        self,
        slots: impl Iterator<Item = (usize, usize)>,
        point: &impl Fn(usize) -> Option<(HitPoint, u32)>,
    ) -> (Bounds, usize) {
        let Self { points, own, numbers, offsets } = self;
        let (mut bounds, mut found) = (Bounds::EMPTY, 0);
        for (slot, number) in slots {
            if let Some((point, triangle)) = point(number) {
                (numbers[slot], points[slot], own[slot]) = (number as u32, point, triangle);
                bounds = bounds.with(point);
                found += 1;
            }
        }
        let middle = bounds.middle();
        for (points, offsets) in points.chunks_exact(LANES).zip(offsets) {
            for (lane, point) in points.iter().enumerate() {
                let offset = (point.position - middle).as_vec3();
                [offsets[0][lane], offsets[1][lane], offsets[2][lane]] = offset.to_array();
            }
        }
        (bounds, found)
    }
}

/// The index of the point with a key.
fn number_of(key: u64) -> usize {
    key as u32 as usize
}

/// The slot in its tile of the n-th point along the curve: groups follow each other, and blocks in these.
fn slot_of(at: usize) -> usize {
    let (group, block, lane) = (at / (LANES * LANES), at / LANES % LANES, at % LANES);
    block_of(group, block) * LANES + lane
}

/// A box around points.
#[derive(Clone, Copy)]
struct Bounds {
    low: DVec3,
    high: DVec3,
    largest_error: f64,
}

impl Default for Bounds {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Bounds {
    const EMPTY: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY, largest_error: 0.0 };

    fn with(self, HitPoint { position, error }: HitPoint) -> Self {
        self.union(Self { low: position, high: position, largest_error: error })
    }

    fn union(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            largest_error: self.largest_error.max(other.largest_error),
        }
    }

    fn middle(&self) -> DVec3 {
        self.low + (self.high - self.low) * 0.5
    }

    fn corners(&self) -> [DVec3; 8] {
        let [low, high] = [self.low, self.high];
        std::array::from_fn(|corner| {
            let of = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
            DVec3::new(of(0), of(1), of(2))
        })
    }

    /// A position's distance along Hilbert's curve through the bounds. Lights take 0.79 to 0.86 of the time for points in
    /// its order as for points in that of their coordinates' bits (`umbrage-bench lit`: cloth, forest, statue).
    fn curve(&self, position: DVec3) -> u32 {
        const CELLS: f64 = 1024.0;
        let size = (self.high - self.low).max_element();
        let scale = if size > 0.0 { CELLS * (1.0 - 1e-9) / size } else { 0.0 };
        let cells = ((position - self.low) * scale).to_array().map(|at| at as u32);
        along_hilbert_curve(cells)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// The positions of listed points by their indices, and whether they were sorted.
    fn fill(list: &mut PointList, points: &[DVec3]) -> (Vec<(u32, DVec3)>, bool) {
        let before = list.keys.clone();
        list.fill(points.len(), |number| {
            let position = points[number];
            position.is_finite().then_some((HitPoint { position, error: 0.0 }, number as u32))
        });
        let numbers = list.numbers.iter().zip(&list.points).filter(|(number, _)| **number != u32::MAX);
        let mut listed: Vec<_> = numbers.map(|(&number, point)| (number, point.position)).collect();
        listed.sort_unstable_by_key(|&(number, _)| number);
        (listed, list.keys != before)
    }

    #[test]
    fn points_are_sorted_again_where_they_are_others_or_further_apart() {
        let mut random = Random::new(7);
        let mut points: Vec<DVec3> =
            (0..20_000).map(|_| DVec3::from([0; 3].map(|_| f64::from(random.signed() as f32)))).collect();
        let mut list = PointList::default();
        let mut fill = |points: &[DVec3]| {
            list.rest = 0;
            let (listed, is_sorted) = fill(&mut list, points);
            let all = (0..).zip(points.iter().copied()).filter(|(_, position)| position.is_finite());
            assert!(listed.into_iter().eq(all), "other points are listed");
            is_sorted
        };
        assert!(fill(&points));
        points
            .iter_mut()
            .for_each(|point| *point = *point * 3.0 + 0.01 * DVec3::new(point.z, point.x, point.y) + DVec3::X);
        assert!(!fill(&points), "the same, moved a little");
        points.rotate_left(10_000);
        assert!(fill(&points), "elsewhere");
        points[5] = DVec3::NAN;
        assert!(fill(&points), "one fewer");
        (points[5], points[17]) = (DVec3::ONE, DVec3::INFINITY);
        assert!(fill(&points), "another one is nowhere");
        points[17] = DVec3::ZERO;
        assert!(fill(&points), "none is nowhere");
        points.pop();
        assert!(fill(&points), "of another count");
    }

    #[test]
    fn of_points_that_fly_apart_few_orders_are_tried() {
        let (mut random, mut list) = (Random::new(8), PointList::default());
        let tried = (0..50).filter(|_| {
            let points: Vec<DVec3> = (0..9_000).map(|_| DVec3::from([0; 3].map(|_| random.signed()))).collect();
            let failures = list.failures;
            fill(&mut list, &points);
            list.failures > failures
        });
        assert_eq!(tried.count(), 8, "one call in two, in four, then in eight");
    }
}
