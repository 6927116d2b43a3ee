use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch};
use rayon::prelude::*;

use super::ListedLightGrid;
use super::points::{Group, PointRow};
use super::sort::SortedRow;
use crate::LightSource;
use crate::light_grid::choose;
use crate::light_grid::face::{Face, VertexErrors};
use crate::light_grid::large::Plane;
use crate::light_grid::settle::Judge;
use crate::light_grid::small::Mapped;
use crate::light_grid::trace::{MOST_UNDECIDED, Worker};
use crate::shot::{Counts, LightMask, Seconds, SeenImage, SeenPixels, Shot, TileOrder};
use crate::simd::vectors::LANES;

/// Marks items of cells that count large triangles rather than being a triangle's id.
pub(super) const LARGE: u32 = 1 << 31;

/// Some points of a cell, and some triangles, that one thread tests against each other (§4.3).
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    row: u32,
    /// First and last but one among the row's groups.
    groups: [u32; 2],
    /// First and last but one among the row's triangles.
    triangles: [u32; 2],
}

impl ListedLightGrid {
    /// Finds which points are lit by `light`: what [`LightGrid::shadow`](crate::LightGrid::shadow) finds, bit for bit.
    ///
    /// # Panics
    /// If `survey` wasn't called for `seen`.
    pub(crate) fn shadow(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource, mask: &mut LightMask) {
        let image = SeenImage { shot, seen };
        let pixels = seen.triangle.len();
        assert!(self.grid.survey.places == pixels, "another image was surveyed");
        mask.resize(seen.order());
        let words = pixels / TileOrder::BLOCK_PIXELS;
        self.counts = Counts::default();
        self.seconds = Seconds { survey: self.grid.seconds.survey, ..Seconds::default() };
        self.grid.counts = Counts::default();
        self.grid.seconds = self.seconds;
        self.grid.shadowed.clear();
        self.grid.shadowed.resize(words, 0);
        self.grid.outliers.clear();
        let mut faces = std::mem::take(&mut self.grid.faces);
        let (rays, level) = (self.grid.survey.rays, self.grid.level);
        if choose::choose(light, &rays, &self.grid.survey.tiles, &mut faces).is_some() {
            let judge = Judge { image, rays, light, level };
            for face in &faces {
                self.shadow_face(*face, &judge);
            }
            self.grid.settle_outliers(&judge);
            self.counts.outliers = self.grid.counts.outliers;
            self.counts.settled += self.grid.counts.settled;
        }
        self.grid.faces = faces;
        self.grid.light_the_rest(seen, mask.blocks_mut());
    }

    /// Shadows the points of a face.
    fn shadow_face(&mut self, face: Face, judge: &Judge<'_>) {
        let mut clock = Instant::now();
        let mut lap = |seconds: &mut f64| {
            let now = Instant::now();
            *seconds += (now - clock).as_secs_f64();
            clock = now;
        };
        let grid = &mut self.grid;
        grid.face = face;
        grid.face.choose_point_error(&grid.survey.rays, &grid.survey.tiles);
        // The direct form's cells, which mapping needs.
        grid.spread(&judge.image);
        grid.map(&judge.image);
        grid.slabs.iter().for_each(|slab| grid.outliers.extend_from_slice(&slab.outliers));
        let points: u64 = grid.slabs.iter().map(|slab| u64::from(slab.points)).sum();
        lap(&mut self.seconds.map);
        self.sort_points();
        lap(&mut self.seconds.points);
        if points == 0 {
            return;
        }
        self.counts.points += points;
        self.counts.faces += 1;
        self.grid.project(judge.image.shot.triangles.positions);
        lap(&mut self.seconds.project);
        self.list(judge.image.shot.triangles);
        lap(&mut self.seconds.list);
        self.sort_pairs();
        self.split();
        lap(&mut self.seconds.sort);
        self.test_blocks(judge);
        lap(&mut self.seconds.trace);
        self.grid.settle(judge);
        self.grid.merge_shadows();
        for worker in &self.grid.workers {
            self.counts += worker.counts;
        }
        lap(&mut self.seconds.settle);
    }

    /// Splits cells into blocks of at most as many points and triangles as the options say: boundaries between cells
    /// are the paper's hard ones, others its soft ones.
    fn split(&mut self) {
        let Self { options, cells, point_rows, triangle_rows, blocks, counts, .. } = self;
        let (points, triangles) = (options.points as usize / LANES, options.triangles as usize);
        blocks.clear();
        for (row, (in_points, in_triangles)) in point_rows.iter().zip(&*triangle_rows).enumerate() {
            for column in 0..cells.across.count {
                let groups = in_points.of_cell(column);
                counts.cells += u64::from(!groups.is_empty());
                for groups in parts(groups, points) {
                    for triangles in parts(in_triangles.range(column), triangles) {
                        blocks.push(Block { row: row as u32, groups, triangles });
                    }
                }
            }
        }
        counts.blocks += blocks.len() as u64;
    }

    /// Tests each block's points against its triangles.
    fn test_blocks(&mut self, judge: &Judge<'_>) {
        const TAKEN_AT_ONCE: usize = 16;
        let Self { grid, cells, point_rows, triangle_rows, large, blocks, .. } = self;
        let level = grid.level.0;
        let vertex_errors = VertexErrors::new(&grid.face);
        let mapped = Mapped { face: &grid.face, vertex_errors, cells, vertices: &grid.vertices };
        let tester = Tester { mapped, point_rows, triangle_rows, large, judge };
        let members = &grid.members;
        grid.workers.resize_with(rayon::current_num_threads(), Worker::default);
        let next = AtomicUsize::new(0);
        grid.workers.par_iter_mut().for_each(|worker| {
            worker.shadowed.clear();
            worker.shadowed.extend(members.iter().map(|members| !members));
            worker.undecided.clear();
            worker.undecided.reserve_exact(MOST_UNDECIDED + LANES);
            worker.counts = Counts::default();
            loop {
                let first = next.fetch_add(TAKEN_AT_ONCE, Ordering::Relaxed);
                if first >= blocks.len() {
                    break;
                }
                let blocks = &blocks[first..(first + TAKEN_AT_ONCE).min(blocks.len())];
                dispatch!(level, simd => blocks.iter().for_each(
                    #[inline(always)]
                    |block| tester.test(simd, worker, block),
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

/// What testing a block needs to know.
struct Tester<'a> {
    mapped: Mapped<'a>,
    point_rows: &'a [PointRow],
    triangle_rows: &'a [SortedRow],
    large: &'a [(u32, Plane)],
    judge: &'a Judge<'a>,
}

impl Tester<'_> {
    #[inline(always)]
    fn test<S: Simd>(&self, simd: S, worker: &mut Worker, block: &Block) {
        let [first, end] = block.groups.map(|group| group as usize);
        let groups = &self.point_rows[block.row as usize].groups[first..end];
        let [first, end] = block.triangles.map(|triangle| triangle as usize);
        let triangles = &self.triangle_rows[block.row as usize].items()[first..end];
        let indices = self.judge.image.shot.triangles.indices;
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
            if worker.undecided.len() >= MOST_UNDECIDED {
                worker.counts.settled += self.judge.settle(&worker.undecided, &mut worker.shadowed);
                worker.undecided.clear();
            }
        }
    }

    /// Notes which points of a group a triangle certainly shadows, of those that it possibly does.
    #[inline(always)]
    fn note(&self, worker: &mut Worker, group: &Group, id: u32, certain: u64, possible: u64) {
        let Worker { shadowed, undecided, counts, .. } = worker;
        let mut possible = possible & ((1 << group.count) - 1);
        while possible != 0 {
            let lane = possible.trailing_zeros() as usize % LANES;
            possible &= possible - 1;
            let place = group.places[lane];
            let (word, bit) = (place as usize / LANES, place as usize % LANES);
            if shadowed[word] >> bit & 1 == 1 || self.judge.image.seen.triangle[place as usize] == id {
                continue;
            }
            let is_certain = certain >> lane & 1 == 1;
            if is_certain && self.judge.image.shot.shadow_opacity.is_opaque(id) {
                shadowed[word] |= 1 << bit;
            } else {
                counts.undecided += u64::from(!is_certain);
                counts.masked += u64::from(is_certain);
                undecided.push([place, id]);
            }
        }
    }
}
