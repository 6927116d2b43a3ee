//! The paper's own form of the light grid (Guntury and Narayanan 2010, §4), for comparison with the direct form.
//!
//! Points are mapped to cells and sorted by cell. Each triangle is listed in the cells that it covers between the light and
//! the cell's farthest point, in the depth slice of its nearest point. Pairs of a triangle and a cell are sorted by cell,
//! and each cell's points are tested against its triangles, slice by slice, until they are in shadow. A cell with R points
//! makes ⌈R/r⌉ jobs, the paper's blocks (§4.3); one with many triangles makes a multiple of these, which the paper leaves
//! for later. Undecided pairs are settled as in the direct form.
//!
//! A [`LightMap`] maps points and triangles: through faces, as in the direct form, or by two angles all around the light, as
//! in the paper.

mod cells;
mod faces;
mod list;
mod map;
mod options;
mod pass;
mod points;
mod sphere;
mod trace;
mod validate;
mod worker;

use umbrage_rays::shot::{LightMask, SeenImage, SeenPixels, Shot, Work};
use umbrage_rays::{LightCells, LightSource, SimdLevel, debug_some};
use web_time::Instant;

use crate::listed::sorted::Sorted;
use cells::Axis;
use faces::Faces;
use list::ListedRange;
use map::LightMap;
pub use options::{ImpossibleLightCells, LightMapping, ListedLightOptions};
use pass::LightPass;
use points::PointRow;
use sphere::Sphere;
use trace::Job;
use worker::CellWorker;

/// Finds the points seen by the camera that a light reaches, with triangles listed by cell, rebuilt for every frame and
/// light.
///
/// Besides the memory for mapping points, it takes 8 + 8 + 4 bytes for each point on its way to its cell, 20 or more for
/// each point there, and as much for each pair of a triangle and a cell. Keep it and use it again: its memory is reused.
#[derive(Default)]
pub(super) struct ListedLightGrid {
    options: ListedLightOptions,
    pass: LightPass,
    faces: Lists<Faces>,
    sphere: Lists<Sphere>,
}

/// The points and triangles of a face, listed by cell.
struct Lists<M: LightMap> {
    options: ListedLightOptions,
    map: M,
    /// Columns and rows.
    axes: [Axis; 2],
    /// Slices of the points' distances from the light.
    slices: Axis,
    point_bins: Vec<Bins>,
    point_rows: Vec<PointRow<M::Points>>,
    ranges: Vec<ListedRange<M>>,
    triangle_rows: Vec<Sorted<u32>>,
    /// Triangles that were set up when listed, with their ids.
    large: Vec<(u32, M::Large)>,
    jobs: Vec<Job>,
    workers: Vec<CellWorker<M::Batch>>,
}

impl<M: LightMap> Default for Lists<M> {
    fn default() -> Self {
        Self {
            options: ListedLightOptions::DEFAULT,
            map: M::default(),
            axes: [Axis::default(); 2],
            slices: Axis::default(),
            point_bins: Vec::new(),
            point_rows: Vec::new(),
            ranges: Vec::new(),
            triangle_rows: Vec::new(),
            large: Vec::new(),
            jobs: Vec::new(),
            workers: Vec::new(),
        }
    }
}

/// An item in a cell: a point's pixel, or a triangle.
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    /// The column, times the number of slices, and the slice.
    key: u16,
    row: u16,
    item: u32,
}

impl Entry {
    fn key_and_item(&self) -> (usize, u32) {
        (self.key.into(), self.item)
    }
}

/// The entries of one range of points or triangles in cells.
#[derive(Debug, Default)]
struct Bins {
    /// Entries in the order in which they were found.
    unsorted: Vec<Entry>,
    /// Entries sorted by row.
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

    /// The entries of a row.
    fn row(&self, row: usize) -> &[Entry] {
        self.sorted.of(row..row + 1)
    }
}

debug_some!(ListedLightGrid as grid: "options" => grid.options);

impl ListedLightGrid {
    /// An empty grid that uses the instructions of `level`.
    pub(super) fn new(level: SimdLevel, options: ListedLightOptions) -> Self {
        let faces = Lists { options, ..Lists::default() };
        let sphere = Lists { options, ..Lists::default() };
        Self { options, pass: LightPass::new(level), faces, sphere }
    }

    /// Whether a light has angles and the options map it by them.
    fn is_spherical(&self, light: &LightSource) -> bool {
        self.options.map == LightMapping::Spherical && !matches!(light, LightSource::Directional { .. })
    }

    /// Measures the distances of the points, once for all lights.
    pub(super) fn survey(&mut self, shot: &Shot<'_>, seen: &SeenPixels) {
        self.pass.survey.find(shot, seen, self.pass.level);
    }

    /// Finds which points `light` reaches; after a survey.
    pub(super) fn shadow(
        &mut self,
        shot: &Shot<'_>,
        seen: &SeenPixels,
        light: &LightSource,
        mask: &mut LightMask,
    ) -> Work {
        if self.is_spherical(light) {
            self.sphere.shadow(&mut self.pass, shot, seen, light, mask)
        } else {
            self.faces.shadow(&mut self.pass, shot, seen, light, mask)
        }
    }

    /// Finds the cell that each point is in; after a survey.
    pub(super) fn locate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource, cells: &mut LightCells) {
        if self.is_spherical(light) {
            self.sphere.locate(&mut self.pass, shot, seen, light, cells);
        } else {
            self.faces.locate(&mut self.pass, shot, seen, light, cells);
        }
    }

    /// Bytes held; points and triangles share lists.
    pub(super) fn bytes(&self) -> usize {
        self.pass.bytes() + self.faces.bytes() + self.sphere.bytes()
    }

    /// As [`Structure::validate`](umbrage_rays::Structure::validate), for one light; after a survey.
    ///
    /// # Errors
    /// Describes the first fault.
    pub(super) fn validate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource) -> Result<(), String> {
        if self.is_spherical(light) {
            self.sphere.check(&mut self.pass, shot, seen, light)
        } else {
            self.faces.check(&mut self.pass, shot, seen, light)
        }
    }
}

impl<M: LightMap> Lists<M> {
    /// Maps the points to each face of a light, and calls `visit`. Returns false for a degenerate light.
    fn visit_faces(
        &mut self,
        pass: &mut LightPass,
        image: &SeenImage<'_>,
        light: &LightSource,
        mut visit: impl FnMut(&mut Self, &mut LightPass),
    ) -> bool {
        pass.start(image.seen);
        let Some(faces) = self.map.choose(light, &pass.survey, &self.options) else { return false };
        for face in 0..faces {
            let start = Instant::now();
            pass.members.fill(0);
            self.map.map(face, image, pass);
            pass.seconds.map += start.elapsed().as_secs_f64();
            visit(self, pass);
        }
        true
    }

    fn shadow(
        &mut self,
        pass: &mut LightPass,
        shot: &Shot<'_>,
        seen: &SeenPixels,
        light: &LightSource,
        mask: &mut LightMask,
    ) -> Work {
        let image = &SeenImage { shot, seen };
        let settler = pass.settler(image, light);
        let is_light = self.visit_faces(pass, image, light, |lists, pass| {
            let points: u64 = pass.members.iter().map(|members| u64::from(members.count_ones())).sum();
            if points == 0 {
                return;
            }
            pass.counts.points += points;
            pass.counts.faces += 1;
            let mut last = Instant::now();
            let mut lap = |seconds: &mut f64| {
                let now = Instant::now();
                *seconds += (now - std::mem::replace(&mut last, now)).as_secs_f64();
            };
            lists.map.project(shot.triangles.positions, pass.level);
            lap(&mut pass.seconds.project);
            lists.sort_points(pass);
            lap(&mut pass.seconds.points);
            lists.list(pass, shot.triangles, &settler.opacity);
            lap(&mut pass.seconds.list);
            lists.sort_pairs(&mut pass.counts);
            lists.split(&mut pass.counts);
            lap(&mut pass.seconds.sort);
            lists.test(pass, &settler);
            lap(&mut pass.seconds.trace);
            lists.settle(pass, &settler);
            lap(&mut pass.seconds.settle);
        });
        if is_light {
            pass.settle_outliers(&settler);
        }
        pass.finish(shot, seen, light, mask)
    }

    fn locate(
        &mut self,
        pass: &mut LightPass,
        shot: &Shot<'_>,
        seen: &SeenPixels,
        light: &LightSource,
        cells: &mut LightCells,
    ) {
        let image = &SeenImage { shot, seen };
        cells.start(seen.order());
        // A degenerate light has no face.
        self.visit_faces(pass, image, light, |lists, pass| {
            lists.sort_points(pass);
            lists.add_located(cells);
        });
    }

    fn check(
        &mut self,
        pass: &mut LightPass,
        shot: &Shot<'_>,
        seen: &SeenPixels,
        light: &LightSource,
    ) -> Result<(), String> {
        let image = &SeenImage { shot, seen };
        let settler = pass.settler(image, light);
        let mut result = Ok(());
        self.visit_faces(pass, image, light, |lists, pass| {
            if result.is_ok() {
                lists.sort_points(pass);
                lists.map.project(shot.triangles.positions, pass.level);
                lists.list(pass, shot.triangles, &settler.opacity);
                lists.sort_pairs(&mut pass.counts);
                result = lists.validate(&pass.members, &settler);
            }
        });
        result
    }

    fn bytes(&self) -> usize {
        self.map.bytes()
            + self.point_bins.iter().map(Bins::bytes).sum::<usize>()
            + self.point_rows.iter().map(PointRow::bytes).sum::<usize>()
            + self.ranges.iter().map(ListedRange::bytes).sum::<usize>()
            + self.triangle_rows.iter().map(Sorted::bytes).sum::<usize>()
            + self.large.capacity() * size_of::<(u32, M::Large)>()
            + self.jobs.capacity() * size_of::<Job>()
            + self.workers.iter().map(CellWorker::bytes).sum::<usize>()
    }
}
