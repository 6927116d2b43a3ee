// Planes of ways: the secondary rays of a generation's hits, written by shading and read by `send`.
//
// The first plane has the mirrored ray's direction, and the length of the path from the hit to the camera; the second its
// throughput, and the sum of WAY_… bits. With transmissive surfaces there are four more: the throughput of the ray straight
// on, and the surface's material; then the directions of refracted red, green and blue light, each with its throughput. If
// all colours take one direction, the second of these three has their throughputs. With rough surfaces followed, there is
// one more, with the largest GGX width along the ways.

const WAY_MIRROR: u32 = 1u;
const WAY_BEHIND: u32 = 2u;
// The ray straight on enters or leaves a medium.
const WAY_CROSSES: u32 = 4u;
// The triangle is hit from its front.
const WAY_FRONT: u32 = 8u;
const WAY_ALL_COLORS: u32 = 16u;
const WAY_RED: u32 = 32u;
const WAY_GREEN: u32 = 64u;
const WAY_BLUE: u32 = 128u;

// Numbers of planes: for mirrors alone, with transmissive surfaces, with rough surfaces too.
const WAYS_OF_MIRRORS: u32 = 2u;
const ALL_WAYS: u32 = 6u;
const GLOSSY_WAYS: u32 = 7u;

fn way_count(bits: u32) -> u32 {
    return countOneBits(bits & (WAY_MIRROR | WAY_BEHIND | WAY_ALL_COLORS | WAY_RED | WAY_GREEN | WAY_BLUE));
}
