use super::header::{HEADER_LARGE_GROUPS, HEADER_WORDS};
use crate::link::shared_constants;
use crate::primitives::Scan;
use crate::{Buffer, Gpu, GpuError, Groups, Kernel, Recorder};

/// The stages `count`, `scan` and `scatter`: list the triangles that each cell may need.
#[derive(Debug)]
pub(crate) struct List {
    kernels: ListKernels,
    scan: Scan,
    size: Buffer,
    /// Chunks of triangles over many cells.
    large: Buffer,
    /// Triangles, grouped by cell.
    pairs: Buffer,
    triangles: u32,
}

/// Kernels of the stages `count` and `scatter`.
#[derive(Debug)]
pub(crate) struct ListKernels {
    count_small: Kernel,
    size_large: Kernel,
    count_large: Kernel,
    scatter_small: Kernel,
    scatter_large: Kernel,
}

impl ListKernels {
    /// Compiles them with values for the `override` constants of `list.wgsl`.
    pub(crate) fn new(gpu: &Gpu, constants: &[(&str, f64)]) -> Self {
        let entries = ["count_small", "size_large", "count_large", "scatter_small", "scatter_large"];
        let [count_small, size_large, count_large, scatter_small, scatter_large] =
            Kernel::all(gpu, "grid::list", entries, constants);
        Self { count_small, size_large, count_large, scatter_small, scatter_large }
    }
}

/// Buffers that listing reads and writes besides its own.
#[derive(Clone, Copy)]
pub(crate) struct ListBuffers<'a> {
    pub(crate) spaces: &'a Buffer,
    pub(crate) triangles: &'a Buffer,
    pub(crate) vertices: &'a Buffer,
    /// Counts, then ends, of the cells' lists.
    pub(crate) cells: &'a Buffer,
    pub(crate) header: &'a Buffer,
    /// A copy of the header, for indirect dispatches.
    pub(crate) sizes: &'a Buffer,
    /// For lights, the farthest point of each tile.
    pub(crate) farthest_point: &'a Buffer,
    /// For lights, the column or row of each bin of a face.
    pub(crate) spread: &'a Buffer,
}

shared_constants! { "grid::list":
    /// Words of a chunk.
    LARGE_WORDS: u64 = 16;
}

impl List {
    const LARGE_BYTES: u64 = 4 * LARGE_WORDS;

    pub(crate) fn new(gpu: &Gpu, has_points: bool) -> Self {
        Self {
            kernels: ListKernels::new(gpu, &[("HAS_POINTS", f64::from(u8::from(has_points)))]),
            scan: Scan::new(gpu),
            size: Buffer::uniform(gpu, "list size"),
            large: Buffer::storage(gpu, "large triangles"),
            pairs: Buffer::storage(gpu, "pairs"),
            triangles: 0,
        }
    }

    /// Workgroups for all triangles of one face.
    pub(crate) fn groups_of_one_face(&self) -> Groups<'static> {
        Groups::Flat(self.triangles.div_ceil(256))
    }

    /// Prepares for this many triangles, vertices and cells, with room for a first guess of their needs.
    pub(crate) fn prepare(&mut self, gpu: &Gpu, triangles: u32, vertices: u32, cells: u32) -> Result<(), GpuError> {
        self.triangles = triangles;
        self.size.write(gpu, &[triangles, vertices, 0, 0])?;
        self.scan.prepare(gpu, cells)?;
        let pairs = (2 * u64::from(triangles) + u64::from(cells)).max(1 << 12);
        self.pairs.reserve(gpu, (4 * pairs).min(gpu.max_binding_bytes()))?;
        self.large.reserve(gpu, (1 << 10) * Self::LARGE_BYTES)
    }

    /// Makes room for the needs of a finished frame.
    pub(crate) fn grow(&mut self, gpu: &Gpu, large: u32, pairs: u32) -> Result<(), GpuError> {
        self.large.grow(gpu, u64::from(large) * Self::LARGE_BYTES)?;
        self.pairs.grow(gpu, u64::from(pairs) * 4)
    }

    /// Records the stages, with the list's own kernels or with others that have the same buffers.
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        kernels: Option<&ListKernels>,
        buffers: ListBuffers<'_>,
        groups: Groups<'_>,
        [count, scan, scatter]: [&'static str; 3],
    ) {
        let kernels = kernels.unwrap_or(&self.kernels);
        let ListBuffers { spaces, triangles, vertices, cells, header, sizes, farthest_point, spread } = buffers;
        let all =
            [&self.size, spaces, triangles, vertices, cells, &self.large, header, farthest_point, spread, &self.pairs];
        let large = Groups::Indirect(sizes, HEADER_LARGE_GROUPS);
        recorder.stage(count, |pass| {
            kernels.count_small.dispatch(gpu, pass, &all, groups);
            kernels.size_large.dispatch(gpu, pass, &all, Groups::Flat(1));
        });
        recorder.copy_words(header, sizes, HEADER_WORDS);
        recorder.stage(count, |pass| kernels.count_large.dispatch(gpu, pass, &all, large));
        recorder.stage(scan, |pass| self.scan.record(gpu, pass, cells));
        recorder.stage(scatter, |pass| {
            kernels.scatter_small.dispatch(gpu, pass, &all, groups);
            kernels.scatter_large.dispatch(gpu, pass, &all, large);
        });
    }

    pub(crate) fn pairs(&self) -> &Buffer {
        &self.pairs
    }

    /// Number of pairs that there is room for.
    pub(crate) fn pair_room(&self) -> u64 {
        self.pairs.bytes() / 4
    }

    /// Number of chunks of large triangles that there is room for.
    pub(crate) fn large_room(&self) -> u64 {
        self.large.bytes() / Self::LARGE_BYTES
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.large.bytes() + self.pairs.bytes() + self.scan.totals().bytes()
    }

    /// The buffer and word that hold the number of pairs.
    pub(crate) fn pair_counts(&self) -> (&Buffer, u32) {
        (self.scan.totals(), self.scan.total_word())
    }
}
