use fearless_simd::Simd;

use super::KdMailbox;
use super::filter::{Filter, Wide};
use super::rays::Rays;
use super::scale::Scale;
use crate::KdTree;
use crate::kdtree::node::Node;
use crate::statistics::Steps;
use umbrage_rays::Triangles;
use umbrage_rays::simd::lanes::bits_of;

/// Settles pairs of a ray's index and a triangle, and writes for each pair the t from which on nothing matters to its ray.
pub type Ask<'a> = dyn FnMut(&[(u32, u32)], &mut [f64]) + 'a;

/// The largest number of pairs that are settled at once.
pub(super) const MOST_PAIRS: usize = 32;

/// Undecided rays and triangles.
#[derive(Default)]
pub(super) struct Pairs {
    pairs: [(u32, u32); MOST_PAIRS],
    count: usize,
}

impl Pairs {
    #[inline(always)]
    fn push(&mut self, index: usize, id: u32, rays: &mut Rays, ask: &mut Ask<'_>) {
        self.pairs[self.count] = (index as u32, id);
        self.count += 1;
        if self.count == MOST_PAIRS {
            self.ask(rays, ask);
        }
    }

    #[inline(never)]
    fn ask(&mut self, rays: &mut Rays, ask: &mut Ask<'_>) {
        let mut ends = [0.0; MOST_PAIRS];
        let pairs = &self.pairs[..self.count];
        ask(pairs, &mut ends[..self.count]);
        for (&(index, _), end) in pairs.iter().zip(ends) {
            rays.end(index as usize, end);
        }
        self.count = 0;
    }
}

/// Tests triangles of leaves for packets.
pub(super) struct Tester<'a, 'b> {
    pub(super) tree: &'a KdTree,
    pub(super) triangles: Triangles<'a>,
    pub(super) scale: Scale,
    pub(super) ask: &'a mut Ask<'b>,
    pub(super) pairs: Pairs,
    pub(super) mailbox: Mailbox,
    pub(super) steps: Steps<'a>,
}

impl<'a> Tester<'a, '_> {
    /// Returns the subtree in the place of a leaf of a tree, with the leaf's cell.
    #[cold]
    pub(super) fn subtree(&self, tree: &'a KdTree, leaf: Node) -> &'a KdTree {
        tree.reach(self.triangles, leaf.ids().start)
    }

    /// Tests the `members` of the rays from `first` on against triangles.
    #[inline(always)]
    pub(super) fn leaf<S: Simd, V: Wide<S>>(
        &mut self,
        simd: S,
        rays: &mut Rays,
        first: usize,
        ids: &[u32],
        members: u64,
    ) {
        self.steps.note(|visits| visits.leaves += 1);
        for &id in ids {
            let members = self.mailbox.untested(id, members);
            if members != 0 {
                let filter = Filter::new(&self.scale, self.triangles.corners(id), rays.moved);
                self.test::<S, V>(simd, rays, first, id, &filter, members);
            }
        }
        self.ask(rays);
    }

    /// Settles the pairs that tests have left undecided.
    #[inline(always)]
    fn ask(&mut self, rays: &mut Rays) {
        if self.pairs.count > 0 {
            self.pairs.ask(rays, self.ask);
        }
    }

    /// Tests the `members` of the rays from `first` on against a triangle, and lists the pairs that f32 can't decide.
    #[inline(always)]
    fn test<S: Simd, V: Wide<S>>(
        &mut self,
        simd: S,
        rays: &mut Rays,
        first: usize,
        id: u32,
        filter: &Filter,
        members: u64,
    ) {
        self.steps.note(|visits| visits.tests += 1);
        let possible = filter.possible::<S, V>(simd, rays, first) & members;
        for lane in bits_of(possible) {
            self.steps.note(|visits| visits.settled += 1);
            self.pairs.push(first + lane, id, rays, self.ask);
        }
    }
}

/// Triangles that a packet remembers to have tested, and masks of the members that were. Forgotten triangles are tested
/// again, which changes nothing.
pub(super) struct Mailbox {
    kind: KdMailbox,
    slots: usize,
    ids: [u32; Self::SLOTS],
    tested: [u16; Self::SLOTS],
    /// The slot of the ring that was used last.
    next: usize,
}

impl Mailbox {
    /// The number of slots of the largest kind.
    const SLOTS: usize = 64;
    /// The number of slots of a ring.
    const RING: usize = 8;

    pub(super) fn new(kind: KdMailbox) -> Self {
        Self { kind, slots: 1, ids: [u32::MAX; Self::SLOTS], tested: [0; Self::SLOTS], next: 0 }
    }

    /// Forgets everything, before a packet.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.slots = match self.kind {
            KdMailbox::None => return,
            KdMailbox::Ring => Self::RING,
            KdMailbox::Hashed => Self::SLOTS,
        };
        self.ids[..self.slots].fill(u32::MAX);
    }

    /// Returns the `members` that weren't tested against `id` yet, and notes that they are.
    #[inline(always)]
    pub(super) fn untested(&mut self, id: u32, members: u64) -> u64 {
        let slot = match self.kind {
            KdMailbox::None => return members,
            KdMailbox::Ring => {
                if let Some(slot) = self.ids[..Self::RING].iter().position(|&other| other == id) {
                    slot
                } else {
                    self.next = (self.next + 1) % Self::RING;
                    self.next
                }
            }
            KdMailbox::Hashed => id as usize & (self.slots - 1),
        };
        let tested = if self.ids[slot] == id { self.tested[slot] } else { 0 };
        self.ids[slot] = id;
        self.tested[slot] = tested | members as u16;
        members & !u64::from(tested)
    }
}
