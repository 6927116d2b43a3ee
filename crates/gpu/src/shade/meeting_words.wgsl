// Hits of secondary rays, in a buffer `meetings` that a stage writes and shading reads as `shade_seen`.

// The triangle or `NO_TRIANGLE`. Then, in f32: the weights of its second and third corner, the ray's length, the unit
// direction back, the distance from the ray's start to the camera, and the throughput to the camera.
const MEETING_WEIGHTS: u32 = 1u;
const MEETING_DEPTH: u32 = 3u;
const MEETING_VIEW: u32 = 4u;
const MEETING_TRAVELLED: u32 = 7u;
const MEETING_THROUGH: u32 = 8u;
// Length since the ray started or passed through a surface, in f32, and the media there.
const MEETING_INSIDE: u32 = 11u;
const MEETING_MEDIA: u32 = 12u;
const MEETING_MEDIA_COUNT: u32 = 16u;
// Number of mirrors and glass surfaces on the path.
const MEETING_BOUNCES: u32 = 17u;
// The pixel of the path, and the largest GGX width of rough surfaces on it, in f32.
const MEETING_PIXEL: u32 = 18u;
const MEETING_BLUR: u32 = 19u;
const MEETING_WORDS: u32 = 20u;
