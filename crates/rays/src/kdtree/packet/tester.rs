use fearless_simd::Simd;

use super::KdMailbox;
use super::filter::{Filter, Wide};
use super::rays::Rays;
use super::scale::Scale;
use super::statistics::Steps;
use crate::Triangles;

/// Asks whether the ray at a place hits a triangle, and is told from which t on nothing matters to the ray.
pub(super) type Ask<'a> = dyn FnMut(usize, u32) -> f64 + 'a;

/// Tests triangles of leaves for packets.
pub(super) struct Tester<'a, 'b> {
    pub(super) triangles: Triangles<'a>,
    pub(super) scale: Scale,
    pub(super) ask: &'a mut Ask<'b>,
    pub(super) mailbox: Mailbox,
    pub(super) steps: Steps<'a>,
}

impl Tester<'_, '_> {
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
    }

    /// Tests the `members` of the rays from `first` on against a triangle; whether any was asked about.
    #[inline(always)]
    pub(super) fn test<S: Simd, V: Wide<S>>(
        &mut self,
        simd: S,
        rays: &mut Rays,
        first: usize,
        id: u32,
        filter: &Filter,
        members: u64,
    ) -> bool {
        self.steps.note(|visits| visits.tests += 1);
        let possible = filter.possible::<S, V>(simd, rays, first) & members;
        for lane in bits_of(possible) {
            self.steps.note(|visits| visits.asked += 1);
            let place = first + lane;
            rays.end(place, (self.ask)(place, id));
        }
        possible != 0
    }
}

/// The places of a word's bits.
#[inline(always)]
pub(super) fn bits_of(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (bit < 64).then_some(bit)
    })
}

/// Triangles that a packet remembers to have tested, and for which members. What is forgotten is tested again, which
/// changes nothing.
pub(super) struct Mailbox {
    kind: KdMailbox,
    ids: [u32; Self::SLOTS],
    tested: [u16; Self::SLOTS],
    /// Where the ring goes on.
    next: usize,
}

impl Mailbox {
    const SLOTS: usize = 64;
    /// What the ring uses of them.
    const RING: usize = 8;

    pub(super) fn new(kind: KdMailbox) -> Self {
        Self { kind, ids: [u32::MAX; Self::SLOTS], tested: [0; Self::SLOTS], next: 0 }
    }

    /// Forgets everything.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        match self.kind {
            KdMailbox::None => {}
            KdMailbox::Ring => self.ids[..Self::RING].fill(u32::MAX),
            KdMailbox::Hashed => self.ids.fill(u32::MAX),
        }
    }

    /// Whether a triangle was tested for any member.
    #[inline(always)]
    pub(super) fn has(&self, id: u32) -> bool {
        match self.kind {
            KdMailbox::None => false,
            KdMailbox::Ring => self.ids[..Self::RING].contains(&id),
            KdMailbox::Hashed => self.ids[id as usize % Self::SLOTS] == id,
        }
    }

    /// Those `members` that weren't tested yet; now they are.
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
            KdMailbox::Hashed => id as usize % Self::SLOTS,
        };
        let tested = if self.ids[slot] == id { self.tested[slot] } else { 0 };
        self.ids[slot] = id;
        self.tested[slot] = tested | members as u16;
        members & !u64::from(tested)
    }
}
