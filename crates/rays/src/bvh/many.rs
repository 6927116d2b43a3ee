use std::ops::ControlFlow;

use fearless_simd::Simd;

use super::Bvh;
use super::leaf::{Leaf, LeafHits};
use super::line::Line;
use super::trace::{Corners, Nearest, Stack};
use crate::predicate::{hit, hit_of_near_at};
use crate::simd::lanes::bits_of;
use crate::{Hit, Ray, SingleRays, Triangles, dispatch, vectorized};

/// The first hit of a ray.
pub(crate) enum First {
    /// The id of the triangle, which f32 tells.
    Certain(u32),
    /// The predicate's answer.
    Settled(Option<Hit>),
}

/// Whether a hit stops a ray, given the ray's index; `None` where all hits do.
type Stops<'a> = Option<&'a dyn Fn(usize, &Ray, &Hit) -> bool>;

/// The same of one ray.
type OfRay<'a> = Option<&'a dyn Fn(&Hit) -> bool>;

/// Answers about many rays, which share the memory of a traversal. The predicate isn't asked where f32 can tell.
impl Bvh {
    /// Calls `note` with each ray's index and its first hit, where all triangles stop it; with the triangle's id alone only
    /// if `is_id_enough`.
    pub(crate) fn first_of_each(
        &self,
        triangles: Triangles<'_>,
        rays: &[Ray],
        is_id_enough: bool,
        mut note: impl FnMut(usize, First),
    ) {
        if self.far.is_some() {
            for (index, ray) in rays.iter().enumerate() {
                note(index, First::Settled(self.nearest(triangles, ray, &|_| true)));
            }
            return;
        }
        dispatch!(self.level, simd => {
            let mut stack = Stack::default();
            for (index, ray) in rays.iter().enumerate() {
                note(index, self.first_at(simd, triangles, ray, is_id_enough, &mut stack));
            }
        });
    }

    #[inline(always)]
    fn first_at<S: Simd>(
        &self,
        simd: S,
        triangles: Triangles<'_>,
        ray: &Ray,
        is_id_enough: bool,
        stack: &mut Stack,
    ) -> First {
        if !self.may_be_met(ray) {
            return First::Settled(None);
        }
        let (own, stops): (u32, &dyn Fn(&Hit) -> bool) = (u32::MAX, &|_| true);
        let Some(line) = Line::new(ray, self.scale) else {
            return First::Settled(self.nearest_of_all(triangles, ray, own, stops));
        };
        let mut nearest = Nearest::new(self, triangles, ray, &line, own, stops);
        let mut far = line.far;
        let _ = self.visit(
            simd,
            (&line, stack),
            &mut far,
            #[inline(always)]
            |leaf, found, far| {
                nearest.take(simd, leaf, found, far);
                ControlFlow::Continue(())
            },
        );
        match nearest.certain(far) {
            Some(id) if is_id_enough => First::Certain(id),
            // Nothing has let the ray through.
            _ => First::Settled(nearest.end(simd, &mut far).flatten()),
        }
    }

    /// Calls `note` with each ray's index and the number of triangles that it hits and that would stop it. Goes no further
    /// than the leaf in which a ray comes to `enough` of them.
    pub(crate) fn hits_of_each(
        &self,
        triangles: Triangles<'_>,
        rays: &[Ray],
        (enough, stops): (u32, Stops<'_>),
        mut note: impl FnMut(usize, u32),
    ) {
        dispatch!(self.level, simd => {
            let mut stack = Stack::default();
            for (index, ray) in rays.iter().enumerate() {
                let of_ray = |hit: &Hit| stops.is_none_or(|stops| stops(index, ray, hit));
                let stops: OfRay<'_> = if stops.is_some() { Some(&of_ray) } else { None };
                let mut count = self.hits_at(simd, triangles, ray, (enough, stops), &mut stack);
                if let Some(far) = self.far.as_ref().filter(|_| count < enough) {
                    count += far.hits_at(simd, triangles, ray, (enough - count, stops), &mut stack);
                }
                note(index, count);
            }
        });
    }

    #[inline(always)]
    fn hits_at<S: Simd>(
        &self,
        simd: S,
        triangles: Triangles<'_>,
        ray: &Ray,
        (enough, stops): (u32, OfRay<'_>),
        stack: &mut Stack,
    ) -> u32 {
        if !self.may_be_met(ray) {
            return 0;
        }
        let Some(line) = Line::new(ray, self.scale) else {
            let is_hit = |id: &u32| hit(ray, triangles, *id).is_some_and(|hit| is_stopped(stops, &hit));
            return self.ids().filter(is_hit).count() as u32;
        };
        let (mut far, mut count) = (line.far, 0);
        let _ = self.visit(
            simd,
            (&line, stack),
            &mut far,
            #[inline(always)]
            |leaf, found, _| {
                count += self.hits_of_leaf(simd, triangles, (ray, &line), (leaf, found), (enough, stops));
                if count >= enough { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            },
        );
        count
    }

    /// The number of a leaf's candidates that are hit. The predicate tests the others only if those that are certainly hit
    /// aren't `enough`.
    #[inline(always)]
    fn hits_of_leaf<S: Simd>(
        &self,
        simd: S,
        triangles: Triangles<'_>,
        (ray, line): (&Ray, &Line),
        (leaf, found): (usize, &LeafHits),
        (enough, stops): (u32, OfRay<'_>),
    ) -> u32 {
        let mut certain = 0;
        if stops.is_none() {
            for lane in bits_of(found.certain) {
                certain |= u32::from(found.is_hit(line, lane % Leaf::LANES)) << lane;
            }
        }
        let mut count = certain.count_ones();
        if count < enough {
            for lane in bits_of(found.possible & !certain) {
                let (id, corners) = triangles.triangle(self, leaf, lane);
                let hit = vectorized!(simd => hit_of_near_at(simd, ray, corners, id));
                count += u32::from(hit.is_some_and(|hit| is_stopped(stops, &hit)));
            }
        }
        count
    }
}

fn is_stopped(stops: OfRay<'_>, hit: &Hit) -> bool {
    stops.is_none_or(|stops| stops(hit))
}
