use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch};
use rayon::prelude::*;

use super::Lists;
use super::pass::LightPass;
use super::plane::Plane;
use super::points::{Group, PointRow};
use super::small::Mapped;
use super::worker::Worker;
use crate::light_grid::face::VertexErrors;
use crate::light_grid::settle::Settler;
use crate::listed::sorted::Sorted;
use crate::shot::Counts;
use crate::simd::lanes::bits_of;
use crate::simd::vectors::LANES;

/// Marks items of cells that count large triangles rather than being a triangle's id.
pub(super) const LARGE: u32 = 1 << 31;

/// Some points of a cell, and some triangles, that one thread tests against each other: a block of the paper's (§4.3).
#[derive(Clone, Copy, Debug)]
pub(super) struct Job {
    row: u32,
    /// First and last but one among the row's groups.
    groups: [u32; 2],
    /// First and last but one among the row's triangles.
    triangles: [u32; 2],
}

impl Lists {
    /// Splits cells into jobs of at most as many points and triangles as the options say: boundaries between cells are
    /// the paper's hard ones, others its soft ones.
    pub(super) fn split(&mut self, counts: &mut Counts) {
        let Self { options, cells, point_rows, triangle_rows, jobs, .. } = self;
        let (points, triangles) = (options.points as usize / LANES, options.triangles as usize);
        jobs.clear();
        for (row, (in_points, in_triangles)) in point_rows.iter().zip(&*triangle_rows).enumerate() {
            for column in 0..cells.across.count {
                let groups = in_points.of_cell(column);
                counts.cells += u64::from(!groups.is_empty());
                for groups in parts(groups, points) {
                    for triangles in parts(in_triangles.range(column..column + 1), triangles) {
                        jobs.push(Job { row: row as u32, groups, triangles });
                    }
                }
            }
        }
        counts.blocks += jobs.len() as u64;
    }

    /// Tests each job's points against its triangles.
    pub(super) fn test(&self, pass: &mut LightPass, settler: &Settler<'_>) {
        const TAKEN_AT_ONCE: usize = 16;
        let Self { cells, point_rows, triangle_rows, large, jobs, .. } = self;
        let LightPass { level, face, vertices, members, workers, .. } = pass;
        let level = level.0;
        let mapped = Mapped { face, vertex_errors: VertexErrors::new(face), cells, vertices };
        let tester = Tester { mapped, point_rows, triangle_rows, large, settler };
        workers.resize_with(rayon::current_num_threads(), Worker::default);
        let next = AtomicUsize::new(0);
        workers.par_iter_mut().for_each(|worker| {
            worker.start(members);
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

/// Parts of a range that are no longer than `most`.
fn parts(range: Range<usize>, most: usize) -> impl Iterator<Item = [u32; 2]> {
    let end = range.end;
    range.step_by(most).map(move |first| [first as u32, (first + most).min(end) as u32])
}

/// What testing a job needs to know.
struct Tester<'a> {
    mapped: Mapped<'a>,
    point_rows: &'a [PointRow],
    triangle_rows: &'a [Sorted<u32>],
    large: &'a [(u32, Plane)],
    settler: &'a Settler<'a>,
}

impl Tester<'_> {
    #[inline(always)]
    fn test<S: Simd>(&self, simd: S, worker: &mut Worker, job: &Job) {
        let [first, end] = job.groups.map(|group| group as usize);
        let groups = &self.point_rows[job.row as usize].groups[first..end];
        let [first, end] = job.triangles.map(|triangle| triangle as usize);
        let triangles = &self.triangle_rows[job.row as usize].items()[first..end];
        let indices = self.settler.image.shot.triangles.indices;
        for items in triangles.chunks(LANES) {
            let mut corners = [[u32::MAX; 3]; LANES];
            let mut any_small = false;
            for (corners, &item) in corners.iter_mut().zip(items) {
                if item & LARGE == 0 {
                    *corners = indices[item as usize];
                    any_small = true;
                }
            }
            let small =
                if any_small { worker.batch.set_up(simd, &self.mapped, &corners[..items.len()], 0).small } else { 0 };
            for (lane, &item) in items.iter().enumerate() {
                if item & LARGE != 0 {
                    let (id, plane) = &self.large[(item & !LARGE) as usize];
                    for group in groups {
                        worker.counts.tests += 1;
                        let (certain, possible) = plane.test(simd, &group.points, group.errors);
                        if possible.any_true() {
                            self.note(worker, group, *id, certain.to_bitmask(), possible.to_bitmask());
                        }
                    }
                } else if small >> lane & 1 == 1 {
                    for group in groups {
                        worker.counts.tests += 1;
                        let (certain, possible) = worker.batch.test(simd, lane, &group.points, group.errors);
                        if possible.any_true() {
                            self.note(worker, group, item, certain.to_bitmask(), possible.to_bitmask());
                        }
                    }
                }
            }
            worker.settle_if_many(self.settler);
        }
    }

    /// Notes which points of a group a triangle certainly shadows, of those that it possibly does.
    #[inline(always)]
    fn note(&self, worker: &mut Worker, group: &Group, id: u32, certain: u64, possible: u64) {
        let Worker { shadowed, undecided, counts, .. } = worker;
        for lane in bits_of(possible & ((1 << group.count) - 1)) {
            let index = group.indices[lane];
            let (word, bit) = (index as usize / LANES, index as usize % LANES);
            if shadowed[word] >> bit & 1 == 1 || self.settler.image.seen.triangle[index as usize] == id {
                continue;
            }
            let is_certain = certain >> lane & 1 == 1;
            if is_certain && self.settler.image.shot.shadow_opacity.is_opaque(id) {
                shadowed[word] |= 1 << bit;
            } else {
                counts.undecided += u64::from(!is_certain);
                counts.masked += u64::from(is_certain);
                undecided.push([index, id]);
            }
        }
    }
}
