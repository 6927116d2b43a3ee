// Stage `assign`: finds each point's cell, a slice of a tile.

import package::dispatch::{Invocation, flat_index};
import package::grid::header::{HEADER_FACES, HEADER_POINT_KEYS};
import package::grid::space::{ordered_bits, slice_between};
import package::light::cells::{BIN_FRACTION_BITS, spread_base};
import package::light::light::{Light};
import package::light::points::{POINT_NONE};

@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var<storage, read> header: array<u32>;
@group(0) @binding(2) var<storage, read> spread: array<u32>;
// Of each slot: fixed-point x and y, key, and face, which becomes the cell.
@group(0) @binding(3) var<storage, read_write> mapped: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> point_cells: array<atomic<u32>>;
// For each tile the complement of its farthest point's key, as ordered bits; zero if it has no points.
@group(0) @binding(5) var<storage, read_write> farthest_point: array<atomic<u32>>;

@compute @workgroup_size(256)
fn assign(at: Invocation) {
    let slot = flat_index(at, 256u);
    if slot >= light.slots {
        return;
    }
    let point = mapped[slot];
    if point.w == POINT_NONE {
        return;
    }
    let side = select(light.side_of_six, light.side_of_one, header[HEADER_FACES] == 1u);
    let bins = point.xy >> vec2<u32>(BIN_FRACTION_BITS);
    let column = spread[spread_base(point.w, 0u) + bins.x];
    let row = spread[spread_base(point.w, 1u) + bins.y];
    let tile = (point.w * side + row) * side + column;
    // The key has an error of one or two units in the last place.
    let key = ordered_bits(bitcast<f32>(point.z)) - 8u;
    // No triangle before the point is in a later slice.
    let slice = slice_between(key, header[HEADER_POINT_KEYS], ~header[HEADER_POINT_KEYS + 1u], light.slices);
    let cell = tile * light.slices + slice;
    mapped[slot].w = cell;
    atomicAdd(&point_cells[cell], 1u);
    atomicMax(&farthest_point[tile], ~key);
}
