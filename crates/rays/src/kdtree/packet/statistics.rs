#[cfg(feature = "statistics")]
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use crate::KdTree;

/// What packets of rays took. All zeros without the feature `statistics`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KdPacketVisits {
    /// Groups of rays that were led to leaves together.
    pub packets: u64,
    /// Inner nodes that were visited, again where a packet came from above again.
    pub nodes: u64,
    /// Leaves that were visited.
    pub leaves: u64,
    /// Triangles that were tested, for up to 16 rays at once.
    pub tests: u64,
    /// Rays and triangles that the predicate was asked about.
    pub asked: u64,
    /// Times that a packet came from above again.
    pub restarts: u64,
}

impl KdTree {
    /// What packets took since the last time, and forgets it. All zeros without the feature `statistics`.
    #[must_use]
    pub fn take_packet_visits(&self) -> KdPacketVisits {
        self.packet_visits.take()
    }
}

/// Sums of what packets took.
#[derive(Debug, Default)]
pub(in crate::kdtree) struct Tally {
    #[cfg(feature = "statistics")]
    sums: [AtomicU64; 6],
}

impl Tally {
    fn take(&self) -> KdPacketVisits {
        #[cfg(feature = "statistics")]
        {
            let [packets, nodes, leaves, tests, asked, restarts] =
                [0, 1, 2, 3, 4, 5].map(|place| self.sums[place].swap(0, Relaxed));
            KdPacketVisits { packets, nodes, leaves, tests, asked, restarts }
        }
        #[cfg(not(feature = "statistics"))]
        KdPacketVisits::default()
    }
}

/// Counts for some packets, and adds that up when they end, where the feature `statistics` is on; else it is empty.
pub(super) struct Steps<'a> {
    #[cfg(feature = "statistics")]
    tally: &'a Tally,
    #[cfg(feature = "statistics")]
    counts: KdPacketVisits,
    #[cfg(not(feature = "statistics"))]
    tally: std::marker::PhantomData<&'a Tally>,
}

impl<'a> Steps<'a> {
    #[inline(always)]
    #[cfg_attr(not(feature = "statistics"), expect(unused_variables, reason = "there is nothing to count in"))]
    pub(super) fn new(tally: &'a Tally) -> Self {
        #[cfg(feature = "statistics")]
        return Self { tally, counts: KdPacketVisits::default() };
        #[cfg(not(feature = "statistics"))]
        Self { tally: std::marker::PhantomData }
    }

    /// Counts in what `count` picks.
    #[inline(always)]
    #[cfg_attr(not(feature = "statistics"), expect(clippy::unused_self, reason = "there is nothing to count in"))]
    pub(super) fn note(&mut self, count: impl FnOnce(&mut KdPacketVisits)) {
        #[cfg(feature = "statistics")]
        count(&mut self.counts);
        #[cfg(not(feature = "statistics"))]
        let _ = count;
    }
}

#[cfg(feature = "statistics")]
impl Drop for Steps<'_> {
    fn drop(&mut self) {
        let KdPacketVisits { packets, nodes, leaves, tests, asked, restarts } = self.counts;
        let counts = [packets, nodes, leaves, tests, asked, restarts];
        for (sum, count) in self.tally.sums.iter().zip(counts) {
            sum.fetch_add(count, Relaxed);
        }
    }
}
