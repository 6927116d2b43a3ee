// Tone maps and encodes the film for a screen: crates/umbrage/src/film.rs.

import package::dispatch::{flat_group};
import package::shade::tone_map::{tone_map_neutral};

const TONE_MAP_NEUTRAL: u32 = 0u;
const TONE_MAP_CLIP: u32 = 1u;

struct DevelopSettings {
    // What the film's sums are multiplied by: exposure over samples.
    scale: f32,
    tone_map: u32,
    pixels: u32,
}

@group(0) @binding(0) var<uniform> develop_settings: DevelopSettings;
@group(0) @binding(1) var<storage, read> develop_film: array<vec4<f32>>;
// RGBA8, red in the lowest byte, alpha full.
@group(0) @binding(2) var<storage, read_write> develop_image: array<u32>;

// So bright that nothing brighter looks different, and finite.
const DEVELOP_BRIGHTEST: f32 = 1e30;

@compute @workgroup_size(256)
fn develop(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let pixel = flat_group(group, groups) * 256u + lane;
    if pixel >= develop_settings.pixels {
        return;
    }
    let radiance = develop_film[pixel].xyz * develop_settings.scale;
    // What isn't above zero is black, and so is what is no number.
    let bounded = select(vec3<f32>(0.0), min(radiance, vec3<f32>(DEVELOP_BRIGHTEST)), radiance > vec3<f32>(0.0));
    var shown = bounded;
    if develop_settings.tone_map == TONE_MAP_NEUTRAL {
        shown = tone_map_neutral(bounded);
    }
    shown = clamp(shown, vec3<f32>(0.0), vec3<f32>(1.0));
    let encoded = select(1.055 * pow(shown, vec3<f32>(1.0 / 2.4)) - 0.055, 12.92 * shown, shown <= vec3<f32>(0.0031308));
    develop_image[pixel] = pack4x8unorm(vec4<f32>(encoded, 1.0));
}
