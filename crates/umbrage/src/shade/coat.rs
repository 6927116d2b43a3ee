use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use glam::Vec3;
use umbrage_scene::Clearcoat;

use super::albedo::{fifth_power, specular_albedo};
use super::brdf::{Between, SMOOTHEST};
use super::lanes::{Each, Vectors};

/// A clear lacquer seen from one side: `KHR_materials_clearcoat`, which has Fresnel's term of its smooth normal rather than
/// of its microfacets.
#[derive(Clone, Copy)]
pub(super) struct Coat<S: Simd> {
    normal: Vectors<S>,
    view: Vectors<S>,
    n_v: f32x16<S>,
    /// Squared GGX width.
    a2: f32x16<S>,
    roughness: f32x16<S>,
    /// The part of the light that it takes from the layers below, 0 to 1; zero without a coat.
    pub(super) part: f32x16<S>,
}

impl<S: Simd> Coat<S> {
    /// A lacquer of coverage `factor`, 0 to 1, with a perceptual roughness and a unit normal of its own.
    #[inline(always)]
    pub(super) fn new(factor: f32x16<S>, roughness: f32x16<S>, [normal, view]: [Vectors<S>; 2]) -> Self {
        let cosine = normal.dot(view);
        let missing = 1.0 - cosine.abs().min(1.0);
        let roughness = roughness.max(SMOOTHEST).min(1.0);
        let alpha = roughness * roughness;
        let part = factor * (fifth_power(missing) * (1.0 - Clearcoat::F0) + Clearcoat::F0);
        Self { normal, view, n_v: cosine.max(1e-4), a2: alpha * alpha, roughness, part }
    }

    /// Reflected radiance, for each unit of irradiance on surfaces that face a light in this unit direction.
    #[inline(always)]
    pub(super) fn lit(&self, simd: S, light: Vectors<S>) -> f32x16<S> {
        let n_l = self.normal.dot(light);
        let lobe = Between::new(self.view, light).lobe(self.a2, self.normal, [n_l, self.n_v]) * n_l;
        n_l.simd_gt(0.0).select(self.part * lobe, f32x16::splat(simd, 0.0))
    }

    /// The one direction whose light stands for all that it reflects, and the perceptual roughness to blur it with.
    #[inline(always)]
    pub(super) fn reflection(&self) -> (Vectors<S>, f32x16<S>) {
        (self.normal.scaled(2.0 * self.view.dot(self.normal)) - self.view, self.roughness)
    }

    /// The lanes so smooth that they reflect the surroundings sharply.
    #[inline(always)]
    pub(super) fn is_mirror(&self, simd: S) -> mask32x16<S> {
        self.roughness.simd_le(SMOOTHEST) & self.part.simd_gt(f32x16::splat(simd, 0.0))
    }

    /// Its reflected part, its unit normal and its GGX width, lane by lane.
    #[inline(always)]
    pub(super) fn store(&self) -> (Each<f32>, [Each<f32>; 3], Each<f32>) {
        (self.part.into(), self.normal.store(), self.a2.sqrt().into())
    }

    /// Directional albedo: its weight for the surroundings' radiance.
    #[inline(always)]
    pub(super) fn albedo(&self, simd: S) -> Vectors<S> {
        let [scale, bias] = specular_albedo(simd, self.roughness, self.n_v);
        Vectors::splat(simd, Vec3::ONE).scaled(self.part * (scale + bias))
    }
}
