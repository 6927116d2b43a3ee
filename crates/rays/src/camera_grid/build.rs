use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f32x16, i32x16, mask32x16};
use glam::Vec3;
use rayon::prelude::*;

use super::bins::{Bins, Fragment, Listed, Path};
use super::general::General;
use super::lanes::{Corners, DepthPlane, LANES, PixelBounds, Setup, largest, splat};
use super::pixel_space::{HALF_ULP, PixelSpace, Vertex};
use super::tile::Batch;
use super::{ImageTooLarge, PerspectiveGrid};
use crate::shot::{Opacity, Shot, Sides, TileOrder};
use crate::simd::lanes::{bits_of, max3, min3};
use crate::simd::{each, vectorized};
use crate::{SimdLevel, Triangles};

impl PerspectiveGrid {
    /// Replaces the grid by one of the triangles of `shot` for its pixels' rays. Runs on all threads of the current pool.
    ///
    /// # Errors
    /// If a side of the image is longer than [`ImageTooLarge::LARGEST_SIDE`].
    pub(super) fn build(&mut self, shot: &Shot<'_>) -> Result<(), ImageTooLarge> {
        ImageTooLarge::check(&shot.view)?;
        let space = PixelSpace::new(shot);
        self.space = Some(space);
        self.triangle_count = shot.triangles.len();
        project(self.level, &space, shot.triangles, &mut self.vertices);
        self.set_up(&space, shot);
        self.omitted.clear();
        for range in &self.ranges {
            self.omitted.append(&range.omitted);
        }
        Ok(())
    }

    /// Sorts triangles to tiles, in ranges whose number doesn't depend on that of threads.
    fn set_up(&mut self, space: &PixelSpace, shot: &Shot<'_>) {
        const SMALLEST_RANGE: usize = 4096;
        const MOST_RANGES: usize = 64;
        let Shot { triangles, opacity, sides, .. } = *shot;
        let count = triangles.len();
        let ranges = count.div_ceil(SMALLEST_RANGE).clamp(1, MOST_RANGES);
        let length = count.div_ceil(ranges).next_multiple_of(LANES);
        let level = self.level.0;
        let (columns, rows) = self.tiles();
        self.ranges.resize_with(ranges, Bins::default);
        let vertices = &self.vertices;
        let facing = space.facing(sides);
        let opacity = (!opacity.are_all_opaque()).then_some(opacity);
        self.ranges.par_iter_mut().enumerate().with_max_len(1).for_each(|(range, bins)| {
            bins.reset(columns, rows);
            let ids = (range * length).min(count)..((range + 1) * length).min(count);
            let set_up = SetUp { space, triangles, vertices, opacity, facing, sides, bins };
            dispatch!(level, simd => set_up.range(simd, ids));
        });
    }
}

/// Projects each vertex once, and one more that stands for those that are out of range.
pub(crate) fn project(level: SimdLevel, space: &PixelSpace, triangles: Triangles<'_>, vertices: &mut Vec<Vertex>) {
    const CHUNK: usize = 4096;
    vertices.resize(triangles.positions.len() + 1, Vertex::AWKWARD);
    if let Some(last) = vertices.last_mut() {
        *last = Vertex::AWKWARD;
    }
    let chunks = vertices.par_chunks_mut(CHUNK).zip(triangles.positions.par_chunks(CHUNK));
    chunks.for_each(|(vertices, positions)| dispatch!(level.0, simd => space.project(simd, positions, vertices)));
}

/// The set-up of one range of triangles.
struct SetUp<'a> {
    space: &'a PixelSpace,
    triangles: Triangles<'a>,
    vertices: &'a [Vertex],
    /// `None` where all triangles are opaque: asking about each took 4 to 10 % of seeing.
    opacity: Option<&'a dyn Opacity>,
    /// The sign of the area in pixel space of triangles that show their front; zero where all have both sides.
    facing: f32,
    sides: Sides<'a>,
    bins: &'a mut Bins,
}

impl SetUp<'_> {
    #[inline(always)]
    fn range<S: Simd>(mut self, simd: S, ids: Range<usize>) {
        let end = ids.end;
        for first in ids.step_by(LANES) {
            let batch = &self.triangles.indices[first..end.min(first + LANES)];
            let lanes = (1_u64 << batch.len()) - 1;
            let corners = Corners::load(simd, self.vertices, batch);
            let ordinary = min3(corners.inverse_depth).simd_gt(splat(simd, 0.0)).to_bitmask();
            let behind = max3(corners.inverse_depth).simd_le(splat(simd, Vertex::BEHIND)).to_bitmask();
            for lane in bits_of(lanes & !(ordinary | behind)) {
                self.set_aside(simd, (first + lane) as u32);
            }
            let mut ordinary = ordinary & lanes;
            for lane in bits_of(corners.coincide().to_bitmask() & lanes & (ordinary | behind)) {
                if self.is_without_area((first + lane) as u32) {
                    ordinary &= !(1 << lane);
                }
            }
            let bounds = PixelBounds::new(simd, self.space, &corners);
            let seen = bounds.x[0].simd_le(bounds.x[1]) & bounds.y[0].simd_le(bounds.y[1]);
            let mut seen = seen.to_bitmask() & ordinary;
            if seen == 0 {
                continue;
            }
            if self.facing != 0.0 {
                let backs = self.sides.sixteen_backs(first as u32);
                seen &= backs | self.fronts(simd, first as u32, &corners, &bounds, seen & !backs);
            }
            let masked = self.opacity.map_or(0, |opacity| {
                let masked = bits_of(seen).filter(|lane| !opacity.is_opaque((first + lane) as u32));
                masked.fold(0, |masked, lane| masked | 1 << lane)
            });
            if masked != 0 {
                seen &= !masked;
                self.list_in_tiles(simd, Path::Masked, first as u32, &corners, &bounds, masked);
            }
            let one = splat(simd, 1.0);
            let tiny = (bounds.x[1] - bounds.x[0]).simd_le(one) & (bounds.y[1] - bounds.y[0]).simd_le(one);
            let tiny_lanes = tiny.to_bitmask() & seen;
            if tiny_lanes != 0 {
                self.leave_fragments(simd, first as u32, &corners, &bounds, tiny_lanes);
            }
            if seen != tiny_lanes {
                self.list_in_tiles(simd, Path::Ordinary, first as u32, &corners, &bounds, seen & !tiny_lanes);
            }
        }
    }

    /// Which of some triangles show their front: those whose area is certain, and those that the predicate says do.
    #[inline(always)]
    fn fronts<S: Simd>(&self, simd: S, first: u32, corners: &Corners<S>, bounds: &PixelBounds<S>, lanes: u64) -> u64 {
        let [area, bound] = corners.signed_area(simd, bounds.error);
        let area = area * splat(simd, self.facing);
        let (mut fronts, backs) = (area.simd_gt(bound).to_bitmask(), area.simd_lt(-bound).to_bitmask());
        for lane in bits_of(lanes & !(fronts | backs)) {
            fronts |= u64::from(self.space.sees_front(self.triangles.corners(first + lane as u32))) << lane;
        }
        fronts
    }

    /// Lists a triangle on the general path, or counts it where no ray can hit it.
    #[cold]
    #[inline(never)]
    fn set_aside<S: Simd>(&mut self, simd: S, id: u32) {
        match self.triangles.usable_corners(id) {
            Err(why) => self.bins.omitted.note(id, why),
            Ok(corners) if !self.sides.has_back(id) && !self.space.sees_front(corners) => {}
            Ok(corners) => {
                let is_opaque = self.opacity.is_none_or(|opacity| opacity.is_opaque(id));
                let path = if is_opaque { Path::General } else { Path::MaskedGeneral };
                self.list_general(simd, path, id, corners);
            }
        }
    }

    /// Lists a triangle where its edge functions in f64 don't rule it out.
    #[cold]
    #[inline(never)]
    fn list_general<S: Simd>(&mut self, simd: S, path: Path, id: u32, corners: [Vec3; 3]) {
        let (space, bins) = (self.space, &mut *self.bins);
        let general = General::new(space, corners);
        vectorized!(simd => bins.list_general(simd, space, path, id, &general));
    }

    /// Whether no ray can hit a triangle with finite corners, which is counted then.
    #[cold]
    #[inline(never)]
    fn is_without_area(&mut self, id: u32) -> bool {
        let unusable = self.triangles.usable_corners(id).err();
        unusable.inspect(|&why| self.bins.omitted.note(id, why)).is_some()
    }

    /// Tests tiny triangles at once, in coordinates with an origin at the first of their two by two samples.
    #[inline(always)]
    fn leave_fragments<S: Simd>(
        &mut self,
        simd: S,
        first: u32,
        corners: &Corners<S>,
        bounds: &PixelBounds<S>,
        tiny_lanes: u64,
    ) {
        // Coordinates are below four, so their own rounding is below 4 half ulps.
        let error = bounds.error + splat(simd, 4.0 * HALF_ULP);
        // Pixels are as far outside of the bounds as their samples may be from them, and samples as far again.
        let shift = self.space.shifts.reach();
        let overhang = 0.01 + 2.0 * shift;
        let x = each!(x in corners.x => x - bounds.x[0]);
        let y = each!(y in corners.y => y - bounds.y[0]);
        let setup = Setup::new(simd, x, y, corners.inverse_depth, error, 1.0 + shift, overhang);
        let odd_columns = is_odd(simd, bounds.x[0], self.space.middle.x);
        let odd_rows = is_odd(simd, bounds.y[0], self.space.middle.y);
        let certain = setup.is_certain(simd);
        let tiny = mask32x16::from_bitmask(simd, tiny_lanes);
        let columns: [f32; LANES] = bounds.x[0].into();
        let rows: [f32; LANES] = bounds.y[0].into();
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (right, down) = (splat(simd, dx as f32), splat(simd, dy as f32));
            let valid = (bounds.x[0] + right).simd_le(bounds.x[1]) & (bounds.y[0] + down).simd_le(bounds.y[1]) & tiny;
            let edges = if shift == 0.0 {
                setup.edges(right, down)
            } else {
                let odd_columns = if dx == 1 { !odd_columns } else { odd_columns };
                let odd_rows = if dy == 1 { !odd_rows } else { odd_rows };
                let [x, y] = self.space.shifts.of_sixteen(simd, odd_columns, odd_rows);
                setup.edges(right + x, down + y)
            };
            let (lowest, highest) = (min3(edges), max3(edges));
            // Where the area's sign isn't certain, a miss takes two edge functions with opposite certain signs.
            let missed = lowest.simd_lt(-setup.bound) & (certain | highest.simd_gt(setup.bound));
            let kept = (valid & !missed).to_bitmask();
            if kept == 0 {
                continue;
            }
            let inside = (lowest.simd_gt(setup.bound) & certain).to_bitmask();
            let depth = corners.inverse_depth[0] + (edges[1] * setup.slopes[0] + edges[2] * setup.slopes[1]);
            let nearest = setup.nearest * splat(simd, 1.0 + 4.0 * HALF_ULP);
            let low: [f32; LANES] = (depth - setup.depth_error).into();
            let high: [f32; LANES] = certain.select(depth + setup.depth_error, nearest).into();
            for lane in bits_of(kept) {
                let triangle = first + lane as u32;
                let undecided = if inside >> lane & 1 == 0 { Fragment::UNDECIDED } else { 0 };
                let x = columns[lane] as i32 + dx + self.space.middle.x;
                let y = rows[lane] as i32 + dy + self.space.middle.y;
                let index = TileOrder::index_in_tile(x as u32, y as u32) | undecided;
                let fragment = Fragment { index, triangle, low: low[lane], high: high[lane] };
                self.bins.bin_mut(x, y).fragments.push(fragment);
            }
        }
    }

    /// Lists triangles in the tiles that they overlap.
    #[inline(always)]
    fn list_in_tiles<S: Simd>(
        &mut self,
        simd: S,
        path: Path,
        first: u32,
        corners: &Corners<S>,
        bounds: &PixelBounds<S>,
        lanes: u64,
    ) {
        let nearest = max3(corners.inverse_depth) * splat(simd, 1.0 + 4.0 * HALF_ULP);
        let nearest: [f32; LANES] = nearest.into();
        let (x0, x1): ([f32; LANES], [f32; LANES]) = (bounds.x[0].into(), bounds.x[1].into());
        let (y0, y1): ([f32; LANES], [f32; LANES]) = (bounds.y[0].into(), bounds.y[1].into());
        let mut large = 0;
        for lane in bits_of(lanes) {
            let id = first + lane as u32;
            let listed = Listed { triangle: id, nearest: nearest[lane] };
            let tiles = self.tiles([x0[lane], x1[lane], y0[lane], y1[lane]]);
            // Where bounds hold many tiles, a triangle often misses most of them. With 1 or 2 here, building takes up to a
            // half longer, and seeing no less time; with 8, both take the same (as measured for `DepthOrder`).
            const MOST_UNTESTED: i32 = 4;
            if (tiles[1] - tiles[0] + 1) * (tiles[3] - tiles[2] + 1) <= MOST_UNTESTED {
                self.bins.list(path, listed, tiles);
            } else {
                large |= 1 << lane;
            }
        }
        if large != 0 {
            self.list_large(simd, path, first, corners, bounds, large);
        }
    }

    /// Lists triangles that may overlap many tiles.
    #[inline(always)]
    fn list_large<S: Simd>(
        &mut self,
        simd: S,
        path: Path,
        first: u32,
        corners: &Corners<S>,
        bounds: &PixelBounds<S>,
        lanes: u64,
    ) {
        // Only samples inside of triangles matter, which are no farther outside of the bounds.
        const OVERHANG_PIXELS: f32 = 1.0;
        let samples = Bins::reach(self.space);
        let (x, y) = (corners.x, corners.y);
        let setup = Setup::new(simd, x, y, corners.inverse_depth, bounds.error, samples, OVERHANG_PIXELS);
        let plane = DepthPlane::new(simd, corners, bounds.error, [0.0; 2], samples);
        // Where corners are far from the image, their own rounding would take so many digits of the depth that most
        // samples' would have to be found again. In f64 they have enough of them.
        const FAR_IN_SIDES: f32 = 4.0;
        let (width, height) = self.space.size();
        let far = splat(simd, FAR_IN_SIDES * width.max(height) as f32);
        let is_near = largest(x, y).simd_le(far) | mask32x16::splat(simd, path != Path::Ordinary);
        let certain = setup.is_certain(simd) & is_near;
        let mut batch = Batch::default();
        batch.fill(simd, &setup, &plane, certain);
        let certain = certain.to_bitmask();
        let (x0, x1): ([f32; LANES], [f32; LANES]) = (bounds.x[0].into(), bounds.x[1].into());
        let (y0, y1): ([f32; LANES], [f32; LANES]) = (bounds.y[0].into(), bounds.y[1].into());
        for lane in bits_of(lanes & certain) {
            let tiles = self.tiles([&x0, &x1, &y0, &y1].map(|bound| bound[lane % LANES]));
            let triangle = batch.linear(lane);
            self.bins.list_linear(simd, self.space, path, first + lane as u32, &triangle, tiles);
        }
        for id in bits_of(lanes & !certain).map(|lane| first + lane as u32) {
            let path = if path == Path::Ordinary { Path::General } else { path };
            self.list_general(simd, path, id, self.triangles.corners(id));
        }
    }

    /// First and last column, and first and last row, of the tiles of samples in pixel space.
    #[inline(always)]
    fn tiles(&self, [x0, x1, y0, y1]: [f32; 4]) -> [i32; 4] {
        let tile = |sample: f32, middle: i32| (sample as i32 + middle) >> Bins::TILE_BITS;
        let middle = self.space.middle;
        [tile(x0, middle.x), tile(x1, middle.x), tile(y0, middle.y), tile(y1, middle.y)]
    }
}

/// Whether integers in pixel space, of which the image's first is `-middle`, stand for odd columns or rows.
#[inline(always)]
fn is_odd<S: Simd>(simd: S, at: f32x16<S>, middle: i32) -> mask32x16<S> {
    let one = i32x16::splat(simd, 1);
    let number: i32x16<S> = (at + splat(simd, middle as f32)).to_int();
    (number & one).simd_eq(one)
}
