//! The paper's own form of the light grid (Guntury and Narayanan 2010, §4): what the direct form is compared with.
//!
//! The light's faces and the points on them are found as in the direct form. Then points are sorted by cell, each
//! triangle is listed in the cells that it covers between the light and the cell's farthest point, pairs of a triangle
//! and a cell are sorted by cell, and each cell's points are tested against its triangles. A cell with R points makes
//! ⌈R/r⌉ jobs, the paper's blocks (§4.3); one with many triangles makes as many times more, which the paper leaves for
//! later. The same filter decides as in the direct form, and what it leaves undecided is settled in the same way.

mod cells;
mod list;
mod pass;
mod plane;
mod points;
mod project;
mod small;
mod trace;
mod validate;
mod worker;

use std::time::Instant;

use crate::grids::LightsGrid;
use crate::listed::sorted::Sorted;
use crate::patches::Patches;
use crate::shot::{Bytes, LightMask, SeenPixels, Shot, Work};
use crate::{LightCells, LightSource, SimdLevel};
use cells::{Axis, Cells};
use list::Range;
use pass::LightPass;
use plane::Plane;
use points::PointRow;
use trace::Job;

/// Which points that the camera sees a light reaches, with triangles listed by cell, rebuilt for every frame and light.
///
/// Beside what a [`LightGrid`](crate::LightGrid) takes to map points, 8 + 8 + 4 bytes for each point on its way to its
/// cell, 20 or more for each there, and as much as for a point for each pair of a triangle and a cell. Keep it and use it
/// again: its memory is reused.
#[derive(Default)]
pub struct ListedLightGrid {
    pass: LightPass,
    lists: Lists,
}

/// The points and triangles of a face, listed by cell.
#[derive(Default)]
struct Lists {
    options: ListedLightOptions,
    cells: Cells,
    point_bins: Vec<Bins>,
    point_rows: Vec<PointRow>,
    ranges: Vec<Range>,
    triangle_rows: Vec<Sorted<u32>>,
    /// Triangles that cover many cells or reach around the light, with their ids.
    large: Vec<(u32, Plane)>,
    jobs: Vec<Job>,
}

/// Something in a cell: a point's pixel, or a triangle.
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    column: u16,
    row: u16,
    item: u32,
}

impl Entry {
    fn column_and_item(&self) -> (usize, u32) {
        (self.column.into(), self.item)
    }
}

/// What one range of points or triangles has in cells.
#[derive(Debug, Default)]
struct Bins {
    /// In the order in which they were found.
    unsorted: Vec<Entry>,
    /// Sorted by row.
    sorted: Sorted<Entry>,
}

impl Bins {
    fn bytes(&self) -> usize {
        self.unsorted.capacity() * size_of::<Entry>() + self.sorted.bytes()
    }

    /// Sorts by row.
    fn sort(&mut self, rows: usize) {
        self.sorted.sort(rows, self.unsorted.iter().map(|entry| (entry.row.into(), *entry)));
    }

    /// What is in a row.
    fn row(&self, row: usize) -> &[Entry] {
        self.sorted.of(row..row + 1)
    }
}

debug_some!(ListedLightGrid as grid: "options" => grid.lists.options);

/// The parameters of a [`ListedLightGrid`]: they change how fast it is, and nothing that it finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListedLightOptions {
    side: u32,
    points: u32,
    triangles: u32,
}

impl Default for ListedLightOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl ListedLightOptions {
    /// 192 × 192 cells, 256 points and 512 triangles to a block of work.
    pub const DEFAULT: Self = Self { side: 192, points: 256, triangles: 512 };
    /// The most cells a side.
    pub const MOST_CELLS: u32 = 2048;
    /// The most points, and the most triangles, of a block of work.
    pub const LARGEST_BLOCK: u32 = 4096;

    /// `cells` × `cells` cells (up to [`MOST_CELLS`](Self::MOST_CELLS)²) on each face of the light, and work in blocks
    /// of at most `points`, the paper's r, which is rounded up to a multiple of 16, times `triangles` (both up to
    /// [`LARGEST_BLOCK`](Self::LARGEST_BLOCK)).
    ///
    /// # Errors
    /// If a number is zero or too large.
    pub fn new(cells: u32, points: u32, triangles: u32) -> Result<Self, ImpossibleLightCells> {
        let sizes = 1..=Self::LARGEST_BLOCK;
        if (1..=Self::MOST_CELLS).contains(&cells) && sizes.contains(&points) && sizes.contains(&triangles) {
            Ok(Self { side: cells, points: points.next_multiple_of(crate::simd::lanes::LANES as u32), triangles })
        } else {
            Err(ImpossibleLightCells { cells, points, triangles })
        }
    }

    /// Cells a side of each face.
    #[must_use]
    pub fn cells(&self) -> u32 {
        self.side
    }

    /// The most points of a block of work: the paper's r.
    #[must_use]
    pub fn points(&self) -> u32 {
        self.points
    }

    /// The most triangles of a block of work.
    #[must_use]
    pub fn triangles(&self) -> u32 {
        self.triangles
    }
}

/// Numbers that no [`ListedLightOptions`] can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{cells} light cells a side, blocks of {points} points and {triangles} triangles: there are 1 to {} cells, and 1 to \
     {} points and triangles",
    ListedLightOptions::MOST_CELLS,
    ListedLightOptions::LARGEST_BLOCK
)]
pub struct ImpossibleLightCells {
    /// Cells a side.
    pub cells: u32,
    /// Points of a block of work.
    pub points: u32,
    /// Triangles of a block of work.
    pub triangles: u32,
}

impl ListedLightGrid {
    /// An empty grid that uses the instructions of `level`.
    #[must_use]
    pub fn new(level: SimdLevel, options: ListedLightOptions) -> Self {
        Self { pass: LightPass::new(level), lists: Lists { options, ..Lists::default() } }
    }
}

impl Lists {
    /// Divides a face on which points are wrong by at most `error` evenly into cells.
    fn choose_cells(&mut self, error: f32) {
        let side = Axis { count: self.options.side as usize };
        // With the rounding of sums with it.
        self.cells = Cells { across: side, down: side, margin: error * 1.001 + 2.0 * f32::EPSILON };
    }

    fn bytes(&self) -> usize {
        self.point_bins.iter().map(Bins::bytes).sum::<usize>()
            + self.point_rows.iter().map(PointRow::bytes).sum::<usize>()
            + self.ranges.iter().map(Range::bytes).sum::<usize>()
            + self.triangle_rows.iter().map(Sorted::bytes).sum::<usize>()
            + self.large.capacity() * size_of::<(u32, Plane)>()
            + self.jobs.capacity() * size_of::<Job>()
    }
}

impl LightsGrid for ListedLightGrid {
    fn survey(&mut self, shot: &Shot<'_>, seen: &SeenPixels) {
        self.pass.survey.find(shot, seen, self.pass.level);
    }

    fn shadow(
        &mut self,
        shot: &Shot<'_>,
        _: &Patches,
        seen: &SeenPixels,
        light: &LightSource,
        mask: &mut LightMask,
    ) -> Work {
        let Self { pass, lists } = self;
        pass.shadow(shot, seen, light, mask, |pass, settler| {
            let mut last = Instant::now();
            let mut lap = |seconds: &mut f64| {
                let now = Instant::now();
                *seconds += (now - std::mem::replace(&mut last, now)).as_secs_f64();
            };
            lists.sort_points(pass);
            lap(&mut pass.seconds.points);
            lists.list(pass, shot.triangles, &settler.opacity);
            lap(&mut pass.seconds.list);
            lists.sort_pairs(&mut pass.counts);
            lists.split(&mut pass.counts);
            lap(&mut pass.seconds.sort);
            lists.test(pass, settler);
            lap(&mut pass.seconds.trace);
        })
    }

    fn locate(&mut self, shot: &Shot<'_>, _: &Patches, seen: &SeenPixels, light: &LightSource, cells: &mut LightCells) {
        let Self { pass, lists } = self;
        cells.start(seen.order());
        // A light that is none has no face.
        pass.visit_faces(shot, seen, light, |pass, _| {
            lists.sort_points(pass);
            lists.add_located(pass, cells);
        });
    }

    /// Points and triangles share lists, and so all are counted as the triangles'.
    fn bytes(&self) -> Bytes {
        let Bytes { triangles, points } = self.pass.bytes();
        Bytes { triangles: triangles + points + self.lists.bytes(), points: 0 }
    }

    fn validate(&mut self, shot: &Shot<'_>, _: &Patches, seen: &SeenPixels, light: &LightSource) -> Result<(), String> {
        let Self { pass, lists } = self;
        let mut result = Ok(());
        pass.visit_faces(shot, seen, light, |pass, settler| {
            if result.is_ok() {
                lists.sort_points(pass);
                pass.project(shot.triangles.positions);
                lists.list(pass, shot.triangles, &settler.opacity);
                lists.sort_pairs(&mut pass.counts);
                result = lists.validate(&pass.members, settler);
            }
        });
        result
    }
}
