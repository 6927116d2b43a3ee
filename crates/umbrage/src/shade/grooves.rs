use std::f32::consts::PI;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

use super::lanes::{Each, Vectors};

/// A highlight stretched in one direction along the surface: Burley's anisotropic GGX, as `KHR_materials_anisotropy` has it.
#[derive(Clone, Copy)]
pub(super) struct Grooves<S: Simd> {
    /// The lanes whose highlight is stretched.
    lanes: mask32x16<S>,
    /// Unit vectors along the surface, in the direction of the stretch and across it.
    along: Vectors<S>,
    across: Vectors<S>,
    /// GGX widths in these directions.
    alpha_along: f32x16<S>,
    alpha_across: f32x16<S>,
    strength: f32x16<S>,
    /// Perceptual roughness across the stretch, that of the material.
    roughness: f32x16<S>,
    /// The length of the view, scaled by the widths along and across.
    view: f32x16<S>,
}

impl<S: Simd> Grooves<S> {
    /// A stretch along `direction`, which needn't be along the surface, in the lanes that have one there. The material has
    /// the perceptual `roughness`.
    #[inline(always)]
    pub(super) fn new(
        lanes: mask32x16<S>,
        direction: Vectors<S>,
        strength: f32x16<S>,
        roughness: f32x16<S>,
        [normal, view]: [Vectors<S>; 2],
    ) -> Self {
        let (along, has_direction) = (direction - normal.scaled(direction.dot(normal))).try_normalized();
        let lanes = lanes & has_direction;
        // Lanes without a direction get finite numbers without a meaning.
        let along = Vectors::select(lanes, along, normal);
        let across = normal.cross(along);
        let alpha_across = roughness * roughness;
        let alpha_along = alpha_across + (1.0 - alpha_across) * (strength * strength);
        let n_v = normal.dot(view).max(1e-4);
        let view = length([alpha_along * along.dot(view), alpha_across * across.dot(view), n_v]);
        Self { lanes, along, across, alpha_along, alpha_across, strength, roughness, view }
    }

    /// The perceptual roughness of a round highlight with the same area, `otherwise` in lanes without a stretch.
    #[inline(always)]
    pub(super) fn mean_roughness(&self, otherwise: f32x16<S>) -> f32x16<S> {
        self.lanes.select((self.alpha_along * self.alpha_across).sqrt().sqrt(), otherwise)
    }

    /// The lanes with a stretched highlight, the direction of the stretch, and GGX widths along and across it, lane by lane.
    #[inline(always)]
    pub(super) fn store(&self) -> (u16, [Each<f32>; 3], [Each<f32>; 2]) {
        let widths = [self.alpha_along.into(), self.alpha_across.into()];
        (self.lanes.to_bitmask() as u16, self.along.store(), widths)
    }

    /// Distribution times visibility, in place of the round highlight's. The cosines are those of the normal with the half
    /// vector, the light and the view.
    #[inline(always)]
    pub(super) fn lobe(
        &self,
        round: f32x16<S>,
        half: Vectors<S>,
        light: Vectors<S>,
        [n_h, n_l, n_v]: [f32x16<S>; 3],
    ) -> f32x16<S> {
        let Self { lanes, along, across, alpha_along, alpha_across, view, .. } = *self;
        let area = alpha_along * alpha_across;
        let [x, y, z] = [alpha_across * along.dot(half), alpha_along * across.dot(half), area * n_h];
        let width = area / (x * x + y * y + z * z);
        let distribution = area * width * width * (1.0 / PI);
        let light = length([alpha_along * along.dot(light), alpha_across * across.dot(light), n_l]);
        let visibility = 0.5 / (n_l * view + n_v * light);
        lanes.select(distribution * visibility, round)
    }

    /// The one direction whose light stands for the whole reflection, and the perceptual roughness to blur it with.
    #[inline(always)]
    pub(super) fn reflection(
        &self,
        [normal, view]: [Vectors<S>; 2],
        (mirrored, roughness): (Vectors<S>, f32x16<S>),
    ) -> (Vectors<S>, f32x16<S>) {
        // As in the extension: the normal is bent towards the view in the plane of the stretch.
        let bent = self.across.cross(view).cross(self.across).normalized_or(normal);
        let straight = 1.0 - self.strength * (1.0 - self.roughness);
        let straight = straight * straight * straight * straight;
        let bent = bent.lerp(normal, straight).normalized_or(normal);
        let stretched = bent.scaled(2.0 * view.dot(bent)) - view;
        (Vectors::select(self.lanes, stretched, mirrored), self.lanes.select(self.roughness, roughness))
    }
}

#[inline(always)]
fn length<S: Simd>([x, y, z]: [f32x16<S>; 3]) -> f32x16<S> {
    (x * x + y * y + z * z).sqrt()
}
