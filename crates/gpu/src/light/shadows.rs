use crate::grid::header::BLOCK_GROUPS;
use crate::{Buffer, Geometry, Gpu, GpuError, Groups, Kernel, Recorder};

/// The stages `balance`, `trace` and `settle` of a light: which points have a triangle before them.
#[derive(Debug)]
pub(super) struct Shadows {
    balance: Kernel,
    size_blocks: Kernel,
    trace: Kernel,
    size_settle: Kernel,
    settle: Kernel,
    blocks: Buffer,
    /// What the filter leaves open.
    open: Buffer,
    open_sizes: Buffer,
}

/// Words before the first block, and of a block.
const BLOCKS_HEADER: u64 = 8;
const BLOCK_WORDS: u64 = 12;
/// Words before the first open question.
const OPEN_HEADER: u64 = 8;
/// The word of the groups that settle them.
const OPEN_GROUPS: u32 = 2;

impl Shadows {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self {
            balance: Kernel::new(gpu, "light::balance", "balance", &[]),
            size_blocks: Kernel::new(gpu, "light::balance", "size_blocks", &[]),
            trace: Kernel::new(gpu, "light::trace", "trace", &[]),
            size_settle: Kernel::new(gpu, "light::trace", "size_settle", &[]),
            settle: Kernel::new(gpu, "light::settle", "settle", &[]),
            blocks: Buffer::storage(gpu, "light blocks"),
            open: Buffer::storage(gpu, "open questions"),
            open_sizes: Buffer::sizes(gpu, "light settle dispatch sizes"),
        }
    }

    fn bytes_of_blocks(blocks: u64) -> u64 {
        4 * (BLOCKS_HEADER + BLOCK_WORDS * blocks)
    }

    fn bytes_of_open(open: u64) -> u64 {
        4 * (OPEN_HEADER + 2 * open)
    }

    pub(super) fn prepare(&mut self, gpu: &Gpu, places: u32, cells: u32) -> Result<(), GpuError> {
        self.blocks.reserve(gpu, Self::bytes_of_blocks(u64::from(places / 64) + u64::from(cells)))?;
        self.open.reserve(gpu, Self::bytes_of_open(u64::from(places / 8) + (1 << 10)))?;
        self.open_sizes.reserve(gpu, 4 * OPEN_HEADER)
    }

    /// Makes room for so much.
    pub(super) fn grow(&mut self, gpu: &Gpu, blocks: u32, open: u32) -> Result<(), GpuError> {
        let (blocks, open) = (Self::bytes_of_blocks(blocks.into()), Self::bytes_of_open(open.into()));
        if blocks > self.blocks.bytes() {
            self.blocks.reserve(gpu, (blocks + blocks / 2).min(gpu.max_binding_bytes()).max(blocks))?;
        }
        if open > self.open.bytes() {
            self.open.reserve(gpu, (open + open / 2).min(gpu.max_binding_bytes()).max(open))?;
        }
        Ok(())
    }

    /// For how many blocks, and how many words of open questions, there is room.
    pub(super) fn room(&self) -> (u64, u64) {
        ((self.blocks.bytes() / 4 - BLOCKS_HEADER) / BLOCK_WORDS, self.open.bytes() / 4)
    }

    pub(super) fn record_clear(&self, recorder: &mut Recorder<'_>) {
        recorder.clear_words(&self.open, OPEN_HEADER);
    }

    /// `read` are the light, the ends of triangles and of points, the header and the spread of columns.
    pub(super) fn record_balance(&self, gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>, read: [&Buffer; 5], cells: u32) {
        let [light, triangle_cells, point_cells, header, spread] = read;
        let buffers = [light, triangle_cells, point_cells, header, spread, &self.blocks];
        self.balance.dispatch(gpu, pass, &buffers, Groups::Flat(cells.div_ceil(64)));
        self.size_blocks.dispatch(gpu, pass, &buffers, Groups::Flat(1));
    }

    /// `read` are the light, its spaces, triangles, vertices, points and pairs.
    pub(super) fn record_trace(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::ComputePass<'_>,
        read: [&Buffer; 6],
        lit: &Buffer,
        masks: &Buffer,
        sizes: &Buffer,
    ) {
        let [light, spaces, triangles, vertices, points, pairs] = read;
        let buffers = [light, spaces, triangles, vertices, points, pairs, &self.blocks, lit, &self.open, masks];
        self.trace.dispatch(gpu, pass, &buffers, Groups::Indirect(sizes, BLOCK_GROUPS));
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
        recorder.copy_words(&self.open, &self.open_sizes, OPEN_HEADER);
        let buffers =
            [light, view, geometry.triangles(), geometry.positions(), seen, &self.open, lit, geometry.masks().buffer()];
        recorder.stage("light settle", |pass| {
            self.settle.dispatch(gpu, pass, &buffers, Groups::Indirect(&self.open_sizes, OPEN_GROUPS));
        });
    }

    pub(super) fn open(&self) -> &Buffer {
        &self.open
    }

    pub(super) fn block_bytes(&self) -> u64 {
        self.blocks.bytes()
    }
}
