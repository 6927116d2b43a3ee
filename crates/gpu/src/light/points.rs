use super::sphere::Sphere;
use crate::primitives::Scan;
use crate::{Buffer, Geometry, Gpu, GpuError, Groups, Kernel, Recorder};

/// The stages `survey`, `choose`, `map` and `sort`: find points and their cells in a light's grid.
#[derive(Debug)]
pub(super) struct Points {
    survey: Kernel,
    choose: Kernel,
    map: Kernel,
    spread_columns: Kernel,
    assign: Kernel,
    sort: Kernel,
    scan: Scan,
    /// Position of each slot's point, as three f64.
    points: Buffer,
    /// Bits of slots with points.
    bits: Buffer,
    /// Bounds of all points.
    bounds: Buffer,
    /// Position of each slot's point in the light's grid.
    mapped: Buffer,
    sorted: Buffer,
    /// For each axis of each face the column of cells of each bin, and the first bin of each column.
    spread: Buffer,
    /// Counts, then ends, of the cells' points.
    cells: Buffer,
    /// The farthest point of each tile.
    farthest: Buffer,
    slots: u32,
    cell_count: u32,
}

impl Points {
    /// Bytes for each axis of a face.
    const AXIS_BYTES: u64 = 4 * 4096;

    pub(super) fn new(gpu: &Gpu) -> Self {
        let (survey, map) = rayon::join(
            || Kernel::new(gpu, "light::survey", "survey", &[]),
            || Kernel::new(gpu, "light::map", "map", &[]),
        );
        Self {
            survey,
            choose: Kernel::new(gpu, "light::choose", "choose", &[]),
            map,
            spread_columns: Kernel::new(gpu, "light::spread", "spread_columns", &[]),
            assign: Kernel::new(gpu, "light::assign", "assign", &[]),
            sort: Kernel::new(gpu, "light::sort", "sort", &[]),
            scan: Scan::new(gpu),
            points: Buffer::storage(gpu, "points"),
            bits: Buffer::storage(gpu, "slots with points"),
            bounds: Buffer::storage(gpu, "bounds"),
            mapped: Buffer::storage(gpu, "mapped points"),
            sorted: Buffer::storage(gpu, "sorted points"),
            spread: Buffer::storage(gpu, "spread of columns"),
            cells: Buffer::storage(gpu, "cells of points"),
            farthest: Buffer::storage(gpu, "farthest points"),
            slots: 0,
            cell_count: 0,
        }
    }

    pub(super) fn prepare(&mut self, gpu: &Gpu, slots: u32, cell_count: u32) -> Result<(), GpuError> {
        (self.slots, self.cell_count) = (slots, cell_count);
        let (slots, cells) = (u64::from(slots), u64::from(cell_count));
        self.points.reserve(gpu, 24 * slots)?;
        self.bits.reserve(gpu, slots / 8)?;
        self.bounds.reserve(gpu, 32)?;
        self.mapped.reserve(gpu, 16 * slots)?;
        self.sorted.reserve(gpu, 20 * slots)?;
        self.spread.reserve(gpu, 12 * Self::AXIS_BYTES)?;
        self.cells.reserve(gpu, 4 * cells)?;
        self.farthest.reserve(gpu, 4 * cells)?;
        self.scan.prepare(gpu, cell_count)
    }

    pub(super) fn record_survey(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        view: &Buffer,
        geometry: &Geometry,
        seen: &Buffer,
    ) {
        recorder.clear(&self.bounds);
        let buffers = [view, geometry.triangles(), geometry.positions(), seen, &self.points, &self.bits, &self.bounds];
        let groups = Groups::Flat(self.slots.div_ceil(256));
        recorder.stage("survey", |pass| self.survey.dispatch(gpu, pass, &buffers, groups));
    }

    pub(super) fn record_choose(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        light: &Buffer,
        spaces: &Buffer,
        header: &Buffer,
        sphere: Option<&Sphere>,
    ) {
        let buffers = [light, &self.bounds, spaces, header];
        let choose = sphere.map_or(&self.choose, |sphere| &sphere.choose);
        recorder.stage("choose", |pass| choose.dispatch(gpu, pass, &buffers, Groups::Flat(1)));
    }

    pub(super) fn record_sort(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        [light, spaces, header]: [&Buffer; 3],
        [seen, lit, undecided]: [&Buffer; 3],
        sphere: Option<&Sphere>,
    ) {
        let Self { points, mapped, sorted, spread, cells, farthest, .. } = self;
        recorder.clear(spread);
        recorder.clear_words(cells, u64::from(self.cell_count));
        recorder.clear_words(farthest, u64::from(self.cell_count));
        let map = [light, spaces, header, lit, points, mapped, spread, undecided];
        let groups = Groups::Flat(self.slots.div_ceil(64));
        recorder.stage("map", |pass| match sphere {
            None => self.map.dispatch(gpu, pass, &map, groups),
            Some(sphere) => {
                sphere.map.dispatch(gpu, pass, &map, groups);
                sphere.bin.dispatch(gpu, pass, &map, groups);
            }
        });
        recorder.stage("spread", |pass| {
            self.spread_columns.dispatch(gpu, pass, &[light, header, spread], Groups::Flat(12));
        });
        let groups = Groups::Flat(self.slots.div_ceil(256));
        recorder.stage("sort", |pass| {
            self.assign.dispatch(gpu, pass, &[light, header, spread, mapped, cells, farthest], groups);
            self.scan.record(gpu, pass, cells);
            let sort = sphere.map_or(&self.sort, |sphere| &sphere.sort);
            sort.dispatch(gpu, pass, &[light, mapped, cells, sorted, seen, points, spaces], groups);
        });
    }

    pub(super) fn spread(&self) -> &Buffer {
        &self.spread
    }

    pub(super) fn bits(&self) -> &Buffer {
        &self.bits
    }

    pub(super) fn sorted(&self) -> &Buffer {
        &self.sorted
    }

    pub(super) fn cells(&self) -> &Buffer {
        &self.cells
    }

    pub(super) fn farthest(&self) -> &Buffer {
        &self.farthest
    }

    pub(super) fn bytes(&self) -> u64 {
        let buffers = [&self.points, &self.bits, &self.mapped, &self.sorted, &self.cells, &self.farthest];
        buffers.into_iter().map(Buffer::bytes).sum()
    }
}
