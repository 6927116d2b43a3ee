// Counters of one structure and the sizes of indirect dispatches, in one buffer that is zero at first.

// Chunks of triangles over many cells, and the groups that take them.
const HEADER_LARGE: u32 = 0u;
const HEADER_LARGE_GROUPS: u32 = 1u;
// Blocks of work, and the groups that take them.
const HEADER_BLOCKS: u32 = 5u;
const HEADER_BLOCK_GROUPS: u32 = 6u;
// Tiles with several blocks, and the groups that merge them.
const HEADER_SPLIT: u32 = 9u;
const HEADER_SPLIT_GROUPS: u32 = 10u;
// Blocks of split tiles.
const HEADER_PARTIALS: u32 = 13u;
// For each face the largest and the complement of the smallest key of visible vertices, both in order.
const HEADER_KEYS: u32 = 16u;
// Instead of them, of a light that sees by angles: for both angles the complement of the lowest and the highest of points,
// both in order, and by how many units any may be wrong; then the lowest and the highest that get cells of their own.
const HEADER_ANGLES: u32 = 16u;
const HEADER_ANGLES_DIVIDED: u32 = 22u;
// Of lights: the largest and the complement of the smallest key of points, both in order, where cells have slices.
const HEADER_POINT_KEYS: u32 = 34u;
// Of lights: how many faces, and the groups that take their vertices and triangles.
const HEADER_FACES: u32 = 14u;
const HEADER_VERTEX_GROUPS: u32 = 28u;
const HEADER_TRIANGLE_GROUPS: u32 = 31u;
