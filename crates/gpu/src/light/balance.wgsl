// Stage `balance`: cuts the light's cells into blocks of work. A cell with R points, and T triangles in its slice of
// the tile and the slices before it, makes ⌈R/r⌉ · ⌈T/t⌉ blocks: cells don't share blocks (the paper's hard
// boundaries), blocks of one cell are interchangeable (its soft ones), and long lists of triangles are split as well.

import package::dispatch::{Invocation, flat_index, groups_of};
import package::grid::header::{HEADER_BLOCKS, HEADER_BLOCK_GROUPS, HEADER_FACES};
import package::light::blocks::{LIGHT_BLOCKS_FIRST, LIGHT_BLOCK_PAIRS, LIGHT_BLOCK_POINTS, LIGHT_BLOCK_WORDS};
import package::light::cells::{SPREAD_STARTS, spread_base};
import package::light::light::{Light};

@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var<storage, read> cells: array<u32>;
@group(0) @binding(2) var<storage, read> point_cells: array<u32>;
@group(0) @binding(3) var<storage, read_write> header: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read> spread: array<u32>;
@group(0) @binding(5) var<storage, read_write> blocks: array<u32>;

@compute @workgroup_size(64)
fn balance(at: Invocation) {
    let tile = flat_index(at, 64u);
    let side = select(light.side_of_six, light.side_of_one, atomicLoad(&header[HEADER_FACES]) == 1u);
    if tile >= atomicLoad(&header[HEADER_FACES]) * side * side {
        return;
    }
    var count = 0u;
    for (var slice = 0u; slice < light.slices; slice++) {
        let blocks = blocks_of(tile, slice);
        count += blocks.x * blocks.y;
    }
    if count == 0u {
        return;
    }
    let face = tile / (side * side);
    let column = spread_base(face, 0u) + SPREAD_STARTS + tile % side;
    let row = spread_base(face, 1u) + SPREAD_STARTS + tile / side % side;
    var word = LIGHT_BLOCKS_FIRST + atomicAdd(&header[HEADER_BLOCKS], count) * LIGHT_BLOCK_WORDS;
    for (var slice = 0u; slice < light.slices; slice++) {
        let points = points_of(tile, slice);
        let pairs = pairs_of(tile, slice);
        let in_slice = blocks_of(tile, slice);
        for (var number = 0u; number < in_slice.x * in_slice.y; number++) {
            if word + LIGHT_BLOCK_WORDS > arrayLength(&blocks) {
                return;
            }
            let point = points.x + (number % in_slice.x) * LIGHT_BLOCK_POINTS;
            let pair = pairs.x + (number / in_slice.x) * LIGHT_BLOCK_PAIRS;
            blocks[word] = face;
            blocks[word + 1u] = point;
            blocks[word + 2u] = min(point + LIGHT_BLOCK_POINTS, points.y);
            blocks[word + 3u] = pair;
            blocks[word + 4u] = min(pair + LIGHT_BLOCK_PAIRS, pairs.y);
            blocks[word + 5u] = spread[column];
            blocks[word + 6u] = spread[row];
            blocks[word + 7u] = spread[column + 1u];
            blocks[word + 8u] = spread[row + 1u];
            word += LIGHT_BLOCK_WORDS;
        }
    }
}

// The points of a slice of a tile: the first and the end.
fn points_of(tile: u32, slice: u32) -> vec2<u32> {
    let cell = tile * light.slices + slice;
    return vec2<u32>(select(point_cells[max(cell, 1u) - 1u], 0u, cell == 0u), point_cells[cell]);
}

// The pairs of a slice and of the slices before it, which include every triangle that shadows its points.
fn pairs_of(tile: u32, slice: u32) -> vec2<u32> {
    let first = tile * light.slices;
    return vec2<u32>(select(cells[max(first, 1u) - 1u], 0u, first == 0u), cells[first + slice]);
}

// Number of blocks of points, and of pairs.
fn blocks_of(tile: u32, slice: u32) -> vec2<u32> {
    let points = points_of(tile, slice);
    let pairs = pairs_of(tile, slice);
    return vec2<u32>(
        (points.y - points.x + LIGHT_BLOCK_POINTS - 1u) / LIGHT_BLOCK_POINTS,
        (pairs.y - pairs.x + LIGHT_BLOCK_PAIRS - 1u) / LIGHT_BLOCK_PAIRS);
}

// Writes the size of the dispatch that traces blocks.
@compute @workgroup_size(1)
fn size_blocks() {
    let room = (arrayLength(&blocks) - LIGHT_BLOCKS_FIRST) / LIGHT_BLOCK_WORDS;
    let count = min(atomicLoad(&header[HEADER_BLOCKS]), room);
    blocks[0] = count;
    let groups = groups_of(count);
    atomicStore(&header[HEADER_BLOCK_GROUPS], groups.x);
    atomicStore(&header[HEADER_BLOCK_GROUPS + 1u], groups.y);
    atomicStore(&header[HEADER_BLOCK_GROUPS + 2u], groups.z);
}
