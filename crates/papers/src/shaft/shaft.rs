use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

use crate::kdtree::{Extent, HALF_ULP, LANES, MOST_RAYS, Plane, Rays, Scale, load};
use umbrage_rays::Ray;

use super::bits_of;
use super::search::Met;

/// Number of ray groups of a shaft.
pub(super) const GROUPS: usize = MOST_RAYS / LANES;

/// Minimum component of rays along a shaft's axis, relative to any other component.
const LEAST: f32 = 0.25;

/// Minimum length of a shaft along its axis.
const SHORTEST: f32 = 1e-3;

/// Bound on rounding errors of positions along the axis, which are one at most.
const SLACK: f64 = 1e-9;

/// For each axis the order in which it is the last one.
const ORDERS: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// The order of axes in which a shaft's own is the last one, and the rays' direction along that.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axes {
    pub(super) order: [usize; 3],
    /// 1 if rays run towards higher coordinates, else −1.
    pub(super) sign: f32,
}

impl Axes {
    /// The axes for rays that agree about the sign of an axis and aren't almost perpendicular to it; `None` if there is
    /// no such axis, or no ray that matters.
    #[inline(always)]
    pub(super) fn of<S: Simd>(simd: S, rays: &Rays) -> Option<Self> {
        let mut best: Option<(f32, Self)> = None;
        for (axis, order) in ORDERS.into_iter().enumerate() {
            let mut low = f32x16::splat(simd, f32::INFINITY);
            let mut high = f32x16::splat(simd, f32::NEG_INFINITY);
            for first in (0..rays.count).step_by(LANES) {
                let direction: f32x16<S> = load(simd, &rays.direction[axis], first);
                let alive = alive(simd, rays, first);
                low = alive.select(low.min(direction), low);
                high = alive.select(high.max(direction), high);
            }
            let (low, high) = (low.reduce_min(), high.reduce_max());
            let (least, sign) = if low > 0.0 { (low, 1.0) } else { (-high, -1.0) };
            if least > LEAST && least.is_finite() && best.is_none_or(|(best, _)| least > best) {
                best = Some((least, Self { order, sign }));
            }
        }
        best.map(|(_, axes)| axes)
    }

    /// A point's coordinates along u, v and the shaft's axis.
    #[inline(always)]
    pub(super) fn turned(&self, point: [f32; 3]) -> [f32; 3] {
        let [u, v, w] = self.order;
        [point[u], point[v], point[w] * self.sign]
    }

    /// A mask of a group's rays that matter, and the interval of each along the shaft's axis.
    #[inline(always)]
    fn ways<S: Simd>(&self, simd: S, rays: &Rays, first: usize) -> (mask32x16<S>, f32x16<S>, f32x16<S>) {
        let axis = self.order[2];
        let sign = f32x16::splat(simd, self.sign);
        let origin = load::<S, f32x16<S>>(simd, &rays.origin[axis], first) * sign;
        let direction = load::<S, f32x16<S>>(simd, &rays.direction[axis], first) * sign;
        let enter = origin + direction * load::<S, f32x16<S>>(simd, &rays.enter, first);
        let leave = origin + direction * load::<S, f32x16<S>>(simd, &rays.leave, first);
        (alive(simd, rays, first), enter, leave)
    }

    /// The last position along the axis at which a hit may matter to a ray of a group; −∞ if there is none.
    #[inline(always)]
    pub(super) fn last<S: Simd>(&self, simd: S, rays: &Rays, group: usize) -> f32 {
        let (alive, _, leave) = self.ways(simd, rays, group * LANES);
        alive.select(leave, f32x16::splat(simd, f32::NEG_INFINITY)).reduce_max() + margin(rays)
    }

    /// Low and high bounds along u and v of a group's rays at a position `way` along the axis, widened by `margin`.
    ///
    /// With slopes of four at most, each with three roundings, ways of two and coordinates of nine, the error is 54 ε
    /// and five times the distance by which f64 may have moved origins; `margin` is more than four times as much, which
    /// leaves room for later arithmetic.
    #[inline(always)]
    fn rectangle<S: Simd>(&self, simd: S, rays: &Rays, first: usize, members: mask32x16<S>, way: f32) -> [f32; 4] {
        let w = self.order[2];
        let sign = f32x16::splat(simd, self.sign);
        let distance = f32x16::splat(simd, way) - load::<S, f32x16<S>>(simd, &rays.origin[w], first) * sign;
        let inverse = load::<S, f32x16<S>>(simd, &rays.inverse[w], first) * sign;
        let mut rectangle = [0.0; 4];
        for index in 0..2 {
            let axis = self.order[index];
            let slope = load::<S, f32x16<S>>(simd, &rays.direction[axis], first) * inverse;
            let at = load::<S, f32x16<S>>(simd, &rays.origin[axis], first) + distance * slope;
            let (least, most) = (f32x16::splat(simd, f32::INFINITY), f32x16::splat(simd, f32::NEG_INFINITY));
            rectangle[2 * index] = members.select(at, least).reduce_min() - margin(rays);
            rectangle[2 * index + 1] = members.select(at, most).reduce_max() + margin(rays);
        }
        rectangle
    }
}

/// A mask of a group's rays that matter.
#[inline(always)]
pub(super) fn alive<S: Simd>(simd: S, rays: &Rays, first: usize) -> mask32x16<S> {
    load::<S, f32x16<S>>(simd, &rays.enter, first).simd_le(load::<S, f32x16<S>>(simd, &rays.leave, first))
}

fn margin(rays: &Rays) -> f32 {
    256.0 * HALF_ULP + 8.0 * rays.moved
}

/// Bounding rectangle of two rectangles.
fn union(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    [a[0].min(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].max(b[3])]
}

const NOTHING: [f32; 4] = [f32::INFINITY, f32::NEG_INFINITY, f32::INFINITY, f32::NEG_INFINITY];

/// A convex part of space that holds rays: between two rectangles across an axis (Reshetov et al. 2005 and 2007;
/// Overbeck et al., *Large Ray Packets for Real-time Whitted Ray Tracing*, 2008).
///
/// The lowest coordinate of lines is a concave function of the way along the axis, the highest a convex one: between
/// two ways the chords of both hold all lines. Four faces are linear functions: low and high along u, low and high
/// along v.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shaft {
    pub(super) axes: Axes,
    /// Interval along the axis in which a triangle may be hit.
    pub(super) from: f32,
    pub(super) to: f32,
    /// Offsets of the faces at `from`, and their rates along the axis: four at most, like the slopes.
    at: [f32; 4],
    rate: [f32; 4],
}

impl Shaft {
    fn between(axes: Axes, [from, to]: [f32; 2], near: [f32; 4], far: [f32; 4]) -> Self {
        let rate = [0, 1, 2, 3].map(|face| (far[face] - near[face]) / (to - from));
        Self { axes, from, to, at: near, rate }
    }

    /// A shaft around all rays between four, inside a tree's bounds; `None` if the four don't agree about the sign of
    /// an axis, one is almost perpendicular to it, or they come from too far away.
    ///
    /// A line between others crosses a plane between their crossings.
    pub(super) fn between_corners(scale: &Scale, extent: &Extent, corners: &[Ray; 4]) -> Option<Self> {
        let steepness = |axis: usize, sign: f64| {
            let steepness = corners.iter().map(|ray| sign * ray.direction[axis] / ray.direction.abs().max_element());
            steepness.fold(f64::INFINITY, f64::min)
        };
        let signed = (0..3).flat_map(|axis| [1.0, -1.0].map(|sign| (steepness(axis, sign), axis, sign)));
        let (least, axis, sign) = signed.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let axes = Axes { order: ORDERS[axis], sign: sign as f32 };
        let unit = f64::from(scale.unit);
        let origins = corners.map(|ray| {
            let [u, v, w] = axes.order.map(|axis| (ray.origin[axis] - f64::from(scale.middle[axis])) * unit);
            [u, v, w * sign]
        });
        let reach = origins.iter().flatten().fold(0.0_f64, |reach, at| reach.max(at.abs()));
        // f64 loses less than 2⁻⁴⁸ of the distance from an origin; eight times `Rays::moved` are that much.
        let margin = 256.0 * f64::from(HALF_ULP) + reach / (1_u64 << 45) as f64;
        if !(least > f64::from(LEAST) && margin < 1.0) {
            return None;
        }
        let ends = [extent.min[axis], extent.max[axis]].map(|at| scale.coordinate(at, axis) * axes.sign);
        let first = origins.iter().fold(f64::INFINITY, |first, origin| first.min(origin[2]));
        let from = first.max(f64::from(ends[0].min(ends[1]))) - margin;
        let to = (f64::from(ends[0].max(ends[1])) + margin).max(from + f64::from(SHORTEST));
        let rectangle = |way: f64| {
            let mut rectangle = [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
            for (ray, origin) in corners.iter().zip(&origins) {
                for side in 0..2 {
                    let slope = ray.direction[axes.order[side]] / (ray.direction[axis] * sign);
                    let at = origin[side] + (way - origin[2]) * slope;
                    rectangle[2 * side] = rectangle[2 * side].min(at - margin);
                    rectangle[2 * side + 1] = rectangle[2 * side + 1].max(at + margin);
                }
            }
            rectangle.map(|face| face as f32)
        };
        Some(Self::between(axes, [from as f32, to as f32], rectangle(from), rectangle(to)))
    }

    /// Coordinate of a face at a position along the axis.
    #[inline(always)]
    fn face(&self, face: usize, way: f32) -> f32 {
        self.at[face] + self.rate[face] * (way - self.from)
    }

    /// The intervals inside `within` at which the shaft may be in the left and in the right cell of a node; an empty
    /// one ends before it starts.
    #[inline(always)]
    pub(super) fn parts(&self, scale: &Scale, plane: Plane, within: [f64; 2]) -> [[f64; 2]; 2] {
        let [enter, leave] = within;
        let at = f64::from(scale.plane(plane));
        let Some(side) = self.axes.order[..2].iter().position(|&axis| axis == plane.axis) else {
            let way = at * f64::from(self.axes.sign);
            // One rounding of the plane's coordinate.
            let slack = 2.0 * f64::from(HALF_ULP);
            let parts = [[enter, leave.min(way + slack)], [enter.max(way - slack), leave]];
            return if self.axes.sign > 0.0 { parts } else { [parts[1], parts[0]] };
        };
        let part = |face: usize, is_below: bool| {
            // The face reaches the plane at this position, or never.
            let rate = f64::from(self.rate[face]);
            let offset = at - f64::from(self.at[face]);
            let way = f64::from(self.from) + offset / rate;
            let comes_closer = if is_below { rate.is_sign_negative() } else { rate.is_sign_positive() };
            // NaN if the face is in the plane; `max` and `min` ignore it.
            if comes_closer { [enter.max(way - SLACK), leave] } else { [enter, leave.min(way + SLACK)] }
        };
        [part(2 * side, true), part(2 * side + 1, false)]
    }

    /// Whether the left child comes before the right one for most rays.
    #[inline(always)]
    pub(super) fn is_left_first(&self, axis: usize) -> bool {
        match self.axes.order.iter().position(|&other| other == axis) {
            Some(index @ 0..=1) => self.rate[2 * index] + self.rate[2 * index + 1] >= 0.0,
            _ => self.axes.sign > 0.0,
        }
    }

    /// Whether all corners of a triangle, [turned](Axes::turned), are outside of one face, or before or behind the shaft.
    #[inline(always)]
    pub(super) fn is_beside(&self, corners: &[[f32; 3]; 3]) -> bool {
        let outside = |is_outside: &dyn Fn(&[f32; 3]) -> bool| corners.iter().all(is_outside);
        outside(&|&[u, _, w]| u < self.face(0, w))
            || outside(&|&[u, _, w]| u > self.face(1, w))
            || outside(&|&[_, v, w]| v < self.face(2, w))
            || outside(&|&[_, v, w]| v > self.face(3, w))
            || outside(&|&[_, _, w]| w < self.from)
            || outside(&|&[_, _, w]| w > self.to)
    }

    /// Lines from each corner of the first rectangle to each corner of the other one.
    pub(super) fn corner_lines(&self) -> Lines {
        let mut lines = Lines { origin: [[0.0; LANES]; 3], direction: [[0.0; LANES]; 3] };
        let [u, v, w] = self.axes.order;
        for line in 0..LANES {
            let corner = |bits: usize, way: f32| [self.face(bits & 1, way), self.face(2 + (bits >> 1 & 1), way)];
            let [near, far] = [corner(line, self.from), corner(line >> 2, self.to)];
            let along = [far[0] - near[0], far[1] - near[1], self.to - self.from];
            let longest = along[0].abs().max(along[1].abs()).max(along[2]);
            for (axis, at, along) in [(u, near[0], along[0]), (v, near[1], along[1])] {
                lines.origin[axis][line] = at;
                lines.direction[axis][line] = along / longest;
            }
            lines.origin[w][line] = self.from * self.axes.sign;
            lines.direction[w][line] = along[2] / longest * self.axes.sign;
        }
        lines
    }
}

/// Sixteen lines.
#[repr(align(64))]
pub(super) struct Lines {
    pub(super) origin: [[f32; LANES]; 3],
    pub(super) direction: [[f32; LANES]; 3],
}

/// A shaft around rays, and one around each group of them.
pub(super) struct Bundle {
    pub(super) whole: Shaft,
    /// The faces of each group's shaft, as in [`Shaft`].
    at: [[f32; GROUPS]; 4],
    rate: [[f32; GROUPS]; 4],
    /// The last position that matters to each group.
    last: [f32; GROUPS],
}

impl Bundle {
    /// Shafts around all rays that matter; there must be some.
    #[inline(always)]
    pub(super) fn around<S: Simd>(simd: S, rays: &Rays, axes: Axes) -> Self {
        let groups = rays.count.div_ceil(LANES);
        let (mut from, mut to) = (f32::INFINITY, f32::NEG_INFINITY);
        for first in (0..rays.count).step_by(LANES) {
            let (alive, enter, leave) = axes.ways(simd, rays, first);
            from = from.min(alive.select(enter, f32x16::splat(simd, f32::INFINITY)).reduce_min());
            to = to.max(alive.select(leave, f32x16::splat(simd, f32::NEG_INFINITY)).reduce_max());
        }
        let from = from - margin(rays);
        let to = (to + margin(rays)).max(from + SHORTEST);
        let mut bundle = Self {
            whole: Shaft::between(axes, [from, to], NOTHING, NOTHING),
            // An interval that ends before it starts.
            at: [[1e9; GROUPS], [-1e9; GROUPS], [1e9; GROUPS], [-1e9; GROUPS]],
            rate: [[0.0; GROUPS]; 4],
            last: [f32::NEG_INFINITY; GROUPS],
        };
        let (mut near, mut far) = (NOTHING, NOTHING);
        for group in 0..groups {
            let alive = alive(simd, rays, group * LANES);
            if alive.any_true() {
                let ends = [from, to].map(
                    #[inline(always)]
                    |way| axes.rectangle(simd, rays, group * LANES, alive, way),
                );
                let shaft = Shaft::between(axes, [from, to], ends[0], ends[1]);
                for face in 0..4 {
                    (bundle.at[face][group], bundle.rate[face][group]) = (shaft.at[face], shaft.rate[face]);
                }
                bundle.last[group] = axes.last(simd, rays, group);
                (near, far) = (union(near, ends[0]), union(far, ends[1]));
            }
        }
        bundle.whole = Shaft::between(axes, [from, to], near, far);
        bundle
    }

    /// A shaft around the rays of the groups that may reach a leaf, inside the leaf; `None` if there are none.
    #[inline(always)]
    pub(super) fn transient<S: Simd>(&self, simd: S, rays: &Rays, scale: &Scale, leaf: &Met) -> Option<Shaft> {
        let axes = self.whole.axes;
        let groups = self.groups_in(simd, scale, leaf);
        let [from, to] = leaf.within;
        // Positions that were computed in f64, rounded outwards.
        let from = (from as f32 - margin(rays)).max(self.whole.from);
        let to = (to as f32 + margin(rays)).max(from + SHORTEST);
        let (mut near, mut far) = (NOTHING, NOTHING);
        for group in bits_of(groups) {
            let (alive, enter, leave) = axes.ways(simd, rays, group * LANES);
            let [start, end] = [from - margin(rays), to + margin(rays)].map(
                #[inline(always)]
                |way| f32x16::splat(simd, way),
            );
            let members = alive & leave.simd_ge(start) & enter.simd_le(end);
            if members.any_true() {
                near = union(near, axes.rectangle(simd, rays, group * LANES, members, from));
                far = union(far, axes.rectangle(simd, rays, group * LANES, members, to));
            }
        }
        (near[0] <= near[1]).then(|| Shaft::between(axes, [from, to], near, far))
    }

    /// Updates a group after its rays have become shorter.
    #[inline(always)]
    pub(super) fn shorten<S: Simd>(&mut self, simd: S, rays: &Rays, group: usize) {
        self.last[group] = self.whole.axes.last(simd, rays, group);
    }

    /// The last position that matters to any ray.
    #[inline(always)]
    pub(super) fn last<S: Simd>(&self, simd: S) -> f32 {
        f32x16::from_slice(simd, &self.last).reduce_max()
    }

    /// A mask of groups whose shafts may meet a node's cell before their last position.
    #[inline(always)]
    pub(super) fn groups_in<S: Simd>(&self, simd: S, scale: &Scale, met: &Met) -> u64 {
        let turned = |corner: [f32; 3]| {
            let [x, y, z] = corner;
            self.whole.axes.turned([scale.coordinate(x, 0), scale.coordinate(y, 1), scale.coordinate(z, 2)])
        };
        let (a, b) = (turned(met.cell.min), turned(met.cell.max));
        let low = [a[0].min(b[0]), a[1].min(b[1]), a[2].min(b[2])];
        self.groups(simd, low, [a[0].max(b[0]), a[1].max(b[1]), a[2].max(b[2])])
    }

    /// A mask of groups whose shafts may meet a box, given by its low and high corner, [turned](Axes::turned).
    #[inline(always)]
    pub(super) fn groups<S: Simd>(&self, simd: S, low: [f32; 3], high: [f32; 3]) -> u64 {
        let splat = |value: f32| f32x16::splat(simd, value);
        let Shaft { from, to, .. } = self.whole;
        // Faces are valid between the ends only.
        let near = splat(low[2].clamp(from, to) - from);
        let far = splat(high[2].clamp(from, to) - from);
        let mut met = f32x16::from_slice(simd, &self.last).simd_ge(splat(low[2]));
        if high[2] < from || low[2] > to {
            return 0;
        }
        for axis in 0..2 {
            let face = |index: usize| {
                let at = f32x16::from_slice(simd, &self.at[2 * axis + index]);
                let rate = f32x16::from_slice(simd, &self.rate[2 * axis + index]);
                (at + rate * near, at + rate * far)
            };
            let ((low_near, low_far), (high_near, high_far)) = (face(0), face(1));
            met = met
                & low_near.min(low_far).simd_le(splat(high[axis]))
                & high_near.max(high_far).simd_ge(splat(low[axis]));
        }
        met.to_bitmask()
    }
}
