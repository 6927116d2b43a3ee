//! Triangles around a common corner, tested together.
//!
//! Galin and Akkouche, *Fast processing of triangle meshes using triangle fans*, 2005.

mod build;
mod hit;
mod validate;

use glam::Vec3;

use umbrage_rays::Omitted;

/// All triangles of a mesh in fans, each triangle in one. 23 bytes a triangle in fans of six, 26 in fans of four.
///
/// A fan's triangles share its centre, and each shares an edge at the centre with the next; the last one may share one
/// with the first.
#[derive(Clone, Debug, Default)]
pub struct Fans {
    fans: Vec<Fan>,
    /// Edges of each fan, from the centre to the rim: one more than its triangles.
    edges: Vec<Vec3>,
    /// Id of each triangle, fan after fan.
    ids: Vec<u32>,
    /// The triangle's corner at the centre: 0, 1 or 2.
    center_corners: Vec<u8>,
    omitted: Omitted,
}

/// 24 bytes.
#[derive(Clone, Copy, Debug)]
struct Fan {
    center: Vec3,
    /// Index of its first triangle in [`Fans::ids`].
    first_triangle: u32,
    /// Index of its first edge in [`Fans::edges`].
    first_edge: u32,
    triangles: u32,
}

/// One of a mesh's fans.
#[derive(Clone, Copy, Debug)]
pub struct TriangleFan<'a> {
    center: Vec3,
    /// One more than its triangles.
    edges: &'a [Vec3],
    ids: &'a [u32],
    center_corners: &'a [u8],
}

impl Fans {
    /// Number of fans.
    #[must_use]
    pub fn len(&self) -> usize {
        self.fans.len()
    }

    /// Whether there are no fans.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.fans.is_empty()
    }

    /// A fan by its index.
    ///
    /// # Panics
    /// If the index is out of range.
    #[must_use]
    #[inline]
    pub fn fan(&self, index: usize) -> TriangleFan<'_> {
        let Fan { center, first_triangle, first_edge, triangles } = self.fans[index];
        let (first_triangle, first_edge, triangles) =
            (first_triangle as usize, first_edge as usize, triangles as usize);
        TriangleFan {
            center,
            edges: &self.edges[first_edge..=first_edge + triangles],
            ids: &self.ids[first_triangle..first_triangle + triangles],
            center_corners: &self.center_corners[first_triangle..first_triangle + triangles],
        }
    }

    /// The triangles in no fan, which no ray can hit.
    #[must_use]
    pub fn omitted(&self) -> &Omitted {
        &self.omitted
    }

    /// Bytes of memory.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.fans.as_slice())
            + size_of_val(self.edges.as_slice())
            + size_of_val(self.ids.as_slice())
            + size_of_val(self.center_corners.as_slice())
    }
}

impl TriangleFan<'_> {
    /// Ids of the fan's triangles, one after the other around the centre.
    #[must_use]
    pub fn ids(&self) -> &[u32] {
        self.ids
    }
}
