// Stage `balance`: cuts the tiles' lists into blocks of bounded work. A tile that is cut gets room for the partial
// results of its blocks, which `merge` joins.

import package::camera::work::{BLOCK_PAIRS, BLOCK_WORDS, MAPPING, WORK_BLOCKS, WORK_FIRST_BLOCK, WORK_KEYS};
import package::dispatch::{Invocation, flat_index, groups_of};
import package::grid::header::{
    HEADER_BLOCKS, HEADER_BLOCK_GROUPS, HEADER_KEYS, HEADER_PARTIALS, HEADER_SPLIT, HEADER_SPLIT_GROUPS,
};
import package::grid::space::{Space};

@group(0) @binding(0) var<uniform> space: Space;
@group(0) @binding(1) var<storage, read_write> cells: array<u32>;
@group(0) @binding(2) var<storage, read_write> header: array<atomic<u32>>;

fn cell_count() -> u32 {
    return space.raster.tile_columns * space.raster.tile_rows * space.raster.slices;
}

// Number of pairs of a sorting tile, in all its slices.
fn pairs_of(tile: vec2<u32>) -> u32 {
    if tile.x >= space.raster.tile_columns || tile.y >= space.raster.tile_rows {
        return 0u;
    }
    let first = (tile.y * space.raster.tile_columns + tile.x) * space.raster.slices;
    let end = cells[first + space.raster.slices - 1u];
    return end - select(0u, cells[max(first, 1u) - 1u], first > 0u);
}

@compute @workgroup_size(64)
fn balance(at: Invocation) {
    let tile = flat_index(at, 64u);
    let columns = (space.raster.tile_columns + MAPPING - 1u) / MAPPING;
    let rows = (space.raster.tile_rows + MAPPING - 1u) / MAPPING;
    if tile >= columns * rows {
        return;
    }
    var most = 0u;
    for (var sub = 0u; sub < MAPPING * MAPPING; sub++) {
        most = max(most, pairs_of(vec2<u32>(tile % columns, tile / columns) * MAPPING
            + vec2<u32>(sub % MAPPING, sub / MAPPING)));
    }
    let blocks = max((most + BLOCK_PAIRS - 1u) / BLOCK_PAIRS, 1u);
    let first = atomicAdd(&header[HEADER_BLOCKS], blocks);
    var partial = 0u;
    if blocks > 1u {
        atomicAdd(&header[HEADER_SPLIT], 1u);
        partial = atomicAdd(&header[HEADER_PARTIALS], blocks);
    }
    for (var number = 0u; number < blocks; number++) {
        let word = cell_count() + WORK_FIRST_BLOCK + (first + number) * BLOCK_WORDS;
        if word + BLOCK_WORDS > arrayLength(&cells) {
            return;
        }
        cells[word] = tile;
        cells[word + 1u] = number;
        cells[word + 2u] = blocks;
        cells[word + 3u] = partial;
    }
}

// Writes the dispatch sizes of `trace` and `merge`, and the numbers that `trace` needs.
@compute @workgroup_size(1)
fn size_blocks() {
    let base = cell_count();
    let room = (arrayLength(&cells) - base - WORK_FIRST_BLOCK) / BLOCK_WORDS;
    let blocks = min(atomicLoad(&header[HEADER_BLOCKS]), room);
    cells[base + WORK_BLOCKS] = blocks;
    cells[base + WORK_KEYS] = atomicLoad(&header[HEADER_KEYS]);
    cells[base + WORK_KEYS + 1u] = ~atomicLoad(&header[HEADER_KEYS + 1u]);
    let groups = groups_of(blocks);
    atomicStore(&header[HEADER_BLOCK_GROUPS], groups.x);
    atomicStore(&header[HEADER_BLOCK_GROUPS + 1u], groups.y);
    atomicStore(&header[HEADER_BLOCK_GROUPS + 2u], groups.z);
    // Blocks know whether they are the first of a cut tile.
    let merges = groups_of(select(0u, blocks, atomicLoad(&header[HEADER_SPLIT]) > 0u));
    atomicStore(&header[HEADER_SPLIT_GROUPS], merges.x);
    atomicStore(&header[HEADER_SPLIT_GROUPS + 1u], merges.y);
    atomicStore(&header[HEADER_SPLIT_GROUPS + 2u], merges.z);
}
