// Blocks of work for a light's cells: their number, then for each one a cell, its first point and the end of its points,
// its first pair and the end of its pairs.

const LIGHT_BLOCKS_FIRST: u32 = 8u;
const LIGHT_BLOCK_WORDS: u32 = 8u;
// The most points, and the most pairs, of a block.
const LIGHT_BLOCK_POINTS: u32 = 64u;
const LIGHT_BLOCK_PAIRS: u32 = 1024u;
