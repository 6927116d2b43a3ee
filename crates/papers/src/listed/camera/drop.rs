use std::ops::Range as Ids;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use umbrage_rays::camera_grid::bins::bytes_of;
use umbrage_rays::camera_grid::homogeneous::{HomogeneousTriangle, Square};
use umbrage_rays::camera_grid::lanes::{Corners, PixelBounds};
use umbrage_rays::camera_grid::pixel_space::{HALF_ULP, PixelSpace, Vertex};
use umbrage_rays::shot::{Opacity, Sides};
use umbrage_rays::simd::lanes::{LANES, bits_of, max3, min3, splat};
use umbrage_rays::{Omitted, Triangles};

use super::list::Pair;
use crate::listed::sorted::Sorted;

/// The state of one range of triangles before its pairs are sorted by cell.
#[derive(Clone, Debug, Default)]
pub(super) struct UnsortedRange {
    /// Triangles for the fast path that aren't dropped.
    pub(super) kept: Vec<Kept>,
    /// Triangles that reach behind the eye or far to the side, and all triangles of orthographic views.
    pub(super) general: Vec<u32>,
    pub(super) omitted: Omitted,
    pub(super) dropped: u64,
    pub(super) any_masked: bool,
    /// Smallest and largest inverse depth of the triangles that aren't dropped.
    pub(super) depths: [f32; 2],
    /// Pairs in the order in which they were found.
    pub(super) unsorted: Vec<Pair>,
    /// Pairs sorted by tile.
    pub(super) pairs: Sorted<Pair>,
}

/// A triangle that may contain samples, with its bounds in pixels of the image. 16 bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kept {
    pub(super) triangle: u32,
    /// First and last column that may be hit.
    pub(super) columns: [u16; 2],
    /// First and last row.
    pub(super) rows: [u16; 2],
    /// Upper bound of the inverse depth.
    pub(super) nearest: f32,
}

impl UnsortedRange {
    pub(super) fn bytes(&self) -> usize {
        bytes_of(&self.kept) + bytes_of(&self.general) + bytes_of(&self.unsorted) + self.pairs.bytes()
    }

    /// Empties everything except the pairs.
    fn clear(&mut self) {
        self.kept.clear();
        self.general.clear();
        self.omitted.clear();
        (self.dropped, self.any_masked, self.depths) = (0, false, [f32::INFINITY, 0.0]);
    }
}

/// Finds the triangles of a range that may contain a sample.
pub(super) struct Drop<'a> {
    pub(super) space: &'a PixelSpace,
    pub(super) triangles: Triangles<'a>,
    pub(super) vertices: &'a [Vertex],
    pub(super) opacity: &'a dyn Opacity,
    /// Area sign of front faces in pixel space; one-sided triangles with the other sign are dropped. Zero drops none.
    pub(super) facing: f32,
    pub(super) sides: Sides<'a>,
    pub(super) range: &'a mut UnsortedRange,
    /// A bit for each triangle of the range.
    pub(super) masked_bits: &'a mut [u64],
}

impl Drop<'_> {
    #[inline(always)]
    pub(super) fn run<S: Simd>(mut self, simd: S, ids: Ids<usize>) {
        self.range.clear();
        self.masked_bits.fill(0);
        let start = ids.start;
        for first in ids.clone().step_by(LANES) {
            let batch = &self.triangles.indices[first..ids.end.min(first + LANES)];
            let corners = Corners::load(simd, self.vertices, batch);
            let all = (1_u64 << batch.len()) - 1;
            let ordinary = min3(corners.inverse_depth).simd_gt(splat(simd, 0.0)).to_bitmask();
            let odd = (!ordinary | corners.coincide().to_bitmask()) & all;
            let mut ordinary = ordinary & all;
            for lane in bits_of(odd) {
                if !self.is_usable((first + lane) as u32) {
                    ordinary &= !(1 << lane);
                } else if ordinary >> lane & 1 == 0 {
                    self.keep_general((first + lane) as u32, start);
                }
            }
            let kept = self.keep_ordinary(simd, first as u32, &corners, ordinary);
            self.range.dropped += u64::from((ordinary & !kept).count_ones());
            for lane in bits_of(kept) {
                self.note_mask((first + lane) as u32, start);
            }
        }
    }

    /// Keeps the triangles, of 16, that may contain a sample, and returns their mask.
    #[inline(always)]
    fn keep_ordinary<S: Simd>(&mut self, simd: S, first: u32, corners: &Corners<S>, mut lanes: u64) -> u64 {
        let inverse_depth = corners.inverse_depth;
        let PixelBounds { x: columns, y: rows, error } = PixelBounds::new(simd, self.space, corners);
        let middle = self.space.middle;
        let kept = columns[0].simd_le(columns[1]) & rows[0].simd_le(rows[1]);
        if self.facing != 0.0 {
            let backs = self.sides.sixteen_backs(first);
            lanes &= backs | !self.faces_away(simd, corners, error).to_bitmask();
        }
        let kept = kept.to_bitmask() & lanes;
        if kept == 0 {
            return 0;
        }
        // The error of vertices' inverse depths is 1.01 half ulps.
        let (one, slack) = (1.0, 4.0 * HALF_ULP);
        let nearest: [f32; LANES] = (max3(inverse_depth) * splat(simd, one + slack)).into();
        let farthest: [f32; LANES] = (min3(inverse_depth) * splat(simd, one - slack)).into();
        let [x0, x1] = columns.map(<[f32; LANES]>::from);
        let [y0, y1] = rows.map(<[f32; LANES]>::from);
        for lane in bits_of(kept) {
            let triangle = first + lane as u32;
            let columns = [x0[lane], x1[lane]].map(|x| (x as i32 + middle.x) as u16);
            let rows = [y0[lane], y1[lane]].map(|y| (y as i32 + middle.y) as u16);
            let [low, high] = &mut self.range.depths;
            (*low, *high) = (low.min(farthest[lane]), high.max(nearest[lane]));
            self.range.kept.push(Kept { triangle, columns, rows, nearest: nearest[lane] });
        }
        kept
    }

    /// The mask of triangles that certainly show their back.
    #[inline(always)]
    fn faces_away<S: Simd>(&self, simd: S, corners: &Corners<S>, error: f32x16<S>) -> mask32x16<S> {
        let [area, bound] = corners.signed_area(simd, error);
        (area * splat(simd, self.facing)).simd_lt(-bound)
    }

    /// Whether any ray can hit a triangle; counts it as omitted if not.
    #[cold]
    #[inline(never)]
    fn is_usable(&mut self, id: u32) -> bool {
        self.triangles.usable_corners(id).inspect_err(|&why| self.range.omitted.note(id, why)).is_ok()
    }

    /// Keeps a triangle for the general path unless it certainly misses the whole image.
    #[cold]
    #[inline(never)]
    fn keep_general(&mut self, id: u32, start: usize) {
        let corners = self.triangles.corners(id);
        if HomogeneousTriangle::new(self.space, corners).misses(Square::around_image(self.space)) {
            self.range.dropped += 1;
            return;
        }
        self.range.general.push(id);
        self.note_mask(id, start);
        if !self.space.is_perspective() {
            for corner in corners {
                let inverse_depth = (1.0 / self.space.camera_point(corner).0.z) as f32;
                if inverse_depth > 0.0 && inverse_depth.is_finite() {
                    let [low, high] = &mut self.range.depths;
                    (*low, *high) = (low.min(inverse_depth), high.max(inverse_depth));
                }
            }
        }
    }

    #[inline(always)]
    fn note_mask(&mut self, id: u32, start: usize) {
        if !self.opacity.is_opaque(id) {
            let index = id as usize - start;
            self.masked_bits[index / 64] |= 1 << (index % 64);
            self.range.any_masked = true;
        }
    }
}
