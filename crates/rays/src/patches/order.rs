use std::sync::atomic::{AtomicU64, Ordering};

use crate::parallel::{Parallel, both};
use glam::Vec3;
use rayon::prelude::*;

use crate::Triangles;

/// Keys are counted by this many of the highest bits of their codes; a comparison sort of each bucket completes the order.
const BUCKET_BITS: u32 = 15;
const BUCKETS: usize = 1 << BUCKET_BITS;

/// The fewest triangles that one thread counts at once: its counts take 128 KB.
const LEAST_CHUNK: usize = 1 << 15;

/// Fewer keys are sorted by comparison alone, in less time than it takes to clear the counts.
const FEW: usize = 1 << 10;

/// Sorts the triangles of a frame, or points, along a Morton curve, with reused memory. 16 bytes each.
#[derive(Debug, Default)]
pub(crate) struct Order {
    /// A triangle's code in the upper half, its id in the lower.
    keys: Vec<u64>,
    /// The keys in their buckets. Threads write to scattered slots.
    in_buckets: Vec<AtomicU64>,
    /// For each chunk of triangles and each bucket: first the number of keys, then the slot of the next one.
    counts: Vec<u32>,
}

impl Order {
    /// The ids of all triangles, in the lower halves of the numbers, along the curve: triangles near each other are mostly
    /// near in this order. Those in one cell of the curve are sorted by id, so that threads play no part.
    pub(super) fn sort(&mut self, triangles: Triangles<'_>) -> &[u64] {
        self.sort_by(triangles.len(), |id| centre(triangles, id))
    }

    /// The same for points.
    pub(crate) fn sort_points(&mut self, points: &[Vec3]) -> &[u64] {
        self.sort_by(points.len(), |index| points[index as usize])
    }

    fn sort_by(&mut self, count: usize, point: impl Fn(u32) -> Vec3 + Copy + Sync) -> &[u64] {
        let Self { keys, in_buckets, counts } = self;
        let curve = Curve::through(count, point);
        let key = |id: u32| u64::from(curve.code(point(id))) << 32 | u64::from(id);
        keys.resize(count, 0);
        if count < FEW {
            for (id, to) in (0..).zip(keys.iter_mut()) {
                *to = key(id);
            }
            keys.sort_unstable();
            return keys;
        }
        let chunk = count.div_ceil(rayon::current_num_threads()).max(LEAST_CHUNK);
        let chunks = count.div_ceil(chunk).max(1);
        in_buckets.resize_with(count, AtomicU64::default);
        counts.clear();
        counts.resize(chunks * BUCKETS, 0);
        keys.par_chunks_mut(chunk).zip(counts.par_chunks_mut(BUCKETS)).enumerate().each(|(number, (keys, counts))| {
            for (id, to) in ((number * chunk) as u32..).zip(keys) {
                *to = key(id);
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
    (key >> (32 + 3 * Curve::BITS - BUCKET_BITS)) as usize
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

/// The middle of a triangle's corners; the origin if they don't exist or aren't finite.
pub(super) fn centre(triangles: Triangles<'_>, id: u32) -> Vec3 {
    let corners = triangles.indices[id as usize].map(|vertex| triangles.positions.get(vertex as usize));
    let sum = corners.into_iter().map(|corner| corner.copied().unwrap_or(Vec3::NAN)).sum::<Vec3>();
    if sum.is_finite() { sum / 3.0 } else { Vec3::ZERO }
}

/// A Morton curve through a frame. (Morton, *A computer oriented geodetic data base*, 1966)
///
/// Half of its steps on each axis are in a cube that holds most triangles. Steps beyond it grow, up to infinity: so a few
/// far triangles don't make the cells of others larger, and are still told apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Curve {
    middle: Vec3,
    /// Two over the cube's size.
    scale: f32,
}

impl Curve {
    /// Bits of the steps on each axis.
    const BITS: u32 = 10;
    /// Number of triangles or points sampled to find the cube.
    const SAMPLES: usize = 1 << 10;

    pub(crate) fn through_triangles(triangles: Triangles<'_>) -> Self {
        Self::through(triangles.len(), |id| centre(triangles, id))
    }

    /// The curve through some of so many points.
    fn through(points: usize, point: impl Fn(u32) -> Vec3) -> Self {
        let mut axes = [[0.0; Self::SAMPLES]; 3];
        let mut count = 0;
        let every = points.div_ceil(Self::SAMPLES).max(1);
        for id in (0..points).step_by(every) {
            let point = point(id as u32);
            if !point.is_finite() {
                continue;
            }
            for (axis, coordinate) in axes.iter_mut().zip(point.to_array()) {
                axis[count] = coordinate;
            }
            count += 1;
        }
        let mut quantile = |share: f32| {
            let index = (share * count as f32) as usize;
            let of = |axis: &mut [f32; Self::SAMPLES]| {
                if count == 0 { 0.0 } else { *axis[..count].select_nth_unstable_by(index, f32::total_cmp).1 }
            };
            // Half of the value, since a sum may overflow.
            0.5 * Vec3::from_array(axes.each_mut().map(of))
        };
        let (low, high) = (quantile(0.05), quantile(0.95));
        let size = high - low;
        let half = 1.3 * size.max_element();
        // A flat frame is at the cube's lower side, away from the boundaries of large cells, which would divide it.
        Self { middle: 2.0 * low - 0.3 * size + half, scale: 1.0 / half }
    }

    /// The middle of the cube that holds most triangles.
    pub(crate) fn middle(&self) -> Vec3 {
        self.middle
    }

    /// The size of the cube that holds most triangles.
    pub(crate) fn size(&self) -> f32 {
        2.0 / self.scale
    }

    /// The position of a point along the curve: any if the cube has no size.
    fn code(&self, point: Vec3) -> u32 {
        const QUARTER: f32 = (1 << (Curve::BITS - 2)) as f32;
        const LAST: u32 = (1 << Curve::BITS) - 1;
        /// The lowest bits of a sum with it are the other number, rounded: faster than a conversion.
        const TO_BITS: f32 = (1 << 23) as f32;
        let [x, y, z] = ((point - self.middle) * self.scale).to_array().map(|across| {
            let size = across.abs();
            let bent = if size <= 1.0 { size } else { 2.0 - 1.0 / size };
            let step = 2.0 * QUARTER + QUARTER * bent.copysign(across);
            (step.max(0.0).min(LAST as f32) + TO_BITS).to_bits() & LAST
        });
        spread(x) | spread(y) << 1 | spread(z) << 2
    }
}

/// A step's bits with two zeros between them.
fn spread(step: u32) -> u32 {
    let step = (step | step << 16) & 0x0300_00ff;
    let step = (step | step << 8) & 0x0300_f00f;
    let step = (step | step << 4) & 0x030c_30c3;
    (step | step << 2) & 0x0924_9249
}
