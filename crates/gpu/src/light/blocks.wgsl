// Blocks of work for a light's cells: their number, then for each block its face, its first point and the end of its
// points, its first pair and the end of its pairs, and the cell's first bins and their ends.

const LIGHT_BLOCKS_FIRST: u32 = 8u;
const LIGHT_BLOCK_WORDS: u32 = 12u;
// Maximum number of points, and of pairs, in a block.
const LIGHT_BLOCK_POINTS: u32 = 64u;
const LIGHT_BLOCK_PAIRS: u32 = 1024u;
