// Terms common to all microfacet lobes: crates/umbrage/src/shade/brdf.rs.

const BRDF_PI: f32 = 3.14159265358979;
// Below this perceptual roughness a point light's highlight is narrower than a pixel and flickers.
const BRDF_SMOOTHEST: f32 = 0.045;

fn ggx_distribution(a2: f32, n_h: f32) -> f32 {
    let d = n_h * n_h * (a2 - 1.0) + 1.0;
    return a2 / (BRDF_PI * d * d);
}

// The unit half vector of two others; the normal if they are opposite.
fn half_vector(normal: vec3<f32>, view: vec3<f32>, light: vec3<f32>) -> vec3<f32> {
    let between = view + light;
    let squared = dot(between, between);
    if squared > 0.0 {
        return between * inverseSqrt(squared);
    }
    return normal;
}
