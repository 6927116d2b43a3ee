// Random points for paths: crates/umbrage/src/points.rs, which has the sources.

import package::shade::tables::{shade_sample};

// Purposes of a bounce's points: the microfacet that is hit, and the direction of ambient occlusion.
const DRAWN_FACET: u32 = 0u;
const DRAWN_AROUND: u32 = 1u;
const DRAWN_PURPOSES: u32 = 2u;

// A point of the unit square for a pixel of the shaded rows, after `bounces` bounces, at this sample.
fn drawn_point(pixel: u32, bounces: u32, purpose: u32) -> vec2<f32> {
    let dimension = drawn_mixed(pixel + shade_sample.first_pixel) + bounces * DRAWN_PURPOSES + purpose;
    let number = drawn_scrambled(shade_sample.number, drawn_seed(dimension, 0u));
    let first = drawn_scrambled(reverseBits(number), drawn_seed(dimension, 1u));
    let second = drawn_scrambled(drawn_second_sobol(number), drawn_seed(dimension, 2u));
    return vec2<f32>(drawn_unit(first), drawn_unit(second));
}

fn drawn_seed(dimension: u32, purpose: u32) -> u32 {
    return drawn_mixed(dimension * 3u + purpose + 1u);
}

// At least zero and below one.
fn drawn_unit(bits: u32) -> f32 {
    return min((f32(bits) + 0.5) / 4294967296.0, 0.99999994);
}

fn drawn_second_sobol(number: u32) -> u32 {
    var sum = 0u;
    var column = 1u << 31u;
    for (var bit = 0u; bit < 32u; bit++) {
        if ((number >> bit) & 1u) == 1u {
            sum ^= column;
        }
        column ^= column >> 1u;
    }
    return sum;
}

fn drawn_scrambled(bits: u32, seed: u32) -> u32 {
    var x = reverseBits(bits);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverseBits(x);
}

fn drawn_mixed(number: u32) -> u32 {
    var x = number * 0x9e3779b9u;
    x = (x ^ (x >> 16u)) * 0x85ebca6bu;
    x = (x ^ (x >> 13u)) * 0xc2b2ae35u;
    return x ^ (x >> 16u);
}
