// What rays that go on have met, in a buffer `meetings` that a stage writes and shading reads as `shade_seen`.

// The triangle or `NO_TRIANGLE`; then, in f32, the weights of its second and third corner, how far the ray went, the unit
// direction back, how far it is from the ray's start to the camera, and how much of what is seen reaches it.
const MEETING_WEIGHTS: u32 = 1u;
const MEETING_DEPTH: u32 = 3u;
const MEETING_VIEW: u32 = 4u;
const MEETING_TRAVELLED: u32 = 7u;
const MEETING_THROUGH: u32 = 8u;
// How far it went since it started or went through something, in f32, and the media there.
const MEETING_INSIDE: u32 = 11u;
const MEETING_MEDIA: u32 = 12u;
const MEETING_MEDIA_COUNT: u32 = 16u;
// By how many mirrors and surfaces of glass it comes.
const MEETING_BOUNCES: u32 = 17u;
// The pixel that shows it, and the largest GGX width of rough surfaces by which it comes, in f32.
const MEETING_PIXEL: u32 = 18u;
const MEETING_BLUR: u32 = 19u;
const MEETING_WORDS: u32 = 20u;
