//! Counting sorts: the number of keys is known, and equal keys keep their order.

/// The first half: counts how often each of `keys` keys comes, and returns how often all do.
///
/// Once [`next_place`] was asked for each, `starts` holds where each key starts and, one further, where it ends.
pub(crate) fn count(starts: &mut Vec<u32>, keys: usize, of: impl Iterator<Item = usize>) -> usize {
    starts.clear();
    starts.resize(keys + 2, 0);
    // Counted two places on, so that handing out places moves each start to where it belongs.
    of.for_each(|key| starts[key + 2] += 1);
    let mut sum = 0;
    for start in starts {
        sum += *start;
        *start = sum;
    }
    sum as usize
}

/// Where the next one with this key belongs.
#[inline(always)]
pub(crate) fn next_place(starts: &mut [u32], key: usize) -> usize {
    let place = &mut starts[key + 1];
    *place += 1;
    *place as usize - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counting_sorts_keep_the_order_of_equal_keys() {
        let keys = [3_usize, 0, 3, 1, 5, 0, 3];
        let mut starts = vec![9; 2];
        let mut sorted = vec![usize::MAX; count(&mut starts, 7, keys.into_iter())];
        keys.iter().enumerate().for_each(|(item, &key)| sorted[next_place(&mut starts, key)] = item);
        assert_eq!(sorted, [1, 5, 3, 0, 2, 6, 4]);
        assert_eq!(starts[..8], [0, 2, 3, 3, 6, 6, 7, 7]);
    }
}
