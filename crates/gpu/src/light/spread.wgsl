// Stage `spread`: makes columns and rows of cells narrow where points are dense. Each axis of a face is cut into bins
// of equal width; a bin's column follows from the number of points before it, and a little from its position.
//
// A workgroup has an axis of a face.

import package::grid::header::{HEADER_FACES};
import package::light::cells::{BINS, SPREAD_STARTS, SPREAD_WORDS};
import package::light::light::{Light};
import package::primitives::workgroup_scan::{SCAN_WIDTH, scan_shared, scan_workgroup};

@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var<storage, read> header: array<u32>;
@group(0) @binding(2) var<storage, read_write> spread: array<u32>;

const SPREAD_DEPTH: u32 = BINS / SCAN_WIDTH;
// Log2 of the inverse share of columns that are spread evenly.
const EVEN_BITS: u32 = 2u;

@compute @workgroup_size(256)
fn spread_columns(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let faces = header[HEADER_FACES];
    let axis = group.x;
    let side = select(light.side_of_six, light.side_of_one, faces == 1u);
    let base = axis * SPREAD_WORDS;
    let first = lane * SPREAD_DEPTH;
    var own = 0u;
    for (var bin = first; bin < first + SPREAD_DEPTH; bin++) {
        own += spread[base + bin];
    }
    var before = scan_workgroup(lane, own);
    let total = max(scan_shared[SCAN_WIDTH - 1u], 1u);
    // In 2²⁰ parts of all points, so that products stay below 2³².
    let step = 1048576.0 / f32(total);
    var previous = column(before, step, first, side);
    if lane == 0u {
        previous = 0u;
        spread[base + SPREAD_STARTS] = 0u;
    } else {
        previous = column(before - spread[base + first - 1u], step, first - 1u, side);
    }
    // Columns replace counts only after all counts have been read.
    var columns: array<u32, SPREAD_DEPTH>;
    for (var i = 0u; i < SPREAD_DEPTH; i++) {
        columns[i] = column(before, step, first + i, side);
        before += spread[base + first + i];
    }
    workgroupBarrier();
    storageBarrier();
    for (var i = 0u; i < SPREAD_DEPTH; i++) {
        spread[base + first + i] = columns[i];
        // A column without bins starts, and ends, where the next one starts.
        for (var next = previous + 1u; next <= columns[i]; next++) {
            spread[base + SPREAD_STARTS + next] = first + i;
        }
        previous = columns[i];
    }
    if lane == SCAN_WIDTH - 1u {
        for (var next = previous + 1u; next <= side; next++) {
            spread[base + SPREAD_STARTS + next] = BINS;
        }
    }
}

// The column of a bin with `before` points before it.
fn column(before: u32, step: f32, bin: u32, side: u32) -> u32 {
    let of_points = u32(f32(before) * step);
    let even = (bin << 20u) / BINS;
    let part = of_points - (of_points >> EVEN_BITS) + (even >> EVEN_BITS);
    return min(((part >> 8u) * side) >> 12u, side - 1u);
}
