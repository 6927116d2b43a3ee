use crate::grid::header;
use crate::{Buffer, Gpu, Groups, Kernel};

/// The stages `trace` and `merge`: what each pixel sees.
#[derive(Debug)]
pub(super) struct Trace {
    trace: Kernel,
    merge: Kernel,
    size_settle: Kernel,
}

impl Trace {
    /// Words before the first node.
    pub(super) const NODES_HEADER: u64 = 12;
    /// Words of a node.
    pub(super) const NODE_WORDS: u64 = 5;
    /// The word that says whether any pixel sees what is behind.
    pub(super) const NODES_ANY: u64 = 5;
    /// For each of 256 pixels four words.
    const PARTIAL_BYTES: u64 = 4096;

    pub(super) fn new(gpu: &Gpu, mapping: u32) -> Self {
        let kernel = |entry| Kernel::new(gpu, "camera::trace", entry, &[("MAPPING", f64::from(mapping))]);
        Self { trace: kernel("trace"), merge: kernel("merge"), size_settle: kernel("size_settle") }
    }

    /// Bytes of the partial results that so many pairs can lead to.
    pub(super) fn partial_bytes(pairs: u64) -> u64 {
        // A cut tile has more than 2,048 pairs in one of its sorting tiles, so at most two blocks for each 2,048.
        2 * (pairs / 2048) * Self::PARTIAL_BYTES
    }

    /// Bytes for so many nodes and as many pixels.
    pub(super) fn node_bytes(nodes: u64) -> u64 {
        4 * (Self::NODES_HEADER + nodes * (Self::NODE_WORDS + 1))
    }

    /// `buffers` are the shader's.
    pub(super) fn record(&self, gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>, buffers: &[&Buffer], sizes: &Buffer) {
        self.trace.dispatch(gpu, pass, buffers, Groups::Indirect(sizes, header::BLOCK_GROUPS));
        self.merge.dispatch(gpu, pass, buffers, Groups::Indirect(sizes, header::SPLIT_GROUPS));
        self.size_settle.dispatch(gpu, pass, buffers, Groups::Flat(1));
    }
}
