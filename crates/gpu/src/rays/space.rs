use bytemuck::{Pod, Zeroable};

use crate::{Buffer, Gpu, GpuError};

/// Uniform of `line.wgsl` and `tester.wgsl`: the space of a structure.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RaySpace {
    min: [f32; 3],
    /// The power of two that scales the bounds to at most one.
    pub(super) scale: f32,
    max: [f32; 3],
    scale_high: u32,
    left_follows: u32,
    is_lost: u32,
    is_empty: u32,
    continues: u32,
}

impl RaySpace {
    /// Exponents of the largest coordinates that can be scaled to one.
    const EXPONENTS: std::ops::RangeInclusive<i32> = -90..=125;
    /// Scale for all other exponents: it keeps the largest coordinate below eight.
    const LOST_EXPONENT: i32 = -126;

    /// The space of a structure with these bounds, the lower corner first; above the upper one if it is empty.
    #[must_use]
    pub fn new([min, max]: [[f32; 3]; 2]) -> Self {
        let is_empty = (0..3).any(|axis| min[axis] > max[axis]);
        let largest = min.into_iter().chain(max).fold(0.0_f32, |largest, at| largest.max(at.abs()));
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
            left_follows: 0,
            is_lost: is_lost.into(),
            is_empty: is_empty.into(),
            continues: 0,
        }
    }

    /// For a kd-tree whose left children follow their parents.
    #[must_use]
    pub fn with_left_children_first(self, left_follows: bool) -> Self {
        Self { left_follows: if left_follows { u32::MAX } else { 0 }, ..self }
    }

    /// For a part of a structure whose walk goes on with the results of the parts before.
    pub(super) fn after_others(self, continues: bool) -> Self {
        Self { continues: continues.into(), ..self }
    }

    /// The largest magnitude of a coordinate of the bounds, or zero.
    #[must_use]
    pub fn reach(&self) -> f32 {
        if self.is_empty != 0 {
            return 0.0;
        }
        self.min.into_iter().chain(self.max).fold(0.0, |largest, at| largest.max(at.abs()))
    }
}

/// A part of a structure on the GPU: its space, nodes, and the triangles' ids in leaves. Rays walk through one part of a
/// structure after the other.
#[derive(Debug)]
pub struct Part {
    pub(super) space: Buffer,
    #[doc(hidden)]
    pub nodes: Buffer,
    #[doc(hidden)]
    pub ids: Buffer,
}

impl Part {
    /// Empty buffers.
    #[doc(hidden)]
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            space: Buffer::uniform(gpu, "space of rays"),
            nodes: Buffer::storage(gpu, "nodes"),
            ids: Buffer::storage(gpu, "ids in leaves"),
        }
    }

    #[doc(hidden)]
    pub fn write_space(&mut self, gpu: &Gpu, space: RaySpace) -> Result<(), GpuError> {
        self.space.write(gpu, &[space])
    }

    #[doc(hidden)]
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.space.bytes() + self.nodes.bytes() + self.ids.bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{differences, layout, module};
    use crate::link::link;

    #[test]
    fn the_space_is_that_of_the_shaders() {
        let layout = layout!(RaySpace { min, scale, max, scale_high, left_follows, is_lost, is_empty, continues });
        for path in ["rays::line", "rays::hierarchy"] {
            assert_eq!(differences(&module(&link(path)), &layout), [""; 0], "{path}");
        }
    }

    #[test]
    fn bounds_are_scaled_to_one() {
        for largest in [1.0_f32, 0.75, 3.0, 1e-20, 1e30, 4.0e37] {
            let space = RaySpace::new([[-largest, 0.0, 0.0], [0.0; 3]]);
            let scaled = largest * space.scale;
            assert!((0.5..=1.0).contains(&scaled) && space.is_lost == 0, "{largest}: {scaled}");
            assert_eq!(f64::from_bits(u64::from(space.scale_high) << 32), f64::from(space.scale));
        }
        for largest in [1e-30_f32, 1e-40, f32::MAX] {
            let space = RaySpace::new([[0.0; 3], [largest; 3]]);
            assert!(space.is_lost == 1 && largest * space.scale < 8.0, "{largest}");
        }
    }
}
