use std::ops::Range;

use crate::dispatch;
use crate::parallel::both;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, mask32x16};
use glam::Vec3;

use super::bins::{Bins, Fragment, Listed, Path};
use super::cull::BoxInImage;
use super::homogeneous::HomogeneousTriangle;
use super::lanes::{BackFaceCull, Corners, DepthPlane, LANES, PixelBounds, Setup, largest, splat};
use super::pixel_space::{HALF_ULP, PixelSpace, Vertex};
use super::tile::TriangleBatch;
use super::two_by_two::{TinyHits, TinyTriangles};
use super::{ImageTooLarge, PerspectiveGrid, PixelBox};
use crate::patches::{Patch, Patches};
use crate::shot::{Opacity, Shot, Sides, TileOrder};
use crate::simd::lanes::{bits_of, load_positions, max3, min3};
use crate::vectorized;
use crate::{SimdLevel, Triangles};

impl PerspectiveGrid {
    /// Replaces the grid by one for the triangles of `shot` and its pixels' rays. Runs on all threads of the current pool.
    ///
    /// # Errors
    /// If a side of the image is longer than [`ImageTooLarge::LARGEST_SIDE`].
    pub(crate) fn build(&mut self, shot: &Shot<'_>, patches: &Patches) -> Result<(), ImageTooLarge> {
        /// Sixteens of patches.
        const SMALLEST_RANGE: usize = 4;
        const MOST_RANGES: usize = 32;
        ImageTooLarge::check(&shot.view)?;
        patches.expect(shot.triangles);
        let space = PixelSpace::new(shot);
        self.space = Some(space);
        self.triangle_count = shot.triangles.len();
        self.vertices.resize(patches.vertex_count() + 1, Vertex::AWKWARD);
        self.boxes.resize(patches.len(), PixelBox::default());
        let sixteens = patches.len().div_ceil(LANES);
        let ranges = sixteens.div_ceil(SMALLEST_RANGE).clamp(1, MOST_RANGES);
        self.ranges.resize_with(ranges, Bins::default);
        let opacity = shot.opacity;
        let listing = Listing {
            level: self.level,
            space: &space,
            shot,
            patches,
            opacity: (!opacity.are_all_opaque()).then_some(opacity),
            tiles: self.tiles(),
            patches_a_range: sixteens.div_ceil(ranges) * LANES,
        };
        listing.list(0, &mut self.ranges, &mut self.vertices[..patches.vertex_count()], &mut self.boxes);
        Ok(())
    }
}

/// Sorts patches into tiles, and triangles of large or awkward patches one by one.
struct Listing<'a> {
    level: SimdLevel,
    space: &'a PixelSpace,
    shot: &'a Shot<'a>,
    patches: &'a Patches,
    /// `None` where all triangles are opaque: a call for each took 4 to 10 % of seeing.
    opacity: Option<&'a dyn Opacity>,
    /// Columns and rows.
    tiles: (u32, u32),
    patches_a_range: usize,
}

impl Listing<'_> {
    /// Fills the ranges from `first` on, in halves for other threads to share. The number of ranges doesn't depend on that
    /// of threads.
    fn list(&self, first: usize, ranges: &mut [Bins], vertices: &mut [Vertex], boxes: &mut [PixelBox]) {
        let start = |range: usize| (range * self.patches_a_range).min(self.patches.len());
        if let [bins] = ranges {
            bins.reset(self.tiles.0, self.tiles.1);
            let numbers = start(first)..start(first + 1);
            dispatch!(self.level, simd => vectorized!(simd => self.list_range(simd, numbers, bins, vertices, boxes)));
            return;
        }
        let middle = ranges.len() / 2;
        let patches = start(first + middle) - start(first);
        let of_patches = self.patches.first_vertex(start(first + middle)) - self.patches.first_vertex(start(first));
        let (low, high) = ranges.split_at_mut(middle);
        let (low_vertices, high_vertices) = vertices.split_at_mut(of_patches);
        let (low_boxes, high_boxes) = boxes.split_at_mut(patches);
        both(
            || self.list(first, low, low_vertices, low_boxes),
            || self.list(first + middle, high, high_vertices, high_boxes),
        );
    }

    #[inline(always)]
    fn list_range<S: Simd>(
        &self,
        simd: S,
        numbers: Range<usize>,
        bins: &mut Bins,
        mut vertices: &mut [Vertex],
        boxes: &mut [PixelBox],
    ) {
        for (number, in_image) in numbers.zip(boxes) {
            let patch = self.patches.get(number);
            let (of_patch, rest) = vertices.split_at_mut(patch.vertices.len());
            vertices = rest;
            match self.space.box_in_image(simd, self.patches.bounds.sixteens[number / LANES].get(number % LANES)) {
                BoxInImage::Outside => {}
                BoxInImage::Within { pixels, nearest } if pixels.is_small() && self.are_opaque(&patch) => {
                    *in_image = pixels;
                    bins.list(Path::Patch, Listed { slot: number as u32 | Listed::PATCH, nearest }, pixels.tiles());
                }
                BoxInImage::Within { .. } | BoxInImage::Anywhere => {
                    self.list_triangles(simd, number, &patch, of_patch, bins);
                }
            }
        }
    }

    fn are_opaque(&self, patch: &Patch<'_>) -> bool {
        self.opacity.is_none_or(|opacity| patch.ids[..patch.count].iter().all(|&id| opacity.is_opaque(id)))
    }

    /// Lists the triangles of a patch.
    #[inline(never)]
    fn list_triangles<S: Simd>(
        &self,
        simd: S,
        number: usize,
        patch: &Patch<'_>,
        vertices: &mut [Vertex],
        bins: &mut Bins,
    ) {
        let &Self { space, opacity, shot, .. } = self;
        let shown = BackFaceCull::new(space, shot);
        let mut set_up = SetUp { space, triangles: shot.triangles, opacity, sides: shot.sides, shown, bins };
        vectorized!(simd => {
            for (vertices, positions) in vertices.chunks_exact_mut(LANES).zip(self.patches.positions(number)) {
                space.project_sixteen(simd, load_positions(simd, positions), vertices);
            }
            for first in (0..patch.count).step_by(LANES) {
                let corners = Corners::of_patch(simd, vertices, &patch.corners[first..first + LANES]);
                let sixteen = Sixteen {
                    first_slot: (self.patches.first_slot(number) + first) as u32,
                    ids: &patch.ids[first..first + LANES],
                    lanes: (1 << (patch.count - first).min(LANES)) - 1,
                };
                set_up.sixteen(simd, &sixteen, &corners);
            }
        });
    }
}

/// Up to sixteen triangles of a patch.
pub(super) struct Sixteen<'a> {
    pub(super) first_slot: u32,
    pub(super) ids: &'a [u32],
    /// A bit for each of them.
    pub(super) lanes: u64,
}

/// The set-up of triangles.
struct SetUp<'a> {
    space: &'a PixelSpace,
    triangles: Triangles<'a>,
    opacity: Option<&'a dyn Opacity>,
    sides: Sides<'a>,
    shown: BackFaceCull<'a>,
    bins: &'a mut Bins,
}

impl SetUp<'_> {
    #[inline(always)]
    fn sixteen<S: Simd>(&mut self, simd: S, sixteen: &Sixteen<'_>, corners: &Corners<S>) {
        let &Sixteen { first_slot, ids, lanes } = sixteen;
        let ordinary = min3(corners.inverse_depth).simd_gt(splat(simd, 0.0)).to_bitmask();
        let behind = max3(corners.inverse_depth).simd_le(splat(simd, Vertex::BEHIND)).to_bitmask();
        for lane in bits_of(lanes & !(ordinary | behind)) {
            self.set_aside(simd, first_slot + lane as u32, ids[lane]);
        }
        let mut seen = ordinary & lanes;
        for lane in bits_of(corners.coincide().to_bitmask() & seen) {
            if self.triangles.usable_corners(ids[lane]).is_err() {
                seen &= !(1 << lane);
            }
        }
        let bounds = PixelBounds::new(simd, self.space, corners);
        seen &= (bounds.x[0].simd_le(bounds.x[1]) & bounds.y[0].simd_le(bounds.y[1])).to_bitmask();
        seen = self.shown.keep(simd, ids, corners, &bounds, seen);
        let masked = self.opacity.map_or(0, |opacity| {
            let masked = bits_of(seen).filter(|&lane| !opacity.is_opaque(ids[lane]));
            masked.fold(0, |masked, lane| masked | 1 << lane)
        });
        if masked != 0 {
            seen &= !masked;
            self.list_in_tiles(simd, Path::Masked, sixteen, corners, &bounds, masked);
        }
        let tiny = TinyTriangles::are(simd, &bounds).to_bitmask() & seen;
        if tiny != 0 {
            self.leave_fragments(simd, ids, corners, &bounds, tiny);
        }
        if seen != tiny {
            self.list_in_tiles(simd, Path::Ordinary, sixteen, corners, &bounds, seen & !tiny);
        }
    }

    /// Lists a triangle on the general path, if a ray can hit it.
    #[cold]
    #[inline(never)]
    fn set_aside<S: Simd>(&mut self, simd: S, slot: u32, id: u32) {
        let Ok(corners) = self.triangles.usable_corners(id) else { return };
        if self.sides.has_back(id) || self.space.sees_front(corners) {
            let is_opaque = self.opacity.is_none_or(|opacity| opacity.is_opaque(id));
            let path = if is_opaque { Path::General } else { Path::MaskedGeneral };
            self.list_homogeneous(simd, path, slot, corners);
        }
    }

    /// Lists a triangle where its edge functions in f64 don't rule it out.
    #[cold]
    #[inline(never)]
    fn list_homogeneous<S: Simd>(&mut self, simd: S, path: Path, slot: u32, corners: [Vec3; 3]) {
        let (space, bins) = (self.space, &mut *self.bins);
        let general = HomogeneousTriangle::new(space, corners);
        vectorized!(simd => bins.list_homogeneous(simd, space, path, slot, &general));
    }

    /// Tests tiny triangles immediately.
    #[inline(always)]
    fn leave_fragments<S: Simd>(
        &mut self,
        simd: S,
        ids: &[u32],
        corners: &Corners<S>,
        bounds: &PixelBounds<S>,
        lanes: u64,
    ) {
        let lanes = mask32x16::from_bitmask(simd, lanes);
        let tiny = TinyTriangles::new(simd, self.space, corners, bounds);
        let columns: [f32; LANES] = bounds.x[0].into();
        let rows: [f32; LANES] = bounds.y[0].into();
        for sample in TinyTriangles::<S>::SAMPLES {
            let TinyHits { possible, inside, low, high } = tiny.hits(simd, sample, bounds.have(simd, sample) & lanes);
            let inside = inside.to_bitmask();
            let (low, high): ([f32; LANES], [f32; LANES]) = (low.into(), high.into());
            for lane in bits_of(possible.to_bitmask()) {
                let undecided = if inside >> lane & 1 == 0 { Fragment::UNDECIDED } else { 0 };
                let x = columns[lane] as i32 + sample.0 + self.space.middle.x;
                let y = rows[lane] as i32 + sample.1 + self.space.middle.y;
                let index = TileOrder::index_in_tile(x as u32, y as u32) | undecided;
                let fragment = Fragment { index, triangle: ids[lane], low: low[lane], high: high[lane] };
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
        sixteen: &Sixteen<'_>,
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
            let listed = Listed { slot: sixteen.first_slot + lane as u32, nearest: nearest[lane] };
            let tiles = self.tiles([x0[lane], x1[lane], y0[lane], y1[lane]]);
            // Of many tiles within its bounds, a triangle often misses most. With 1 or 2 here, building takes up to a half
            // longer, and seeing no less time; with 8, both take the same (as measured for `DepthOrder`).
            const MOST_UNTESTED: i32 = 4;
            if (tiles[1] - tiles[0] + 1) * (tiles[3] - tiles[2] + 1) <= MOST_UNTESTED {
                self.bins.list(path, listed, tiles);
            } else {
                large |= 1 << lane;
            }
        }
        if large != 0 {
            self.list_large(simd, path, sixteen, corners, bounds, large);
        }
    }

    /// Lists triangles that may overlap many tiles.
    #[inline(always)]
    fn list_large<S: Simd>(
        &mut self,
        simd: S,
        path: Path,
        sixteen: &Sixteen<'_>,
        corners: &Corners<S>,
        bounds: &PixelBounds<S>,
        lanes: u64,
    ) {
        // Only samples inside of triangles matter, and these are no farther outside of the bounds.
        const OVERHANG_PIXELS: f32 = 1.0;
        let samples = Bins::reach(self.space);
        let (x, y) = (corners.x, corners.y);
        let setup = Setup::new(simd, x, y, corners.inverse_depth, bounds.error, samples, OVERHANG_PIXELS);
        let plane = DepthPlane::new(simd, corners, bounds.error, [0.0; 2], samples);
        // Where corners are far from the image, their own rounding would take so many digits of the depth that most samples'
        // would have to be recomputed. In f64 there are enough digits.
        const FAR_IN_SIDES: f32 = 4.0;
        let (width, height) = self.space.size();
        let far = splat(simd, FAR_IN_SIDES * width.max(height) as f32);
        let is_near = largest(x, y).simd_le(far) | mask32x16::splat(simd, path != Path::Ordinary);
        let certain = setup.is_certain(simd) & is_near;
        let mut batch = TriangleBatch::default();
        batch.fill(simd, &setup, &plane, certain);
        let certain = certain.to_bitmask();
        let (x0, x1): ([f32; LANES], [f32; LANES]) = (bounds.x[0].into(), bounds.x[1].into());
        let (y0, y1): ([f32; LANES], [f32; LANES]) = (bounds.y[0].into(), bounds.y[1].into());
        for lane in bits_of(lanes & certain) {
            let tiles = self.tiles([&x0, &x1, &y0, &y1].map(|bound| bound[lane % LANES]));
            let triangle = batch.linear(lane);
            self.bins.list_linear(simd, self.space, path, sixteen.first_slot + lane as u32, &triangle, tiles);
        }
        for lane in bits_of(lanes & !certain) {
            let path = if path == Path::Ordinary { Path::General } else { path };
            let corners = self.triangles.corners(sixteen.ids[lane]);
            self.list_homogeneous(simd, path, sixteen.first_slot + lane as u32, corners);
        }
    }

    /// First and last column, then row, of the tiles of a range of samples in pixel space.
    #[inline(always)]
    fn tiles(&self, [x0, x1, y0, y1]: [f32; 4]) -> [i32; 4] {
        let tile = |sample: f32, middle: i32| (sample as i32 + middle) >> Bins::TILE_BITS;
        let middle = self.space.middle;
        [tile(x0, middle.x), tile(x1, middle.x), tile(y0, middle.y), tile(y1, middle.y)]
    }
}
