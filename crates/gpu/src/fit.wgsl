// Stage `fit`: decides whether a frame's structures had enough room. Later stages are dispatched only then: a frame
// that doesn't fit is rendered again with more room, and must not leave anything behind.

import package::dispatch::{groups_of};
import package::grid::header::{HEADER_BLOCKS, HEADER_FACES, HEADER_LARGE};

// Capacities: counts, and words of the buffer for undecided pairs.
struct FitRoom {
    large: u32,
    pairs: u32,
    blocks: u32,
    faces: u32,
    undecided_words: u32,
    words_per_undecided: u32,
    words_per_pixel: u32,
    // Words before the first undecided pair.
    undecided_header: u32,
}

struct Fit {
    camera: FitRoom,
    light: FitRoom,
    lights: u32,
    // The workgroups of the next dispatch.
    groups: u32,
}

@group(0) @binding(0) var<uniform> fit_room: Fit;
@group(0) @binding(1) var<storage, read> camera_needs: array<u32>;
// One record for each light.
@group(0) @binding(2) var<storage, read> light_needs: array<u32>;
@group(0) @binding(3) var<storage, read_write> sizes: array<u32>;

// A record of needs: a header, then the numbers of pairs, of undecided pairs, and of pixels with undecided pairs.
const NEEDS_PAIRS: u32 = 36u;
const NEEDS_UNDECIDED: u32 = 37u;
const NEEDS_PIXELS: u32 = 38u;
const NEEDS_WORDS: u32 = 40u;

fn fits(room: FitRoom, large: u32, pairs: u32, blocks: u32, faces: u32, undecided: u32, pixels: u32) -> bool {
    // Keeps the products far below 2³².
    let is_small = undecided < 0x10000000u && pixels < 0x10000000u;
    let words = room.undecided_header + undecided * room.words_per_undecided + pixels * room.words_per_pixel;
    return large <= room.large && pairs <= room.pairs && blocks <= room.blocks && faces <= room.faces
        && is_small && words <= room.undecided_words;
}

@compute @workgroup_size(1)
fn fit() {
    var all_fit = fits(
        fit_room.camera, camera_needs[HEADER_LARGE], camera_needs[NEEDS_PAIRS], camera_needs[HEADER_BLOCKS], 1u,
        camera_needs[NEEDS_UNDECIDED], camera_needs[NEEDS_PIXELS]);
    for (var light = 0u; light < fit_room.lights; light++) {
        let base = light * NEEDS_WORDS;
        all_fit = all_fit && fits(
            fit_room.light, light_needs[base + HEADER_LARGE], light_needs[base + NEEDS_PAIRS],
            light_needs[base + HEADER_BLOCKS], light_needs[base + HEADER_FACES], light_needs[base + NEEDS_UNDECIDED],
            0u);
    }
    let groups = select(vec3<u32>(0u), groups_of(fit_room.groups), all_fit);
    sizes[0] = groups.x;
    sizes[1] = groups.y;
    sizes[2] = groups.z;
}
