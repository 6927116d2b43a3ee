use std::f32::consts::PI;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use glam::Vec3;

use super::albedo::{fifth_power, masked, specular_albedo};
use super::gloss::Gloss;
use super::lanes::Vectors;
use super::layer_paint::LayerPaint;
use super::layers::Layers;

/// The metallic-roughness model of glTF 2.0 (appendix B), Lambert below a GGX microfacet layer, with two corrections of
/// energy: the diffuse part lacks the light that the layer reflects, and rough metals keep their light.
#[derive(Clone, Copy)]
pub(crate) struct Reflectance<S: Simd> {
    /// Diffuse albedo.
    diffuse: Vectors<S>,
    /// Specular reflectance at normal incidence.
    f0: Vectors<S>,
    /// Specular reflectance at grazing angles.
    f90: f32x16<S>,
    /// GGX width: perceptual roughness squared.
    alpha: f32x16<S>,
    roughness: f32x16<S>,
}

/// A reflectance seen from one side, with all terms that depend on the view alone.
#[derive(Clone, Copy)]
pub(crate) struct SeenReflectance<S: Simd> {
    reflectance: Reflectance<S>,
    normal: Vectors<S>,
    view: Vectors<S>,
    n_v: f32x16<S>,
    /// Albedo of the diffuse layer over π, less the part that the specular layer reflects before.
    diffuse: Vectors<S>,
    /// Directional albedo of the specular layer.
    specular: Vectors<S>,
    /// The part of the light that the specular layer doesn't mirror, and that enters the material.
    entering: Vectors<S>,
    /// Factor for light that bounces several times between microfacets, over the single bounce: without it rough metals lose
    /// up to half of their light (Turquin, *Practical Multiple Scattering Compensation for Microfacet Models*, 2019).
    scattered_again: Vectors<S>,
    /// GGX width of highlights.
    highlight: f32x16<S>,
}

/// Below this perceptual roughness a point light's highlight is narrower than a pixel and flickers.
pub(crate) const SMOOTHEST: f32 = 0.045;

impl<S: Simd> Reflectance<S> {
    /// A material whose dielectric part reflects the share `dielectric` straight ahead.
    #[inline(always)]
    pub(crate) fn new(
        simd: S,
        base_color: Vectors<S>,
        metallic: f32x16<S>,
        roughness: f32x16<S>,
        dielectric: f32x16<S>,
    ) -> Self {
        let dielectric = Vectors::splat(simd, Vec3::ONE).scaled(dielectric);
        let roughness = roughness.max(SMOOTHEST).min(1.0);
        Self {
            diffuse: base_color.scaled(1.0 - metallic),
            f0: dielectric.lerp(base_color, metallic),
            f90: f32x16::splat(simd, 1.0),
            alpha: roughness * roughness,
            roughness,
        }
    }

    /// The same material with a part of its diffuse reflection replaced by transmission.
    #[inline(always)]
    pub(crate) fn with_transmission(mut self, transmission: f32x16<S>) -> Self {
        self.diffuse = self.diffuse.scaled(1.0 - transmission);
        self
    }

    /// The same material with another strength and colour of its dielectric reflection, in some lanes.
    #[inline(always)]
    pub(super) fn with_specular(
        mut self,
        simd: S,
        specular: &LayerPaint,
        (base_color, metallic, dielectric): (Vectors<S>, f32x16<S>, f32x16<S>),
    ) -> Self {
        let lanes = mask32x16::from_bitmask(simd, specular.specular_lanes.into());
        let weight = f32x16::from_slice(simd, &specular.specular);
        let colored = Vectors::load(simd, &specular.specular_color).scaled(dielectric).at_most_one();
        let f0 = colored.scaled(weight).lerp(base_color, metallic);
        self.f0 = Vectors::select(lanes, f0, self.f0);
        self.f90 = lanes.select(weight + (1.0 - weight) * metallic, self.f90);
        self
    }

    #[inline(always)]
    pub(crate) fn roughness(&self) -> f32x16<S> {
        self.roughness
    }

    #[inline(always)]
    pub(super) fn f0(&self) -> Vectors<S> {
        self.f0
    }

    /// Sets the roughness that the specular albedo and mirrors depend on.
    #[inline(always)]
    pub(super) fn roughen(&mut self, roughness: f32x16<S>) {
        self.roughness = roughness;
    }

    /// The lanes so smooth that they reflect the surroundings sharply.
    #[inline(always)]
    pub(crate) fn is_mirror(&self) -> mask32x16<S> {
        self.roughness.simd_le(SMOOTHEST)
    }

    /// The reflectance at a unit normal, seen from the direction `view`, of unit length and away from the surface, with its
    /// layers if it has any.
    #[inline(always)]
    pub(crate) fn seen(
        self,
        simd: S,
        normal: Vectors<S>,
        view: Vectors<S>,
        layers: Option<&Layers<S>>,
    ) -> SeenReflectance<S> {
        let n_v = normal.dot(view).max(1e-4);
        let [scale, bias] = specular_albedo(simd, self.roughness, n_v);
        let lost = (1.0 / (scale + bias) - 1.0).max(0.0);
        let one = Vectors::splat(simd, Vec3::ONE);
        let (mut f0, mut once) = (self.f0, self.f0.scaled(scale).raised(bias * self.f90));
        if let Some(Layers { film: Some(film), .. }) = layers {
            (f0, once) = (film.tinted(f0), film.mixed(once, film.reflected.scaled(scale + bias)));
        }
        let scattered_again = one + f0.scaled(lost);
        let specular = once * scattered_again;
        let entering = one - specular;
        let diffuse = self.diffuse.scaled(f32x16::splat(simd, 1.0 / PI)) * entering;
        let seen = SeenReflectance {
            reflectance: self,
            normal,
            view,
            n_v,
            diffuse,
            specular,
            entering,
            scattered_again,
            highlight: self.alpha,
        };
        match layers {
            Some(layers) => seen.below(simd, layers),
            None => seen,
        }
    }
}

impl<S: Simd> SeenReflectance<S> {
    /// The part of it that is seen below its layers.
    #[inline(always)]
    fn below(mut self, simd: S, layers: &Layers<S>) -> Self {
        // A coloured reflection would leave the opposite colour to the layers below.
        let entering = (1.0 - self.specular.largest()).max(0.0);
        let entering = Vectors { x: entering, y: entering, z: entering };
        let diffuse = self.reflectance.diffuse.scaled(f32x16::splat(simd, 1.0 / PI)) * entering;
        self.diffuse = Vectors::select(layers.tinting, diffuse, self.diffuse).scaled(layers.below);
        self.entering = Vectors::select(layers.tinting, entering, self.entering).scaled(layers.below);
        self.specular = self.specular.scaled(layers.below);
        self.scattered_again = self.scattered_again.scaled(layers.below);
        self
    }

    /// Reflected radiance for each unit of irradiance from `light`, a unit vector away from the surface. Zero where that
    /// is below the horizon of the normal.
    #[inline(always)]
    pub(crate) fn evaluate(&self, simd: S, light: Vectors<S>, layers: Option<&Layers<S>>) -> Vectors<S> {
        let Self {
            reflectance: Reflectance { f0, f90, .. },
            normal,
            view,
            n_v,
            diffuse,
            scattered_again,
            highlight,
            ..
        } = *self;
        let a2 = highlight * highlight;
        let n_l = normal.dot(light);
        let between = Between::new(view, light);
        let mut fresnel = schlick(f0, f90, between.cosine());
        let mut lobe = between.lobe(a2, normal, [n_l, n_v]);
        if let Some(layers) = layers {
            if let Some(film) = &layers.film {
                fresnel = film.tinted(fresnel);
            }
            if let Some(grooves) = &layers.grooves {
                let half = between.half();
                lobe = grooves.lobe(lobe, half, light, [normal.dot(half).max(0.0), n_l, n_v]);
            }
        }
        let specular = fresnel.scaled(lobe);
        let reflected = diffuse + specular * scattered_again;
        Vectors::select(n_l.simd_gt(0.0), reflected, Vectors::splat(simd, Vec3::ZERO))
    }

    /// Reflected radiance under even light from all sides: `irradiance` around the normal for the diffuse layer and
    /// `reflected`, the mean radiance around the mirror direction, for the specular one.
    #[inline(always)]
    pub(crate) fn ambient(&self, irradiance: Vectors<S>, reflected: Vectors<S>) -> Vectors<S> {
        self.diffuse * irradiance + self.specular * reflected
    }

    /// Makes highlights of lights at least `alpha` wide, by GGX's measure. This is for paths that come by way of rough
    /// surfaces: few of them would find much of a narrower highlight's light, which makes bright specks (Kaplanyan and
    /// Dachsbacher, *Path Space Regularization*, 2013).
    #[inline(always)]
    pub(crate) fn widen(&mut self, alpha: f32x16<S>) {
        self.highlight = self.highlight.max(alpha);
    }

    /// The parameters of its reflection, lane by lane, with its layers if it has any.
    #[inline(always)]
    pub(crate) fn gloss(&self, simd: S, layers: Option<&Layers<S>>) -> Gloss {
        let Reflectance { alpha, f0, f90, .. } = self.reflectance;
        Gloss {
            alpha: alpha.into(),
            f0: f0.store(),
            scattered_again: self.scattered_again.store(),
            layers: layers.map(|layers| Box::new(layers.gloss(simd, f90, self.specular.largest()))),
        }
    }

    /// Reflected radiance of the diffuse layer for each unit of irradiance.
    #[inline(always)]
    pub(crate) fn diffuse(&self) -> Vectors<S> {
        self.diffuse
    }

    /// The specular layer's weight for radiance from the mirror direction.
    #[inline(always)]
    pub(crate) fn specular(&self) -> Vectors<S> {
        self.specular
    }

    /// The part of the light that isn't mirrored, and that enters the material.
    #[inline(always)]
    pub(crate) fn entering(&self) -> Vectors<S> {
        self.entering
    }
}

/// The microfacets that mirror one unit vector into another face between the two.
pub(super) struct Between<S: Simd> {
    sum: Vectors<S>,
    /// The sum's squared length.
    squared: f32x16<S>,
}

impl<S: Simd> Between<S> {
    #[inline(always)]
    pub(super) fn new(view: Vectors<S>, light: Vectors<S>) -> Self {
        // Below this, the vectors are opposite and lengths lost to rounding.
        const LEAST: f32 = 1e-6;
        let sum = view + light;
        Self { sum, squared: sum.dot(sum).max(LEAST) }
    }

    /// The microfacets' unit normal.
    #[inline(always)]
    pub(super) fn half(&self) -> Vectors<S> {
        self.sum.scaled(1.0 / self.squared.sqrt())
    }

    /// The cosine between this normal and either of the vectors.
    #[inline(always)]
    pub(super) fn cosine(&self) -> f32x16<S> {
        0.5 * self.squared.sqrt()
    }

    /// The GGX distribution of squared width `a2` at this normal (Walter et al., *Microfacet Models for Refraction through
    /// Rough Surfaces*, 2007, equation 33) times [`visibility`], as one fraction: its numerator and denominator are
    /// multiplied by the squared length. Cosines are those of the light and of the view with the surface's `normal`.
    #[inline(always)]
    pub(super) fn lobe(&self, a2: f32x16<S>, normal: Vectors<S>, [n_l, n_v]: [f32x16<S>; 2]) -> f32x16<S> {
        let along = normal.dot(self.sum).max(0.0);
        let d = along * along * (a2 - 1.0) + self.squared;
        0.5 / PI * a2 * self.squared * self.squared / (d * d * masked(a2, n_l, n_v))
    }
}

/// Schlick's Fresnel term, from `f0` straight ahead to `f90` at grazing angles.
#[inline(always)]
fn schlick<S: Simd>(f0: Vectors<S>, f90: f32x16<S>, cosine: f32x16<S>) -> Vectors<S> {
    let missing = 1.0 - cosine.max(0.0).min(1.0);
    f0 + (-f0).raised(f90).scaled(fifth_power(missing))
}

#[cfg(test)]
mod tests {
    use umbrage_rays::{SimdLevel, dispatch};

    use super::*;
    use crate::shade::lanes::{Each, LANES, put, vector_of};

    #[derive(Clone, Copy)]
    struct Material {
        base_color: Vec3,
        metallic: f32,
        roughness: f32,
    }

    impl Material {
        #[inline(always)]
        fn seen<S: Simd>(&self, simd: S, view: Vec3) -> SeenReflectance<S> {
            let number = |value: f32| f32x16::splat(simd, value);
            let base_color = Vectors::splat(simd, self.base_color);
            Reflectance::new(simd, base_color, number(self.metallic), number(self.roughness), number(0.04)).seen(
                simd,
                Vectors::splat(simd, Vec3::Z),
                Vectors::splat(simd, view),
                None,
            )
        }

        fn evaluate(&self, view: Vec3, lights: &Each<Vec3>) -> Each<Vec3> {
            let mut each = [[0.0; LANES]; 3];
            for (lane, light) in lights.iter().enumerate() {
                put(lane, *light, &mut each);
            }
            let reflected: [Each<f32>; 3] = dispatch!(SimdLevel::default(), simd => {
                self.seen(simd, view).evaluate(simd, Vectors::load(simd, &each), None).store()
            });
            std::array::from_fn(|lane| vector_of(lane, &reflected))
        }

        fn ambient(&self, view: Vec3) -> Vec3 {
            let reflected: [Each<f32>; 3] = dispatch!(SimdLevel::default(), simd => {
                let (irradiance, radiance) = (Vectors::splat(simd, Vec3::splat(PI)), Vectors::splat(simd, Vec3::ONE));
                self.seen(simd, view).ambient(irradiance, radiance).store()
            });
            vector_of(0, &reflected)
        }

        /// Directional albedo by the midpoint rule over the hemisphere of light directions.
        fn albedo(&self, view: Vec3) -> Vec3 {
            const STEPS: usize = 256;
            let mut sum = Vec3::ZERO;
            for ring in 0..STEPS {
                for first in (0..STEPS).step_by(LANES) {
                    // Equal steps of cos² θ: each direction stands for the same π / STEPS² of projected solid angle.
                    let cosine = ((ring as f32 + 0.5) / STEPS as f32).sqrt();
                    let radius = (1.0 - cosine * cosine).sqrt();
                    let lights = std::array::from_fn(|lane| {
                        let (sin, cos) = (((first + lane) as f32 + 0.5) / STEPS as f32 * 2.0 * PI).sin_cos();
                        Vec3::new(radius * cos, radius * sin, cosine)
                    });
                    sum += self.evaluate(view, &lights).into_iter().sum::<Vec3>();
                }
            }
            sum * PI / (STEPS * STEPS) as f32
        }
    }

    #[test]
    fn white_materials_reflect_about_all_the_light_that_they_get() {
        for roughness in [0.3, 0.5, 1.0] {
            for metallic in [0.0, 1.0] {
                for cosine in [0.2_f32, 0.6, 1.0] {
                    let view = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
                    let white = Material { base_color: Vec3::ONE, metallic, roughness };
                    let albedo = white.albedo(view).x;
                    let of = format!("roughness {roughness}, metallic {metallic}, n·v {cosine}: {albedo}");
                    assert!((0.85..1.1).contains(&albedo), "{of}");
                }
            }
        }
    }

    #[test]
    fn the_lobe_is_the_product_of_distribution_and_visibility() {
        let direction = |cosine: f64, turn: f64| {
            let sine = (1.0 - cosine * cosine).sqrt();
            [sine * libm::cos(turn), sine * libm::sin(turn), cosine]
        };
        for alpha in [0.01_f64, 0.2, 1.0] {
            for (n_v, n_l) in [(1.0, 1.0), (0.9, 0.3), (0.05, 0.6), (0.4, 0.02)] {
                for turn in [0.0, 0.4, 2.0, PI.into()] {
                    let (view, light) = (direction(n_v, 0.0), direction(n_l, turn));
                    let dot = view.iter().zip(light).map(|(v, l)| v * l).sum::<f64>();
                    let a2 = alpha * alpha;
                    let n_h2 = (n_v + n_l).powi(2) / (2.0 + 2.0 * dot);
                    let distribution = a2 / (f64::from(PI) * (n_h2 * (a2 - 1.0) + 1.0).powi(2));
                    let masked = |one: f64, other: f64| one * (other * other * (1.0 - a2) + a2).sqrt();
                    let expected = distribution * 0.5 / (masked(n_l, n_v) + masked(n_v, n_l));
                    for level in SimdLevel::available() {
                        let lobe: Each<f32> = dispatch!(level, simd => {
                            let of = |[x, y, z]: [f64; 3]| Vectors::splat(simd, Vec3::new(x as f32, y as f32, z as f32));
                            let cosines = [n_l, n_v].map(|cosine| f32x16::splat(simd, cosine as f32));
                            let between = Between::new(of(view), of(light));
                            between.lobe(f32x16::splat(simd, a2 as f32), of([0.0, 0.0, 1.0]), cosines).into()
                        });
                        let relative = f64::from(lobe[0]) / expected - 1.0;
                        // A narrow peak amplifies the roundings of its cosine.
                        assert!(relative.abs() < 1e-4 + 2e-6 / a2, "{alpha} {n_v} {n_l} {turn}: {relative}");
                    }
                }
            }
        }
    }

    #[test]
    fn light_and_view_may_be_exchanged() {
        let material = Material { base_color: Vec3::new(0.8, 0.5, 0.2), metallic: 0.0, roughness: 0.4 };
        let (view, light) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, -0.8, 0.6));
        let there = material.evaluate(view, &[light; LANES])[0];
        let back = material.evaluate(light, &[view; LANES])[0];
        // The energy correction depends on the view alone; for plastic that is little.
        assert!(there.distance(back) < 0.03 * there.length(), "{there} {back}");
    }

    #[test]
    fn even_light_is_reflected_as_the_integral_says() {
        for roughness in [0.3, 0.6, 1.0] {
            let metal = Material { base_color: Vec3::ONE, metallic: 1.0, roughness };
            let view = Vec3::new(0.6, 0.0, 0.8);
            let (tabled, integrated) = (metal.ambient(view).x, metal.albedo(view).x);
            assert!((tabled - integrated).abs() < 0.03, "roughness {roughness}: {tabled} and {integrated}");
        }
    }

    #[test]
    fn nothing_is_reflected_from_below() {
        let material = Material { base_color: Vec3::ONE, metallic: 0.0, roughness: 0.5 };
        assert_eq!(material.evaluate(Vec3::Z, &[Vec3::NEG_Z; LANES]), [Vec3::ZERO; LANES]);
    }
}
