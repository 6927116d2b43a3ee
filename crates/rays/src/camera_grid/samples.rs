use fearless_simd::Simd;
use fearless_simd::f64x8;
use fearless_simd::prelude::*;
use glam::{DVec3, IVec2, Vec3};

use super::homogeneous::{Depth, HomogeneousTriangle, Square};
use super::lanes::LANES;
use super::pixel_space::PixelSpace;
use crate::Ray;
use crate::predicate::{crossing, settle};
use crate::shot::{BlockSamples, Counts, Kind, SeenPixels, Shot, TileOrder, TileWork};
use crate::simd::lanes::bits_of;

/// Blocks of 4×4 samples a side of a tile.
pub const BLOCKS: usize = (TileOrder::TILE / TileOrder::BLOCK) as usize;
/// Samples of a tile.
pub const SAMPLES: usize = TileOrder::TILE_PIXELS;

/// The nearest hits found so far in one tile of the [`TileOrder`], in blocks of 4×4 samples. 49 KB.
#[repr(C, align(64))]
pub struct Samples {
    /// Lower bounds of one over the depth; zero for no hit.
    pub low: [f32; SAMPLES],
    /// Upper bounds.
    pub high: [f32; SAMPLES],
    pub triangle: [u32; SAMPLES],
    /// The samples' positions in each block.
    pub(crate) of_block: BlockSamples,
    pub undecided: Vec<Undecided>,
}

/// A triangle that may be the nearest at a sample, for the predicate to settle.
#[derive(Clone, Copy, Debug)]
pub struct Undecided {
    /// The sample's index in the tile.
    pub index: u32,
    pub triangle: u32,
    /// Upper bound of the inverse depth.
    pub high: f32,
}

impl Default for Samples {
    fn default() -> Self {
        Self {
            low: [0.0; SAMPLES],
            high: [0.0; SAMPLES],
            triangle: [SeenPixels::NONE; SAMPLES],
            of_block: BlockSamples::default(),
            undecided: Vec::new(),
        }
    }
}

impl Samples {
    pub(crate) fn clear(&mut self) {
        self.low.fill(0.0);
        self.high.fill(0.0);
        self.triangle.fill(SeenPixels::NONE);
    }

    /// Notes the samples of a block at which the filter couldn't decide about a triangle.
    #[cold]
    #[inline(never)]
    pub(crate) fn note_undecided(&mut self, block: usize, triangle: u32, lanes: u64, high: &[f32; LANES]) {
        for lane in bits_of(lanes) {
            let index = (block * LANES + lane) as u32;
            self.undecided.push(Undecided { index, triangle, high: high[lane] });
        }
    }

    /// Tests a general triangle against the samples of one block, whose first pixel is in the corner of `square`. If
    /// `questioned`, the predicate has to settle every hit.
    #[inline(always)]
    pub(crate) fn test_general<S: Simd>(
        &mut self,
        simd: S,
        triangle: &HomogeneousTriangle,
        id: u32,
        questioned: bool,
        block: usize,
        square: Square,
    ) {
        for half in [0, 8] {
            let eight =
                |numbers: &[f32; LANES]| -> [f64; 8] { std::array::from_fn(|lane| f64::from(numbers[half + lane])) };
            let x = f64x8::splat(simd, f64::from(square.x)) + f64x8::simd_from(simd, eight(&self.of_block.columns));
            let y = f64x8::splat(simd, f64::from(square.y)) + f64x8::simd_from(simd, eight(&self.of_block.rows));
            let at = |plane: DVec3| {
                f64x8::splat(simd, plane.x) * x + (f64x8::splat(simd, plane.y) * y + f64x8::splat(simd, plane.z))
            };
            // Bit masks of the lanes with an edge function certainly above, or below, zero.
            let all = 0xff;
            let (mut every_above, mut every_below, mut some_above, mut some_below) = (all, all, 0, 0);
            for (&edge, &bound) in triangle.edges.iter().zip(&triangle.bounds) {
                let (value, bound) = (at(edge), f64x8::splat(simd, bound));
                let (above, below) = (value.simd_gt(bound).to_bitmask(), value.simd_lt(-bound).to_bitmask());
                (every_above, every_below) = (every_above & above, every_below & below);
                (some_above, some_below) = (some_above | above, some_below | below);
            }
            let missed = some_below & (if triangle.oriented { all } else { some_above });
            let possible = all & !missed;
            if possible == 0 {
                continue;
            }
            let inside = every_above | (if triangle.oriented { 0 } else { every_below });
            let depth = match triangle.depth {
                Depth::Unknown => [0.0; 8],
                Depth::Inverse { plane, .. } | Depth::Direct { plane, .. } => at(plane).into(),
            };
            for lane in bits_of(possible) {
                let index = block * LANES + half + lane;
                let Some((low, high)) = triangle.depth.inverse_bounds(depth[lane]) else { continue };
                if high < self.low[index] {
                    continue;
                }
                if inside >> lane & 1 == 1 && !questioned && low > self.high[index] {
                    (self.low[index], self.high[index], self.triangle[index]) = (low, high, id);
                } else {
                    self.undecided.push(Undecided { index: index as u32, triangle: id, high });
                }
            }
        }
    }
}

/// A tile of a shot, for settling its samples.
#[derive(Clone, Copy)]
pub struct TileOfShot<'a> {
    pub shot: &'a Shot<'a>,
    pub space: &'a PixelSpace,
    /// The tile's first column and row in the image.
    pub corner: IVec2,
}

impl TileOfShot<'_> {
    /// Settles all undecided cases.
    #[cold]
    #[inline(never)]
    pub(crate) fn settle<const N: usize>(&self, samples: &mut Samples, work: &mut TileWork<'_, N>, tally: &mut Counts) {
        tally.undecided += samples.undecided.len() as u64;
        let mut undecided = std::mem::take(&mut samples.undecided);
        for Undecided { index, triangle, high } in undecided.drain(..) {
            let index = index as usize;
            work.add(Kind::Undecided, index..index + 1, 1);
            let (x, y) = self.pixel(index);
            let (width, height) = self.space.size();
            if high < samples.low[index] || x >= width || y >= height {
                continue;
            }
            let best = samples.triangle[index];
            if let Some(nearest) = settle::nearest(self.shot, (x, y), best, triangle, &mut tally.settled) {
                let inverse = (1.0 / nearest.t) as f32;
                (samples.low[index], samples.high[index]) = (inverse.next_down(), inverse.next_up());
                samples.triangle[index] = nearest.triangle;
            }
        }
        samples.undecided = undecided;
    }

    /// As [`settle`](Self::settle), if there are many undecided cases.
    pub(crate) fn settle_if_many<const N: usize>(
        &self,
        samples: &mut Samples,
        work: &mut TileWork<'_, N>,
        tally: &mut Counts,
    ) {
        const MANY: usize = 1 << 14;
        if samples.undecided.len() >= MANY {
            self.settle(samples, work, tally);
        }
    }

    /// The inverse depth of triangle `id` at a sample, in f64 or by the predicate.
    #[cold]
    #[inline(never)]
    pub(crate) fn inverse_depth(&self, index: usize, id: u32) -> f32 {
        if id == SeenPixels::NONE {
            return f32::NAN;
        }
        let (x, y) = self.pixel(index);
        let (ray, corners) = (self.shot.ray(x, y), self.shot.triangles.corners(id));
        let of_predicate = || crossing(&ray, corners).map(|crossing| SeenPixels::inverse_of(crossing.t));
        inverse_depth_in_f64(&ray, corners).or_else(of_predicate).unwrap_or(f32::NAN)
    }

    /// Column and row in the image of a sample, given its index in the tile.
    #[inline]
    pub fn pixel(&self, index: usize) -> (u32, u32) {
        let (block, sample) = (index / LANES, index % LANES);
        let side = TileOrder::BLOCK as usize;
        let x = self.corner.x as u32 + (block % BLOCKS * side + sample % side) as u32;
        let y = self.corner.y as u32 + (block / BLOCKS * side + sample / side) as u32;
        (x, y)
    }
}

/// One over the depth at which a ray meets the plane of a triangle, in f64; `None` where the error may exceed
/// [`SeenPixels::RELATIVE_ERROR`].
///
/// Each path from an input to the numerator or denominator has at most eight roundings: two for differences of corners, one
/// each for a product, their difference and the offset from the ray's origin, a product, and two sums.
fn inverse_depth_in_f64(ray: &Ray, corners: [Vec3; 3]) -> Option<f32> {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let (u, v, from_origin) = (b - a, c - a, a - ray.origin);
    let normal = u.cross(v);
    let (slope, height) = (normal.dot(ray.direction), normal.dot(from_origin));
    let (u, v) = (u.abs(), v.abs());
    let magnitude = DVec3::new(u.y * v.z + u.z * v.y, u.z * v.x + u.x * v.z, u.x * v.y + u.y * v.x);
    let (largest_slope, largest_height) = (magnitude.dot(ray.direction.abs()), magnitude.dot(from_origin.abs()));
    // Doubled for products of errors and for the bound's own rounding.
    let error = 8.0 * f64::EPSILON * (largest_slope / slope.abs() + largest_height / height.abs());
    let inverse = slope / height;
    let is_sure = error < f64::from(SeenPixels::RELATIVE_ERROR) / 4.0 && (1e-29..=1e29).contains(&inverse);
    is_sure.then_some(inverse as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predicate::crossing;

    #[test]
    fn depths_in_f64_are_the_predicates() {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1 << 23) as f32 - 1.0
        };
        let (mut met, mut sure) = (0, 0);
        for step in 0..20_000 {
            let [a, b, c] = [0; 3].map(|_| Vec3::new(random(), random(), random()));
            // Origins from anywhere to almost in the plane.
            let away = 10.0_f64.powi(-(step % 14));
            let center = (a + b + c).as_dvec3() / 3.0;
            let origin = center + (b - a).as_dvec3() * 3.0 + DVec3::new(0.0, 0.0, f64::from(random()) * away);
            let ray = Ray::new(origin, center - origin);
            let Some(crossing) = crossing(&ray, [a, b, c]).filter(|crossing| crossing.t > 0.0) else { continue };
            met += 1;
            if let Some(inverse) = inverse_depth_in_f64(&ray, [a, b, c]) {
                sure += 1;
                let off = (f64::from(inverse) * crossing.t - 1.0).abs();
                assert!(off < f64::from(SeenPixels::RELATIVE_ERROR), "{off}");
            }
        }
        assert!(met > 19_000 && sure > met / 2 && sure < met - 1000, "{met} {sure}");
    }
}
