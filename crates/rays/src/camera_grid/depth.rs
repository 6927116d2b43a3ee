//! Inverse depths within [`SeenPixels::RELATIVE_ERROR`], without the predicate where possible.

use glam::Vec3;

use crate::Ray;
use crate::shot::SeenPixels;

/// One over the depth at which a ray meets the plane of a triangle, in f64; `None` where the error may exceed
/// [`SeenPixels::RELATIVE_ERROR`].
///
/// Each path from an input to the numerator or denominator has at most eight roundings: two for differences of corners, one
/// each for a product, their difference and the offset from the ray's origin, a product, and two sums.
pub(super) fn inverse_depth(ray: &Ray, corners: [Vec3; 3]) -> Option<f32> {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let (u, v, from_origin) = (b - a, c - a, a - ray.origin);
    let normal = u.cross(v);
    let (slope, height) = (normal.dot(ray.direction), normal.dot(from_origin));
    let (u, v) = (u.abs(), v.abs());
    let magnitude = glam::DVec3::new(u.y * v.z + u.z * v.y, u.z * v.x + u.x * v.z, u.x * v.y + u.y * v.x);
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
            // Origins from anywhere to almost in the plane.
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
