//! The camera's grid, rebuilt for every frame: `project`, `count`, `scan`, `scatter`, `balance`, `trace`, `settle`.

mod balance;
mod settle;
mod trace;

use glam::DVec2;

use crate::fit::{NEEDS_PAIRS, NEEDS_UNDECIDED, NEEDS_WORDS, Needs, Room};
use crate::grid::header::HEADER_WORDS;
use crate::grid::{List, ListBuffers, Project, Space};
use crate::{Band, Buffer, Done, Fetch, Geometry, Gpu, GpuError, Recorder};
use balance::Balance;
use settle::Settle;
use trace::{NODE_WORDS, NODES_ANY, NODES_FIRST, Trace};

/// Cells of the camera's grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CameraOptions {
    /// Sorting tiles on each axis of a tracing tile, which always has 16×16 pixels: 1 or 2.
    pub mapping: u32,
    /// Depth slices of a tile, 1 or more.
    pub slices: u32,
}

impl Default for CameraOptions {
    fn default() -> Self {
        Self { mapping: 1, slices: 8 }
    }
}

/// The hit to find along each pixel's ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sight {
    /// Whether a pixel gets the nearest triangle behind the one that [`CameraGrid::seen`] has for it, instead of the
    /// nearest of all. Pixels without a triangle there stay without one.
    pub is_behind: bool,
}

/// Counts of a camera frame's work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CameraWork {
    /// Pairs of a triangle and a cell.
    pub pairs: u32,
    /// Chunks of triangles over many cells.
    pub large: u32,
    /// Hits that were left to the predicate.
    pub undecided_hits: u32,
    /// Pixels with such hits.
    pub undecided_pixels: u32,
}

/// The triangle that each pixel of a camera sees, found through a grid made for its rays.
#[derive(Debug)]
pub struct CameraGrid {
    options: CameraOptions,
    project: Project,
    list: List,
    balance: Balance,
    trace: Trace,
    settle: Settle,
    spaces: Buffer,
    space: Buffer,
    header: Buffer,
    sizes: Buffer,
    /// Counts, then ends, of the cells' lists; after these the blocks of work.
    cells: Buffer,
    /// Cameras have no points.
    no_points: Buffer,
    /// The triangle of each pixel, in [`TileOrder`](umbrage_rays::TileOrder).
    seen: Buffer,
    /// The triangles that pixels showed before, kept for [`Sight::is_behind`].
    front: Buffer,
    /// Hits that the filter leaves undecided.
    nodes: Buffer,
    /// The frame's needs, one record.
    needs: Buffer,
    fetch: Fetch,
    cell_count: u32,
    slots: u64,
    is_behind: bool,
    sees_any: bool,
    work: CameraWork,
}

impl CameraGrid {
    /// Compiles the stages.
    #[must_use]
    pub fn new(gpu: &Gpu, options: CameraOptions) -> Self {
        let (settle, (project, trace)) =
            rayon::join(|| Settle::new(gpu), || rayon::join(|| Project::new(gpu), || Trace::new(gpu, options.mapping)));
        Self {
            options,
            project,
            list: List::new(gpu, false),
            balance: Balance::new(gpu, options.mapping),
            trace,
            settle,
            spaces: Buffer::storage(gpu, "spaces"),
            space: Buffer::uniform(gpu, "space"),
            header: Buffer::storage(gpu, "camera header"),
            sizes: Buffer::sizes(gpu, "camera dispatch sizes"),
            cells: Buffer::storage(gpu, "cells"),
            no_points: Buffer::storage(gpu, "no points"),
            seen: Buffer::storage(gpu, "seen"),
            front: Buffer::storage(gpu, "seen before"),
            nodes: Buffer::storage(gpu, "nodes"),
            needs: Buffer::storage(gpu, "camera needs"),
            fetch: Fetch::default(),
            cell_count: 0,
            slots: 0,
            is_behind: false,
            sees_any: false,
            work: CameraWork::default(),
        }
    }

    /// Cuts the next frames' grids into other cells. Another mapping is compiled anew.
    pub fn set_options(&mut self, gpu: &Gpu, options: CameraOptions) {
        if options.mapping != self.options.mapping {
            self.balance = Balance::new(gpu, options.mapping);
            self.trace = Trace::new(gpu, options.mapping);
        }
        self.options = options;
    }

    /// Prepares a frame of some or all rows of an image: parameters and room.
    ///
    /// # Errors
    /// If a stage needs more bytes than one buffer of the device can have.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        geometry: &Geometry,
        band: impl Into<Band>,
        offset_pixels: DVec2,
        sight: Sight,
    ) -> Result<(), GpuError> {
        let CameraOptions { mapping, slices } = self.options;
        let tile_bits = 4 - mapping.trailing_zeros();
        let band = band.into();
        let mut space = Space::of_band(&band, offset_pixels, tile_bits, slices);
        space.raster.sees_behind = u32::from(sight.is_behind);
        self.cell_count = space.cells();
        self.spaces.reserve(gpu, 6 * Space::BYTES)?;
        self.spaces.write(gpu, &[space])?;
        self.space.write(gpu, &[space])?;
        self.header.reserve(gpu, 4 * HEADER_WORDS)?;
        self.sizes.reserve(gpu, 4 * HEADER_WORDS)?;
        self.needs.reserve(gpu, 4 * NEEDS_WORDS)?;
        self.project.prepare(gpu, geometry.vertex_count(), 1)?;
        self.list.prepare(gpu, geometry.triangle_count(), geometry.vertex_count(), self.cell_count)?;
        self.balance.prepare(&space);
        let blocks = Balance::most_blocks(&space, self.list.pair_room());
        self.cells.reserve(gpu, 4 * u64::from(self.cell_count) + Balance::block_bytes(blocks))?;
        self.is_behind = sight.is_behind;
        self.slots = band.order().slots() as u64;
        self.seen.reserve(gpu, 4 * self.slots + Trace::partial_bytes(self.list.pair_room()))?;
        let pixels = u64::from(band.size()[0]) * u64::from(band.size()[1]);
        self.nodes.reserve(gpu, Trace::node_bytes(pixels / 16 + (1 << 10)))?;
        self.settle.prepare(gpu, &band, offset_pixels)
    }

    /// Records all stages.
    pub fn record(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, geometry: &Geometry) {
        recorder.clear(&self.header);
        recorder.clear_words(&self.cells, u64::from(self.cell_count));
        recorder.clear_words(&self.nodes, NODES_FIRST);
        if self.is_behind {
            recorder.copy_words(&self.front, &self.seen, self.slots);
        }
        recorder.stage("project", |pass| {
            self.project.record(
                gpu,
                pass,
                None,
                [&self.spaces, geometry.positions(), &self.header],
                self.project.groups_of_one_face(),
            );
        });
        let buffers = ListBuffers {
            spaces: &self.spaces,
            triangles: geometry.triangles(),
            vertices: self.project.vertices(),
            cells: &self.cells,
            header: &self.header,
            sizes: &self.sizes,
            farthest_point: &self.no_points,
            spread: &self.no_points,
        };
        let groups = self.list.groups_of_one_face();
        self.list.record(gpu, recorder, None, buffers, groups, ["count", "scan", "scatter"]);
        recorder.stage("balance", |pass| self.balance.record(gpu, pass, &self.space, &self.cells, &self.header));
        recorder.copy_words(&self.header, &self.sizes, HEADER_WORDS);
        let vertices = self.project.vertices();
        let traced = [
            &self.space,
            geometry.triangles(),
            vertices,
            geometry.positions(),
            &self.cells,
            self.list.pairs(),
            &self.seen,
            &self.nodes,
            geometry.masks().buffer(),
        ];
        recorder.stage("trace", |pass| self.trace.record(gpu, pass, &traced, &self.sizes));
        self.settle.record(gpu, recorder, geometry, &self.seen, &self.nodes);

        recorder.copy_words(&self.header, &self.needs, HEADER_WORDS);
        let (pair_counts, word) = self.list.pair_counts();
        recorder.copy_range((pair_counts, u64::from(word)), (&self.needs, NEEDS_PAIRS), 1);
        recorder.copy_range((&self.nodes, 0), (&self.needs, NEEDS_UNDECIDED), 2);
        recorder.copy_range((&self.nodes, NODES_ANY), (&self.needs, NEEDS_PAIRS + 3), 1);
        self.fetch = recorder.fetch(&self.needs, NEEDS_WORDS);
    }

    /// The frame's record of needs, on the GPU.
    pub(crate) fn needs(&self) -> &Buffer {
        &self.needs
    }

    /// Capacities of the buffers.
    pub(crate) fn room(&self) -> Room {
        let at_most = |room: u64| room.min(u64::from(u32::MAX)) as u32;
        Room {
            large: at_most(self.list.large_room()),
            pairs: at_most(self.list.pair_room()),
            // Always enough: the buffer is sized for the most blocks that the pairs can lead to.
            blocks: u32::MAX,
            faces: 1,
            undecided_words: at_most(self.nodes.bytes() / 4),
            words_per_undecided: NODE_WORDS as u32,
            words_per_pixel: 1,
            undecided_header: NODES_FIRST as u32,
        }
    }

    /// Keeps the triangles that pixels show, for a next frame that looks [behind](Sight::is_behind) them.
    ///
    /// # Errors
    /// If it needs more bytes than one buffer of the device can have.
    pub fn keep(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>) -> Result<(), GpuError> {
        self.front.reserve(gpu, 4 * self.slots)?;
        recorder.copy_words(&self.seen, &self.front, self.slots);
        Ok(())
    }

    /// Whether any pixel of the last finished frame, one that looked behind, saw a triangle.
    #[must_use]
    pub fn sees_any(&self) -> bool {
        self.sees_any
    }

    /// Reads the needs of a frame that is done. If they exceed the room there was, makes more and returns `false`: the
    /// frame has to be rendered again.
    ///
    /// # Errors
    /// If the device is lost, or a buffer would need more bytes than the device allows.
    pub fn finish(&mut self, gpu: &Gpu, done: &Done) -> Result<bool, GpuError> {
        let needs = Needs::from_words(&done.read::<u32>(self.fetch)?);
        let Needs { large, pairs, undecided: undecided_hits, pixels: undecided_pixels, any, .. } = needs;
        self.sees_any = any != 0;
        self.work = CameraWork { pairs, large, undecided_hits, undecided_pixels };
        let fits = self.room().holds(&needs);
        if !fits {
            self.list.grow(gpu, large, pairs)?;
            let nodes = Trace::node_bytes(u64::from(undecided_hits)) + 4 * u64::from(undecided_pixels);
            self.nodes.grow(gpu, nodes)?;
        }
        Ok(fits)
    }

    /// Counts of the last finished frame's work.
    #[must_use]
    pub fn work(&self) -> CameraWork {
        self.work
    }

    /// The triangle that each pixel shows, one u32 in
    /// [`TileOrder`](umbrage_rays::TileOrder), or [`SeenPixels::NONE`].
    ///
    /// [`SeenPixels::NONE`]: umbrage_rays::SeenPixels::NONE
    #[must_use]
    pub fn seen(&self) -> &Buffer {
        &self.seen
    }

    /// Number of slots of [`CameraGrid::seen`].
    #[must_use]
    pub fn slots(&self) -> u64 {
        self.slots
    }

    /// Bytes on the GPU for triangles.
    #[must_use]
    pub fn structure_bytes(&self) -> u64 {
        self.project.vertices().bytes() + self.list.bytes() + self.cells.bytes()
    }

    /// Bytes on the GPU for pixels.
    #[must_use]
    pub fn pixel_bytes(&self) -> u64 {
        self.seen.bytes() + self.front.bytes() + self.nodes.bytes()
    }
}
