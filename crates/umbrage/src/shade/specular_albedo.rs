use std::f32::consts::PI;
use std::sync::LazyLock;

use glam::{Vec2, Vec3};

/// Places along each side of the table.
const SIDE: usize = 24;

/// Scale and bias of f0 by perceptual roughness and cosine, both from 0 to 1: 4.6 KB.
static TABLE: LazyLock<[[Vec2; SIDE]; SIDE]> = LazyLock::new(|| {
    // At zero itself the integrand has no value.
    let value = |place: usize| (place as f32 / (SIDE - 1) as f32).max(1e-3);
    std::array::from_fn(|row| std::array::from_fn(|column| integrated(value(row), value(column))))
});

/// The table, by roughness and then by cosine, both from 0 to 1.
#[cfg(feature = "gpu")]
pub(crate) fn specular_albedo_table() -> [[[f32; 2]; SIDE]; SIDE] {
    TABLE.map(|row| row.map(Vec2::into))
}

/// Scale and bias of f0 in the directional albedo of a GGX layer, at the cosine `n_v` between normal and view: the
/// second of the two sums into which Karis splits light from all around (*Real Shading in Unreal Engine 4*, 2013).
pub(super) fn specular_albedo(roughness: f32, n_v: f32) -> Vec2 {
    let place = |value: f32| {
        let place = value.clamp(0.0, 1.0) * (SIDE - 1) as f32;
        let lower = (place as usize).min(SIDE - 2);
        (lower, place - lower as f32)
    };
    let ((row, down), (column, right)) = (place(roughness), place(n_v));
    let across = |row: usize| TABLE[row][column].lerp(TABLE[row][column + 1], right);
    across(row).lerp(across(row + 1), down)
}

/// The integral over light directions, by microfacet normals drawn from the distribution itself.
fn integrated(roughness: f32, n_v: f32) -> Vec2 {
    const SAMPLES: u32 = 256;
    let a2 = roughness.powi(4);
    let view = Vec3::new((1.0 - n_v * n_v).sqrt(), 0.0, n_v);
    let sum: Vec2 = (0..SAMPLES)
        .map(|sample| {
            let (u, v) = ((sample as f32 + 0.5) / SAMPLES as f32, sample.reverse_bits() as f32 / u32::MAX as f32);
            let cosine = ((1.0 - u) / (1.0 + (a2 - 1.0) * u)).sqrt();
            let sine = (1.0 - cosine * cosine).sqrt();
            let (sin, cos) = (2.0 * PI * v).sin_cos();
            let half = Vec3::new(sine * cos, sine * sin, cosine);
            let v_h = view.dot(half).max(0.0);
            let n_l = 2.0 * v_h * half.z - view.z;
            if n_l <= 0.0 {
                return Vec2::ZERO;
            }
            let weight = 4.0 * visibility(a2, n_l, n_v) * n_l * v_h / half.z;
            let fresnel = (1.0 - v_h).powi(5);
            Vec2::new(1.0 - fresnel, fresnel) * weight
        })
        .sum();
    sum / SAMPLES as f32
}

/// Height-correlated Smith shadowing over 4 (n·l)(n·v), `a2` being the squared GGX width: Heitz, *Understanding the
/// Masking-Shadowing Function in Microfacet-Based BRDFs*, 2014.
pub(super) fn visibility(a2: f32, n_l: f32, n_v: f32) -> f32 {
    let masking = n_l * (n_v * n_v * (1.0 - a2) + a2).sqrt();
    let shadowing = n_v * (n_l * n_l * (1.0 - a2) + a2).sqrt();
    0.5 / (masking + shadowing)
}
