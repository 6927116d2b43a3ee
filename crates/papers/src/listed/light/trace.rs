use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use fearless_simd::Simd;
use fearless_simd::prelude::*;
use rayon::prelude::*;
use umbrage_rays::dispatch;
use umbrage_rays::light_grid::settle::Settler;
use umbrage_rays::parallel::Parallel;
use umbrage_rays::shot::Counts;
use umbrage_rays::simd::lanes::bits_of;
use umbrage_rays::simd::vectors::LANES;

use super::Lists;
use super::map::LightMap;
use super::pass::LightPass;
use super::points::{PointGroup, PointRow};
use super::worker::{CellWorker, Open};
use crate::listed::sorted::Sorted;

/// Marks items of cells that are indices of large triangles instead of ids.
pub(super) const LARGE: u32 = 1 << 31;

/// Some points of a cell and some triangles, which one thread tests against each other: a block of the paper's (§4.3).
#[derive(Clone, Copy, Debug)]
pub(super) struct Job {
    row: u32,
    column: u32,
    /// The range of the row's groups.
    groups: [u32; 2],
    /// The range of the row's triangles.
    triangles: [u32; 2],
}

impl<M: LightMap> Lists<M> {
    /// Splits cells into jobs of at most as many points and triangles as the options allow: boundaries between cells are the
    /// paper's hard ones, others its soft ones.
    pub(super) fn split(&mut self, counts: &mut Counts) {
        let Self { options, axes, slices, point_rows, triangle_rows, jobs, .. } = self;
        let (points, triangles) = (options.points() as usize / LANES, options.triangles() as usize);
        jobs.clear();
        for (row, (in_points, in_triangles)) in point_rows.iter().zip(&*triangle_rows).enumerate() {
            for column in 0..axes[0].count {
                let groups = in_points.of_cell(column);
                counts.cells += u64::from(!groups.is_empty());
                let keys = column * slices.count..(column + 1) * slices.count;
                for groups in parts(groups, points) {
                    for triangles in parts(in_triangles.range(keys.clone()), triangles) {
                        jobs.push(Job { row: row as u32, column: column as u32, groups, triangles });
                    }
                }
            }
        }
        counts.blocks += jobs.len() as u64;
    }

    /// Tests each job's points against its triangles.
    pub(super) fn test(&mut self, pass: &LightPass, settler: &Settler<'_>) {
        const TAKEN_AT_ONCE: usize = 16;
        let Self { map, slices, point_rows, triangle_rows, large, jobs, workers, .. } = self;
        let level = pass.level;
        let tester = Tester { map, slices: slices.count, point_rows, triangle_rows, large, settler };
        let jobs = &*jobs;
        workers.resize_with(rayon::current_num_threads(), CellWorker::default);
        let next = AtomicUsize::new(0);
        workers.par_iter_mut().each(|worker| {
            worker.start(&pass.members);
            loop {
                let first = next.fetch_add(TAKEN_AT_ONCE, Ordering::Relaxed);
                if first >= jobs.len() {
                    break;
                }
                let jobs = &jobs[first..(first + TAKEN_AT_ONCE).min(jobs.len())];
                dispatch!(level, simd => jobs.iter().for_each(
                    #[inline(always)]
                    |job| tester.test(simd, worker, job),
                ));
            }
        });
    }
}

/// Parts of a range, at most `most` long.
fn parts(range: Range<usize>, most: usize) -> impl Iterator<Item = [u32; 2]> {
    let end = range.end;
    range.step_by(most).map(move |first| [first as u32, (first + most).min(end) as u32])
}

/// The inputs of testing a job.
struct Tester<'a, M: LightMap> {
    map: &'a M,
    slices: usize,
    point_rows: &'a [PointRow<M::Points>],
    triangle_rows: &'a [Sorted<u32>],
    large: &'a [(u32, M::Large)],
    settler: &'a Settler<'a>,
}

impl<M: LightMap> Tester<'_, M> {
    #[inline(always)]
    fn test<S: Simd>(&self, simd: S, worker: &mut CellWorker<M::Batch>, job: &Job) {
        let [first, end] = job.groups.map(|group| group as usize);
        let groups = &self.point_rows[job.row as usize].groups[first..end];
        let [first, end] = job.triangles.map(|triangle| triangle as usize);
        let of_row = &self.triangle_rows[job.row as usize];
        let keys = job.column as usize * self.slices;
        worker.open.clear();
        worker.open.extend(groups.iter().map(|group| Open {
            points: open_points(&worker.shadowed, group),
            // Triangles of later slices are behind all of its points.
            end: of_row.range(keys..keys + group.slice as usize + 1).end,
        }));
        for (chunk, items) in of_row.items()[first..end].chunks(LANES).enumerate() {
            if worker.open.iter().all(|open| open.points == 0) {
                break;
            }
            let mut ids = [u32::MAX; LANES];
            let mut any_small = false;
            for (id, &item) in ids.iter_mut().zip(items) {
                if item & LARGE == 0 {
                    *id = item;
                    any_small = true;
                }
            }
            let triangles = self.settler.opacity.triangles;
            let small =
                if any_small { self.map.set_up(simd, triangles, &ids[..items.len()], &mut worker.batch) } else { 0 };
            for (lane, &item) in items.iter().enumerate() {
                let at = first + chunk * LANES + lane;
                if item & LARGE == 0 && small >> lane & 1 == 0 {
                    continue;
                }
                let large = (item & LARGE != 0).then(|| &self.large[(item & !LARGE) as usize]);
                let id = large.map_or(item, |(id, _)| *id);
                for (number, group) in groups.iter().enumerate() {
                    let Open { points, end } = worker.open[number];
                    // The paper's shadow bit (§4.4): a point in shadow isn't tested again.
                    if points == 0 || end <= at {
                        continue;
                    }
                    worker.counts.tests += 1;
                    let (certain, possible) = match large {
                        Some((_, large)) => M::test_large(simd, large, &group.points),
                        None => M::test(simd, &worker.batch, lane, &group.points),
                    };
                    if possible.any_true() {
                        self.note(worker, number, group, id, certain.to_bitmask(), possible.to_bitmask());
                    }
                }
            }
            worker.settle_if_many(self.settler);
        }
    }

    /// Notes a triangle's certain shadows among the possibly shadowed points of a group.
    #[inline(always)]
    fn note(
        &self,
        worker: &mut CellWorker<M::Batch>,
        number: usize,
        group: &PointGroup<M::Points>,
        id: u32,
        certain: u64,
        possible: u64,
    ) {
        let CellWorker { shadowed, undecided, counts, open, .. } = worker;
        let open = &mut open[number].points;
        for lane in bits_of(possible & u64::from(*open)) {
            let index = group.indices[lane];
            if self.settler.points.own()[index as usize] == id {
                continue;
            }
            let is_certain = certain >> lane & 1 == 1;
            if is_certain && self.settler.opacity.opacity.is_opaque(id) {
                *open &= !(1 << lane);
                shadowed[index as usize / LANES] |= 1 << (index as usize % LANES);
            } else {
                counts.undecided += u64::from(!is_certain);
                counts.masked += u64::from(is_certain);
                undecided.push([index, id]);
            }
        }
    }
}

/// The mask of a group's points that aren't known to be in shadow.
#[inline(always)]
fn open_points<P>(shadowed: &[u16], group: &PointGroup<P>) -> u16 {
    let indices = group.indices[..group.count as usize].iter().enumerate();
    indices.fold(0, |open, (lane, &index)| {
        let is_shadowed = shadowed[index as usize / LANES] >> (index as usize % LANES) & 1;
        open | (1 - is_shadowed) << lane
    })
}
