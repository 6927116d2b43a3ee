//! Packets: rays that are led through the tree together (Wald et al. 2001; Rahikainen 2013, §3.2, 3.3 and 5).
//!
//! `rays` holds up to 256 rays in f32, and shows why no hit is missed; `scale` has their coordinates. `filter` leaves out
//! triangles that rays certainly miss, `tester` asks the predicate about the rest. `step` takes 4, 8 or 16 rays, in their
//! lanes, past a node; `stack` and `trail` lead them to leaves, also those of subtrees that are built then. `see` traces the
//! rays of a camera's pixels and of a light. `options` has the options.

mod filter;
mod options;
mod rays;
mod scale;
mod see;
mod stack;
mod step;
mod tester;
mod trail;

use std::ops::ControlFlow;

use fearless_simd::{Simd, f32x4, f32x8, f32x16};
use umbrage_rays::dispatch;

use super::KdTree;
use crate::single::Filter as LineFilter;
use crate::single::Visit as _;
use crate::statistics::Steps;
pub use filter::{Filter, Wide, load};
pub use options::{KdMailbox, KdPacketOptions, KdPacketWidth};
pub use rays::{HALF_ULP, LANES, MOST_RAYS, Rays};
pub use scale::Scale;
pub(crate) use see::{NO_RAY, PacketRays, SQUARE_PIXELS};
use stack::{Stack, WaitingPacket};
pub use tester::Ask;
use tester::{MOST_PAIRS, Mailbox, Pairs, Tester};
use umbrage_rays::predicate::{self, ShadowRay};
use umbrage_rays::simd::lanes::bits_of;
use umbrage_rays::{Hit, Ray, Triangles};

impl KdTree {
    /// Finds the [`nearest`](umbrage_rays::SingleRays::nearest) hit of each of `rays`, which may start anywhere and go
    /// anywhere. It is written to the same index of `hits`, `None` for a miss.
    ///
    /// Rays in a row are led to leaves together as the tree's [options](super::KdTreeOptions) say, which pays if neighbours
    /// run side by side.
    ///
    /// # Panics
    /// If there are more or fewer `hits` than `rays`.
    pub fn nearest_of_packet(
        &self,
        triangles: Triangles<'_>,
        rays: &[Ray],
        stops: impl Fn(&Hit) -> bool,
        hits: &mut [Option<Hit>],
    ) {
        self.nearest_by(triangles, rays, stops, hits, |ask| {
            self.visit_packets(triangles, &|index| rays[index], rays.len(), ask);
        });
    }

    /// As [`nearest_of_packet`](Self::nearest_of_packet), of the triangles that `visit` names.
    #[doc(hidden)]
    pub fn nearest_by(
        &self,
        triangles: Triangles<'_>,
        rays: &[Ray],
        stops: impl Fn(&Hit) -> bool,
        hits: &mut [Option<Hit>],
        visit: impl FnOnce(&mut Ask<'_>),
    ) {
        assert!(rays.len() == hits.len(), "{} hits for {} rays", hits.len(), rays.len());
        hits.fill(None);
        let mut found = [None; MOST_PAIRS];
        visit(&mut |pairs, ends| {
            predicate::hits(self.level, triangles, rays, pairs, &mut found);
            for ((&(index, id), end), hit) in pairs.iter().zip(ends).zip(found) {
                let best = &mut hits[index as usize];
                if let Some(hit) = hit
                    && best.is_none_or(|best| (hit.t, id) < (best.t, best.triangle))
                    && stops(&hit)
                {
                    *best = Some(hit);
                }
                *end = best.map_or(f64::INFINITY, |best| best.t);
            }
        });
    }

    /// Finds whether each of `rays` is [`blocked`](umbrage_rays::SingleRays::blocked). Their points are on the triangles
    /// `own`.
    ///
    /// Rays are led to leaves together as by [`nearest_of_packet`](Self::nearest_of_packet).
    ///
    /// # Panics
    /// If there are more or fewer `own` or `blocked` than `rays`.
    pub fn blocked_of_packet(
        &self,
        triangles: Triangles<'_>,
        rays: &[ShadowRay],
        own: &[u32],
        stops: impl Fn(u32, [f32; 2]) -> bool,
        blocked: &mut [bool],
    ) {
        self.blocked_by(triangles, rays, own, stops, blocked, |ask| {
            self.visit_packets(triangles, &|index| rays[index].ray, rays.len(), ask);
        });
    }

    /// As [`blocked_of_packet`](Self::blocked_of_packet), by the triangles that `visit` names.
    #[doc(hidden)]
    pub fn blocked_by(
        &self,
        triangles: Triangles<'_>,
        rays: &[ShadowRay],
        own: &[u32],
        stops: impl Fn(u32, [f32; 2]) -> bool,
        blocked: &mut [bool],
        visit: impl FnOnce(&mut Ask<'_>),
    ) {
        let lens = (own.len(), blocked.len());
        assert!(lens == (rays.len(), rays.len()), "{lens:?} triangles and answers for {} rays", rays.len());
        blocked.fill(false);
        visit(&mut |pairs, ends| {
            for (&(index, id), end) in pairs.iter().zip(ends) {
                let index = index as usize;
                let asked = !blocked[index] && id != own[index];
                blocked[index] |= asked
                    && rays[index].blocked_by(triangles.corners(id)).is_some_and(|barycentric| stops(id, barycentric));
                *end = if blocked[index] { f64::NEG_INFINITY } else { f64::INFINITY };
            }
        });
    }

    /// Calls `ask` with pairs of a ray's index, of `count` rays, and a triangle that it may hit. `ask` sets the t from which
    /// on nothing matters to the ray. `ray` and `ask` are references, so that this is compiled once.
    fn visit_packets(&self, triangles: Triangles<'_>, ray: &dyn Fn(usize) -> Ray, count: usize, ask: &mut Ask<'_>) {
        if self.is_stretched {
            return (0..count).for_each(|index| self.visit_alone(triangles, &ray(index), index as u32, ask));
        }
        self.prepare(ray, count, ask, &mut |rays, ask| self.visit_from(triangles, rays, 0, ask));
    }

    /// Calls `ask` with the triangles that one ray may hit.
    fn visit_alone(&self, triangles: Triangles<'_>, ray: &Ray, index: u32, ask: &mut Ask<'_>) {
        if !ray.is_sound() {
            return;
        }
        let filter = LineFilter::new(ray.origin, ray.direction);
        let _ = self.visit(triangles, ray, |id, t_max| {
            if !filter.misses(triangles.corners(id)) {
                let mut end = [f64::INFINITY];
                ask(&[(index, id)], &mut end);
                *t_max = t_max.min(end[0]);
            }
            if *t_max == f64::NEG_INFINITY { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
    }

    /// Prepares `count` rays, up to [`MOST_RAYS`] at a time, and hands them to `visit`. Those whose numbers can't be
    /// trusted are tested against all triangles.
    #[doc(hidden)]
    pub fn prepare(
        &self,
        ray: &dyn Fn(usize) -> Ray,
        count: usize,
        ask: &mut Ask<'_>,
        visit: &mut dyn FnMut(&mut Rays, &mut Ask<'_>),
    ) {
        if self.extent.is_empty() {
            return;
        }
        let scale = Scale::of(&self.extent);
        let mut rays = Rays::default();
        for first in (0..count).step_by(MOST_RAYS) {
            let mut ask = |pairs: &[(u32, u32)], ends: &mut [f64]| {
                let mut moved = [(0, 0); MOST_PAIRS];
                for (moved, &(index, id)) in moved.iter_mut().zip(pairs) {
                    *moved = (first as u32 + index, id);
                }
                ask(&moved[..pairs.len()], ends);
            };
            let ray = |index: usize| ray(first + index);
            let count = (count - first).min(MOST_RAYS);
            dispatch!(self.level, simd => rays.set_up(simd, &self.extent, &scale, &ray, count));
            for (group, &exhaustive) in rays.exhaustive[..count.div_ceil(LANES)].iter().enumerate() {
                for lane in bits_of(exhaustive) {
                    let index = (group * LANES + lane) as u32;
                    self.ids.iter().for_each(|&id| ask(&[(index, id)], &mut [0.0]));
                }
            }
            visit(&mut rays, &mut ask);
        }
    }

    /// Leads prepared rays to leaves below the node at `root`, in packets.
    #[doc(hidden)]
    pub fn visit_from(&self, triangles: Triangles<'_>, rays: &mut Rays, root: u32, ask: &mut Ask<'_>) {
        let mut stack = [WaitingPacket::at_root(self); super::node::Nodes::MAX_DEPTH];
        let tester = Tester {
            tree: self,
            triangles,
            scale: Scale::of(&self.extent),
            ask,
            pairs: Pairs::default(),
            mailbox: Mailbox::new(self.options.packets.mailbox),
            steps: Steps::new(&self.visits),
        };
        let mut packets = Packets { rays, stack: &mut stack, root, tester };
        let level = self.level;
        // Each width is dispatched by itself, since all of them together would become one huge function.
        match self.options.packets.width {
            KdPacketWidth::Four => dispatch!(level, simd => packets.visit::<_, f32x4<_>>(simd)),
            KdPacketWidth::Eight => dispatch!(level, simd => packets.visit::<_, f32x8<_>>(simd)),
            KdPacketWidth::Sixteen => dispatch!(level, simd => packets.visit::<_, f32x16<_>>(simd)),
        }
    }
}

/// Up to 256 rays that are traced, and the data to trace them.
struct Packets<'a, 'b, 'c> {
    rays: &'c mut Rays,
    stack: &'c mut Stack<'a>,
    /// The node at which they begin.
    root: u32,
    tester: Tester<'a, 'b>,
}

impl Packets<'_, '_, '_> {
    /// Leads all rays to leaves, as many at once as `V` has lanes.
    #[inline(always)]
    fn visit<S: Simd, V: Wide<S>>(&mut self, simd: S) {
        let Self { rays, stack, root, tester } = self;
        let trail = tester.tree.options.traversal.trail();
        for first in (0..rays.count).step_by(V::LEN) {
            match trail {
                None => stack::visit::<S, V>(simd, rays, first, *root, stack, tester),
                Some(trail) => trail::visit::<S, V>(simd, rays, first, *root, stack, tester, trail),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::random::Random;

    /// Counts the pairs of 300 rays and triangles that the predicate is asked about: for small triangles around the origin,
    /// and with one that covers all of them.
    #[test]
    fn a_triangle_that_covers_all_leaves_little_to_the_predicate() {
        let mut random = Random::new(9);
        let mut point = || Vec3::from_array([0; 3].map(|_| random.signed() as f32));
        let mut positions: Vec<Vec3> =
            (0..2000).map(|_| point()).flat_map(|at| [at, at + 0.02 * Vec3::X, at + 0.02 * Vec3::Y]).collect();
        let rays: Vec<Ray> = (0..300).map(|_| Ray::new(DVec3::Z * 3.0, point().as_dvec3() - DVec3::Z * 3.0)).collect();
        let all: Vec<[u32; 3]> = (0..2001).map(|id| [3 * id, 3 * id + 1, 3 * id + 2]).collect();
        positions.extend([Vec3::NEG_X, Vec3::X, Vec3::Y].map(|corner| (corner - 0.2 * Vec3::Y) * 1e20 - Vec3::Z * 2.0));
        let pairs = |indices: &[[u32; 3]]| {
            let triangles = Triangles { positions: &positions, indices };
            let mut tree = KdTree::default();
            tree.build(triangles);
            let mut count = 0;
            tree.visit_packets(triangles, &|index| rays[index], rays.len(), &mut |pairs, ends| {
                count += pairs.len();
                ends.fill(f64::INFINITY);
            });
            (tree.is_stretched, count)
        };
        let (usual, covered) = (pairs(&all[..2000]), pairs(&all));
        assert!(!usual.0 && covered.0, "{usual:?} {covered:?}");
        assert!(covered.1 <= 2 * usual.1 + 30 * rays.len(), "{usual:?} {covered:?}");
    }
}
