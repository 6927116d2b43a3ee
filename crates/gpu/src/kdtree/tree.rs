use bytemuck::{Pod, Zeroable};
use umbrage_rays::KdTree;

use super::words::{KdTreeForm, write_words};

use crate::{Buffer, Gpu, GpuError};

/// A kd-tree from the CPU, on the GPU: 8 bytes for a node and 4 for a reference, as on the CPU.
#[derive(Debug)]
pub struct KdNodes {
    shape: Buffer,
    nodes: Buffer,
    ids: Buffer,
    /// The last uploaded words; kept to reuse the memory.
    words: Vec<[u32; 2]>,
    /// The largest magnitude of a coordinate of the bounds.
    reach: f32,
}

/// Uniform of `line.wgsl` and `tester.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
struct KdShape {
    min: [f32; 3],
    scale: f32,
    max: [f32; 3],
    scale_high: u32,
    left_follows: u32,
    is_lost: u32,
    is_empty: u32,
    unused: u32,
}

impl KdShape {
    /// Exponents of the largest coordinates that can be scaled to one.
    const EXPONENTS: std::ops::RangeInclusive<i32> = -90..=125;
    /// Scale for all other exponents: it keeps the largest coordinate below eight.
    const LOST_EXPONENT: i32 = -126;

    fn new(form: KdTreeForm) -> Self {
        let KdTreeForm { left_follows, min, max } = form;
        let is_empty = (0..3).any(|axis| min[axis] > max[axis]);
        let largest = largest(form);
        // The exponent of the next power of two above, exactly, from the exponent bits.
        let exponent = (f64::from(largest).to_bits() >> 52) as i32 - 1022;
        let is_lost = !is_empty && !Self::EXPONENTS.contains(&exponent);
        let scaling = match (is_empty, is_lost) {
            (true, _) => 0,
            (false, true) => Self::LOST_EXPONENT,
            (false, false) => -exponent,
        };
        let scale = 2.0_f64.powi(scaling);
        Self {
            min,
            scale: scale as f32,
            max,
            scale_high: (scale.to_bits() >> 32) as u32,
            left_follows: if left_follows { u32::MAX } else { 0 },
            is_lost: is_lost.into(),
            is_empty: is_empty.into(),
            unused: 0,
        }
    }
}

/// The largest magnitude of a coordinate of the bounds; infinite if they are empty.
fn largest(KdTreeForm { min, max, .. }: KdTreeForm) -> f32 {
    min.into_iter().chain(max).fold(0.0_f32, |largest, at| largest.max(at.abs()))
}

impl KdNodes {
    /// Makes an empty tree.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            shape: Buffer::uniform(gpu, "kd-tree shape"),
            nodes: Buffer::storage(gpu, "kd-tree nodes"),
            ids: Buffer::storage(gpu, "kd-tree ids"),
            words: Vec::new(),
            reach: 0.0,
        }
    }

    /// Uploads a tree. Buffers are reused, and grow if they must.
    ///
    /// # Errors
    /// If it needs more bytes than one buffer of the device can have.
    pub fn write(&mut self, gpu: &Gpu, tree: &KdTree) -> Result<(), GpuError> {
        self.write_nodes(gpu, tree)?;
        self.ids.write(gpu, tree.ids())
    }

    /// As [`KdNodes::write`], for a tree of a subset of triangles: `ids` are their ids in the whole scene.
    ///
    /// # Errors
    /// As [`KdNodes::write`].
    pub(crate) fn write_some(&mut self, gpu: &Gpu, tree: &KdTree, ids: &[u32]) -> Result<(), GpuError> {
        self.write_nodes(gpu, tree)?;
        let ids: Vec<u32> = tree.ids().iter().map(|&id| ids[id as usize]).collect();
        self.ids.write(gpu, &ids)
    }

    fn write_nodes(&mut self, gpu: &Gpu, tree: &KdTree) -> Result<(), GpuError> {
        let form = write_words(tree, &mut self.words);
        let largest = largest(form);
        self.reach = if largest.is_finite() { largest } else { 0.0 };
        self.shape.write(gpu, &[KdShape::new(form)])?;
        self.nodes.write(gpu, &self.words)
    }

    /// Bytes on the GPU.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.shape.bytes() + self.nodes.bytes() + self.ids.bytes()
    }

    /// The largest magnitude of a coordinate of any triangle that can be hit, or zero.
    #[must_use]
    pub fn reach(&self) -> f32 {
        self.reach
    }

    pub(super) fn shape(&self) -> &Buffer {
        &self.shape
    }

    pub(super) fn nodes(&self) -> &Buffer {
        &self.nodes
    }

    pub(super) fn ids(&self) -> &Buffer {
        &self.ids
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{differences, layout, module};
    use crate::link::link;

    #[test]
    fn the_shape_is_that_of_the_shaders() {
        let layout = layout!(KdShape { min, scale, max, scale_high, left_follows, is_lost, is_empty, unused });
        for path in ["kdtree::line", "kdtree::stack"] {
            assert_eq!(differences(&module(&link(path)), &layout), [""; 0], "{path}");
        }
    }

    #[test]
    fn bounds_are_scaled_to_one() {
        for largest in [1.0_f32, 0.75, 3.0, 1e-20, 1e30, 4.0e37] {
            let form = KdTreeForm { left_follows: true, min: [-largest, 0.0, 0.0], max: [0.0; 3] };
            let shape = KdShape::new(form);
            let scaled = largest * shape.scale;
            assert!((0.5..=1.0).contains(&scaled) && shape.is_lost == 0, "{largest}: {scaled}");
            assert_eq!(f64::from_bits(u64::from(shape.scale_high) << 32), f64::from(shape.scale));
        }
        for largest in [1e-30_f32, 1e-40, f32::MAX] {
            let shape = KdShape::new(KdTreeForm { left_follows: true, min: [0.0; 3], max: [largest; 3] });
            assert!(shape.is_lost == 1 && largest * shape.scale < 8.0, "{largest}");
        }
    }
}
