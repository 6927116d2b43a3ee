//! Rays of a packet, eight in lanes, and their tests at leaves.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};
use umbrage_rays::internals::{BVH_LESS, BVH_MORE, BVH_WIDTH, BvhLeaf, BvhLine, BvhNearest, BvhNode};

/// Rays of a group.
pub(super) const LANES: usize = 8;

/// Query of a ray at the leaves that it reaches. It isn't inlined: each method would have a copy for each level.
pub(super) trait Task {
    /// Tests ray `index` of the packet against the triangles in some lanes of a leaf. It may lower `far`, the t beyond
    /// which hits don't matter, to minus infinity if none matters any more.
    fn test<S: Simd>(&mut self, simd: S, index: usize, leaf: usize, lanes: u32, far: &mut f32);
}

/// Finds the nearest hit of each ray.
pub(super) struct NearestTask<'a> {
    pub(super) lines: &'a [BvhLine],
    pub(super) leaves: &'a [BvhLeaf],
    pub(super) nearest: Vec<BvhNearest<'a>>,
    /// For each ray, the t beyond which hits don't matter.
    pub(super) far: Vec<f32>,
}

impl Task for NearestTask<'_> {
    fn test<S: Simd>(&mut self, simd: S, index: usize, leaf: usize, lanes: u32, far: &mut f32) {
        simd.vectorize(
            #[inline(always)]
            || {
                if let Some(found) = self.leaves[leaf].find(simd, &self.lines[index], lanes, *far) {
                    self.nearest[index].take(simd, leaf, &found, far);
                    self.far[index] = *far;
                }
            },
        );
    }
}

/// Finds blocked rays: `blocks` decides for a ray and a triangle's id.
pub(super) struct BlockedTask<'a, F> {
    pub(super) lines: &'a [BvhLine],
    pub(super) leaves: &'a [BvhLeaf],
    pub(super) blocks: F,
    pub(super) is_blocked: Vec<bool>,
}

impl<F: Fn(usize, u32) -> bool> Task for BlockedTask<'_, F> {
    fn test<S: Simd>(&mut self, simd: S, index: usize, leaf: usize, lanes: u32, far: &mut f32) {
        if self.is_blocked[index] {
            return;
        }
        let leaf = &self.leaves[leaf];
        let found = simd.vectorize(
            #[inline(always)]
            || leaf.find(simd, &self.lines[index], lanes, *far),
        );
        let Some(found) = found else { return };
        if bits_of(found.possible.into()).any(|lane| (self.blocks)(index, leaf.ids[lane % BvhLeaf::LANES])) {
            self.is_blocked[index] = true;
            *far = f32::NEG_INFINITY;
        }
    }
}

/// Eight rays in lanes, none with a t below zero. Boxes are culled by the same numbers as in [`BvhLine`].
#[derive(Clone)]
pub(super) struct Group {
    enter_origin: [[f32; LANES]; 3],
    leave_origin: [[f32; LANES]; 3],
    enter_inverse: [[f32; LANES]; 3],
    leave_inverse: [[f32; LANES]; 3],
    near: [f32; LANES],
    pub(super) far: [f32; LANES],
    /// The bounds of a node that the rays reach first, if they agree.
    first: Option<[usize; 3]>,
}

impl Group {
    /// Up to eight rays, each with the t beyond which hits don't matter.
    pub(super) fn new<'a>(lines: impl Iterator<Item = (&'a BvhLine, f32)>) -> Self {
        let zero = [[0.0; LANES]; 3];
        let mut group = Self {
            enter_origin: zero,
            leave_origin: zero,
            enter_inverse: zero,
            leave_inverse: zero,
            near: [f32::INFINITY; LANES],
            far: [f32::NEG_INFINITY; LANES],
            first: None,
        };
        let mut agree = true;
        for (lane, (line, far)) in lines.enumerate() {
            for axis in 0..3 {
                group.enter_origin[axis][lane] = line.enter_origin[axis];
                group.leave_origin[axis][lane] = line.leave_origin[axis];
                group.enter_inverse[axis][lane] = line.inverse[axis] * BVH_LESS;
                group.leave_inverse[axis][lane] = line.inverse[axis] * BVH_MORE;
            }
            (group.near[lane], group.far[lane]) = (line.near, far);
            agree &= *group.first.get_or_insert(line.is_backward) == line.is_backward;
        }
        group.first = group.first.filter(|_| agree);
        group
    }

    /// All rays of a packet in groups.
    pub(super) fn all(lines: &[BvhLine]) -> Vec<Self> {
        lines.chunks(LANES).map(|lines| Self::new(lines.iter().map(|line| (line, line.far)))).collect()
    }

    /// Lower bound on t of each ray's entry into a child's box, and a bit for each ray that doesn't certainly miss it;
    /// infinity for a miss.
    #[inline(always)]
    pub(super) fn enter<S: Simd>(&self, simd: S, node: &BvhNode, slot: usize) -> (f32x8<S>, u32) {
        let slot = slot % BVH_WIDTH;
        let (mut enter, mut leave) = (f32x8::splat(simd, f32::NEG_INFINITY), f32x8::from_slice(simd, &self.far));
        for axis in 0..3 {
            let low = f32x8::splat(simd, node.bounds[2 * axis][slot]);
            let high = f32x8::splat(simd, node.bounds[2 * axis + 1][slot]);
            let enter_inverse = f32x8::from_slice(simd, &self.enter_inverse[axis]);
            let leave_inverse = f32x8::from_slice(simd, &self.leave_inverse[axis]);
            let (first, last) = match self.first {
                Some(first) if first[axis] == 0 => (low, high),
                Some(_) => (high, low),
                None => {
                    let is_backward = enter_inverse.simd_lt(0.0);
                    (is_backward.select(high, low), is_backward.select(low, high))
                }
            };
            enter = enter.max((first - f32x8::from_slice(simd, &self.enter_origin[axis])) * enter_inverse);
            leave = leave.min((last - f32x8::from_slice(simd, &self.leave_origin[axis])) * leave_inverse);
        }
        // NaN becomes the start of the ray's interval.
        let near = f32x8::from_slice(simd, &self.near);
        let enter = enter.simd_gt(near).select(enter, near);
        let missed = enter.simd_gt(leave);
        (missed.select(f32x8::splat(simd, f32::INFINITY), enter), !(missed.to_bitmask() as u32) & 0xff)
    }

    /// A bit for each ray for which a hit at t may matter.
    #[inline(always)]
    pub(super) fn waiting<S: Simd>(&self, simd: S, t: f32) -> u32 {
        f32x8::from_slice(simd, &self.far).simd_ge(t).to_bitmask() as u32 & 0xff
    }
}

/// Indices of a word's set bits, the lowest first.
#[inline(always)]
pub(super) fn bits_of(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (bit < 64).then_some(bit)
    })
}

/// A mask of `count` bits.
pub(super) fn bits_below(count: usize) -> u64 {
    u64::MAX.checked_shr(64 - count as u32).unwrap_or(0)
}

/// A node's children in the mask `children`, the farthest first.
#[inline(always)]
pub(super) fn farthest_first(children: u32, keys: &[f32; BVH_WIDTH]) -> impl Iterator<Item = usize> + use<> {
    let (mut slots, mut count) = ([0_usize; BVH_WIDTH], 0);
    for slot in bits_of(children.into()) {
        let mut at = count;
        while at > 0 && keys[slots[at - 1]] < keys[slot] {
            slots[at] = slots[at - 1];
            at -= 1;
        }
        slots[at] = slot;
        count += 1;
    }
    slots.into_iter().take(count)
}

/// A mask of a node's children.
#[inline(always)]
pub(super) fn children_of(node: &BvhNode) -> u32 {
    let bit = |slot: usize| u32::from(node.children[slot] != umbrage_rays::internals::BvhChild::NONE) << slot;
    (0..BVH_WIDTH).fold(0, |bits, slot| bits | bit(slot))
}
