use super::Cells;

/// Depth slices, the nearest first, as ranges of inverse depth.
///
/// Each spans the same number of f32 values: their bits, read as an integer, grow about as their logarithm. So slices are
/// thin where the scene is near, and the slice is a monotonic function of the inverse depth, roundings included.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slices {
    /// The bits of the largest inverse depth.
    nearest: u32,
    /// Slices per step of the bits.
    scale: f32,
    /// The last slice.
    last: u32,
    /// For each slice, the smallest inverse depth in it or in an earlier one.
    ends: [f32; Cells::MOST_SLICES as usize],
}

impl Default for Slices {
    fn default() -> Self {
        Self::new(1, f32::INFINITY, 0.0)
    }
}

impl Slices {
    /// `count` slices between two positive inverse depths; a single one if the range is empty.
    pub(super) fn new(count: u32, farthest: f32, nearest: f32) -> Self {
        let (first, last) = (nearest.max(0.0).to_bits(), farthest.max(0.0).to_bits());
        let span = first.saturating_sub(last);
        let scale = if span > 0 { count as f32 / span as f32 } else { 0.0 };
        let mut slices = Self { nearest: first, scale, last: count - 1, ends: [0.0; Cells::MOST_SLICES as usize] };
        for slice in 0..count - 1 {
            // Zero is in the last slice and infinity in the first.
            let (mut beyond, mut within) = (0, f32::INFINITY.to_bits());
            while within - beyond > 1 {
                let middle = beyond + (within - beyond) / 2;
                if slices.of(f32::from_bits(middle)) <= slice { within = middle } else { beyond = middle }
            }
            slices.ends[slice as usize] = f32::from_bits(within);
        }
        slices
    }

    /// The number of slices.
    pub(super) fn count(&self) -> u32 {
        self.last + 1
    }

    /// The slice of an inverse depth; the last one for values that aren't positive.
    #[inline(always)]
    pub(super) fn of(&self, inverse_depth: f32) -> u32 {
        let steps = self.nearest.saturating_sub(inverse_depth.to_bits());
        let slice = ((steps as f32 * self.scale) as u32).min(self.last);
        if inverse_depth > 0.0 { slice } else { self.last }
    }

    /// The smallest inverse depth that is certainly in slice `slice` or an earlier one: a hit no farther hides all triangles
    /// listed in later slices.
    pub(super) fn end(&self, slice: u32) -> f32 {
        self.ends[slice as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_cover_all_depths_in_order() {
        for (count, farthest, nearest) in
            [(1, 0.1, 1.0), (7, 0.01, 3.0), (64, 1e-30, 1e30), (5, 2.0, 2.0), (3, 0.0, 1.0)]
        {
            let slices = Slices::new(count, farthest, nearest);
            assert_eq!(slices.of(f32::INFINITY), 0);
            assert_eq!(slices.of(nearest), 0);
            let mut before = count - 1;
            for step in 0..10_000_u32 {
                let inverse_depth = f32::from_bits(step * (f32::INFINITY.to_bits() / 10_000));
                let slice = slices.of(inverse_depth);
                assert!(slice <= before, "{count} {inverse_depth}");
                before = slice;
                for end in 0..count {
                    assert_eq!(inverse_depth >= slices.end(end), slice <= end, "{count} {inverse_depth} {end}");
                }
            }
        }
        let slices = Slices::new(4, 1.0, 16.0);
        assert_eq!([16.1, 15.9, 7.9, 3.9, 1.9, 0.5].map(|depth| slices.of(depth)), [0, 0, 1, 2, 3, 3]);
        assert_eq!([0.0, -1.0, f32::NAN].map(|depth| slices.of(depth)), [3; 3]);
    }
}
