use rayon::prelude::*;

/// Triangles whose part of a fingerprint one thread finds at once.
const CHUNK: usize = 1 << 14;

/// A number that stands for an index buffer: two that differ in one index, or in their lengths, have different ones, and
/// others with a chance of one in 2⁶⁴ the same.
///
/// Comparing with the patches' own vertices takes four times as long: their triangles lie all over the buffer.
pub(super) fn fingerprint(indices: &[[u32; 3]]) -> u64 {
    let of_chunks = indices.par_chunks(CHUNK).enumerate().map(|(number, chunk)| {
        // Four at once, since each multiplication waits for the last.
        let mut four = [1, 2, 3, 4].map(|lane| mixed(number as u64, lane));
        let words = chunk.as_flattened().chunks_exact(8);
        for &index in words.remainder() {
            four[0] = mixed(four[0], index.into());
        }
        for eight in words {
            for (mixture, pair) in four.iter_mut().zip(eight.chunks_exact(2)) {
                *mixture = mixed(*mixture, u64::from(pair[0]) | u64::from(pair[1]) << 32);
            }
        }
        four.into_iter().reduce(mixed).unwrap_or_default()
    });
    // A sum: the order in which threads are done plays no part.
    of_chunks.reduce(|| 0, u64::wrapping_add).wrapping_add(indices.len() as u64)
}

/// Differs for each second number where the first is the same, and for each first where the second is.
fn mixed(first: u64, second: u64) -> u64 {
    (first ^ second).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29)
}
