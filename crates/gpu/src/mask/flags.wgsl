// Of a triangle's fourth word: its material, and what has to be asked about its points.
const TRIANGLE_MATERIAL: u32 = 0x00ffffffu;
// A camera's ray may go through.
const TRIANGLE_MASKED: u32 = 0x80000000u;
// Light may go through.
const TRIANGLE_SHADOW_MASKED: u32 = 0x40000000u;
// Light always goes through.
const TRIANGLE_SHADOWLESS: u32 = 0x20000000u;
// Rays of either kind go through its back.
const TRIANGLE_ONE_SIDED: u32 = 0x10000000u;
