// What the stages of a light's grid share about points.

// No point: the pixel shows nothing.
const POINT_NONE: u32 = 0xffffffffu;
// 2⁻⁴²: how much points may be wrong by, as part of the distance that they were found from.
const POINT_ERROR: f32 = 2.2737368e-13;
// The bounds of all points: complements of their lowest coordinates (3), their highest (3), in order.
const BOUNDS_LOW: u32 = 0u;

// Of the buffer of undecided pairs: how many there are, the groups that settle them, then a slot and a triangle each.
const UNDECIDED_COUNT: u32 = 0u;
const UNDECIDED_GROUPS: u32 = 2u;
const UNDECIDED_FIRST: u32 = 8u;
// Instead of a triangle: all of a page of triangles.
const UNDECIDED_PAGE: u32 = 0x80000000u;
const UNDECIDED_PAGE_TRIANGLES: u32 = 256u;
