// Blocks of work for the camera's tiles, behind the ends of the cells' lists in the same buffer.

// Pairs that a block takes from each of its sorting tiles.
const BLOCK_PAIRS: u32 = 2048u;
// How many blocks there are; the keys' range, in order; a word that nothing uses; then the blocks.
const WORK_BLOCKS: u32 = 0u;
const WORK_KEYS: u32 = 1u;
const WORK_FIRST_BLOCK: u32 = 4u;
// Tile, number among the tile's blocks, how many these are, where the first of their partial results is.
const BLOCK_WORDS: u32 = 4u;

// Sorting tiles on each axis of a tracing tile, whose side is always 16 pixels.
override MAPPING: u32 = 1u;

const TRACING_TILE: u32 = 16u;
