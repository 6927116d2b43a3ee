use rayon::prelude::*;

use crate::HashKey;

/// Triangles whose part of a fingerprint one thread computes at once.
const CHUNK: usize = 1 << 14;

/// A hash of an index buffer: two different buffers have the same one with a chance of about one in 2⁶³, even if chosen by
/// an adversary, since the process's key is mixed in.
///
/// Comparing with the patches' own vertices takes four times as long: their triangles lie all over the buffer.
pub(super) fn fingerprint(indices: &[[u32; 3]]) -> u64 {
    let key = HashKey::default();
    let of_chunks = indices.par_chunks(CHUNK).enumerate().map(|(number, chunk)| {
        // Four at once, since each multiplication waits for the previous one.
        let mut four = [1, 2, 3, 4].map(|lane| key.mix(key.mix(key.start(), number as u64), lane));
        let words = chunk.as_flattened().chunks_exact(8);
        for &index in words.remainder() {
            four[0] = key.mix(four[0], index.into());
        }
        for eight in words {
            for (mixture, pair) in four.iter_mut().zip(eight.chunks_exact(2)) {
                *mixture = key.mix(*mixture, u64::from(pair[0]) | u64::from(pair[1]) << 32);
            }
        }
        four.into_iter().reduce(|one, other| key.mix(one, other)).unwrap_or_default()
    });
    // A sum, so that the order of threads plays no part.
    of_chunks.reduce(|| 0, u64::wrapping_add).wrapping_add(indices.len() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buffers_that_differ_have_fingerprints_that_differ() {
        let buffer: Vec<[u32; 3]> = (0..3 * CHUNK as u32).map(|id| [id, id + 1, id + 2]).collect();
        let expected = fingerprint(&buffer);
        assert_eq!(fingerprint(&buffer.clone()), expected);
        for place in [0, 5, 8, CHUNK, 3 * CHUNK - 1] {
            for bit in 0..32 {
                let mut other = buffer.clone();
                other[place][1] ^= 1 << bit;
                assert_ne!(fingerprint(&other), expected, "{place}, {bit}");
            }
        }
        let mut other = buffer.clone();
        other.swap(3, CHUNK + 3);
        assert_ne!(fingerprint(&other), expected);
        assert_ne!(fingerprint(&buffer[1..]), expected);
    }

    #[test]
    fn nobody_makes_two_with_one_fingerprint() {
        // For a product by any odd factor, the second change would undo the effect of the first without the product's upper
        // half.
        let buffer = vec![[1, 2, 3]; 32];
        let mut other = buffer.clone();
        other.as_flattened_mut()[1] ^= 1 << 31;
        other.as_flattened_mut()[8] ^= 1 << 28;
        assert_ne!(fingerprint(&other), fingerprint(&buffer));
    }
}
