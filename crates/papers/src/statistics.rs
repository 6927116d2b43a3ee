//! Counts of the work of single rays and of packets, compiled in by the feature `statistics`.

use std::sync::{Mutex, PoisonError};

use umbrage_rays::Counts;

/// Whether counting is compiled in.
const IS_ON: bool = cfg!(feature = "statistics");

/// Counts where the feature `statistics` is on; else it is empty, and its methods do nothing.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Statistics {
    counts: [Counts; IS_ON as usize],
}

impl Statistics {
    /// Updates the counts by `count`, if they are on.
    #[inline(always)]
    pub(crate) fn note(&mut self, count: impl FnOnce(&mut Counts)) {
        if let Some(counts) = self.counts.first_mut() {
            count(counts);
        }
    }

    /// Returns the counts since the last call and resets them.
    pub(crate) fn take(&mut self) -> Counts {
        self.counts.first_mut().map(std::mem::take).unwrap_or_default()
    }
}

/// The counts of the rays of all threads.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    sum: Mutex<Counts>,
}

impl Tally {
    /// Returns the counts since the last call and resets them.
    pub(crate) fn take(&self) -> Counts {
        std::mem::take(&mut *self.sum.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// The counts of a ray or some packets, added to a tally when dropped.
pub(crate) struct Steps<'a> {
    tally: &'a Tally,
    statistics: Statistics,
}

impl<'a> Steps<'a> {
    #[inline(always)]
    pub(crate) fn new(tally: &'a Tally) -> Self {
        Self { tally, statistics: Statistics::default() }
    }

    /// Updates the counts by `count`, if they are on.
    #[inline(always)]
    pub(crate) fn note(&mut self, count: impl FnOnce(&mut Counts)) {
        self.statistics.note(count);
    }
}

impl Drop for Steps<'_> {
    #[inline(always)]
    fn drop(&mut self) {
        if IS_ON {
            *self.tally.sum.lock().unwrap_or_else(PoisonError::into_inner) += self.statistics.take();
        }
    }
}
