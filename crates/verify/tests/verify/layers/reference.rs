//! The extensions' formulas, in scalar f64, written from their texts alone. Normal (0, 0, 1), tangent (1, 0, 0).

use std::f64::consts::PI;

use glam::DVec3;

/// Cosines of a lobe.
struct Angles {
    half: DVec3,
    n_h: f64,
    n_l: f64,
    n_v: f64,
}

impl Angles {
    fn new(view: DVec3, light: DVec3) -> Self {
        let half = (view + light).normalize();
        Self { half, n_h: half.z, n_l: light.z, n_v: view.z }
    }
}

pub(super) fn schlick(f0: f64, f90: f64, cosine: f64) -> f64 {
    f0 + (f90 - f0) * (1.0 - cosine.abs()).powi(5)
}

/// glTF 2.0, appendix B: D·V of GGX.
pub(super) fn ggx(roughness: f64, view: DVec3, light: DVec3) -> f64 {
    stretched_ggx(roughness, 0.0, 0.0, view, light)
}

/// `KHR_materials_anisotropy`: D·V of a highlight that is stretched along the tangent, turned by `rotation`.
pub(super) fn stretched_ggx(roughness: f64, strength: f64, rotation: f64, view: DVec3, light: DVec3) -> f64 {
    let Angles { half, n_h, n_l, n_v } = Angles::new(view, light);
    let (tangent, bitangent) =
        (DVec3::new(rotation.cos(), rotation.sin(), 0.0), DVec3::new(-rotation.sin(), rotation.cos(), 0.0));
    let across = roughness * roughness;
    let along = across + (1.0 - across) * strength * strength;
    let (x, y) = (half.dot(tangent) / along, half.dot(bitangent) / across);
    let distribution = 1.0 / (PI * along * across * (x * x + y * y + n_h * n_h).powi(2));
    let length = |of: DVec3| DVec3::new(along * of.dot(tangent), across * of.dot(bitangent), of.z).length();
    distribution * 0.5 / (n_l * length(view) + n_v * length(light))
}

/// `KHR_materials_sheen`: D·V of fibres.
pub(super) fn charlie(roughness: f64, view: DVec3, light: DVec3) -> f64 {
    let Angles { n_h, n_l, n_v, .. } = Angles::new(view, light);
    let alpha = roughness * roughness;
    let distribution = (2.0 + 1.0 / alpha) * (1.0 - n_h * n_h).max(0.0).powf(0.5 / alpha) / (2.0 * PI);
    let masking = 1.0 + lambda(n_v, alpha) + lambda(n_l, alpha);
    distribution / (masking * 4.0 * n_v * n_l)
}

fn lambda(cosine: f64, alpha: f64) -> f64 {
    let l = |x: f64| {
        let part = (1.0 - alpha) * (1.0 - alpha);
        let mix = |wide: f64, narrow: f64| wide + (narrow - wide) * part;
        let [a, b, c] = [mix(21.5473, 25.3245), mix(3.82987, 3.32435), mix(0.19823, 0.16801)];
        a / (1.0 + b * x.powf(c)) + mix(-1.97760, -1.27393) * x + mix(-4.32054, -4.85967)
    };
    if cosine < 0.5 { l(cosine).exp() } else { (2.0 * l(0.5) - l(1.0 - cosine)).exp() }
}

/// `KHR_materials_iridescence`: reflectance of a film of some index and thickness on a surface with `f0` at normal
/// incidence.
pub(super) fn film(ior: f64, nanometers: f64, f0: [f64; 3], cosine: f64) -> [f64; 3] {
    let squared = |x: f64| x * x;
    let f0_of = |behind: f64, before: f64| squared((behind - before) / (behind + before));
    let inside = (1.0 - squared(1.0 / ior) * (1.0 - squared(cosine))).sqrt();
    let r12 = schlick(f0_of(ior, 1.0), 1.0, cosine);
    let t121 = 1.0 - r12;
    let difference = 2.0 * ior * nanometers * inside;
    let base = f0.map(|f0| {
        let root = (f0 + 0.0001).sqrt();
        (1.0 + root) / (1.0 - root)
    });
    let phi = base.map(|base| PI + if base < ior { PI } else { 0.0 });
    let r23 = base.map(|base| schlick(f0_of(base, ior), 1.0, inside));
    let r123 = r23.map(|r23| (r12 * r23).clamp(1e-5, 0.9999));
    let rs: [f64; 3] = std::array::from_fn(|of| squared(t121) * r23[of] / (1.0 - r123[of]));
    let mut sum = rs.map(|rs| r12 + rs);
    let mut amplitude = rs.map(|rs| rs - t121);
    for order in [1.0, 2.0] {
        let answer = sensitivity(order * difference, phi.map(|phi| order * phi));
        for channel in 0..3 {
            amplitude[channel] *= r123[channel].sqrt();
            sum[channel] += amplitude[channel] * 2.0 * answer[channel];
        }
    }
    sum.map(|sum| sum.max(0.0))
}

fn sensitivity(nanometers: f64, shift: [f64; 3]) -> [f64; 3] {
    let phase = 2.0 * PI * nanometers * 1e-9;
    let gaussian = |height: f64, position: f64, variance: f64, shift: f64| {
        height * (2.0 * PI * variance).sqrt() * (position * phase + shift).cos() * (-phase * phase * variance).exp()
            / 1.0685e-7
    };
    let x = gaussian(5.4856e-13, 1.6810e6, 4.3278e9, shift[0]) + gaussian(9.7470e-14, 2.2399e6, 4.5282e9, shift[0]);
    let y = gaussian(4.4201e-13, 1.7953e6, 9.3046e9, shift[1]);
    let z = gaussian(5.2481e-13, 2.2084e6, 6.6121e9, shift[2]);
    [
        3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
        -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
        0.0556434 * x - 0.2040259 * y + 1.0572252 * z,
    ]
}

/// Albedo of a lobe under even light, by the midpoint rule.
pub(super) fn albedo(lobe: impl Fn(DVec3) -> f64) -> f64 {
    const STEPS: usize = 400;
    let mut sum = 0.0;
    for ring in 0..STEPS {
        let root = (ring as f64 + 0.5) / STEPS as f64;
        let (height, radius) = (root * root, (1.0 - root.powi(4)).sqrt());
        for step in 0..STEPS {
            let (sin, cos) = ((step as f64 + 0.5) / STEPS as f64 * 2.0 * PI).sin_cos();
            sum += lobe(DVec3::new(radius * cos, radius * sin, height)) * height * root;
        }
    }
    sum * 4.0 * PI / (STEPS * STEPS) as f64
}
