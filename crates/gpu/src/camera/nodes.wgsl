// What is left undecided about pixels: nodes of lists from the front of a buffer, and the pixels that have some from its end.

// Nothing is seen, or no node follows.
const NONE: u32 = 0xffffffffu;
// How many nodes, how many pixels with some, and the groups that settle nodes and pixels.
const NODES_COUNT: u32 = 0u;
const NODES_PIXELS: u32 = 1u;
const NODES_GROUPS: u32 = 2u;
// Whether any pixel sees anything; known only of what is behind.
const NODES_ANY: u32 = 5u;
const NODES_PIXEL_GROUPS: u32 = 6u;
const NODES_FIRST: u32 = 12u;
// Triangle and flags; the next node; a bound on its key there; then its slot, which `settle` replaces by t: two words,
// infinite where the pixel doesn't see it.
const NODE_WORDS: u32 = 5u;
const NODE_NEXT: u32 = 1u;
const NODE_KEY: u32 = 2u;
const NODE_SLOT: u32 = 3u;
const NODE_T: u32 = 3u;
// Set of the triangle that the pixel has seen already: hits count from there on.
const NODE_FRONT: u32 = 0x80000000u;
// Set of the triangle that the pixel sees for certain if none of the others: its key is at least the node's. Keys of
// others are at most that.
const NODE_CERTAIN: u32 = 0x40000000u;
const NODE_TRIANGLE: u32 = 0x3fffffffu;

// For how many pixels there is room behind the nodes.
fn node_pixel_room(count: u32, words: u32) -> u32 {
    let used = NODES_FIRST + min(count, words / NODE_WORDS) * NODE_WORDS;
    return words - min(used, words);
}
