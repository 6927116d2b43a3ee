//! Surfaces that show only the shadows on them.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use glam::Vec3;

use super::shade::{AroundLight, Shading};
use crate::shade::lanes::Vectors;
use crate::shade::{Emitter, Surface};

/// The look of sixteen points of shadow catchers: the surroundings behind them, times the part of their light that arrives.
pub(super) struct Caught<S: Simd> {
    /// The lanes with such a surface.
    pub(super) lanes: mask32x16<S>,
    /// Radiance of the surroundings behind them.
    pub(super) around: Vectors<S>,
    /// The share of their light that comes from the surroundings, occluded or not.
    pub(super) ambient: Vectors<S>,
    /// The same share where nearby triangles may occlude it.
    pub(super) near: Vectors<S>,
    /// One over the irradiance from the surroundings and all lights, without occlusion.
    inverse: Vectors<S>,
}

impl<S: Simd> Caught<S> {
    /// `around` is the radiance of the surroundings behind them.
    #[inline(always)]
    pub(super) fn new(simd: S, shading: &Shading<'_>, surface: &Surface<S>, around: Vectors<S>) -> Self {
        /// Replaces zero irradiance, so that a surface without any light counts as fully lit.
        const LEAST: Vec3 = Vec3::splat(1e-30);
        let ambient = shading.surroundings.irradiance(simd, surface.normal) + Vectors::splat(simd, LEAST);
        // The irradiance of the sky's lights, over all samples, is the ambient one.
        let lights = shading.emitters[..shading.first_sky_light].iter().map(|light| irradiance(simd, surface, light));
        let sum = lights.fold(ambient, |sum, light| (sum + light).at_most_brightest());
        let one = f32x16::splat(simd, 1.0);
        let inverse = Vectors { x: one / sum.x, y: one / sum.y, z: one / sum.z };
        let lanes = mask32x16::from_bitmask(simd, surface.catches.into());
        let (share, nothing) = (ambient * inverse, Vectors::splat(simd, Vec3::ZERO));
        let [ambient, near] = match shading.around_light() {
            AroundLight::Even => [share, nothing],
            AroundLight::Near => [nothing, share],
            AroundLight::Lights => [nothing; 2],
        };
        Self { lanes, around, ambient, near, inverse }
    }

    /// The share of their light that a light sends without occlusion; zero in lanes of other surfaces.
    #[inline(always)]
    pub(super) fn share(&self, simd: S, surface: &Surface<S>, light: &Emitter) -> Vectors<S> {
        let share = irradiance(simd, surface, light) * self.inverse;
        Vectors::select(self.lanes, share, Vectors::splat(simd, Vec3::ZERO))
    }
}

/// Irradiance of the surface from an unoccluded light.
#[inline(always)]
fn irradiance<S: Simd>(simd: S, surface: &Surface<S>, light: &Emitter) -> Vectors<S> {
    let arriving = light.arriving(simd, surface.position);
    let cosine = surface.normal.dot(arriving.towards).max(0.0);
    arriving.irradiance.scaled(cosine).at_least_zero().at_most_brightest()
}
