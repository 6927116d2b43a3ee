//! Packets: rays that are led through the tree together (Wald et al. 2001; Rahikainen 2013, §3.2, 3.3 and 5).
//!
//! `rays` holds up to 256 rays in f32, and says why nothing is missed; `scale` is the coordinates of that. `filter` leaves
//! out what rays certainly miss, `tester` asks the predicate about the rest. `step` is what 4, 8 or 16 rays do at a node, in
//! their lanes; `stack` and `trail` lead them to leaves. `shaft` holds up to 256 rays: `search` finds where its rays may
//! begin, and `beam` leads it to leaves in their place. `see` traces the rays of a camera's pixels and
//! of a light. `options` says what there is to choose, `statistics` counts.

mod beam;
mod filter;
mod options;
mod rays;
mod scale;
mod search;
mod see;
mod shaft;
mod stack;
mod statistics;
mod step;
mod tester;
mod trail;

use fearless_simd::{Simd, dispatch, f32x4, f32x8, f32x16};

use super::{KdTraversal, KdTree};
use crate::predicate::{self, ShadowRay};
use crate::{Hit, Ray, Triangles};
use filter::Wide;
pub use options::{KdCulling, KdEntry, KdMailbox, KdPacketOptions, KdPacketWidth};
use rays::{MOST_RAYS, Rays};
use scale::Scale;
use search::{Met, Search};
use shaft::{Axes, Bundle};
use stack::{Stack, Waiting};
pub use statistics::KdPacketVisits;
use statistics::Steps;
pub(super) use statistics::Tally;
use step::Start;
use tester::{Ask, MOST_PAIRS, Mailbox, Pairs, Tester, bits_of};
use trail::Trail;

impl KdTree {
    /// Says how packets are led from now on.
    pub fn set_packet_options(&mut self, options: KdPacketOptions) {
        self.packet_options = options;
    }

    /// How packets are led.
    #[must_use]
    pub fn packet_options(&self) -> KdPacketOptions {
        self.packet_options
    }

    /// Does what [`nearest`](Self::nearest) does for each of `rays`, which may start anywhere and go anywhere: the hit of
    /// each is written to the same place in `hits`, `None` for a miss.
    ///
    /// Rays in a row are led to leaves together as the [packet options](Self::set_packet_options) and the tree's
    /// [traversal](super::KdTreeOptions::traversal) say: it pays where neighbours run side by side.
    ///
    /// # Panics
    /// If there are more or fewer `hits` than `rays`.
    pub fn nearest_of_packet(
        &self,
        triangles: Triangles<'_>,
        rays: &[Ray],
        counts: impl Fn(&Hit) -> bool,
        hits: &mut [Option<Hit>],
    ) {
        assert!(rays.len() == hits.len(), "{} hits for {} rays", hits.len(), rays.len());
        hits.fill(None);
        let mut found = [None; MOST_PAIRS];
        self.visit_packets(triangles, &|place| rays[place], rays.len(), &mut |pairs, ends| {
            predicate::hits(self.level.into(), triangles, rays, pairs, &mut found);
            for ((&(place, id), end), hit) in pairs.iter().zip(ends).zip(found) {
                let best = &mut hits[place as usize];
                if let Some(hit) = hit
                    && best.is_none_or(|best| (hit.t, id) < (best.t, best.triangle))
                    && counts(&hit)
                {
                    *best = Some(hit);
                }
                *end = best.map_or(f64::INFINITY, |best| best.t);
            }
        });
    }

    /// Does what [`blocked`](Self::blocked) does for each of `rays`, the points of which are on the triangles `own`.
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
        counts: impl Fn(u32, [f32; 2]) -> bool,
        blocked: &mut [bool],
    ) {
        let lens = (own.len(), blocked.len());
        assert!(lens == (rays.len(), rays.len()), "{lens:?} triangles and answers for {} rays", rays.len());
        blocked.fill(false);
        self.visit_packets(triangles, &|place| rays[place].ray, rays.len(), &mut |pairs, ends| {
            for (&(place, id), end) in pairs.iter().zip(ends) {
                let place = place as usize;
                let asked = !blocked[place] && id != own[place];
                blocked[place] |= asked
                    && rays[place].blocked_by(triangles.corners(id)).is_some_and(|barycentric| counts(id, barycentric));
                *end = if blocked[place] { f64::NEG_INFINITY } else { f64::INFINITY };
            }
        });
    }

    /// Calls `ask` with the place of each of `count` rays and each triangle that it may hit, until that says that nothing at some
    /// t or later matters to the ray. Knows both by reference, so that this is compiled once.
    fn visit_packets(&self, triangles: Triangles<'_>, ray: &dyn Fn(usize) -> Ray, count: usize, ask: &mut Ask<'_>) {
        if self.extent.is_empty() {
            return;
        }
        let KdPacketOptions { width, culling, .. } = self.packet_options;
        let keeps_intervals = width == KdPacketWidth::Shaft && culling == KdCulling::Intervals;
        let mut rays = Rays::default();
        rays.keeps_intervals = keeps_intervals;
        let mut stack = [Waiting::default(); super::node::Nodes::MAX_DEPTH];
        for first in (0..count).step_by(MOST_RAYS) {
            let mut ask = |pairs: &[(u32, u32)], ends: &mut [f64]| {
                let mut moved = [(0, 0); MOST_PAIRS];
                for (moved, &(place, id)) in moved.iter_mut().zip(pairs) {
                    *moved = (first as u32 + place, id);
                }
                ask(&moved[..pairs.len()], ends);
            };
            let ray = |place: usize| ray(first + place);
            let tester = Tester {
                tree: self,
                triangles,
                scale: Scale::of(&self.extent),
                ask: &mut ask,
                pairs: Pairs::default(),
                mailbox: Mailbox::new(self.packet_options.mailbox),
                steps: Steps::new(&self.packet_visits),
            };
            let mut packets = Packets { rays: &mut rays, stack: &mut stack, tester };
            packets.trace(&ray, (count - first).min(MOST_RAYS));
        }
    }
}

/// Up to 256 rays that are traced, and what with.
struct Packets<'a, 'b> {
    rays: &'a mut Rays,
    stack: &'a mut Stack,
    tester: Tester<'a, 'b>,
}

impl Packets<'_, '_> {
    fn trace(&mut self, ray: &dyn Fn(usize) -> Ray, count: usize) {
        let tree = self.tester.tree;
        let level = tree.level.into();
        let (extent, scale) = (&tree.extent, self.tester.scale);
        dispatch!(level, simd => self.rays.set_up(simd, extent, &scale, ray, count));
        self.test_everything(count);
        let options = tree.packet_options;
        let mut start = Start { place: 0, cell: tree.extent };
        if options.width == KdPacketWidth::Shaft || options.entry != KdEntry::Root {
            match dispatch!(level, simd => self.visit_shaft(simd)) {
                Shafted::Done => return,
                Shafted::Begun(met) => start = Start { place: met.place, cell: met.cell },
                Shafted::Impossible => {}
            }
        }
        // What is compiled for several widths is dispatched for each, lest it become one huge function.
        match options.width {
            KdPacketWidth::Four => dispatch!(level, simd => self.visit::<_, f32x4<_>>(simd, &start)),
            KdPacketWidth::Eight => dispatch!(level, simd => self.visit::<_, f32x8<_>>(simd, &start)),
            KdPacketWidth::Sixteen | KdPacketWidth::Shaft => {
                dispatch!(level, simd => self.visit::<_, f32x16<_>>(simd, &start));
            }
        }
    }

    /// Looks for where rays begin, and traces them if shafts do.
    #[inline(always)]
    fn visit_shaft<S: Simd>(&mut self, simd: S) -> Shafted {
        let Self { rays, tester, .. } = self;
        let tree = tester.tree;
        let KdPacketOptions { width, entry, culling, .. } = tree.packet_options;
        let Some(axes) = Axes::of(simd, rays) else { return Shafted::Impossible };
        let mut bundle = Bundle::around(simd, rays, axes);
        let (triangles, shaft) = (tester.triangles, &bundle.whole);
        let mut search = Search { tree, triangles, scale: &tester.scale, shaft, kind: entry, steps: &mut tester.steps };
        let Some(start) = search.start() else { return Shafted::Done };
        if width != KdPacketWidth::Shaft {
            return Shafted::Begun(start);
        }
        beam::visit(simd, rays, &mut bundle, &start, culling, tester);
        Shafted::Done
    }

    /// Leads all rays to leaves, as many at once as `V` has lanes.
    #[inline(always)]
    fn visit<S: Simd, V: Wide<S>>(&mut self, simd: S, start: &Start) {
        let Self { rays, stack, tester } = self;
        let trail = match tester.tree.options.traversal {
            KdTraversal::Stack => {
                for first in (0..rays.count).step_by(V::LEN) {
                    stack::visit::<S, V>(simd, rays, first, start, stack, tester);
                }
                return;
            }
            KdTraversal::Restart => Trail { entries: 0, pushes_down: false },
            KdTraversal::PushDown => Trail { entries: 0, pushes_down: true },
            KdTraversal::ShortStack(entries) => Trail { entries: entries.into(), pushes_down: true },
        };
        for first in (0..rays.count).step_by(V::LEN) {
            trail::visit::<S, V>(simd, rays, first, start, stack, tester, trail);
        }
    }

    /// Tests the rays whose numbers can't be trusted against all triangles.
    fn test_everything(&mut self, count: usize) {
        for group in 0..count.div_ceil(rays::LANES) {
            for lane in bits_of(self.rays.exhaustive[group].into()) {
                for &id in &self.tester.tree.ids {
                    let place = (group * rays::LANES + lane) as u32;
                    (self.tester.ask)(&[(place, id)], &mut [0.0]);
                }
            }
        }
    }
}

/// What became of a shaft.
enum Shafted {
    /// Nothing is left to trace.
    Done,
    /// Rays begin there.
    Begun(Met),
    /// None holds the rays.
    Impossible,
}
