use crate::grid::header::{HEADER_BLOCK_GROUPS, HEADER_SPLIT_GROUPS};
use crate::link::shared_constants;
use crate::{Buffer, Gpu, Groups, Kernel};

/// The stages `trace` and `merge`: the triangle that each pixel sees.
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
    /// The word that says whether any pixel sees a triangle when it looks behind.
    NODES_ANY: u64 = 5;
    /// The words of the groups that settle nodes, …
    NODES_GROUPS: u32 = 2;
    /// … and pixels.
    NODES_PIXEL_GROUPS: u32 = 6;
}

impl Trace {
    /// Bytes of a block's partial results: four words for each of 256 pixels.
    const PARTIAL_BYTES: u64 = 4096;

    pub(super) fn new(gpu: &Gpu, mapping: u32) -> Self {
        let constants = [("MAPPING", f64::from(mapping))];
        let [trace, merge, size_settle] =
            Kernel::all(gpu, "camera::trace", ["trace", "merge", "size_settle"], &constants);
        Self { trace, merge, size_settle }
    }

    /// Bytes of the most partial results that this number of pairs can lead to.
    pub(super) fn partial_bytes(pairs: u64) -> u64 {
        // A cut tile has more than 2,048 pairs in one of its sorting tiles, so at most two blocks for each 2,048.
        2 * (pairs / 2048) * Self::PARTIAL_BYTES
    }

    /// Bytes of `nodes` nodes and as many pixels.
    pub(super) fn node_bytes(nodes: u64) -> u64 {
        4 * (NODES_FIRST + nodes * (NODE_WORDS + 1))
    }

    /// `buffers` are in the order of the shader's bindings.
    pub(super) fn record(&self, gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>, buffers: &[&Buffer], sizes: &Buffer) {
        self.trace.dispatch(gpu, pass, buffers, Groups::Indirect(sizes, HEADER_BLOCK_GROUPS));
        self.merge.dispatch(gpu, pass, buffers, Groups::Indirect(sizes, HEADER_SPLIT_GROUPS));
        self.size_settle.dispatch(gpu, pass, buffers, Groups::Flat(1));
    }
}
