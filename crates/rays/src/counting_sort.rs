//! Counting sorts: the number of keys is known, and equal keys keep their order.

/// The first half: counts how often each of `keys` keys comes, and returns how often all do.
///
/// Once [`next_index`] was called for each of them, `starts` holds the index where each key starts and, one further, where
/// it ends.
pub(crate) fn count(starts: &mut Vec<u32>, keys: usize, of: impl Iterator<Item = usize>) -> usize {
    starts.clear();
    starts.resize(keys + 2, 0);
    // Counted two slots on, so that handing out indices moves each start to where it belongs.
    of.for_each(|key| starts[key + 2] += 1);
    let mut sum = 0;
    for start in starts {
        sum += *start;
        *start = sum;
    }
    sum as usize
}

/// The index at which the next item with this key belongs.
#[inline(always)]
pub(crate) fn next_index(starts: &mut [u32], key: usize) -> usize {
    let next = &mut starts[key + 1];
    *next += 1;
    *next as usize - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counting_sorts_keep_the_order_of_equal_keys() {
        let keys = [3_usize, 0, 3, 1, 5, 0, 3];
        let mut starts = vec![9; 2];
        let mut sorted = vec![usize::MAX; count(&mut starts, 7, keys.into_iter())];
        keys.iter().enumerate().for_each(|(item, &key)| sorted[next_index(&mut starts, key)] = item);
        assert_eq!(sorted, [1, 5, 3, 0, 2, 6, 4]);
        assert_eq!(starts[..8], [0, 2, 3, 3, 6, 6, 7, 7]);
    }
}
