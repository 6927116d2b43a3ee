use std::f32::consts::PI;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use super::albedo::fifth_power;
use super::lanes::{Each, Vector, Vectors};
use super::transcendental::{cosine, exp};

/// A thin film seen from one side: Belcour and Barla, *A Practical Extension to Microfacet Theory for the Modeling of
/// Varying Iridescence*, 2017, as `KHR_materials_iridescence` approximates it, with the view's angle for all light.
#[derive(Clone, Copy)]
pub(super) struct Film<S: Simd> {
    /// The part of the reflection that it colours, 0 to 1.
    part: f32x16<S>,
    /// Reflectance of the film together with the surface below; at most one.
    pub(super) reflected: Vectors<S>,
}

/// The eye's X, Y or Z response to a path difference: a sum of Gaussians, in Fourier space.
struct Sensitivity {
    height: f32,
    /// Per metre.
    position: f32,
    /// Per square metre.
    variance: f32,
}

const X: Sensitivity = Sensitivity { height: 5.4856e-13, position: 1.6810e6, variance: 4.3278e9 };
/// The second Gaussian of X, in the blue.
const X_BLUE: Sensitivity = Sensitivity { height: 9.7470e-14, position: 2.2399e6, variance: 4.5282e9 };
const Y: Sensitivity = Sensitivity { height: 4.4201e-13, position: 1.7953e6, variance: 9.3046e9 };
const Z: Sensitivity = Sensitivity { height: 5.2481e-13, position: 2.2084e6, variance: 6.6121e9 };

impl<S: Simd> Film<S> {
    /// A film of coverage `part`, 0 to 1, with an index of refraction and a thickness in nanometres. The surface has the
    /// reflectance `f0` at normal incidence, and the cosine between its normal and the view is `n_v`.
    #[inline(always)]
    pub(super) fn new(simd: S, [part, ior, nanometers]: [f32x16<S>; 3], f0: Vectors<S>, n_v: f32x16<S>) -> Self {
        let n_v = n_v.min(1.0);
        let sine = (1.0 - n_v * n_v) / (ior * ior);
        let cosine_inside = (1.0 - sine).max(0.0).sqrt();
        let first = schlick(reflected_ahead(ior, f32x16::splat(simd, 1.0)), n_v);
        let phase = 2.0 * PI * 1e-9 * (2.0 * ior * nanometers * cosine_inside);
        let red = Interface::new(simd, first, ior, f0.x, cosine_inside);
        let green = Interface::new(simd, first, ior, f0.y, cosine_inside);
        let blue = Interface::new(simd, first, ior, f0.z, cosine_inside);
        let mut sum = Vector { x: red.mean, y: green.mean, z: blue.mean };
        for order in [1, 2] {
            let phase = phase * order as f32;
            let signs = [red.sign(order), green.sign(order), blue.sign(order)];
            let answer = Vector {
                x: (answer(&X, phase) + answer(&X_BLUE, phase)) * signs[0],
                y: answer(&Y, phase) * signs[1],
                z: answer(&Z, phase) * signs[2],
            };
            let amplitude = Vector { x: red.amplitude(order), y: green.amplitude(order), z: blue.amplitude(order) };
            sum += amplitude * rec709_from_xyz(answer).scaled(f32x16::splat(simd, 2.0));
        }
        Self { part, reflected: sum.at_least_zero().at_most_one() }
    }

    /// Coverage and reflectance, lane by lane.
    #[inline(always)]
    pub(super) fn store(&self) -> (Each<f32>, [Each<f32>; 3]) {
        (self.part.into(), self.reflected.store())
    }

    /// The reflection `mirrored` of the bare surface, coloured by the film.
    #[inline(always)]
    pub(super) fn tinted(&self, mirrored: Vectors<S>) -> Vectors<S> {
        self.mixed(mirrored, self.reflected)
    }

    /// `bare` where there is no film, `filmed` where it is whole.
    #[inline(always)]
    pub(super) fn mixed(&self, bare: Vectors<S>, filmed: Vectors<S>) -> Vectors<S> {
        bare.scaled(1.0 - self.part) + filmed.scaled(self.part)
    }
}

/// Light of one colour between the two sides of a film.
struct Interface<S: Simd> {
    /// The mean reflectance over all path lengths.
    mean: f32x16<S>,
    /// The factor of amplitude for one way there and back.
    there_and_back: f32x16<S>,
    /// The part that comes out again, less the part that enters.
    surplus: f32x16<S>,
    /// 1 where both sides shift the phase, −1 where only one does.
    shift: f32x16<S>,
}

impl<S: Simd> Interface<S> {
    #[inline(always)]
    fn new(simd: S, first: f32x16<S>, ior: f32x16<S>, f0: f32x16<S>, cosine_inside: f32x16<S>) -> Self {
        let root = (f0 + 1e-4).max(0.0).min(0.9999).sqrt();
        let below = (1.0 + root) / (1.0 - root);
        let second = schlick(reflected_ahead(below, ior), cosine_inside);
        let both = (first * second).max(1e-5).min(0.9999);
        let transmitted = 1.0 - first;
        let returned = transmitted * transmitted * second / (1.0 - both);
        let one = f32x16::splat(simd, 1.0);
        let shift = below.simd_lt(ior).select(one, -one);
        Self { mean: first + returned, there_and_back: both.sqrt(), surplus: returned - transmitted, shift }
    }

    #[inline(always)]
    fn amplitude(&self, order: u32) -> f32x16<S> {
        let once = self.surplus * self.there_and_back;
        if order == 1 { once } else { once * self.there_and_back }
    }

    #[inline(always)]
    fn sign(&self, order: u32) -> f32x16<S> {
        if order == 1 { self.shift } else { self.shift * self.shift }
    }
}

/// Reflectance at normal incidence between two media of these indices.
#[inline(always)]
fn reflected_ahead<S: Simd>(behind: f32x16<S>, before: f32x16<S>) -> f32x16<S> {
    let ratio = (behind - before) / (behind + before);
    ratio * ratio
}

#[inline(always)]
fn schlick<S: Simd>(f0: f32x16<S>, cosine: f32x16<S>) -> f32x16<S> {
    f0 + (1.0 - f0) * fifth_power(1.0 - cosine.max(0.0).min(1.0))
}

#[inline(always)]
fn answer<S: Simd>(of: &Sensitivity, phase: f32x16<S>) -> f32x16<S> {
    // Y of light of all wavelengths, which scales it to one.
    const WHOLE: f32 = 1.0685e-7;
    let amplitude = of.height * (2.0 * PI * of.variance).sqrt() / WHOLE;
    amplitude * cosine(of.position * phase) * exp(-(of.variance * phase * phase))
}

#[inline(always)]
fn rec709_from_xyz<S: Simd>(Vector { x, y, z }: Vectors<S>) -> Vectors<S> {
    Vector {
        x: 3.240_454_2 * x - 1.537_138_5 * y - 0.498_531_4 * z,
        y: -0.969_266 * x + 1.876_010_8 * y + 0.041_556 * z,
        z: 0.055_643_4 * x - 0.204_025_9 * y + 1.057_225_2 * z,
    }
}
