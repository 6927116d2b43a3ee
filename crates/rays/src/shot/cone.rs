use crate::dispatch;
use crate::parallel::Parallel;
use fearless_simd::Simd;
use fearless_simd::prelude::*;
use glam::DVec3;
use rayon::prelude::*;

use super::{CameraRays, EightPoints, LightMask, SeenImage, SeenPixels, Shot, TileOrder};
use crate::LightSource;
use crate::simd::SimdLevel;
use crate::simd::lanes::bits_of;
use crate::simd::vectors::{dot, splat_vector};

/// The cone that a spot lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Position of the light.
    pub apex: DVec3,
    /// Axis, away from the light.
    pub axis: DVec3,
    /// Squared cosine of the half-angle, times the axis's squared length.
    pub squared_cosine: f64,
}

impl Cone {
    /// The cone of a light; `None` for lights other than spots and for numbers that aren't finite.
    #[must_use]
    pub fn of(light: &LightSource) -> Option<Self> {
        let LightSource::Spot { position, direction, outer_radians, .. } = *light else { return None };
        let axis = direction.as_dvec3();
        let cosine = libm::cos(f64::from(outer_radians)).max(0.0);
        let squared_cosine = cosine * cosine * axis.length_squared();
        let is_known = position.is_finite() && squared_cosine.is_finite() && axis != DVec3::ZERO;
        is_known.then_some(Self { apex: position.as_dvec3(), axis, squared_cosine })
    }

    /// Whether a point is in the cone.
    ///
    /// Every sum and product is rounded to f64 from left to right, so that the answer is the same on every machine.
    #[must_use]
    pub fn contains(&self, point: DVec3) -> bool {
        let v = point - self.apex;
        let along = self.axis.x * v.x + self.axis.y * v.y + self.axis.z * v.z;
        let squared = v.x * v.x + v.y * v.y + v.z * v.z;
        along > 0.0 && along * along >= self.squared_cosine * squared
    }

    /// Returns masks of the points, of eight, that are certainly in the cone, and that are certainly outside.
    ///
    /// With e the error of each coordinate, `along` is wrong by less than d = 4 e times the axis's largest component, its
    /// square by (2 |along| + d) d, and the squared length by (4 |v| + 4 e) e. The bound is more than twice that, plus the
    /// roundings of both squares.
    #[inline(always)]
    pub fn divide<S: Simd>(&self, simd: S, points: &EightPoints<S>) -> [u64; 2] {
        let along = dot(splat_vector(simd, self.axis), points.offset);
        let squared = dot(points.offset, points.offset);
        let error = points.error * 4.0;
        let of_along = error * self.axis.abs().max_element().max(1e-30) * 2.0;
        let rounding = (along * along + squared * self.squared_cosine) * 1e-14;
        let bound = (along.abs() * 2.0 + of_along) * of_along
            + (squared.sqrt() * 2.0 + error) * error * self.squared_cosine
            + rounding;
        let difference = along * along - squared * self.squared_cosine;
        let is_inside = points.certain & along.simd_gt(of_along) & difference.simd_gt(bound);
        let is_outside = points.certain & ((-along).simd_gt(of_along) | (-difference).simd_gt(bound));
        [is_inside.to_bitmask(), is_outside.to_bitmask()]
    }
}

impl LightMask {
    /// Clears the pixels whose points are outside of a light's cone, if it has one.
    pub fn keep_in_cone(&mut self, light: &LightSource, shot: &Shot<'_>, seen: &SeenPixels, level: SimdLevel) {
        let Some(cone) = Cone::of(light) else { return };
        let (image, rays) = (&SeenImage { shot, seen }, &CameraRays::new(shot));
        self.blocks_mut().par_iter_mut().enumerate().with_min_len(256).each(|(block, lit)| {
            if *lit != 0 {
                let first = block * TileOrder::BLOCK_PIXELS;
                *lit &= dispatch!(level, simd => in_cone(simd, &cone, light, image, rays, first, *lit));
            }
        });
    }
}

/// Returns a mask of a block's `asked` pixels that show a point in the cone.
#[inline(always)]
fn in_cone<S: Simd>(
    simd: S,
    cone: &Cone,
    light: &LightSource,
    image: &SeenImage<'_>,
    rays: &CameraRays,
    first: usize,
    asked: u16,
) -> u16 {
    let mut inside = 0;
    for half in [0, 8] {
        let indices = std::array::from_fn(|lane| (first + half + lane) as u32);
        let points = EightPoints::find(simd, image, rays, indices, cone.apex);
        let [is_inside, is_outside] = cone.divide(simd, &points);
        inside |= is_inside << half;
        for lane in bits_of(!(is_inside | is_outside) & 0xff & u64::from(asked) >> half) {
            let ray = image.shot.shadow_ray(image.seen, first + half + lane, light);
            let is_in = ray.is_some_and(|ray| cone.contains(ray.point()));
            inside |= u64::from(is_in) << (half + lane);
        }
    }
    inside as u16
}
