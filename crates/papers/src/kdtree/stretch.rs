//! Stretched scenes: many triangles are tiny compared to the whole scene, as with one far vertex.

use super::KdBuilder;
use super::extent::Extent;
use umbrage_rays::Triangles;

/// The size of a tiny triangle, relative to the scene: f32 coordinates from −1 to 1 hardly tell its corners apart.
const TINY: f64 = 1.0 / (1 << 18) as f64;

/// A scene is stretched if more than one triangle in this number is tiny.
const SHARE: usize = 16;

/// The approximate number of sampled boxes.
const SAMPLES: usize = 1 << 10;

/// Facts about the triangles of a whole tree, on which the build of each part depends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Whole {
    /// The largest magnitude of a coordinate.
    pub(crate) reach: f32,
    /// Whether more than a sixteenth of a sample of about a thousand triangles are tiny compared to the whole scene.
    pub(crate) is_stretched: bool,
}

impl Whole {
    /// Measures triangles that are within `extent`.
    pub(crate) fn new(extent: &Extent, triangles: Triangles<'_>) -> Self {
        let size = |extent: &Extent| {
            let sides = [0, 1, 2].map(|axis| f64::from(extent.max[axis]) - f64::from(extent.min[axis]));
            sides[0].max(sides[1]).max(sides[2])
        };
        // An odd step, since triangles often come in pairs.
        let step = (triangles.len() / SAMPLES) | 1;
        let tiny = size(extent) * TINY;
        let (mut all, mut tiny_ones) = (0, 0);
        let ids = (0..triangles.len() as u32).step_by(step);
        for corners in ids.filter_map(|id| triangles.usable_corners(id).ok()) {
            all += 1;
            tiny_ones += usize::from(size(&Extent::around(corners)) < tiny);
        }
        Self { reach: extent.reach(), is_stretched: tiny_ones > all / SHARE }
    }

    /// Returns the builder to use for the one that is `asked` for. Evenly spaced samples would tell nothing apart in a
    /// stretched tree, so planes are found exactly there.
    pub(super) fn builder(self, asked: KdBuilder) -> KdBuilder {
        match asked {
            KdBuilder::Streaming | KdBuilder::Adaptive if self.is_stretched => KdBuilder::Presorted,
            other => other,
        }
    }
}
