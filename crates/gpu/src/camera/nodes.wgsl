// Undecided hits: nodes of one list for each pixel, from the front of a buffer, and the pixels that have a list, from
// its end.

// No triangle is seen, or no node follows.
const NONE: u32 = 0xffffffffu;
// Number of nodes, number of pixels with nodes, and the workgroups that settle nodes and pixels.
const NODES_COUNT: u32 = 0u;
const NODES_PIXELS: u32 = 1u;
const NODES_GROUPS: u32 = 2u;
// Whether any pixel sees a triangle; only written when pixels look behind.
const NODES_ANY: u32 = 5u;
const NODES_PIXEL_GROUPS: u32 = 6u;
const NODES_FIRST: u32 = 12u;
// Words of a node: triangle and flags; the next node; a bound on the key of the triangle at the pixel; the pixel's
// slot, which `settle` replaces by t: two words, infinite where the pixel doesn't see the triangle.
const NODE_WORDS: u32 = 5u;
const NODE_NEXT: u32 = 1u;
const NODE_KEY: u32 = 2u;
const NODE_SLOT: u32 = 3u;
const NODE_T: u32 = 3u;
// Flag of the triangle that the pixel has seen already: hits count from there on.
const NODE_FRONT: u32 = 0x80000000u;
// Flag of the triangle that the pixel certainly sees unless another node hides it: its key is at least the node's. Keys
// of other triangles are at most their node's.
const NODE_CERTAIN: u32 = 0x40000000u;
const NODE_TRIANGLE: u32 = 0x3fffffffu;

// Number of pixels for which there is room behind the nodes.
fn node_pixel_room(count: u32, words: u32) -> u32 {
    let used = NODES_FIRST + min(count, words / NODE_WORDS) * NODE_WORDS;
    return words - min(used, words);
}
