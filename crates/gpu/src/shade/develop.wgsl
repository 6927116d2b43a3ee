// Tone maps and encodes the film for a screen: crates/umbrage/src/screen.rs.

import package::dispatch::{Invocation, flat_index};
import package::shade::tone_map::{tone_map_neutral};

const TONE_MAP_NEUTRAL: u32 = 0u;
const TONE_MAP_CLIP: u32 = 1u;
const NO_PLANE: u32 = 0xffffffffu;
// A pixel whose remaining fraction, 0 to 1, is below this counts as wholly unlit.
const LEAST_REST: f32 = 0.0009765625;

struct DevelopSettings {
    // One over the number of samples, which turns the film's sums into means.
    weight: f32,
    exposure: f32,
    tone_map: u32,
    width: u32,
    height: u32,
    // Distance between rows of the image, in pixels.
    row_pixels: u32,
    // First pixel of the film's plane of unlit colour, which is shown without tone mapping; NO_PLANE if there is none.
    flat_plane: u32,
}

@group(0) @binding(0) var<uniform> develop_settings: DevelopSettings;
@group(0) @binding(1) var<storage, read> develop_film: array<vec4<f32>>;
// The least linear value of each level of an sRGB-encoded channel: the same numbers as on the CPU, since `pow` differs
// between adapters.
@group(0) @binding(2) var<storage, read> develop_levels: array<f32>;
// RGBA8, red in the lowest byte, alpha full.
@group(0) @binding(3) var<storage, read_write> develop_image: array<u32>;

// Finite, and so bright that brighter values look the same.
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

fn tone_mapped(radiance: vec3<f32>) -> vec3<f32> {
    // Zero, negative numbers and NaN are black.
    let bounded = select(vec3<f32>(0.0), min(radiance, vec3<f32>(DEVELOP_BRIGHTEST)), radiance > vec3<f32>(0.0));
    if develop_settings.tone_map == TONE_MAP_NEUTRAL {
        return tone_map_neutral(bounded);
    }
    return min(bounded, vec3<f32>(1.0));
}

@compute @workgroup_size(256)
fn develop(at: Invocation) {
    let pixel = flat_index(at, 256u);
    if pixel >= develop_settings.width * develop_settings.height {
        return;
    }
    var color = develop_film[pixel].xyz * develop_settings.weight;
    var as_it_is = vec3<f32>(0.0);
    var rest = 1.0;
    if develop_settings.flat_plane != NO_PLANE {
        let flat_color = develop_film[develop_settings.flat_plane + pixel] * develop_settings.weight;
        as_it_is = flat_color.xyz;
        rest = 1.0 - flat_color.w;
        // Without a remainder, light on top of unlit surfaces is added in full.
        rest = select(rest, 1.0, rest < LEAST_REST);
        color = (color - as_it_is) / rest;
    }
    let shown = tone_mapped(color * develop_settings.exposure) * rest + as_it_is;
    let levels = vec3<u32>(develop_level(shown.x), develop_level(shown.y), develop_level(shown.z));
    let word = pixel / develop_settings.width * develop_settings.row_pixels + pixel % develop_settings.width;
    develop_image[word] = levels.x | (levels.y << 8u) | (levels.z << 16u) | 0xff000000u;
}
