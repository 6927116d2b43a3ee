use crate::grid::header::{HEADER_BLOCK_GROUPS, HEADER_SPLIT_GROUPS};
use crate::link::shared_constants;
use crate::{Buffer, Gpu, Groups, Kernel};

/// The stages `trace` and `merge`: what each pixel sees.
#[derive(Debug)]
pub(super) struct Trace {
    trace: Kernel,
    merge: Kernel,
    size_settle: Kernel,
}

shared_constants! { "camera::trace":
    /// Words before the first node.
    NODES_FIRST: u64 = 12;
    /// Words of a node.
    NODE_WORDS: u64 = 5;
    /// The word that says whether any pixel sees what is behind.
    NODES_ANY: u64 = 5;
    /// The words of the groups that settle nodes, …
    NODES_GROUPS: u32 = 2;
    /// … and pixels.
    NODES_PIXEL_GROUPS: u32 = 6;
}

impl Trace {
    /// For each of 256 pixels four words.
    const PARTIAL_BYTES: u64 = 4096;

    pub(super) fn new(gpu: &Gpu, mapping: u32) -> Self {
        let constants = [("MAPPING", f64::from(mapping))];
        let [trace, merge, size_settle] =
            Kernel::all(gpu, "camera::trace", ["trace", "merge", "size_settle"], &constants);
        Self { trace, merge, size_settle }
    }

    /// Bytes of the partial results that so many pairs can lead to.
    pub(super) fn partial_bytes(pairs: u64) -> u64 {
        // A cut tile has more than 2,048 pairs in one of its sorting tiles, so at most two blocks for each 2,048.
        2 * (pairs / 2048) * Self::PARTIAL_BYTES
    }

    /// Bytes for so many nodes and as many pixels.
    pub(super) fn node_bytes(nodes: u64) -> u64 {
        4 * (NODES_FIRST + nodes * (NODE_WORDS + 1))
    }

    /// `buffers` are the shader's.
    pub(super) fn record(&self, gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>, buffers: &[&Buffer], sizes: &Buffer) {
        self.trace.dispatch(gpu, pass, buffers, Groups::Indirect(sizes, HEADER_BLOCK_GROUPS));
        self.merge.dispatch(gpu, pass, buffers, Groups::Indirect(sizes, HEADER_SPLIT_GROUPS));
        self.size_settle.dispatch(gpu, pass, buffers, Groups::Flat(1));
    }
}
