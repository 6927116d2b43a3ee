use umbrage_gpu::internals::RaySpace;
use umbrage_gpu::rays::Part;
use umbrage_gpu::{Gpu, GpuError};

use super::words::{KdTreeForm, write_words};
use crate::KdTree;

/// A kd-tree from the CPU, on the GPU: 8 bytes for a node and 4 for a reference, as on the CPU.
#[derive(Debug)]
pub struct KdNodes {
    part: Part,
    /// The last uploaded words; kept to reuse the memory.
    words: Vec<[u32; 2]>,
    reach: f32,
}

impl KdNodes {
    /// Makes an empty tree.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        Self { part: Part::new(gpu), words: Vec::new(), reach: 0.0 }
    }

    /// Uploads a tree. Buffers are reused, and grow if they must.
    ///
    /// # Errors
    /// If it needs more bytes than one buffer of the device can have.
    pub fn write(&mut self, gpu: &Gpu, tree: &KdTree) -> Result<(), GpuError> {
        let KdTreeForm { left_follows, min, max } = write_words(tree, &mut self.words);
        let space = RaySpace::new([min, max]).with_left_children_first(left_follows);
        self.reach = space.reach();
        self.part.write_space(gpu, space)?;
        self.part.nodes.write(gpu, &self.words)?;
        self.part.ids.write(gpu, tree.ids())
    }

    /// Bytes on the GPU.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.part.bytes()
    }

    /// The largest magnitude of a coordinate of any triangle that can be hit, or zero.
    #[must_use]
    pub fn reach(&self) -> f32 {
        self.reach
    }
}

impl AsRef<[Part]> for KdNodes {
    fn as_ref(&self) -> &[Part] {
        std::slice::from_ref(&self.part)
    }
}
