// What rays from mirrors have met: as shading reads it from `shade_seen`.

// The triangle or `NO_TRIANGLE`; then, in f32, the weights of its second and third corner, how far the ray went, the unit
// direction back, how far it is from the ray's start to the camera, and how much of what is seen reaches it.
const MEETING_WEIGHTS: u32 = 1u;
const MEETING_DEPTH: u32 = 3u;
const MEETING_VIEW: u32 = 4u;
const MEETING_TRAVELLED: u32 = 7u;
const MEETING_THROUGH: u32 = 8u;
const MEETING_WORDS: u32 = 11u;
