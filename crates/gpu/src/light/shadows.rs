use super::sphere::Sphere;
use crate::grid::header::HEADER_BLOCK_GROUPS;
use crate::link::shared_constants;
use crate::{Buffer, Geometry, Gpu, GpuError, Groups, Kernel, Recorder};

/// The stages `cone`, `balance`, `trace` and `settle` of a light: find the points that triangles shadow.
#[derive(Debug)]
pub(super) struct Shadows {
    cone: Kernel,
    balance: Kernel,
    size_blocks: Kernel,
    trace: Kernel,
    size_settle: Kernel,
    settle: Kernel,
    blocks: Buffer,
    /// Undecided pairs of a point and a triangle.
    undecided: Buffer,
    undecided_sizes: Buffer,
}

shared_constants! { "light::trace":
    /// Words before the first block.
    LIGHT_BLOCKS_FIRST: u64 = 8;
    /// Words of a block.
    LIGHT_BLOCK_WORDS: u64 = 12;
    /// Words before the first undecided pair.
    UNDECIDED_FIRST: u64 = 8;
    /// The word of the workgroups that settle them.
    UNDECIDED_GROUPS: u32 = 2;
}

impl Shadows {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let [balance, size_blocks] = Kernel::all(gpu, "light::balance", ["balance", "size_blocks"], &[]);
        let [trace, size_settle] = Kernel::all(gpu, "light::trace", ["trace", "size_settle"], &[]);
        let (settle, cone) = rayon::join(
            || Kernel::new(gpu, "light::settle", "settle", &[]),
            || Kernel::new(gpu, "light::cone", "cone", &[]),
        );
        Self {
            cone,
            balance,
            size_blocks,
            trace,
            size_settle,
            settle,
            blocks: Buffer::storage(gpu, "light blocks"),
            undecided: Buffer::storage(gpu, "undecided pairs"),
            undecided_sizes: Buffer::sizes(gpu, "light settle dispatch sizes"),
        }
    }

    fn bytes_of_blocks(blocks: u64) -> u64 {
        4 * (LIGHT_BLOCKS_FIRST + LIGHT_BLOCK_WORDS * blocks)
    }

    fn bytes_of_undecided(undecided: u64) -> u64 {
        4 * (UNDECIDED_FIRST + 2 * undecided)
    }

    pub(super) fn prepare(&mut self, gpu: &Gpu, slots: u32, cells: u32) -> Result<(), GpuError> {
        self.blocks.reserve(gpu, Self::bytes_of_blocks(u64::from(slots / 64) + u64::from(cells)))?;
        self.undecided.reserve(gpu, Self::bytes_of_undecided(u64::from(slots / 8) + (1 << 10)))?;
        self.undecided_sizes.reserve(gpu, 4 * UNDECIDED_FIRST)
    }

    /// Makes room for this many blocks and undecided pairs.
    pub(super) fn grow(&mut self, gpu: &Gpu, blocks: u32, undecided: u32) -> Result<(), GpuError> {
        self.blocks.grow(gpu, Self::bytes_of_blocks(blocks.into()))?;
        self.undecided.grow(gpu, Self::bytes_of_undecided(undecided.into()))
    }

    /// Number of blocks, and of words of undecided pairs, that there is room for.
    pub(super) fn room(&self) -> (u64, u64) {
        ((self.blocks.bytes() / 4 - LIGHT_BLOCKS_FIRST) / LIGHT_BLOCK_WORDS, self.undecided.bytes() / 4)
    }

    pub(super) fn record_clear(&self, recorder: &mut Recorder<'_>) {
        recorder.clear_words(&self.undecided, UNDECIDED_FIRST);
    }

    /// Records the stage `cone`, for a light that has a cone.
    pub(super) fn record_cone(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        [light, view]: [&Buffer; 2],
        geometry: &Geometry,
        seen: &Buffer,
        (lit, slots): (&Buffer, u32),
    ) {
        let buffers = [light, view, geometry.triangles(), geometry.positions(), seen, lit];
        let groups = Groups::Flat(slots.div_ceil(64));
        recorder.stage("light cone", |pass| self.cone.dispatch(gpu, pass, &buffers, groups));
    }

    /// `read` are the light, the ends of triangles and of points, the header and the spread of columns.
    pub(super) fn record_balance(&self, gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>, read: [&Buffer; 5], tiles: u32) {
        let [light, triangle_cells, point_cells, header, spread] = read;
        let buffers = [light, triangle_cells, point_cells, header, spread, &self.blocks];
        self.balance.dispatch(gpu, pass, &buffers, Groups::Flat(tiles.div_ceil(64)));
        self.size_blocks.dispatch(gpu, pass, &buffers, Groups::Flat(1));
    }

    /// `read` are the light, its spaces, triangles, vertices, points and pairs.
    pub(super) fn record_trace(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::ComputePass<'_>,
        read: [&Buffer; 6],
        [lit, masks, sizes]: [&Buffer; 3],
        sphere: Option<&Sphere>,
    ) {
        let trace = sphere.map_or(&self.trace, |sphere| &sphere.trace);
        let [light, spaces, triangles, vertices, points, pairs] = read;
        let buffers = [light, spaces, triangles, vertices, points, pairs, &self.blocks, lit, &self.undecided, masks];
        trace.dispatch(gpu, pass, &buffers, Groups::Indirect(sizes, HEADER_BLOCK_GROUPS));
        self.size_settle.dispatch(gpu, pass, &buffers, Groups::Flat(1));
    }

    pub(super) fn record_settle(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        [light, view]: [&Buffer; 2],
        geometry: &Geometry,
        seen: &Buffer,
        lit: &Buffer,
    ) {
        recorder.copy_words(&self.undecided, &self.undecided_sizes, UNDECIDED_FIRST);
        let buffers = [
            light,
            view,
            geometry.triangles(),
            geometry.positions(),
            seen,
            &self.undecided,
            lit,
            geometry.masks().buffer(),
        ];
        recorder.stage("light settle", |pass| {
            self.settle.dispatch(gpu, pass, &buffers, Groups::Indirect(&self.undecided_sizes, UNDECIDED_GROUPS));
        });
    }

    pub(super) fn undecided(&self) -> &Buffer {
        &self.undecided
    }

    pub(super) fn block_bytes(&self) -> u64 {
        self.blocks.bytes()
    }
}
