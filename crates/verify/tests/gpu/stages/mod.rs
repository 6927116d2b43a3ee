//! Devices, single stages and the arithmetic of their shaders.

mod device;
mod exact;
mod omit;
mod operations;
mod primitives;
mod shade;
mod tile_order;

/// Pseudorandom numbers: small ones for an even seed, any for an odd one.
pub(crate) fn numbers(count: usize, seed: u32) -> Vec<u32> {
    let mut state = 0x9e37_79b9_u32.wrapping_mul(seed + 1) | 1;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        if seed.is_multiple_of(2) { state % 17 } else { state }
    };
    (0..count).map(|_| next()).collect()
}
