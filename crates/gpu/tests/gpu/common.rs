//! What the tests of stages share.

use umbrage_gpu::{DeviceLimits, Gpu};

/// The machine's adapter, or none: then says so on the standard error, and CI counts it.
pub(crate) fn gpu() -> Option<Gpu> {
    match Gpu::open("", DeviceLimits::Portable) {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            eprintln!("skipped-gpu: {error}");
            None
        }
    }
}

/// Sizes from nothing to 2²⁰ + 1, with those around powers of two.
pub(crate) fn sizes() -> Vec<usize> {
    let around = (0..=20).map(|power| 1_usize << power).flat_map(|size| [size - 1, size, size + 1]);
    let mut sizes: Vec<_> = around.collect();
    sizes.dedup();
    sizes
}

/// Numbers without order: small ones for an even seed, any at all for an odd one.
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
