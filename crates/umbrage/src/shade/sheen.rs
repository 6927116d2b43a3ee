use std::f32::consts::{LOG2_E, PI};
use std::sync::LazyLock;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::Vec3;
use umbrage_rays::{SimdLevel, dispatch};

use super::albedo::{SIDE, Table, looked_up};
use super::lanes::{LANES, Vector, Vectors};
use super::transcendental::{exp2, power};

/// The least perceptual roughness. Fibres that lean less are visible only from so near the surface that pixels hardly show
/// them, and the formula has no value for fibres that don't lean at all.
const STRAIGHTEST: f32 = 0.1;

/// Fibres seen from one side: Estevez and Kulla, *Production Friendly Microfacet Sheen BRDF*, 2017, as `KHR_materials_sheen`
/// has it.
#[derive(Clone, Copy)]
pub(super) struct Sheen<S: Simd> {
    normal: Vectors<S>,
    view: Vectors<S>,
    /// Sheen colour; zero without sheen.
    color: Vectors<S>,
    fibres: Fibres<S>,
    /// Directional albedo of white fibres; at most one.
    albedo: f32x16<S>,
}

/// The terms of the fibres that depend on their roughness and on the view.
#[derive(Clone, Copy)]
struct Fibres<S: Simd> {
    /// Exponent of the squared sine between normal and half vector.
    exponent: f32x16<S>,
    /// Normalisation of the power to a distribution, over 4 n·v.
    scale: f32x16<S>,
    masking: Masking<S>,
    /// One more than the masking of the view.
    of_view: f32x16<S>,
}

impl<S: Simd> Sheen<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, color: Vectors<S>, roughness: f32x16<S>, [normal, view]: [Vectors<S>; 2]) -> Self {
        let roughness = roughness.max(STRAIGHTEST).min(1.0);
        let n_v = normal.dot(view).max(1e-4).min(1.0);
        let whole = albedo(simd, roughness, n_v);
        // Straight fibres would reflect more light than arrives, seen from within five degrees of the surface.
        let albedo = whole.min(1.0);
        let color = color.scaled(albedo / whole);
        Self { normal, view, color, fibres: Fibres::new(roughness, n_v), albedo }
    }

    /// The part of the light that it leaves to the layers below: the extension's albedo scaling, by the view alone.
    #[inline(always)]
    pub(super) fn below(&self) -> f32x16<S> {
        1.0 - self.color.largest() * self.albedo
    }

    /// Reflected radiance, for each unit of irradiance on surfaces that face a light in this unit direction.
    #[inline(always)]
    pub(super) fn lit(&self, simd: S, light: Vectors<S>) -> Vectors<S> {
        let n_l = self.normal.dot(light);
        let half = (self.view + light).normalized_or(self.normal);
        let lobe = self.fibres.lobe(self.normal.dot(half), n_l.max(0.0).min(1.0));
        self.color.scaled(n_l.simd_gt(0.0).select(lobe, f32x16::splat(simd, 0.0)))
    }

    /// Directional albedo: its weight for even light from all around.
    #[inline(always)]
    pub(super) fn albedo(&self) -> Vectors<S> {
        self.color.scaled(self.albedo)
    }
}

impl<S: Simd> Fibres<S> {
    #[inline(always)]
    fn new(roughness: f32x16<S>, n_v: f32x16<S>) -> Self {
        let alpha = roughness * roughness;
        let inverse = 1.0 / alpha;
        let masking = Masking::new(alpha);
        let scale = (inverse + 2.0) / (8.0 * PI * n_v);
        Self { exponent: 0.5 * inverse, scale, masking, of_view: masking.at(n_v) + 1.0 }
    }

    /// Distribution times visibility times the cosine to the light.
    #[inline(always)]
    fn lobe(&self, n_h: f32x16<S>, n_l: f32x16<S>) -> f32x16<S> {
        let squared_sine = (1.0 - n_h * n_h).max(0.0);
        self.scale * power(squared_sine, self.exponent) / (self.of_view + self.masking.at(n_l))
    }
}

/// The extension's fit of the masking between fibres.
#[derive(Clone, Copy)]
struct Masking<S: Simd> {
    /// The curve's five numbers.
    curve: [f32x16<S>; 5],
    /// Twice the curve at one half.
    middle: f32x16<S>,
}

impl<S: Simd> Masking<S> {
    #[inline(always)]
    fn new(alpha: f32x16<S>) -> Self {
        /// For the widest and the narrowest distribution.
        const CURVES: [[f32; 2]; 5] = [
            [21.5473, 25.3245],
            [3.829_87, 3.324_35],
            [0.198_23, 0.168_01],
            [-1.977_60, -1.273_93],
            [-4.320_54, -4.859_67],
        ];
        let narrow = (1.0 - alpha) * (1.0 - alpha);
        let mut curve = [narrow; 5];
        for (number, [widest, narrowest]) in curve.iter_mut().zip(CURVES) {
            *number = narrow * (narrowest - widest) + widest;
        }
        let mut masking = Self { curve, middle: narrow };
        let half = narrow * 0.0 + 0.5;
        masking.middle = 2.0 * masking.curve_at(half);
        masking
    }

    #[inline(always)]
    fn curve_at(&self, x: f32x16<S>) -> f32x16<S> {
        let [a, b, c, d, e] = self.curve;
        a / (b * power(x, c) + 1.0) + d * x + e
    }

    #[inline(always)]
    fn at(&self, cosine: f32x16<S>) -> f32x16<S> {
        let at = self.curve_at(cosine.min(1.0 - cosine));
        exp2(cosine.simd_lt(0.5).select(at, self.middle - at) * LOG2_E)
    }
}

/// Directional albedo of white fibres, by perceptual roughness and the root of the cosine to the view, both from 0 to 1: 2.3
/// KB.
static TABLE: LazyLock<Table<1>> = LazyLock::new(|| {
    let value = |index: usize| index as f32 / (SIDE - 1) as f32;
    let roughness = |row: usize| value(row).max(0.5 * STRAIGHTEST);
    let integrated = |row, column: usize| {
        let n_v = (value(column) * value(column)).max(1e-4);
        dispatch!(SimdLevel::default(), simd => integrated(simd, roughness(row), n_v))
    };
    std::array::from_fn(|row| std::array::from_fn(|column| [integrated(row, column)]))
});

/// The table, by roughness and then by the root of the cosine, both from 0 to 1.
#[cfg(feature = "gpu")]
pub(crate) fn sheen_albedo_table() -> [[f32; SIDE]; SIDE] {
    TABLE.map(|row| row.map(|[albedo]| albedo))
}

#[inline(always)]
fn albedo<S: Simd>(simd: S, roughness: f32x16<S>, n_v: f32x16<S>) -> f32x16<S> {
    let [albedo] = looked_up(simd, &TABLE, roughness.max(0.0).min(1.0), n_v.max(0.0).min(1.0).sqrt());
    albedo
}

/// The integral over light directions, by the midpoint rule.
#[inline(always)]
fn integrated<S: Simd>(simd: S, roughness: f32, n_v: f32) -> f32 {
    const RINGS: usize = 64;
    const HALF_TURN: usize = 2 * LANES;
    let fibres = Fibres::new(f32x16::splat(simd, roughness), f32x16::splat(simd, n_v));
    let sine = (1.0 - n_v * n_v).sqrt();
    let view = Vectors::splat(simd, Vec3::new(sine, 0.0, n_v));
    let mut sum = f32x16::splat(simd, 0.0);
    for first in (0..HALF_TURN).step_by(LANES) {
        let (mut cosines, mut sines) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            // The same on all machines.
            let angle = ((first + lane) as f32 + 0.5) / HALF_TURN as f32 * PI;
            (sines[lane], cosines[lane]) = libm::sincosf(angle);
        }
        let (cosines, sines) = (f32x16::from_slice(simd, &cosines), f32x16::from_slice(simd, &sines));
        for ring in 0..RINGS {
            // Cosines are squares, so that many are near the surface, where fibres are visible.
            let root = (ring as f32 + 0.5) / RINGS as f32;
            let n_l = f32x16::splat(simd, root * root);
            let radius = (1.0 - root * root * root * root).sqrt();
            let light = Vector { x: cosines * radius, y: sines * radius, z: n_l };
            let half = view + light;
            let n_h = half.z / half.length().max(1e-20);
            sum += fibres.lobe(n_h, n_l) * root;
        }
    }
    sum.reduce_sum() * (4.0 * PI / (RINGS * HALF_TURN) as f32)
}
