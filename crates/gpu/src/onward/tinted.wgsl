// Stage `tinted`: stores the transmittance from each point to a light, after the bits of all lights.

import package::dispatch::{Invocation, flat_index};
import package::rays::light::{ShadowLight};
import package::rays::records::{RECORDS_COUNT};

@group(0) @binding(0) var<uniform> shadow_light: ShadowLight;
@group(0) @binding(1) var<storage, read> records: array<u32>;
@group(0) @binding(2) var<storage, read> traced: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> undecided_hits: array<u32>;
@group(0) @binding(4) var<storage, read_write> lit_words: array<u32>;

// As in `shade/tint.wgsl`.
const LIST_FIRST: u32 = 16u;
const LIST_WORDS: u32 = 8u;

@compute @workgroup_size(64)
fn tinted(at: Invocation) {
    let number = flat_index(at, 64u);
    if number >= records[RECORDS_COUNT] {
        return;
    }
    var left = vec2<u32>(0xffffffffu, 0x0000ffffu);
    let room = (arrayLength(&undecided_hits) - LIST_FIRST) / LIST_WORDS;
    if shadow_light.casts_shadow != 0u && traced[number].y < room {
        let base = LIST_FIRST + traced[number].y * LIST_WORDS;
        left = vec2<u32>(undecided_hits[base + 3u], undecided_hits[base + 5u]);
    }
    // A word of bits covers 32 points, whose transmittances take 64 words.
    let word = shadow_light.tints + 64u * shadow_light.mask + 2u * number;
    lit_words[word] = left.x;
    lit_words[word + 1u] = left.y;
}
