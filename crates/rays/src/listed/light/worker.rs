use super::small::Batch;
use crate::light_grid::settle::Settler;
use crate::shot::Counts;
use crate::simd::vectors::LANES;

/// Undecided pairs that a thread collects before it has them settled.
const MOST_UNDECIDED: usize = 1 << 15;

/// What one thread has found out about the points of a face.
#[derive(Default)]
pub(crate) struct Worker {
    /// For each block which of its lanes needn't be tested any more: those in shadow, and those without a point of the
    /// face.
    pub(crate) shadowed: Vec<u16>,
    /// Pairs of a point's index and a triangle that the filter couldn't decide.
    pub(crate) undecided: Vec<[u32; 2]>,
    pub(crate) batch: Batch,
    pub(crate) counts: Counts,
}

impl Worker {
    /// Forgets what was found, and takes the `members` of each block for unshadowed.
    pub(crate) fn start(&mut self, members: &[u16]) {
        self.shadowed.clear();
        self.shadowed.extend(members.iter().map(|members| !members));
        self.undecided.clear();
        self.undecided.reserve_exact(MOST_UNDECIDED + LANES);
        self.counts = Counts::default();
    }

    /// Settles the undecided pairs when there are many.
    #[inline(always)]
    pub(crate) fn settle_if_many(&mut self, settler: &Settler<'_>) {
        if self.undecided.len() >= MOST_UNDECIDED {
            self.counts.settled += settler.settle(&self.undecided, 0, &mut self.shadowed);
            self.undecided.clear();
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        self.shadowed.capacity() * size_of::<u16>() + self.undecided.capacity() * size_of::<[u32; 2]>()
    }
}
