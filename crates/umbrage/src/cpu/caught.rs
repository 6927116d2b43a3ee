//! Surfaces of which only the shadows on them are seen.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use glam::Vec3;
use umbrage_scene::Light;

use super::shade::{AroundLight, Shading};
use crate::shade::lanes::Vectors;
use crate::shade::{Surface, arriving};

/// What sixteen points of surfaces show that only catch shadows: what is around the scene, times the part of their light that
/// nothing keeps away.
pub(super) struct Caught<S: Simd> {
    /// The lanes with such a surface.
    pub(super) lanes: mask32x16<S>,
    /// What is around the scene behind them.
    pub(super) around: Vectors<S>,
    /// Which part of all of their light comes from around the scene, whatever is in between.
    pub(super) ambient: Vectors<S>,
    /// The same where nothing near may be in between.
    pub(super) near: Vectors<S>,
    /// One over the irradiance from all around and from all lights, were nothing in between.
    inverse: Vectors<S>,
}

impl<S: Simd> Caught<S> {
    /// `around` is what is around the scene behind them.
    #[inline(always)]
    pub(super) fn new(simd: S, shading: &Shading<'_>, surface: &Surface<S>, around: Vectors<S>) -> Self {
        /// In place of no light at all, so that the darkest surfaces are whole.
        const LEAST: Vec3 = Vec3::splat(1e-30);
        let ambient = shading.surroundings.irradiance(simd, surface.normal) + Vectors::splat(simd, LEAST);
        // That of the sky's lights, over all samples, is the ambient one.
        let lights = shading.lights[..shading.first_sky_light].iter().map(|light| irradiance(simd, surface, light));
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

    /// Which part of all of their light comes from a light that nothing keeps away; zero in lanes of other surfaces.
    #[inline(always)]
    pub(super) fn share(&self, simd: S, surface: &Surface<S>, light: &Light) -> Vectors<S> {
        let share = irradiance(simd, surface, light) * self.inverse;
        Vectors::select(self.lanes, share, Vectors::splat(simd, Vec3::ZERO))
    }
}

/// What a light sends to surfaces that face it.
#[inline(always)]
fn irradiance<S: Simd>(simd: S, surface: &Surface<S>, light: &Light) -> Vectors<S> {
    let arriving = arriving(simd, light, surface.position);
    let cosine = surface.normal.dot(arriving.towards).max(0.0);
    arriving.irradiance.scaled(cosine).at_least_zero().at_most_brightest()
}
