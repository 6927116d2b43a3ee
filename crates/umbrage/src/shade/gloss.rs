//! Where single rays go on from rough surfaces: mirrors too small to be seen, whose normals are spread as GGX says.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

/// Draws the normal of a small mirror, as often as such mirrors are seen: Dupuy and Benyoub, *Sampling Visible GGX Normals with
/// Spherical Caps*, 2023. `view` and `normal` are of unit length, on one side of the surface; `point` is in the unit square.
pub(crate) fn visible_normal(view: DVec3, normal: DVec3, alpha: f64, point: DVec2) -> DVec3 {
    let (right, up) = normal.any_orthonormal_pair();
    let seen = DVec3::new(view.dot(right), view.dot(up), view.dot(normal).max(0.0));
    let stretched = (seen * DVec3::new(alpha, alpha, 1.0)).normalize();
    let height = (1.0 - point.y) * (1.0 + stretched.z) - stretched.z;
    let (sine, cosine) = libm::sincos(TAU * point.x);
    let radius = (1.0 - height * height).max(0.0).sqrt();
    let half = DVec3::new(radius * cosine, radius * sine, height) + stretched;
    let facet = (half * DVec3::new(alpha, alpha, 1.0)).normalize_or(DVec3::Z);
    right * facet.x + up * facet.y + normal * facet.z
}

/// How much of what leaves small mirrors that are seen isn't kept back by others: Smith's shadowing for correlated heights, of
/// light and view with such cosines to the normal.
pub(crate) fn unshadowed(alpha: f64, view_cosine: f64, light_cosine: f64) -> f64 {
    let [view, light] = [view_cosine, light_cosine].map(|cosine| hidden(alpha, cosine));
    (1.0 + view) / (1.0 + view + light)
}

/// The same of light that goes through small facets of glass, where either side hides by itself.
pub(crate) fn unshadowed_behind(alpha: f64, light_cosine: f64) -> f64 {
    1.0 / (1.0 + hidden(alpha, light_cosine))
}

/// Smith's Λ of GGX.
fn hidden(alpha: f64, cosine: f64) -> f64 {
    let squared = (cosine * cosine).clamp(1e-12, 1.0);
    0.5 * ((1.0 + alpha * alpha * (1.0 - squared) / squared).sqrt() - 1.0)
}

/// A unit direction around a normal, as often as light from there is scattered by a rough surface: evenly in the disk below.
pub(crate) fn scattered(normal: DVec3, point: DVec2) -> DVec3 {
    let (right, up) = normal.any_orthonormal_pair();
    let (sine, cosine) = libm::sincos(TAU * point.y);
    let radius = point.x.sqrt();
    right * (radius * cosine) + up * (radius * sine) + normal * (1.0 - point.x).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::points::pair;

    #[test]
    fn small_mirrors_are_as_large_from_the_side_as_the_surface() {
        // Walter et al., 2007, equation 11: the projected area of what is seen is the cosine of the view.
        for alpha in [0.05, 0.3, 1.0] {
            for cosine in [0.1_f64, 0.5, 1.0] {
                let view = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
                let normals = (0..4096).map(|number| visible_normal(view, DVec3::Z, alpha, pair(number, 0)));
                // With the density ⟨view, facet⟩ D(facet) / (cosine (1 + Λ)) the mean of z / ⟨view, facet⟩ is that of D's own
                // projected area, which is 1, over cosine (1 + Λ), less what faces away.
                let mean = normals.map(|facet| facet.z / view.dot(facet)).sum::<f64>() / 4096.0;
                let part = mean * (1.0 + hidden(alpha, cosine)) * cosine;
                assert!(part < 1.02 && part > 0.5, "{alpha}, {cosine}: {part}");
            }
        }
    }

    #[test]
    fn what_is_scattered_is_as_a_cosine() {
        let normal = DVec3::new(0.6, 0.0, 0.8);
        let directions: Vec<DVec3> = (0..4096).map(|number| scattered(normal, pair(number, 3))).collect();
        let mean = directions.iter().sum::<DVec3>() / 4096.0;
        assert!(mean.abs_diff_eq(normal * (2.0 / 3.0), 1e-2), "{mean}");
        assert!(directions.iter().all(|direction| (direction.length() - 1.0).abs() < 1e-12));
    }
}
