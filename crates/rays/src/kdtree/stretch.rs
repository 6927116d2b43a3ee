//! Scenes most of whose triangles are tiny beside all of them together, as one far vertex makes them.

use super::KdBuilder;
use super::extent::Extent;
use crate::Triangles;

/// How much smaller than the scene a tiny triangle is: f32 coordinates that reach from −1 to 1 hardly tell its corners apart.
const TINY: f64 = 1.0 / (1 << 18) as f64;

/// A scene is stretched where more than one of so many triangles are tiny.
const SHARE: usize = 16;

/// About as many boxes are looked at.
const SAMPLES: usize = 1 << 10;

/// Facts about the triangles of a whole tree, which each of its parts is built by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Whole {
    /// The largest magnitude of a coordinate.
    pub(crate) reach: f32,
    /// Whether more than a sixteenth of the triangles, of which about a thousand are looked at, are tiny beside all together.
    pub(crate) is_stretched: bool,
}

impl Whole {
    /// For triangles that are within `extent`.
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

    /// The builder that is used where this one is asked for: samples in equal distances would tell nothing apart in a stretched
    /// tree, so that planes are found exactly there.
    pub(super) fn builder(self, asked: KdBuilder) -> KdBuilder {
        match asked {
            KdBuilder::Streaming | KdBuilder::Adaptive if self.is_stretched => KdBuilder::Presorted,
            other => other,
        }
    }
}
