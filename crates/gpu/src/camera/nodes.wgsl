// What is left open about pixels: nodes of lists from the front of a buffer, and the pixels that have some from its end.

// Nothing is seen, or no node follows.
const NONE: u32 = 0xffffffffu;
// How many nodes, how many pixels with some, and the groups that settle these.
const NODES_COUNT: u32 = 0u;
const NODES_PIXELS: u32 = 1u;
const NODES_GROUPS: u32 = 2u;
// Whether any pixel sees anything; known only of what is behind.
const NODES_ANY: u32 = 5u;
const NODES_FIRST: u32 = 8u;
// Triangle, the next node, and the largest key that it may have there.
const NODE_WORDS: u32 = 3u;
// Set of the triangle that the pixel has seen already: hits count from there on.
const NODE_FRONT: u32 = 0x80000000u;

// For how many pixels there is room behind the nodes.
fn node_pixel_room(count: u32, words: u32) -> u32 {
    let used = NODES_FIRST + min(count, words / NODE_WORDS) * NODE_WORDS;
    return words - min(used, words);
}
