use rayon::prelude::*;
use umbrage_rays::light_grid::settle::Settler;
use umbrage_rays::parallel::Parallel;
use umbrage_rays::shot::Counts;
use umbrage_rays::simd::vectors::LANES;

use super::Lists;
use super::map::LightMap;
use super::pass::LightPass;

/// Undecided pairs that a thread collects before they are settled.
const MOST_UNDECIDED: usize = 1 << 15;

/// The results of one thread for the points of a face.
#[derive(Default)]
pub(super) struct CellWorker<B> {
    /// For each block, the lanes that need no more tests: those in shadow, and those without a point of the face.
    pub(super) shadowed: Vec<u16>,
    /// The groups of the current job.
    pub(super) open: Vec<Open>,
    /// Pairs of a point's index and a triangle that the filter couldn't decide.
    pub(super) undecided: Vec<[u32; 2]>,
    pub(super) batch: B,
    pub(super) counts: Counts,
}

/// The open points of a group.
#[derive(Clone, Copy, Debug)]
pub(super) struct Open {
    /// Points that aren't known to be in shadow.
    pub(super) points: u16,
    /// End, in the row's list, of the triangles that may shadow them.
    pub(super) end: usize,
}

impl<B> CellWorker<B> {
    /// Clears the results, with the `members` of each block unshadowed.
    pub(super) fn start(&mut self, members: &[u16]) {
        self.shadowed.clear();
        self.shadowed.extend(members.iter().map(|members| !members));
        self.undecided.clear();
        self.undecided.reserve_exact(MOST_UNDECIDED + LANES);
        self.counts = Counts::default();
    }

    /// Settles the undecided pairs when there are many.
    #[inline(always)]
    pub(super) fn settle_if_many(&mut self, settler: &Settler<'_>) {
        if self.undecided.len() >= MOST_UNDECIDED {
            self.counts.settled += settler.settle(&self.undecided, 0, &mut self.shadowed);
            self.undecided.clear();
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.shadowed.capacity() * size_of::<u16>()
            + self.open.capacity() * size_of::<Open>()
            + self.undecided.capacity() * size_of::<[u32; 2]>()
    }
}

impl<M: LightMap> Lists<M> {
    /// Settles the threads' undecided pairs, in equal shares, adds up their counts, and merges the shadowed points of a
    /// face.
    pub(super) fn settle(&mut self, pass: &mut LightPass, settler: &Settler<'_>) {
        let workers = &mut self.workers;
        let LightPass { undecided, counts, shadowed, members, .. } = pass;
        undecided.clear();
        for worker in workers.iter_mut() {
            undecided.append(&mut worker.undecided);
            *counts += worker.counts;
        }
        let share = undecided.len().div_ceil(workers.len()).max(8);
        let shares = workers.par_iter_mut().zip(undecided.par_chunks(share));
        counts.settled += shares.map(|(worker, pairs)| settler.settle(pairs, 0, &mut worker.shadowed)).sum::<u64>();

        const CHUNK: usize = 4096;
        let chunks = shadowed.par_chunks_mut(CHUNK).zip(members.par_chunks(CHUNK)).enumerate();
        chunks.each(|(chunk, (shadowed, members))| {
            for worker in workers.iter() {
                let found = &worker.shadowed[chunk * CHUNK..][..shadowed.len()];
                shadowed.iter_mut().zip(found).zip(members).for_each(|((all, found), members)| *all |= found & members);
            }
        });
    }
}
