use fearless_simd::Simd;
use fearless_simd::prelude::*;

use super::filter::{Wide, load, splat};
use super::rays::{LANES, Rays};
use super::scale::Scale;
use crate::kdtree::extent::Plane;

/// Members of a group of rays in a cell, and their intervals of τ there.
#[derive(Clone, Copy)]
pub(super) struct Within<V> {
    /// A bit for each.
    pub(super) members: u64,
    pub(super) enter: V,
    pub(super) leave: V,
}

/// The children of a node that members of a group may meet.
pub(super) enum Way<V> {
    Left,
    Right,
    /// The left one and the right one.
    Both([Within<V>; 2]),
}

/// The rays from `first` on at the root.
#[inline(always)]
pub(super) fn begin<S: Simd, V: Wide<S>>(simd: S, rays: &Rays, first: usize) -> Within<V> {
    let (enter, leave) = (load::<S, V>(simd, &rays.enter, first), load::<S, V>(simd, &rays.leave, first));
    Within { members: enter.simd_le(leave).to_bitmask(), enter, leave }
}

/// Returns the children that members of a group may meet; there is at least one member. A ray is in one of them up to its τ
/// at the plane, in the other one from there on, each grown by doubt.
#[inline(always)]
pub(super) fn way<S: Simd, V: Wide<S>>(
    simd: S,
    scale: &Scale,
    rays: &Rays,
    first: usize,
    plane: Plane,
    within: &Within<V>,
) -> Way<V> {
    let axis = plane.axis % 3;
    let at = splat::<S, V>(simd, scale.plane(plane));
    let inverse = load::<S, V>(simd, &rays.inverse[axis], first);
    let doubt = load::<S, V>(simd, &rays.doubt[axis], first);
    let crossing = (at - load::<S, V>(simd, &rays.origin[axis], first)) * inverse;
    let (early, late) = (crossing - doubt, crossing + doubt);
    let &Within { members, enter, leave } = within;
    let near = enter.simd_le(late).to_bitmask() & members;
    let far = early.simd_le(leave).to_bitmask() & members;
    let backward = backward::<S, V>(rays, axis, first);
    let left = near & !backward | far & backward;
    let right = near & backward | far & !backward;
    if right == 0 {
        Way::Left
    } else if left == 0 {
        Way::Right
    } else {
        let (near_leave, far_enter) = (leave.min(late), enter.max(early));
        // Packets of rays from one point mostly agree.
        let turned = backward & members;
        if turned == 0 {
            Way::Both([
                Within { members: left, enter, leave: near_leave },
                Within { members: right, enter: far_enter, leave },
            ])
        } else if turned == members {
            Way::Both([
                Within { members: left, enter: far_enter, leave },
                Within { members: right, enter, leave: near_leave },
            ])
        } else {
            let backward = V::Mask::from_bitmask(simd, backward);
            Way::Both([
                Within {
                    members: left,
                    enter: backward.select(far_enter, enter),
                    leave: backward.select(leave, near_leave),
                },
                Within {
                    members: right,
                    enter: backward.select(enter, far_enter),
                    leave: backward.select(near_leave, leave),
                },
            ])
        }
    }
}

/// Returns a mask of the rays from `first` on that run towards lower coordinates of an axis.
#[inline(always)]
pub(super) fn backward<S: Simd, V: Wide<S>>(rays: &Rays, axis: usize, first: usize) -> u64 {
    let word = u64::from(rays.backward[axis][first / LANES]);
    word >> (first % LANES) & ((1 << V::LEN) - 1)
}
