// What lies beyond the edges of a texture, on each axis.

const WRAP_REPEAT: u32 = 0u;
const WRAP_MIRRORED_REPEAT: u32 = 1u;
const WRAP_CLAMP_TO_EDGE: u32 = 2u;
