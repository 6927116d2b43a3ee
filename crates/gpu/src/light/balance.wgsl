// Stage `balance`: blocks of work for the light's cells. A cell with R points and T triangles makes ⌈R/r⌉ · ⌈T/t⌉ of
// them: cells don't share blocks (the paper's hard boundaries), blocks of one cell are interchangeable (its soft ones),
// and crowds of triangles are split as well.

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
    let cell = flat_index(at, 64u);
    let faces = atomicLoad(&header[HEADER_FACES]);
    let side = select(light.side_of_six, light.side_of_one, faces == 1u);
    if cell >= faces * side * side {
        return;
    }
    let before = max(cell, 1u) - 1u;
    let pairs = vec2<u32>(select(cells[before], 0u, cell == 0u), cells[cell]);
    let points = vec2<u32>(select(point_cells[before], 0u, cell == 0u), point_cells[cell]);
    let columns = (points.y - points.x + LIGHT_BLOCK_POINTS - 1u) / LIGHT_BLOCK_POINTS;
    let rows = (pairs.y - pairs.x + LIGHT_BLOCK_PAIRS - 1u) / LIGHT_BLOCK_PAIRS;
    if columns * rows == 0u {
        return;
    }
    let face = cell / (side * side);
    let column = spread_base(face, 0u) + SPREAD_STARTS + cell % side;
    let row = spread_base(face, 1u) + SPREAD_STARTS + cell / side % side;
    let first = atomicAdd(&header[HEADER_BLOCKS], columns * rows);
    for (var number = 0u; number < columns * rows; number++) {
        let word = LIGHT_BLOCKS_FIRST + (first + number) * LIGHT_BLOCK_WORDS;
        if word + LIGHT_BLOCK_WORDS > arrayLength(&blocks) {
            return;
        }
        let point = points.x + (number % columns) * LIGHT_BLOCK_POINTS;
        let pair = pairs.x + (number / columns) * LIGHT_BLOCK_PAIRS;
        blocks[word] = face;
        blocks[word + 1u] = point;
        blocks[word + 2u] = min(point + LIGHT_BLOCK_POINTS, points.y);
        blocks[word + 3u] = pair;
        blocks[word + 4u] = min(pair + LIGHT_BLOCK_PAIRS, pairs.y);
        blocks[word + 5u] = spread[column];
        blocks[word + 6u] = spread[row];
        blocks[word + 7u] = spread[column + 1u];
        blocks[word + 8u] = spread[row + 1u];
    }
}

// The size of the dispatch that traces blocks.
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
