use super::cull::Boxes;
use super::lines::Lines;
use crate::patches::Patches;
use crate::{Opacity, Ray, Sides, SimdLevel, Triangles};

/// The kind of answer for lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Asked {
    /// The nearest hit.
    Nearest,
    /// All hits, the nearest first.
    All,
    /// Whether there is any hit.
    Any,
}

/// The inputs of tracing tiles.
pub(super) struct Job<'a> {
    pub(super) triangles: Triangles<'a>,
    pub(super) patches: &'a Patches,
    pub(super) boxes: &'a Boxes,
    pub(super) opacity: &'a dyn Opacity,
    pub(super) sides: Sides<'a>,
    pub(super) lines: Lines<'a>,
    pub(super) asked: Asked,
    /// Factor for lengths: a power of two.
    pub(super) scale: f64,
    /// Whether all sides of all triangles stop all lines.
    pub(super) all_stop: bool,
    pub(super) level: SimdLevel,
}

impl Job<'_> {
    /// Whether a triangle stops every line that meets it.
    pub(super) fn always_stops(&self, id: u32) -> bool {
        self.all_stop || (self.opacity.is_opaque(id) && self.sides.has_back(id))
    }

    /// Whether a triangle stops a ray that hits it at these weights.
    pub(super) fn stops(&self, ray: &Ray, id: u32, barycentric: [f32; 2]) -> bool {
        self.all_stop
            || (self.sides.stop(ray, id, self.triangles.corners(id)) && self.opacity.is_stopped_at(id, barycentric))
    }
}

/// The power of two that makes a length about 2¹⁰. Then products of lengths don't overflow, and underflow only where they
/// are far below the rounding errors of the others.
pub(super) fn scale(length: f64) -> f64 {
    // The factor itself is an f32 far from the smallest and the largest.
    if length > 0.0 && length.is_finite() { f64::exp2((10.0 - length.log2().ceil()).clamp(-122.0, 110.0)) } else { 1.0 }
}
