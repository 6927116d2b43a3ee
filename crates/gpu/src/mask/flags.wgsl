// A triangle's fourth word: its material, and flags for tests of its points.
const TRIANGLE_MATERIAL: u32 = 0x00ffffffu;
// A camera's ray may pass through.
const TRIANGLE_MASKED: u32 = 0x80000000u;
// Light may pass through.
const TRIANGLE_SHADOW_MASKED: u32 = 0x40000000u;
// Light always passes through.
const TRIANGLE_SHADOWLESS: u32 = 0x20000000u;
// Rays of either kind pass through its back.
const TRIANGLE_ONE_SIDED: u32 = 0x10000000u;
