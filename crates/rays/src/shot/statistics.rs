#[cfg(feature = "statistics")]
use std::sync::{Mutex, PoisonError};

use super::Counts;

/// Counts where the feature `statistics` is on; else it is empty, and its methods do nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Statistics {
    #[cfg(feature = "statistics")]
    counts: Counts,
}

impl Statistics {
    /// Counts in what `count` picks.
    #[inline(always)]
    pub fn note(&mut self, count: impl FnOnce(&mut Counts)) {
        #[cfg(feature = "statistics")]
        count(&mut self.counts);
        #[cfg(not(feature = "statistics"))]
        let _ = count;
    }

    /// What was counted since the last time, and forgets it.
    pub(crate) fn take(&mut self) -> Counts {
        #[cfg(feature = "statistics")]
        return std::mem::take(&mut self.counts);
        #[cfg(not(feature = "statistics"))]
        Counts::default()
    }
}

/// What the rays of all threads have taken.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    #[cfg(feature = "statistics")]
    sum: Mutex<Counts>,
}

impl Tally {
    /// What was counted since the last time, and forgets it.
    #[cfg_attr(not(feature = "statistics"), expect(clippy::unused_self, reason = "nothing was counted"))]
    pub(crate) fn take(&self) -> Counts {
        #[cfg(feature = "statistics")]
        return std::mem::take(&mut *self.sum.lock().unwrap_or_else(PoisonError::into_inner));
        #[cfg(not(feature = "statistics"))]
        Counts::default()
    }
}

/// Counts for a ray or some packets, and adds that up when they end.
pub(crate) struct Steps<'a> {
    #[cfg(feature = "statistics")]
    tally: &'a Tally,
    #[cfg(not(feature = "statistics"))]
    tally: std::marker::PhantomData<&'a Tally>,
    statistics: Statistics,
}

impl<'a> Steps<'a> {
    #[inline(always)]
    #[cfg_attr(not(feature = "statistics"), expect(unused_variables, reason = "there is nothing to count in"))]
    pub(crate) fn new(tally: &'a Tally) -> Self {
        #[cfg(not(feature = "statistics"))]
        let tally = std::marker::PhantomData;
        Self { tally, statistics: Statistics::default() }
    }

    /// Counts in what `count` picks.
    #[inline(always)]
    pub(crate) fn note(&mut self, count: impl FnOnce(&mut Counts)) {
        self.statistics.note(count);
    }
}

#[cfg(feature = "statistics")]
impl Drop for Steps<'_> {
    fn drop(&mut self) {
        *self.tally.sum.lock().unwrap_or_else(PoisonError::into_inner) += self.statistics.take();
    }
}
