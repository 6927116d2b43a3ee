// Tone maps and encodes the film for a screen: crates/umbrage/src/screen.rs.

import package::dispatch::{Invocation, flat_index};
import package::shade::tone_map::{tone_map_neutral};

const TONE_MAP_NEUTRAL: u32 = 0u;
const TONE_MAP_CLIP: u32 = 1u;

struct DevelopSettings {
    // What makes means of the film's sums.
    weight: f32,
    exposure: f32,
    tone_map: u32,
    width: u32,
    height: u32,
    // From one row of the image to the next.
    row_pixels: u32,
}

@group(0) @binding(0) var<uniform> develop_settings: DevelopSettings;
@group(0) @binding(1) var<storage, read> develop_film: array<vec4<f32>>;
// The least linear value of each level of an sRGB-encoded channel: the same numbers as on the CPU, since no two adapters
// have the same powers.
@group(0) @binding(2) var<storage, read> develop_levels: array<f32>;
// RGBA8, red in the lowest byte, alpha full.
@group(0) @binding(3) var<storage, read_write> develop_image: array<u32>;

// So bright that nothing brighter looks different, and finite.
const DEVELOP_BRIGHTEST: f32 = 1e30;

// The highest level whose least value is reached.
fn develop_level(linear: f32) -> u32 {
    var level = 0u;
    for (var step = 128u; step > 0u; step /= 2u) {
        if develop_levels[level + step] <= linear {
            level += step;
        }
    }
    return level;
}

@compute @workgroup_size(256)
fn develop(at: Invocation) {
    let pixel = flat_index(at, 256u);
    if pixel >= develop_settings.width * develop_settings.height {
        return;
    }
    let radiance = develop_film[pixel].xyz * develop_settings.weight * develop_settings.exposure;
    // What isn't above zero is black, and so is what is no number.
    let bounded = select(vec3<f32>(0.0), min(radiance, vec3<f32>(DEVELOP_BRIGHTEST)), radiance > vec3<f32>(0.0));
    var shown = bounded;
    if develop_settings.tone_map == TONE_MAP_NEUTRAL {
        shown = tone_map_neutral(bounded);
    }
    let levels = vec3<u32>(develop_level(shown.x), develop_level(shown.y), develop_level(shown.z));
    let word = pixel / develop_settings.width * develop_settings.row_pixels + pixel % develop_settings.width;
    develop_image[word] = levels.x | (levels.y << 8u) | (levels.z << 16u) | 0xff000000u;
}
