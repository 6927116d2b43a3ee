//! Inverse depths within [`SeenPixels::RELATIVE_ERROR`], without the predicate where that can be.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::Vec3;

use crate::Ray;
use crate::camera_grid::lanes::{Setup, splat};
use crate::camera_grid::pixel_space::HALF_ULP;
use crate::shot::SeenPixels;
use crate::simd::lanes::{max3, min3};

/// How wrong the depths of `setup` may be where its orientation is certain and no edge function is below minus its
/// bound: far less than what follows from the edge functions' bounds alone.
///
/// With δ the `error` of corners' x and y, ε half an ulp, A the computed area, w and h the sides of the bounds, r the
/// rises, s the slopes and q the edge functions' bound over A, which is at most 1/8:
/// - The area of the corners as they are is at least A (1 − 4 q) (see [`Setup::new`]). Barycentric coordinates are no
///   less than −q, so that their magnitudes add up to 1 + 4 q at most. 2 δ (w + h) is at most q A.
/// - At corners the true depths' plane is off by G δ, G being its slope along both axes together, and by 1.01 ε of the
///   nearest. G is at most (G' + 1.01 ε · nearest · 2 (w + h) / A) / (1 − 2 q), where G' is the slope of the plane
///   through the corners as they are; that is computed as g, a sum of magnitudes along both axes, within 1/(1 − 4 q)
///   and eight roundings of its terms. So depths are off by (g δ + 2 ε · nearest) (1 + 4 q) / (1 − 4 q) / (1 − 2 q).
/// - Evaluated, each edge function is wrong by ρ = 4 ε (samples · (w + h) + 2 m²), its product with a slope by five
///   roundings, A by 8 ε w h, the sum by one, and so are its bounds:
///   Σ |s| (ρ + 10 ε w h) / (1 − 4 q) + Σ |r| 8 ε + 4 ε · nearest.
///
/// All the fractions are convex in q and no more than 1 + 24 q at both ends, and so between.
#[inline(always)]
pub(crate) fn depth_error<S: Simd>(
    simd: S,
    setup: &Setup<S>,
    x: [f32x16<S>; 3],
    y: [f32x16<S>; 3],
    error: f32x16<S>,
    samples: f32,
) -> f32x16<S> {
    let (width, height) = (max3(x) - min3(x), max3(y) - min3(y));
    let largest = max3(x).max(max3(y)).max(-(min3(x).min(min3(y))));
    let rounding = (width + height) * splat(simd, samples) + largest * largest * splat(simd, 2.0);
    let of_edges = (rounding + width * height * splat(simd, 2.5)) * splat(simd, 4.0 * HALF_ULP);
    let [second, third] = setup.slopes;
    let along = |factors: &[f32x16<S>; 3]| {
        let (second, third) = (second * factors[1], third * factors[2]);
        (second + third).abs() + (second.abs() + third.abs()) * splat(simd, 8.0 * HALF_ULP)
    };
    let steepness = along(&setup.a) + along(&setup.b);
    let slopes = second.abs() + third.abs();
    let of_denominators = splat(simd, 1.0) + setup.bound / setup.area * splat(simd, 24.0);
    let nearest = setup.nearest * splat(simd, 2.0 * HALF_ULP);
    let of_terms = (nearest + nearest) + slopes * setup.area * splat(simd, 8.0 * HALF_ULP);
    // The last factor covers the bound's own rounding.
    (of_terms + (slopes * of_edges + steepness * error + nearest) * of_denominators) * splat(simd, 1.001)
}

/// One over the depth at which a ray meets the plane of a triangle, in f64; `None` where that isn't sure to be within
/// [`SeenPixels::RELATIVE_ERROR`].
///
/// Each path from an input to the numerator or denominator has eight roundings at most: two for differences of corners,
/// one each for a product, their difference and the way from the ray's origin, a product, and two sums.
pub(crate) fn inverse_depth(ray: &Ray, corners: [Vec3; 3]) -> Option<f32> {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let (u, v, from_origin) = (b - a, c - a, a - ray.origin);
    let normal = u.cross(v);
    let (slope, height) = (normal.dot(ray.direction), normal.dot(from_origin));
    let (u, v) = (u.abs(), v.abs());
    let magnitude = glam::DVec3::new(u.y * v.z + u.z * v.y, u.z * v.x + u.x * v.z, u.x * v.y + u.y * v.x);
    let (largest_slope, largest_height) = (magnitude.dot(ray.direction.abs()), magnitude.dot(from_origin.abs()));
    // Doubled for products of errors and for the rounding of the bound itself.
    let error = 8.0 * f64::EPSILON * (largest_slope / slope.abs() + largest_height / height.abs());
    let inverse = slope / height;
    let is_sure = error < f64::from(SeenPixels::RELATIVE_ERROR) / 4.0 && (1e-29..=1e29).contains(&inverse);
    is_sure.then_some(inverse as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predicate::crossing;
    use glam::DVec3;

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
            // From anywhere to almost in the plane.
            let away = 10.0_f64.powi(-(step % 14));
            let center = (a + b + c).as_dvec3() / 3.0;
            let origin = center + (b - a).as_dvec3() * 3.0 + DVec3::new(0.0, 0.0, f64::from(random()) * away);
            let ray = Ray::new(origin, center - origin);
            let Some(crossing) = crossing(&ray, [a, b, c]).filter(|crossing| crossing.t > 0.0) else { continue };
            met += 1;
            if let Some(inverse) = inverse_depth(&ray, [a, b, c]) {
                sure += 1;
                let off = (f64::from(inverse) * crossing.t - 1.0).abs();
                assert!(off < f64::from(SeenPixels::RELATIVE_ERROR), "{off}");
            }
        }
        assert!(met > 19_000 && sure > met / 2 && sure < met - 1000, "{met} {sure}");
    }
}
