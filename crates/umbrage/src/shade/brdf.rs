use std::f32::consts::PI;

use glam::Vec3;

use super::specular_albedo::{specular_albedo, visibility};

/// The metallic-roughness model of glTF 2.0 (appendix B), Lambert below a GGX microfacet layer, with two losses of
/// energy mended: light that the layer reflects is what the diffuse part lacks, and rough metals keep their light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reflectance {
    /// Diffuse albedo.
    diffuse: Vec3,
    /// Specular reflectance at normal incidence.
    f0: Vec3,
    /// GGX width: perceptual roughness squared.
    alpha: f32,
    roughness: f32,
}

impl Reflectance {
    /// Below this perceptual roughness a point light's highlight is narrower than a pixel and flickers.
    const SMOOTHEST: f32 = 0.045;

    pub(crate) fn new(base_color: Vec3, metallic: f32, roughness: f32, ior: f32) -> Self {
        let dielectric = ((ior - 1.0) / (ior + 1.0)).powi(2);
        let roughness = roughness.clamp(Self::SMOOTHEST, 1.0);
        Self {
            diffuse: base_color * (1.0 - metallic),
            f0: Vec3::splat(dielectric).lerp(base_color, metallic),
            alpha: roughness * roughness,
            roughness,
        }
    }

    /// The same material with a part of its diffuse reflection taken away, which passes through instead.
    pub(crate) fn with_transmission(mut self, transmission: f32) -> Self {
        self.diffuse *= 1.0 - transmission;
        self
    }

    pub(crate) fn roughness(&self) -> f32 {
        self.roughness
    }

    /// Reflected radiance towards `view` for each unit of irradiance from `light`; all three vectors of unit length
    /// and pointing away from the surface. Zero where `light` is below the horizon of `normal`.
    pub(crate) fn evaluate(&self, normal: Vec3, view: Vec3, light: Vec3) -> Vec3 {
        let n_l = normal.dot(light);
        if n_l <= 0.0 {
            return Vec3::ZERO;
        }
        let n_v = normal.dot(view).max(1e-4);
        let half = (view + light).normalize_or(normal);
        let n_h = normal.dot(half).max(0.0);
        let fresnel = schlick(self.f0, view.dot(half));
        let specular = fresnel * (self.distribution(n_h) * visibility(self.alpha * self.alpha, n_l, n_v));
        self.diffuse / PI * (Vec3::ONE - self.specular(n_v)) + specular * self.scattered_again(n_v)
    }

    /// Reflected radiance under even light from all sides: `irradiance` around the normal, over π, for the diffuse
    /// layer and `reflected`, the mean radiance around the mirror direction, for the specular one.
    pub(crate) fn ambient(&self, n_v: f32, irradiance: Vec3, reflected: Vec3) -> Vec3 {
        let specular = self.specular(n_v);
        self.diffuse / PI * irradiance * (Vec3::ONE - specular) + specular * reflected
    }

    /// Directional albedo of the specular layer: what it reflects doesn't reach the diffuse one.
    fn specular(&self, n_v: f32) -> Vec3 {
        let [scale, bias] = specular_albedo(self.roughness, n_v).to_array();
        (self.f0 * scale + bias) * self.scattered_again(n_v)
    }

    /// What light that bounces several times between microfacets adds to the single bounce, as a factor: without it
    /// rough metals lose up to half of their light (Turquin, *Practical Multiple Scattering Compensation for Microfacet
    /// Models*, 2019).
    fn scattered_again(&self, n_v: f32) -> Vec3 {
        let once = specular_albedo(self.roughness, n_v).element_sum();
        Vec3::ONE + self.f0 * (1.0 / once - 1.0).max(0.0)
    }

    /// GGX: Walter et al., *Microfacet Models for Refraction through Rough Surfaces*, 2007, equation 33.
    fn distribution(&self, n_h: f32) -> f32 {
        let a2 = self.alpha * self.alpha;
        let d = n_h * n_h * (a2 - 1.0) + 1.0;
        a2 / (PI * d * d)
    }
}

/// Schlick's Fresnel term.
fn schlick(f0: Vec3, cosine: f32) -> Vec3 {
    f0 + (Vec3::ONE - f0) * (1.0 - cosine.clamp(0.0, 1.0)).powi(5)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directional albedo by the midpoint rule over the hemisphere of light directions.
    fn albedo(reflectance: &Reflectance, view: Vec3) -> Vec3 {
        const STEPS: usize = 256;
        let mut sum = Vec3::ZERO;
        for ring in 0..STEPS {
            for step in 0..STEPS {
                // Equal steps of cos² θ: each direction stands for the same π / STEPS² of projected solid angle.
                let cosine = ((ring as f32 + 0.5) / STEPS as f32).sqrt();
                let (sin, cos) = ((step as f32 + 0.5) / STEPS as f32 * 2.0 * PI).sin_cos();
                let radius = (1.0 - cosine * cosine).sqrt();
                sum += reflectance.evaluate(Vec3::Z, view, Vec3::new(radius * cos, radius * sin, cosine));
            }
        }
        sum * PI / (STEPS * STEPS) as f32
    }

    #[test]
    fn white_materials_reflect_about_all_the_light_that_they_get() {
        for roughness in [0.3, 0.5, 1.0] {
            for metallic in [0.0, 1.0] {
                for cosine in [0.2_f32, 0.6, 1.0] {
                    let view = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
                    let white = Reflectance::new(Vec3::ONE, metallic, roughness, 1.5);
                    let albedo = albedo(&white, view).x;
                    let of = format!("roughness {roughness}, metallic {metallic}, n·v {cosine}: {albedo}");
                    assert!((0.85..1.1).contains(&albedo), "{of}");
                }
            }
        }
    }

    #[test]
    fn light_and_view_may_be_exchanged() {
        let material = Reflectance::new(Vec3::new(0.8, 0.5, 0.2), 0.0, 0.4, 1.5);
        let (view, light) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, -0.8, 0.6));
        let (there, back) = (material.evaluate(Vec3::Z, view, light), material.evaluate(Vec3::Z, light, view));
        // The mended energy depends on the view alone; for plastic that is little.
        assert!(there.distance(back) < 0.03 * there.length(), "{there} {back}");
    }

    #[test]
    fn even_light_is_reflected_as_the_integral_says() {
        for roughness in [0.3, 0.6, 1.0] {
            let metal = Reflectance::new(Vec3::ONE, 1.0, roughness, 1.5);
            let view = Vec3::new(0.6, 0.0, 0.8);
            let tabled = metal.ambient(0.8, Vec3::splat(PI), Vec3::ONE).x;
            let integrated = albedo(&metal, view).x;
            assert!((tabled - integrated).abs() < 0.03, "roughness {roughness}: {tabled} and {integrated}");
        }
    }

    #[test]
    fn nothing_is_reflected_from_below() {
        let material = Reflectance::new(Vec3::ONE, 0.0, 0.5, 1.5);
        assert_eq!(material.evaluate(Vec3::Z, Vec3::Z, Vec3::NEG_Z), Vec3::ZERO);
    }
}
