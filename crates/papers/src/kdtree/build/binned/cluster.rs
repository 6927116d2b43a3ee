//! The top of the tree: initial clustering (Shevtsov et al. 2007, §3.2), where threads share the passes over a node's boxes.
//!
//! Planes are those of least cost among samples, not medians, to which the thesis (§4.2) attributes the loss of 30 % in
//! trace time.

use fearless_simd::Simd;
use rayon::prelude::*;

use super::boxes::{Around, Boxed};
use super::planes::{Counts, Node, best_of, count_part};
use super::{Arena, Binning, crowd};
use crate::kdtree::build::sah::{Cell, SplitCandidate};
use crate::kdtree::layout::Branch;
use umbrage_rays::vectorized;

/// Nodes of fewer boxes are clusters, which one thread builds, …
const CLUSTER: usize = 1 << 12;
/// … and so are nodes of fewer than one in this number of all triangles.
const CLUSTERS: usize = 32;

impl<S: Simd> Binning<'_, S> {
    /// Adds the subtree of boxes in chunks. Its children have as many chunks, so that no chunk waits for another.
    pub(super) fn cluster(&self, mut chunks: Vec<Arena>, cell: Cell, out: &mut Branch) {
        let Self { job, simd, costs, .. } = self;
        let count = chunks.iter().map(|chunk| chunk.boxes.len()).sum();
        if count < CLUSTER.max(job.triangles.len() / CLUSTERS) {
            let mut arena = job.pool.arenas.take();
            arena.boxes.reserve(2 * count);
            for chunk in chunks {
                arena.boxes.extend_from_slice(&chunk.boxes);
                job.pool.chunks.keep(chunk);
            }
            self.grow(&mut arena, 0..count, cell, out);
            job.pool.arenas.keep(arena);
            return;
        }
        let around = Around::chunks(*simd, &chunks);
        let counts = self.count_chunks(&chunks, &around);
        let node = Node::new(costs, &cell.extent, count);
        let mut best = best_of(*simd, &node, &around, &counts);
        if self.is_stretched
            && let Some(most) = crowd::among_most(&around, &counts, &chunks.iter().flat_map(|chunk| &chunk.boxes))
        {
            let other = best_of(*simd, &node, &most, &self.count_chunks(&chunks, &most));
            best = SplitCandidate::better(best, other);
        }
        let Some((best, cells)) = job.heuristic.split(&cell, count, best) else {
            out.push_leaf(chunks.iter().flat_map(|chunk| &chunk.boxes).map(Boxed::id));
            chunks.into_iter().for_each(|chunk| job.pool.chunks.keep(chunk));
            return;
        };
        let parted = chunks.par_iter_mut().map(|Arena { boxes, cut }| {
            let mut left = job.pool.chunks.take();
            left.boxes.resize(boxes.len(), Boxed::default());
            let counts = self.part(boxes, &best, &mut left.boxes, cut);
            left.boxes.truncate(counts[0]);
            boxes.truncate(counts[1]);
            left
        });
        let mut left = Vec::new();
        parted.collect_into_vec(&mut left);
        let counts = [&left, &chunks].map(|chunks| chunks.iter().map(|chunk| chunk.boxes.len()).sum());
        let [left_cell, right_cell] = Cell::share(cells, counts);
        job.join(
            best.plane,
            out,
            |out| self.cluster(left, left_cell, out),
            |out| self.cluster(chunks, right_cell, out),
        );
    }

    /// Counts the boxes of all chunks at planes within a box.
    fn count_chunks(&self, chunks: &[Arena], around: &Around) -> Counts {
        let simd = self.simd;
        let counts = chunks.par_iter().map(|chunk| vectorized!(simd => count_part(simd, &chunk.boxes, around)));
        counts.reduce(Counts::default, |mut a, b| {
            let of_b = b.iter().flatten().flatten();
            a.iter_mut().flatten().flatten().zip(of_b).for_each(|(a, b)| *a += b);
            a
        })
    }
}
