use std::sync::atomic::{AtomicU64, Ordering};

use crate::parallel::{Parallel, both};
use rayon::prelude::*;

/// Keys are counted by this many of the highest bits of their codes; a comparison sort of each bucket completes the order.
const BUCKET_BITS: u32 = 15;
const BUCKETS: usize = 1 << BUCKET_BITS;

/// The fewest things that one thread counts at once: its counts take 128 KB.
const LEAST_CHUNK: usize = 1 << 15;

/// As many things as are sorted by comparison alone.
const FEW: usize = 1 << 12;

/// Sorts things along a curve through space, with reused memory. 16 bytes each.
#[derive(Debug, Default)]
pub(crate) struct CurveOrder {
    /// A thing's code in the upper half, its number in the lower.
    keys: Vec<u64>,
    /// The keys in their buckets. Threads write to scattered slots.
    in_buckets: Vec<AtomicU64>,
    /// For each chunk of things and each bucket: first the number of keys, then the slot of the next one.
    counts: Vec<u32>,
}

impl CurveOrder {
    /// The bits of a code.
    pub(crate) const BITS: u32 = 30;

    /// The code of things that come last.
    pub(crate) const NOWHERE: u32 = u32::MAX;

    /// The numbers below `count`, in the lower halves, in the order of their codes; those with the same code are sorted by
    /// number, so that threads play no part.
    pub(crate) fn sort(&mut self, count: usize, code: impl Fn(u32) -> u32 + Sync) -> &[u64] {
        let Self { keys, in_buckets, counts } = self;
        let key = |number: u32| u64::from(code(number)) << 32 | u64::from(number);
        keys.resize(count, 0);
        if count <= FEW {
            (0..).zip(&mut *keys).for_each(|(number, to)| *to = key(number));
            keys.sort_unstable();
            return keys;
        }
        let chunk = count.div_ceil(rayon::current_num_threads()).max(LEAST_CHUNK);
        let chunks = count.div_ceil(chunk);
        in_buckets.resize_with(count, AtomicU64::default);
        counts.clear();
        counts.resize(chunks * BUCKETS, 0);
        keys.par_chunks_mut(chunk).zip(counts.par_chunks_mut(BUCKETS)).enumerate().each(|(part, (keys, counts))| {
            for (number, to) in ((part * chunk) as u32..).zip(keys) {
                *to = key(number);
                counts[bucket(*to)] += 1;
            }
        });
        let mut sum = 0;
        for bucket in 0..BUCKETS {
            for chunk in 0..chunks {
                sum += std::mem::replace(&mut counts[chunk * BUCKETS + bucket], sum);
            }
        }
        keys.par_chunks(chunk).zip(counts.par_chunks_mut(BUCKETS)).each(|(keys, counts)| {
            for &key in keys {
                let next = &mut counts[bucket(key)];
                in_buckets[*next as usize].store(key, Ordering::Relaxed);
                *next += 1;
            }
        });
        // The last chunk's next slot is the end of each bucket.
        sort_buckets(keys, in_buckets, &counts[(chunks - 1) * BUCKETS..], 0);
        keys
    }

    pub(crate) fn bytes(&self) -> usize {
        (self.keys.capacity() + self.in_buckets.capacity()) * size_of::<u64>()
            + self.counts.capacity() * size_of::<u32>()
    }
}

fn bucket(key: u64) -> usize {
    ((key >> (32 + CurveOrder::BITS - BUCKET_BITS)) as usize).min(BUCKETS - 1)
}

/// Sorts the keys of some buckets, which end at `ends`; the first one begins at `first`.
fn sort_buckets(sorted: &mut [u64], in_buckets: &[AtomicU64], ends: &[u32], first: u32) {
    let half = ends.len() / 2;
    if sorted.len() > 1 << 13 && half > 0 {
        let middle = ends[half - 1];
        let (low, high) = sorted.split_at_mut((middle - first) as usize);
        let (low_ends, high_ends) = ends.split_at(half);
        both(|| sort_buckets(low, in_buckets, low_ends, first), || sort_buckets(high, in_buckets, high_ends, middle));
        return;
    }
    let mut start = 0;
    for (key, of) in sorted.iter_mut().zip(&in_buckets[first as usize..]) {
        *key = of.load(Ordering::Relaxed);
    }
    for end in ends.iter().map(|&end| (end - first) as usize) {
        sorted[start..end].sort_unstable();
        start = end;
    }
}
