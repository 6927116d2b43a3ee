// What the stages of a light's grid share about points.

// No point: the pixel shows nothing.
const POINT_NONE: u32 = 0xffffffffu;
// The survey of all points: complements of their lowest coordinates (3), their highest (3), in order.
const SURVEY_LOW: u32 = 0u;

// Of the buffer of open questions: how many there are, the groups that settle them, then a place and a triangle each.
const OPEN_COUNT: u32 = 0u;
const OPEN_GROUPS: u32 = 2u;
const OPEN_FIRST: u32 = 8u;
// Instead of a triangle: all of a page of triangles.
const OPEN_PAGE: u32 = 0x80000000u;
const OPEN_PAGE_TRIANGLES: u32 = 256u;
