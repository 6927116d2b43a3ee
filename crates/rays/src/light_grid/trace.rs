use std::sync::atomic::{AtomicUsize, Ordering};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, mask32x16, u32x16};
use rayon::prelude::*;

use super::block::{Block, BlockErrors};
use super::face::VertexErrors;
use super::large::{Plane, planes};
use super::pass::LightPass;
use super::settle::Settler;
use super::small::{BATCH, Batch, Mapped};
use super::worker::Worker;
use crate::shot::Counts;
use crate::simd::lanes::bits_of;
use crate::simd::vectorized;
use crate::simd::vectors::LANES;

/// Triangles that a thread takes at once.
const CHUNK_TRIANGLES: usize = 512;

/// Triangles that cover much of the face that a thread sets aside.
const MOST_HUGE: usize = 1024;

/// Rows of cells that a thread takes at once for the triangles that cover much of the face.
const CHUNK_ROWS: usize = 4;

/// Tests every triangle against the blocks that it covers; `huge` is memory for those that cover much of the face.
pub(crate) fn test_triangles(pass: &mut LightPass, huge: &mut Vec<u32>, settler: &Settler<'_>) {
    let LightPass { face, cells, blocks, errors, members, vertices, workers, level, .. } = pass;
    let level = level.0;
    let mapped = Mapped { face, vertex_errors: VertexErrors::new(face), cells, vertices };
    let tester = Tester { mapped, blocks, errors, settler };
    workers.resize_with(rayon::current_num_threads(), Worker::default);
    let next = AtomicUsize::new(0);
    workers.par_iter_mut().for_each(|worker| {
        worker.start(members);
        worker.huge.reserve_exact(MOST_HUGE);
        loop {
            let first = next.fetch_add(CHUNK_TRIANGLES, Ordering::Relaxed);
            if first >= settler.image.shot.triangles.len() {
                break;
            }
            dispatch!(level, simd => tester.test_chunk(simd, worker, first));
        }
    });
    huge.clear();
    workers.iter().for_each(|worker| huge.extend_from_slice(&worker.huge));
    if !huge.is_empty() {
        let next = AtomicUsize::new(0);
        workers.par_iter_mut().for_each(|worker| {
            loop {
                let first = next.fetch_add(CHUNK_ROWS, Ordering::Relaxed);
                if first >= cells.rows().len() {
                    break;
                }
                let rows = first..(first + CHUNK_ROWS).min(cells.rows().len());
                dispatch!(level, simd => tester.test_huge(simd, worker, huge, rows));
            }
        });
    }
}

/// What testing a triangle needs to know.
pub(crate) struct Tester<'a> {
    pub(crate) mapped: Mapped<'a>,
    pub(crate) blocks: &'a [Block],
    pub(crate) errors: &'a [BlockErrors],
    pub(crate) settler: &'a Settler<'a>,
}

impl Tester<'_> {
    #[inline(always)]
    fn test_chunk<S: Simd>(&self, simd: S, worker: &mut Worker, first: usize) {
        let all = self.settler.image.shot.triangles.indices;
        let chunk = &all[first..(first + CHUNK_TRIANGLES).min(all.len())];
        for (batch, triangles) in chunk.chunks(BATCH).enumerate() {
            let first = first + batch * BATCH;
            let (mut small, mut large) = (0_u64, 0_u64);
            for (group, triangles) in triangles.chunks(LANES).enumerate() {
                let slot = group * LANES;
                let survivors = worker.batch.set_up(simd, &self.mapped, triangles, slot);
                small |= survivors.small << slot;
                large |= survivors.large << slot;
            }
            worker.counts.small_triangles += u64::from(small.count_ones());
            for lane in bits_of(small) {
                self.enqueue(simd, worker, first, lane);
            }
            self.flush(simd, worker, first);
            for lane in bits_of(large) {
                self.test_large(simd, worker, (first + lane) as u32);
            }
        }
    }

    /// Lists the blocks that a small triangle may shadow points of, `first` being the id of the batch's first.
    #[inline(always)]
    fn enqueue<S: Simd>(&self, simd: S, worker: &mut Worker, first_id: usize, triangle: usize) {
        let slot = triangle % BATCH;
        let bounds = worker.batch.bounds(simd, slot);
        let cells = worker.batch.cells[slot];
        // A triangle that is smaller than a cluster touches most that its bounds do, and tests for it take longer: 10 %
        // in the shards. For all triangles it spares 35 % of the tests of 16 points in the forest and the hall, 20 % in the
        // cloth, and 2 to 5 % of the time.
        let covers_much = cells.columns[1] - cells.columns[0] >= 2 || cells.rows[1] - cells.rows[0] >= 2;
        for row in cells.rows[0]..=cells.rows[1] {
            let is_first = row == cells.rows[0];
            let row = &self.mapped.cells.rows()[usize::from(row)];
            let mut clusters = row.reaching(cells.columns[0].into(), cells.columns[1].into());
            while clusters.start < clusters.end {
                let first = clusters.start;
                // What is beyond the end begins too far right to overlap. What began above was found there.
                let mut overlapping = row.overlap(simd, first, &bounds);
                if !is_first {
                    overlapping &= row.begin_here(simd, first);
                }
                if covers_much {
                    overlapping &= worker.batch.may_touch(simd, slot, row.part_in(simd, first, &bounds));
                }
                worker.counts.cluster_tests += 1;
                if worker.queue.is_full() {
                    self.flush_apart(simd, worker, first_id);
                }
                worker.queue.add(simd, triangle as u32, row, first, overlapping);
                clusters.start += LANES;
            }
        }
    }

    /// [`flush`](Self::flush), out of the way of the loop that seldom needs it.
    #[cold]
    #[inline(never)]
    fn flush_apart<S: Simd>(&self, simd: S, worker: &mut Worker, first_id: usize) {
        vectorized!(simd => self.flush(simd, worker, first_id));
    }

    /// Tests what is listed, and empties the list; `first` is the id of the batch's first triangle.
    #[inline(always)]
    fn flush<S: Simd>(&self, simd: S, worker: &mut Worker, first: usize) {
        let Worker { batch, queue, shadowed, undecided, counts, .. } = worker;
        counts.tests += queue.pairs().len() as u64;
        for (block, triangle) in queue.pairs() {
            if shadowed[block] == u16::MAX {
                continue;
            }
            let (certain, possible) = batch.test(simd, triangle, &self.blocks[block], self.errors[block]);
            if possible.any_true() {
                let found = Found { id: (first + triangle) as u32, block, certain, possible };
                let of_batch = Some((&*batch, triangle));
                self.note(simd, &mut shadowed[block], undecided, counts, &found, of_batch);
            }
        }
        queue.clear();
        worker.settle_if_many(self.settler);
    }

    /// Tests a triangle row by row.
    #[inline(always)]
    fn test_large<S: Simd>(&self, simd: S, worker: &mut Worker, id: u32) {
        let Ok(corners) = self.settler.image.shot.triangles.usable_corners(id) else { return };
        let planes = planes(self.mapped.face, corners);
        if planes.iter().flatten().any(|plane| self.is_huge(plane)) && worker.huge.len() < MOST_HUGE {
            worker.huge.push(id);
            return;
        }
        for plane in planes.iter().flatten() {
            worker.counts.large_triangles += 1;
            for row in plane.rows(self.mapped.cells) {
                self.test_row(simd, worker, plane, id, row);
            }
        }
    }

    fn is_huge(&self, plane: &Plane) -> bool {
        plane.cells(self.mapped.cells) * 16 > self.mapped.cells.across.count * self.mapped.cells.rows().len()
    }

    /// Tests triangles that cover much of the face against the points in `rows`.
    #[inline(always)]
    fn test_huge<S: Simd>(&self, simd: S, worker: &mut Worker, huge: &[u32], rows: std::ops::Range<usize>) {
        for &id in huge {
            let Ok(corners) = self.settler.image.shot.triangles.usable_corners(id) else { continue };
            for plane in planes(self.mapped.face, corners).iter().flatten() {
                worker.counts.large_triangles += u64::from(rows.start == 0);
                let covered = plane.rows(self.mapped.cells);
                for row in rows.start.max(*covered.start())..rows.end.min(covered.end() + 1) {
                    self.test_row(simd, worker, plane, id, row);
                }
            }
        }
    }

    #[inline(always)]
    fn test_row<S: Simd>(&self, simd: S, worker: &mut Worker, plane: &Plane, id: u32, row: usize) {
        let Worker { shadowed, undecided, counts, .. } = worker;
        counts.cluster_tests += self.visit_row(
            simd,
            plane,
            row,
            #[inline(always)]
            |block| {
                if shadowed[block] == u16::MAX {
                    return;
                }
                counts.tests += 1;
                let (certain, possible) = plane.test(simd, &self.blocks[block], self.errors[block]);
                if possible.any_true() {
                    let found = Found { id, block, certain, possible };
                    self.note(simd, &mut shadowed[block], undecided, counts, &found, None);
                }
            },
        );
        worker.settle_if_many(self.settler);
    }

    /// Calls `visit` with the blocks in a row of cells that a large triangle may shadow points of; how often it tested 16
    /// clusters for that.
    #[inline(always)]
    fn visit_row<S: Simd>(&self, simd: S, plane: &Plane, row: usize, mut visit: impl FnMut(usize)) -> u64 {
        let Some((columns, bounds)) = plane.span(simd, self.mapped.cells, row) else { return 0 };
        let row = &self.mapped.cells.rows()[row];
        let clusters = row.reaching(*columns.start(), *columns.end()).step_by(LANES);
        let tests = clusters.len() as u64;
        for first in clusters {
            for cluster in bits_of(row.overlap(simd, first, &bounds).to_bitmask()) {
                visit(row.block[first + cluster] as usize);
            }
        }
        tests
    }

    /// Calls `visit` with the blocks that a triangle is tested against, if they are few enough for the queue.
    #[inline(always)]
    pub(crate) fn visit_blocks<S: Simd>(&self, simd: S, worker: &mut Worker, id: u32, mut visit: impl FnMut(usize)) {
        let triangle = &self.settler.image.shot.triangles.indices[id as usize..=id as usize];
        let survivors = worker.batch.set_up(simd, &self.mapped, triangle, 0);
        if survivors.small != 0 {
            self.enqueue(simd, worker, id as usize, 0);
            worker.queue.pairs().for_each(|(block, _)| visit(block));
            worker.queue.clear();
        }
        let Ok(corners) = self.settler.image.shot.triangles.usable_corners(id) else { return };
        if survivors.large != 0 {
            for plane in planes(self.mapped.face, corners).iter().flatten() {
                for row in plane.rows(self.mapped.cells) {
                    self.visit_row(simd, plane, row, &mut visit);
                }
            }
        }
    }

    /// Notes which points of a block a triangle shadows. `of_batch` is the triangle's slot in the batch, if it has one:
    /// its mask can then be asked where the rays of these points cross it.
    #[inline(always)]
    fn note<S: Simd>(
        &self,
        simd: S,
        shadowed: &mut u16,
        undecided: &mut Vec<[u32; 2]>,
        counts: &mut Counts,
        found: &Found<S>,
        of_batch: Option<(&Batch, usize)>,
    ) {
        let &Found { id, block, certain, possible } = found;
        // Only now, since they are in a cache line of their own.
        let own = u32x16::from_slice(simd, &self.settler.image.seen.triangle[block * LANES..(block + 1) * LANES]);
        let others = own.simd_ne(u32x16::splat(simd, id)).to_bitmask() as u16 & !*shadowed;
        let mut certain = certain.to_bitmask() as u16 & others;
        let mut possible = possible.to_bitmask() as u16 & others;
        if certain != 0 && !self.settler.image.shot.shadow_opacity.is_opaque(id) {
            let answers = of_batch.map(
                #[inline(always)]
                |(batch, triangle)| {
                    counts.masked += u64::from(possible.count_ones());
                    let (points, error) = (&self.blocks[block], self.errors[block]);
                    let asked = batch.weights(simd, self.mapped.face, triangle, points, error, possible);
                    self.settler.image.shot.shadow_opacity.which_stop(id, &asked)
                },
            );
            let answers = answers.unwrap_or_default();
            (certain, possible) = (certain & answers.opaque, possible & !answers.cut);
        }
        let pending = possible & !certain;
        counts.undecided += u64::from(pending.count_ones());
        *shadowed |= certain;
        undecided.extend(bits_of(pending).map(|lane| [(block * LANES + lane) as u32, id]));
    }
}

/// What the filter says about a triangle and a block's points.
struct Found<S: Simd> {
    id: u32,
    block: usize,
    /// Which points it shadows for certain, but for its mask.
    certain: mask32x16<S>,
    /// Which it shadows possibly.
    possible: mask32x16<S>,
}
