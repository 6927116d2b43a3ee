// Counters of one structure and the sizes of indirect dispatches, in one buffer that starts as zeros.

// Chunks of triangles over many cells, and the workgroups for them.
const HEADER_LARGE: u32 = 0u;
const HEADER_LARGE_GROUPS: u32 = 1u;
// Blocks of work, and the workgroups for them.
const HEADER_BLOCKS: u32 = 5u;
const HEADER_BLOCK_GROUPS: u32 = 6u;
// Tiles with several blocks, and the workgroups that merge them.
const HEADER_SPLIT: u32 = 9u;
const HEADER_SPLIT_GROUPS: u32 = 10u;
// Blocks of split tiles.
const HEADER_PARTIALS: u32 = 13u;
// For each face the largest key of visible vertices and the complement of the smallest, both as ordered bits.
const HEADER_KEYS: u32 = 16u;
// Used instead by a light that sees by angles. For each of the two angles: the complement of the points' lowest value
// and their highest, both as ordered bits, and the error of any, in units. Then the lowest and highest values that get
// cells of their own.
const HEADER_ANGLES: u32 = 16u;
const HEADER_ANGLES_DIVIDED: u32 = 22u;
// For lights whose cells have slices: the largest key of points and the complement of the smallest, as ordered bits.
const HEADER_POINT_KEYS: u32 = 34u;
// For lights: number of faces, and workgroups for their vertices and triangles.
const HEADER_FACES: u32 = 14u;
const HEADER_VERTEX_GROUPS: u32 = 28u;
const HEADER_TRIANGLE_GROUPS: u32 = 31u;
