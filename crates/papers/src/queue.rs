//! Ways to distribute work to threads, as interactive ray tracers did before work stealing was common.

use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

/// How the threads of the current pool get groups of work, which are numbered from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Queue {
    /// Thread k of n does groups k, k + n, k + 2n …, at any cost of these.
    RoundRobin,
    /// One group after the other from a counter behind a lock.
    Locked,
    /// One group after the other from an atomic counter.
    Swapped,
    /// Several groups at once, fewer towards the end: a share of 1 / 2n of the remaining groups (Parker et al.,
    /// *Interactive Ray Tracing*, 1999).
    Decreasing,
    /// Each thread a half, and later groups that other threads haven't begun: rayon's way.
    Stealing,
}

impl Queue {
    /// All ways.
    pub const ALL: [Self; 5] = [Self::RoundRobin, Self::Locked, Self::Swapped, Self::Decreasing, Self::Stealing];

    /// Name for output.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::RoundRobin => "round robin",
            Self::Locked => "locked",
            Self::Swapped => "swapped",
            Self::Decreasing => "decreasing",
            Self::Stealing => "stealing",
        }
    }

    /// Does each of `groups` once, on all threads of the current pool.
    pub fn for_each(self, groups: usize, work: impl Fn(usize) + Sync) {
        let threads = rayon::current_num_threads();
        let next = AtomicUsize::new(0);
        // Takes `share` of the remaining groups at a time, until there are none.
        let take = |share: &dyn Fn(usize) -> usize| {
            loop {
                let taken = |first: usize| (first < groups).then(|| first + share(groups - first));
                let Ok(first) = next.fetch_update(Relaxed, Relaxed, taken) else { break };
                (first..groups.min(first + share(groups - first))).for_each(&work);
            }
        };
        match self {
            Self::Stealing => (0..groups).into_par_iter().with_max_len(1).for_each(&work),
            Self::RoundRobin => {
                rayon::broadcast(|thread| (thread.index()..groups).step_by(threads).for_each(&work));
            }
            Self::Swapped => {
                rayon::broadcast(|_| take(&|_| 1));
            }
            Self::Decreasing => {
                rayon::broadcast(|_| take(&|left| decreasing(left, threads)));
            }
            Self::Locked => {
                let next = Mutex::new(0..groups);
                let take = || next.lock().unwrap_or_else(PoisonError::into_inner).next();
                rayon::broadcast(|_| std::iter::from_fn(take).for_each(&work));
            }
        }
    }

    /// Finishing time on `threads` otherwise idle threads, given each group's cost and no cost of scheduling: the first
    /// free thread takes the next groups. Stealing counts as one group after the other.
    #[must_use]
    pub fn simulated(self, costs: &[f64], threads: usize) -> f64 {
        let mut ends = vec![0.0_f64; threads.max(1)];
        let mut first = 0;
        while first < costs.len() {
            let count = if self == Self::Decreasing { decreasing(costs.len() - first, ends.len()) } else { 1 };
            let cost: f64 = costs[first..costs.len().min(first + count)].iter().sum();
            let earliest = (0..ends.len()).min_by(|&a, &b| ends[a].total_cmp(&ends[b])).unwrap_or_default();
            let thread = if self == Self::RoundRobin { first % ends.len() } else { earliest };
            ends[thread] += cost;
            first += count;
        }
        ends.into_iter().fold(0.0, f64::max)
    }
}

/// Number of remaining groups that a thread takes at once.
fn decreasing(left: usize, threads: usize) -> usize {
    (left / (2 * threads.max(1))).max(1)
}
