use std::sync::Mutex;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8, mask32x16};
use rayon::prelude::*;
use umbrage_rays::dispatch;
use umbrage_rays::light_grid::face::HALF_ULP;
use umbrage_rays::light_grid::points::TILE_BLOCKS;
use umbrage_rays::predicate::ROUNDING;
use umbrage_rays::shot::{CameraRays, Cone, EightPoints, SeenImage};
use umbrage_rays::simd::lanes::bits_of;
use umbrage_rays::simd::vectors::{LANES, largest, narrow, splat};

use super::angles::{ANGLE_ERROR, atan2};
use super::vertices::along_axes;
use super::{Frame, LightPass, Place};

/// ε, half the distance from one to the next f32.
const EPSILON: f32 = HALF_ULP as f32;

/// Points with larger angle errors, in radians, aren't mapped.
const LARGEST_ANGLE_ERROR: f64 = 1.0 / 1024.0;

/// Points nearer to the light than this aren't mapped either; the farthest is at about one.
const NEAREST: f64 = 1e-20;

/// The points of 4×4 pixels, in pixel order. 384 bytes.
///
/// Lanes without a point are undefined.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(crate) struct Offsets {
    at: [[f32; LANES]; 3],
    /// α and β.
    angles: [[f32; LANES]; 2],
    /// Error bound of any coordinate, apart from its own rounding.
    error: f32,
}

impl Offsets {
    /// The position at α and β; the distance is the largest coordinate of the offset.
    #[inline(always)]
    pub(super) fn place(&self, lane: usize) -> Place {
        let [x, y, z] = self.at;
        let distance = x[lane].abs().max(y[lane].abs()).max(z[lane].abs());
        let farthest = distance * (1.0 + 4.0 * EPSILON) + self.error;
        Place { at: self.angles.map(|angles| angles[lane]), distance, farthest }
    }
}

/// Up to 16 points, as offsets from the light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpherePoints {
    pub(super) at: [[f32; LANES]; 3],
    /// The largest coordinate.
    pub(super) reach: f32,
    /// Error bound of any coordinate.
    pub(super) error: f32,
}

impl SpherePoints {
    #[inline(always)]
    pub(super) fn gather(blocks: &[Offsets], indices: &[u32]) -> Self {
        let mut points = Self { at: [[0.0; LANES]; 3], reach: 0.0, error: 0.0 };
        for (lane, &index) in indices.iter().enumerate() {
            let (block, from) = (&blocks[index as usize / LANES], index as usize % LANES);
            for (to, axis) in points.at.iter_mut().zip(&block.at) {
                to[lane] = axis[from];
                points.reach = points.reach.max(axis[from].abs());
            }
            points.error = points.error.max(block.error);
        }
        points.error += points.reach * (1.01 * EPSILON);
        points
    }
}

/// The range of the mapped points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    /// Lowest and highest α, and β.
    pub(super) angles: [[f32; 2]; 2],
    /// Upper bound of any point's largest coordinate.
    pub(super) farthest: f32,
    /// Error bound of any angle, apart from [`ANGLE_ERROR`].
    angle_error: f32,
}

impl Default for Seen {
    fn default() -> Self {
        Self { angles: [[f32::INFINITY, f32::NEG_INFINITY]; 2], farthest: 0.0, angle_error: 0.0 }
    }
}

impl Seen {
    fn and(self, other: Self) -> Self {
        let both = |axis: usize| {
            let ([low, high], [other_low, other_high]) = (self.angles[axis], other.angles[axis]);
            [low.min(other_low), high.max(other_high)]
        };
        Self {
            angles: [both(0), both(1)],
            farthest: self.farthest.max(other.farthest),
            angle_error: self.angle_error.max(other.angle_error),
        }
    }

    /// The growth of triangles' arcs in each plane that makes them hold the angles of all points in them.
    ///
    /// Angles of points and of corners have an error of [`ANGLE_ERROR`] times themselves. Of corners' angles only those up
    /// to the largest angle of points matter: corners farther out are on the same side of all points, in spite of their
    /// errors. To this come `angle_error` for points and 2⁻²³ for corners, and the rounding of sums.
    pub(super) fn margins(&self) -> [f32; 2] {
        self.angles.map(|[low, high]| {
            low.abs().max(high.abs()) * (4.0 * ANGLE_ERROR) + self.angle_error * 1.01 + 1.0 / (1 << 22) as f32
        })
    }
}

/// Maps the points of all pixels, except those certainly outside of a cone. Returns their range.
pub(super) fn map(
    frame: &Frame,
    cone: Option<&Cone>,
    image: &SeenImage<'_>,
    blocks: &mut Vec<Offsets>,
    pass: &mut LightPass,
) -> Seen {
    let LightPass { survey, members, outliers, level, .. } = pass;
    blocks.resize(survey.slots / LANES, Offsets::default());
    let (level, tiles) = (level, &survey.tiles);
    let mapper = Mapper { frame, cone, image, rays: &survey.rays };
    let outliers = Mutex::new(outliers);
    let outputs = blocks.par_chunks_exact_mut(TILE_BLOCKS).zip(members.par_chunks_exact_mut(TILE_BLOCKS));
    let of_tiles = outputs.enumerate().map(|(tile, (blocks, members))| {
        let mut lost = Vec::new();
        let mut seen = Seen::default();
        if tiles[tile].points > 0 {
            seen = dispatch!(*level, simd => mapper.map_tile(simd, tile, blocks, members, &mut lost));
        }
        if let (false, Ok(mut all)) = (lost.is_empty(), outliers.lock()) {
            all.append(&mut lost);
        }
        seen
    });
    of_tiles.reduce(Seen::default, Seen::and)
}

struct Mapper<'a> {
    frame: &'a Frame,
    cone: Option<&'a Cone>,
    image: &'a SeenImage<'a>,
    rays: &'a CameraRays,
}

/// Eight points, scaled.
struct Eight<S: Simd> {
    offset: [f64x8<S>; 3],
    /// Components along the light's axes.
    parts: [f64x8<S>; 3],
    error: f64x8<S>,
    angle_error: f64x8<S>,
    /// Masks of the mapped points, and of those certainly outside of the cone.
    mapped: u64,
    outside: u64,
}

impl Mapper<'_> {
    #[inline(always)]
    fn map_tile<S: Simd>(
        &self,
        simd: S,
        tile: usize,
        blocks: &mut [Offsets],
        members: &mut [u16],
        outliers: &mut Vec<u32>,
    ) -> Seen {
        let infinity = splat(simd, f32::INFINITY);
        let (mut low, mut high) = ([infinity; 2], [-infinity; 2]);
        let (mut farthest, mut angle_error) = (splat(simd, 0.0), 0.0_f64);
        for (block, (points, member)) in blocks.iter_mut().zip(members).enumerate() {
            let first = (tile * TILE_BLOCKS + block) * LANES;
            let depth = f32x16::from_slice(simd, &self.image.seen.inverse_depth[first..first + LANES]);
            let known = depth.simd_eq(depth).to_bitmask();
            if known == 0 {
                continue;
            }
            let [a, b] = [self.eight(simd, first), self.eight(simd, first + 8)];
            let wanted = known & !(a.outside | b.outside << 8);
            let mapped = wanted & (a.mapped | b.mapped << 8);
            outliers.extend(bits_of(wanted & !mapped).map(|lane| (first + lane) as u32));
            *member = mapped as u16;
            let of_mapped = mask32x16::from_bitmask(simd, mapped);
            let offset = narrow(a.offset, b.offset);
            let [x, y, z] = narrow(a.parts, b.parts);
            let angles = [atan2(simd, x, z), atan2(simd, y, z)];
            let reach = offset[0].abs().max(offset[1].abs()).max(offset[2].abs());
            let [mut error, mut of_angle] = [f64x8::splat(simd, 0.0); 2];
            for (half, eight) in [&a, &b].into_iter().enumerate() {
                let of_mapped = fearless_simd::mask64x8::from_bitmask(simd, mapped >> (8 * half) & 0xff);
                error = of_mapped.select(error.max(eight.error), error);
                of_angle = of_mapped.select(of_angle.max(eight.angle_error), of_angle);
            }
            let errors: [f64; 8] = error.into();
            let of_angles: [f64; 8] = of_angle.into();
            angle_error = of_angles.into_iter().fold(angle_error, f64::max);
            // Rounded up.
            points.error = (errors.into_iter().fold(0.0, f64::max) * 1.000_001) as f32 + 1e-37;
            for (to, axis) in points.at.iter_mut().zip(offset) {
                axis.store_slice(to);
            }
            for (plane, angles) in angles.into_iter().enumerate() {
                angles.store_slice(&mut points.angles[plane]);
                low[plane] = of_mapped.select(low[plane].min(angles), low[plane]);
                high[plane] = of_mapped.select(high[plane].max(angles), high[plane]);
            }
            farthest =
                of_mapped.select(farthest.max(reach * (1.0 + 4.0 * EPSILON) + splat(simd, points.error)), farthest);
        }
        Seen {
            angles: [0, 1].map(|plane| [low[plane].reduce_min(), high[plane].reduce_max()]),
            farthest: farthest.reduce_max(),
            angle_error: (angle_error * 1.000_001) as f32,
        }
    }

    /// The points of eight pixels.
    ///
    /// The error of a component along an axis of length one is at most √3 times that of coordinates, plus its own roundings.
    /// That moves an angle by at most twice as much, divided by the larger of its two components.
    #[inline(always)]
    fn eight<S: Simd>(&self, simd: S, first: usize) -> Eight<S> {
        let Self { frame, cone, image, rays } = self;
        let indices = std::array::from_fn(|lane| (first + lane) as u32);
        let points = EightPoints::find(simd, image, rays, indices, frame.light.as_dvec3());
        let outside = cone.map_or(0, |cone| cone.divide(simd, &points)[1]);
        let scale = f64x8::splat(simd, frame.scale);
        let offset = [points.offset[0] * scale, points.offset[1] * scale, points.offset[2] * scale];
        let error = points.error * scale;
        let parts = along_axes(simd, frame, offset);
        let reach = largest(offset);
        let of_parts = error * 1.75 + reach * (16.0 * ROUNDING);
        let (x, y, z) = (parts[0].abs(), parts[1].abs(), parts[2].abs());
        let angle_error = of_parts * 2.0 / x.max(z).min(y.max(z));
        // Written so that NaN isn't mapped.
        let mapped = points.certain
            & angle_error.simd_le(f64x8::splat(simd, LARGEST_ANGLE_ERROR))
            & reach.simd_gt(f64x8::splat(simd, NEAREST))
            & reach.simd_lt(f64x8::splat(simd, 16.0));
        Eight { offset, parts, error, angle_error, mapped: mapped.to_bitmask(), outside }
    }
}
