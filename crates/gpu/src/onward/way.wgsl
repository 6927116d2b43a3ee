// Where a generation's rays go on from what they have met, as planes keep it: shading writes what `send` reads.
//
// The first plane has where a mirror leads, and how far it is from there to the camera; the second how much of what is there
// reaches it, and WAY_… added up. Where something is seen through there are four more: how much of what is straight behind
// reaches the camera, and the number of the surface's material; then where light is refracted to, of red, green and blue, each
// with how much of it reaches the camera. Where all colours go one way, the second of these three has how much of each does.
// Where rough surfaces are followed, there is one more, with the largest GGX width by which light comes along these ways.

const WAY_MIRROR: u32 = 1u;
const WAY_BEHIND: u32 = 2u;
// What is straight behind is in other media.
const WAY_CROSSES: u32 = 4u;
// The front of a triangle is seen.
const WAY_FRONT: u32 = 8u;
const WAY_ALL_COLORS: u32 = 16u;
const WAY_RED: u32 = 32u;
const WAY_GREEN: u32 = 64u;
const WAY_BLUE: u32 = 128u;

// The planes of mirrors alone, and all of them.
const WAYS_OF_MIRRORS: u32 = 2u;
const ALL_WAYS: u32 = 6u;
const GLOSSY_WAYS: u32 = 7u;

fn way_count(bits: u32) -> u32 {
    return countOneBits(bits & (WAY_MIRROR | WAY_BEHIND | WAY_ALL_COLORS | WAY_RED | WAY_GREEN | WAY_BLUE));
}
