// Blocks of work for the camera's tiles, behind the ends of the cells' lists in the same buffer.

// Pairs that a block takes from each of its sorting tiles.
const BLOCK_PAIRS: u32 = 2048u;
// Number of blocks; the range of keys, as ordered bits (two words); an unused word; then the blocks.
const WORK_BLOCKS: u32 = 0u;
const WORK_KEYS: u32 = 1u;
const WORK_FIRST_BLOCK: u32 = 4u;
// Words of a block: tile, number among the tile's blocks, number of these, index of the first of their partial results.
const BLOCK_WORDS: u32 = 4u;

// Sorting tiles on each axis of a tracing tile, whose side is always 16 pixels.
override MAPPING: u32 = 1u;

const TRACING_TILE: u32 = 16u;
