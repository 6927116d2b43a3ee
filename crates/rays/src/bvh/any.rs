use std::ops::ControlFlow;

use fearless_simd::Simd;

use super::Bvh;
use super::leaf::{Leaf, LeafHits};
use super::line::Line;
use crate::predicate::{hit, hit_of_near_at};
use crate::simd::lanes::bits_of;
use crate::{Ray, Triangles, dispatch, vectorized};

impl Bvh {
    /// Whether a ray hits any triangle within its interval, where all triangles are opaque on both sides. False for a ray
    /// whose direction is zero, that isn't finite, or whose interval is empty.
    ///
    /// # Panics
    /// If a vertex or a triangle of the build isn't in `triangles`.
    #[must_use]
    pub fn hits_any(&self, triangles: Triangles<'_>, ray: &Ray) -> bool {
        self.meets(triangles, ray, 1) != 0
    }

    /// The number of triangles that a ray hits within its interval, as in [`hits_any`](Self::hits_any): through an edge
    /// that two of them share it hits both.
    ///
    /// # Panics
    /// As [`hits_any`](Self::hits_any).
    #[must_use]
    pub fn count_hits(&self, triangles: Triangles<'_>, ray: &Ray) -> u32 {
        self.meets(triangles, ray, u32::MAX)
    }

    /// The number of triangles that a ray hits; stops at the leaf in which it comes to `enough`.
    fn meets(&self, triangles: Triangles<'_>, ray: &Ray, enough: u32) -> u32 {
        if !self.may_be_met(ray) {
            return 0;
        }
        let count = dispatch!(self.level, simd => self.meets_at(simd, triangles, ray, enough));
        match &self.far {
            Some(far) if count < enough => count + far.meets(triangles, ray, enough - count),
            _ => count,
        }
    }

    #[inline(always)]
    fn meets_at<S: Simd>(&self, simd: S, triangles: Triangles<'_>, ray: &Ray, enough: u32) -> u32 {
        let Some(line) = Line::new(ray, self.scale) else {
            return self.ids().filter(|&id| hit(ray, triangles, id).is_some()).count() as u32;
        };
        let (mut far, mut count) = (line.far, 0);
        let _ = self.visit(
            simd,
            &line,
            &mut far,
            #[inline(always)]
            |leaf, found, _| {
                count += self.met_of_leaf(simd, triangles, ray, &line, (leaf, found), enough);
                if count >= enough { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            },
        );
        count
    }

    /// The number of a leaf's candidates that are hit; those that are certainly hit come first, up to `enough`.
    #[inline(always)]
    fn met_of_leaf<S: Simd>(
        &self,
        simd: S,
        triangles: Triangles<'_>,
        ray: &Ray,
        line: &Line,
        (leaf, found): (usize, &LeafHits),
        enough: u32,
    ) -> u32 {
        let (mut count, mut uncertain) = (0, 0);
        for lane in bits_of(found.possible) {
            let is_hit = found.is_hit(line, lane % Leaf::LANES);
            count += u32::from(is_hit);
            uncertain |= u32::from(!is_hit) << lane;
        }
        if count < enough {
            for lane in bits_of(uncertain) {
                let (id, corners) = self.triangle(triangles, leaf, lane);
                let is_hit = vectorized!(simd => hit_of_near_at(simd, ray, corners, id).is_some());
                count += u32::from(is_hit);
            }
        }
        count
    }
}
