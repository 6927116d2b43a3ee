//! Secondary rays from rough surfaces, one for each hit: from microfacets whose normals have GGX's distribution.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec3};

use super::lanes::{Each, vector_of};

/// The reflection of surfaces, lane by lane.
pub(crate) struct Gloss {
    /// GGX width.
    pub(super) alpha: Each<f32>,
    /// Specular reflectance at normal incidence.
    pub(super) f0: [Each<f32>; 3],
    /// Factor for light that bounces several times between microfacets.
    pub(super) scattered_again: [Each<f32>; 3],
    pub(super) layers: Option<Box<GlossyLayers>>,
}

/// The layers' effect on it; lanes without a layer have neutral values.
pub(crate) struct GlossyLayers {
    /// Specular reflectance at grazing angles, which is one without layers.
    pub(super) f90: Each<f32>,
    /// Albedo of the specular layer below a coat under even light, in the brightest colour.
    pub(super) albedo: Each<f32>,
    /// The part of the reflection that a film colours, and the film's reflectance.
    pub(super) film_part: Each<f32>,
    pub(super) film_reflected: [Each<f32>; 3],
    /// The lanes with stretched highlights, the direction of the stretch, and GGX widths along and across it.
    pub(super) grooves: u16,
    pub(super) along: [Each<f32>; 3],
    pub(super) widths: [Each<f32>; 2],
    /// Unit normals of coats, their GGX widths, the lanes in which they are mirrors, and their reflected part.
    pub(super) coat_normal: [Each<f32>; 3],
    pub(super) coat_alpha: Each<f32>,
    pub(super) coat_mirrors: u16,
    pub(super) coat_part: Each<f32>,
}

/// A coat that a ray meets.
pub(crate) struct GlossyCoat {
    pub(crate) normal: DVec3,
    pub(crate) alpha: f32,
    pub(crate) is_mirror: bool,
    /// Its reflected part, 0 to 1.
    pub(crate) part: f32,
    /// The share of the onward rays that leave from the coat, rather than from the layers below.
    pub(crate) share: f64,
}

impl Gloss {
    /// The reflectance of a lane's microfacet for light that meets it with this cosine.
    pub(crate) fn reflected(&self, lane: usize, cosine: f32) -> Vec3 {
        let f0 = vector_of(lane, &self.f0);
        let missing = (1.0 - cosine).clamp(0.0, 1.0);
        let schlick = missing * missing * missing * missing * missing;
        let reflected = match &self.layers {
            Some(layers) => (f0 + (Vec3::splat(layers.f90[lane]) - f0) * schlick)
                .lerp(vector_of(lane, &layers.film_reflected), layers.film_part[lane]),
            None => f0 + (Vec3::ONE - f0) * schlick,
        };
        reflected * vector_of(lane, &self.scattered_again)
    }

    /// The microfacets of a lane with this unit normal.
    pub(crate) fn facets(&self, lane: usize, normal: DVec3) -> Facets {
        let alpha = f64::from(self.alpha[lane]);
        let Some(layers) = self.layers.as_ref().filter(|layers| layers.grooves >> lane & 1 == 1) else {
            return Facets::round(normal, alpha);
        };
        let along = vector_of(lane, &layers.along).as_dvec3();
        match (along - normal * along.dot(normal)).try_normalize() {
            Some(along) => {
                Facets::stretched(normal, along, DVec2::from(layers.widths.map(|widths| f64::from(widths[lane]))))
            }
            None => Facets::round(normal, alpha),
        }
    }

    /// The coat of a lane, if it has one.
    pub(crate) fn coat(&self, lane: usize) -> Option<GlossyCoat> {
        let layers = self.layers.as_ref().filter(|layers| layers.coat_part[lane] > 0.0)?;
        let part = layers.coat_part[lane];
        Some(GlossyCoat {
            normal: vector_of(lane, &layers.coat_normal).as_dvec3().normalize(),
            alpha: layers.coat_alpha[lane],
            is_mirror: layers.coat_mirrors >> lane & 1 == 1,
            part,
            share: (part / (part + layers.albedo[lane])).into(),
        })
    }
}

/// The microfacets of a rough surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facets {
    /// Unit vectors along the surface, and its normal.
    axes: [DVec3; 3],
    /// GGX widths along the first two.
    widths: DVec2,
}

impl Facets {
    /// Facets with the same width all around a unit normal.
    pub(crate) fn round(normal: DVec3, alpha: f64) -> Self {
        let (right, up) = normal.any_orthonormal_pair();
        Self { axes: [right, up, normal], widths: DVec2::splat(alpha) }
    }

    /// Facets with one width in a unit direction, at a right angle to the normal, and another across it.
    pub(crate) fn stretched(normal: DVec3, along: DVec3, widths: DVec2) -> Self {
        Self { axes: [along, normal.cross(along), normal], widths }
    }

    /// The GGX width of a round surface with as wide a distribution.
    pub(crate) fn mean_width(&self) -> f64 {
        (self.widths.x * self.widths.y).sqrt()
    }

    /// Draws the normal of a visible facet, in proportion to its visible area: Dupuy and Benyoub, *Sampling Visible GGX
    /// Normals with Spherical Caps*, 2023. `view` is of unit length, on the side of the normal; `point` is in the unit
    /// square.
    pub(crate) fn visible(&self, view: DVec3, point: DVec2) -> DVec3 {
        let scale = self.widths.extend(1.0);
        let seen = self.inside(view);
        let stretched = (seen.with_z(seen.z.max(0.0)) * scale).normalize();
        let height = (1.0 - point.y) * (1.0 + stretched.z) - stretched.z;
        let (sine, cosine) = libm::sincos(TAU * point.x);
        let radius = (1.0 - height * height).max(0.0).sqrt();
        let half = DVec3::new(radius * cosine, radius * sine, height) + stretched;
        let facet = (half * scale).normalize_or(DVec3::Z);
        let [along, across, normal] = self.axes;
        along * facet.x + across * facet.y + normal * facet.z
    }

    /// Smith's height-correlated shadowing of visible facets, G2 / G1, 0 to 1, for unit view and light directions.
    pub(crate) fn unshadowed(&self, view: DVec3, light: DVec3) -> f64 {
        let [view, light] = [view, light].map(|way| self.hidden(way));
        (1.0 + view) / (1.0 + view + light)
    }

    /// The shadowing G1 of light that passes through facets of glass, where each side hides by itself.
    pub(crate) fn unshadowed_behind(&self, light: DVec3) -> f64 {
        1.0 / (1.0 + self.hidden(light))
    }

    /// Smith's Λ of GGX.
    fn hidden(&self, way: DVec3) -> f64 {
        let cosine = way.dot(self.axes[2]);
        let squared = (cosine * cosine).clamp(1e-12, 1.0);
        let across = if self.widths.x == self.widths.y {
            self.widths.x * self.widths.x * (1.0 - squared)
        } else {
            let DVec3 { x, y, .. } = self.inside(way) * self.widths.extend(1.0);
            x * x + y * y
        };
        0.5 * ((1.0 + across / squared).sqrt() - 1.0)
    }

    /// A direction in terms of the axes.
    fn inside(&self, way: DVec3) -> DVec3 {
        self.axes.map(|axis| way.dot(axis)).into()
    }
}

/// A unit direction around a normal, distributed as light scattered by a rough surface: even over the disk below it.
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
        // Walter et al., 2007, equation 11: the projected area of the visible facets is the cosine of the view.
        for alpha in [0.05, 0.3, 1.0] {
            for cosine in [0.1_f64, 0.5, 1.0] {
                let view = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
                let facets = Facets::round(DVec3::Z, alpha);
                let normals = (0..4096).map(|number| facets.visible(view, pair(number, 0)));
                // With the density ⟨view, facet⟩ D(facet) / (cosine (1 + Λ)) the mean of z / ⟨view, facet⟩ is that of D's
                // own projected area, which is 1, over cosine (1 + Λ), less the facets that face away.
                let mean = normals.map(|facet| facet.z / view.dot(facet)).sum::<f64>() / 4096.0;
                let part = mean * (1.0 + facets.hidden(view)) * cosine;
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
