//! Counting sorts: the number of keys is known, and equal keys keep their order.

use std::ops::Range;

/// Items sorted by a key.
#[derive(Clone, Debug)]
pub(super) struct Sorted<T> {
    /// The start of each key's items, and finally the end of the last key's.
    starts: Vec<u32>,
    items: Vec<T>,
}

impl<T> Default for Sorted<T> {
    fn default() -> Self {
        Self { starts: Vec::new(), items: Vec::new() }
    }
}

impl<T: Copy + Default> Sorted<T> {
    /// Replaces the items by others with their keys, which are below `keys`.
    pub(super) fn sort(&mut self, keys: usize, of: impl Iterator<Item = (usize, T)> + Clone) {
        let Self { starts, items } = self;
        starts.clear();
        starts.resize(keys + 2, 0);
        // Counted two slots on, so that taking the next index moves each start to its final position.
        of.clone().for_each(|(key, _)| starts[key + 2] += 1);
        let mut sum = 0;
        for start in &mut *starts {
            sum += *start;
            *start = sum;
        }
        items.resize(sum as usize, T::default());
        for (key, item) in of {
            let next = &mut starts[key + 1];
            items[*next as usize] = item;
            *next += 1;
        }
    }

    /// The index range of the items of consecutive keys.
    #[inline(always)]
    pub(super) fn range(&self, keys: Range<usize>) -> Range<usize> {
        self.starts[keys.start] as usize..self.starts[keys.end] as usize
    }

    /// The items of consecutive keys.
    #[inline(always)]
    pub(super) fn of(&self, keys: Range<usize>) -> &[T] {
        &self.items[self.range(keys)]
    }

    /// All items.
    pub(super) fn items(&self) -> &[T] {
        &self.items
    }

    pub(super) fn bytes(&self) -> usize {
        self.starts.capacity() * size_of::<u32>() + self.items.capacity() * size_of::<T>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counting_sorts_keep_the_order_of_equal_keys() {
        let keys = [3_usize, 0, 3, 1, 5, 0, 3];
        let mut sorted = Sorted::default();
        sorted.sort(7, keys.into_iter().zip(0..7));
        assert_eq!(sorted.items(), [1, 5, 3, 0, 2, 6, 4]);
        assert_eq!([0, 1, 2, 3, 4, 5, 6].map(|key| sorted.of(key..key + 1).len()), [2, 1, 0, 3, 0, 1, 0]);
    }
}
