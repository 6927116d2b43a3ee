// Constants of points, shared by the stages of a light's grid.

// No point: the pixel shows no triangle.
const POINT_NONE: u32 = 0xffffffffu;
// 2⁻⁴²: error of points, relative to the distance from the ray's origin.
const POINT_ERROR: f32 = 2.2737368e-13;
// Bounds of all points: complements of their lowest coordinates (3), their highest (3), as ordered bits.
const BOUNDS_LOW: u32 = 0u;

// Buffer of undecided pairs: their number, the workgroups that settle them, then a slot and a triangle for each.
const UNDECIDED_COUNT: u32 = 0u;
const UNDECIDED_GROUPS: u32 = 2u;
const UNDECIDED_FIRST: u32 = 8u;
// Flag in place of a triangle: all triangles of a page.
const UNDECIDED_PAGE: u32 = 0x80000000u;
const UNDECIDED_PAGE_TRIANGLES: u32 = 256u;
