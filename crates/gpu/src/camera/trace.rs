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
    /// The words of the groups that settle nodes, then pixels.
    pub(super) const NODE_GROUPS: u32 = 2;
    pub(super) const PIXEL_GROUPS: u32 = 6;
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
        4 * (Self::NODES_HEADER + nodes * (Self::NODE_WORDS + 1))
    }

    /// `buffers` are the shader's.
    pub(super) fn record(&self, gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>, buffers: &[&Buffer], sizes: &Buffer) {
        self.trace.dispatch(gpu, pass, buffers, Groups::Indirect(sizes, header::BLOCK_GROUPS));
        self.merge.dispatch(gpu, pass, buffers, Groups::Indirect(sizes, header::SPLIT_GROUPS));
        self.size_settle.dispatch(gpu, pass, buffers, Groups::Flat(1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{module, other_constants};
    use crate::link::link;

    #[test]
    fn nodes_are_those_of_the_shaders() {
        let constants = [
            ("NODES_FIRST", Trace::NODES_HEADER as u32),
            ("NODE_WORDS", Trace::NODE_WORDS as u32),
            ("NODES_ANY", Trace::NODES_ANY as u32),
            ("NODES_GROUPS", Trace::NODE_GROUPS),
            ("NODES_PIXEL_GROUPS", Trace::PIXEL_GROUPS),
        ];
        assert_eq!(other_constants(&module(&link("camera::trace")), &constants), [""; 0]);
    }
}
