use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8, mask64x8};

use super::scale::Scale;
use crate::kdtree::extent::Extent;
use umbrage_rays::Ray;

/// The largest number of rays that are prepared at once.
pub const MOST_RAYS: usize = 256;

/// The number of rays in the widest groups.
pub const LANES: usize = 16;

/// Half the distance from one to the next f32.
pub const HALF_ULP: f32 = 1.0 / (1 << 24) as f32;

/// A number for each ray.
pub(super) type Numbers = [f32; MOST_RAYS];

/// Rays in a tree's [coordinates](Scale), in f32: o + τ d, where τ is zero where a ray enters the tree's bounds or its
/// interval, and the largest component of d is one. 13 KiB.
///
/// **Error bounds.** Let ε be half an ulp of an f32. Planes and origins are one at most and have one rounding each; their
/// difference has a third, relative to two. Its product with 1 / d has two more of its own, so the error of a τ of no more
/// than 4 is less than (4 + 8) ε / |d|. `doubt` is 32 ε / |d| plus the loss of f64 on the way to the origin: an interval
/// that is grown by it holds all hits of its cell, and larger τ are certainly outside. If a ray runs almost along a plane,
/// |d| is taken as 2⁻⁴⁰, which moves points of the ray by less than ε.
#[repr(align(64))]
pub struct Rays {
    /// The number of rays.
    pub count: usize,
    /// o, by axis.
    pub origin: [Numbers; 3],
    /// d, by axis.
    pub direction: [Numbers; 3],
    /// 1 / d.
    pub inverse: [Numbers; 3],
    /// Error bound of τ at planes across each axis.
    pub doubt: [Numbers; 3],
    /// The τ at which the relevant part of each ray begins, minus its error; above `leave` if no part is relevant.
    pub enter: Numbers,
    /// The τ at which that part ends, plus its error.
    pub leave: Numbers,
    /// Masks of the rays that run towards lower coordinates of each axis.
    pub(super) backward: [[u16; MOST_RAYS / LANES]; 3],
    /// The t at which τ is zero, the τ in one unit of t, and the error bound of a τ that comes from a t.
    start: [f64; MOST_RAYS],
    rate: [f64; MOST_RAYS],
    slack: Numbers,
    /// The largest distance by which f64 may have moved an origin.
    pub moved: f32,
    /// Masks of rays whose numbers are too large or small to be trusted: they are tested against all triangles.
    pub(super) exhaustive: [u16; MOST_RAYS / LANES],
}

impl Default for Rays {
    fn default() -> Self {
        Self {
            count: 0,
            origin: [[0.0; MOST_RAYS]; 3],
            direction: [[0.0; MOST_RAYS]; 3],
            inverse: [[1.0; MOST_RAYS]; 3],
            doubt: [[0.0; MOST_RAYS]; 3],
            enter: [1.0; MOST_RAYS],
            leave: [-1.0; MOST_RAYS],
            backward: [[0; MOST_RAYS / LANES]; 3],
            start: [0.0; MOST_RAYS],
            rate: [0.0; MOST_RAYS],
            slack: [0.0; MOST_RAYS],
            moved: 0.0,
            exhaustive: [0; MOST_RAYS / LANES],
        }
    }
}

/// The least magnitude that a direction's component is taken as, relative to the largest one.
const LEAST_COMPONENT: f64 = 1.0 / (1_u64 << 40) as f64;

impl Rays {
    /// Prepares `count` rays.
    #[inline(always)]
    pub(super) fn set_up<S: Simd>(
        &mut self,
        simd: S,
        extent: &Extent,
        scale: &Scale,
        ray: &dyn Fn(usize) -> Ray,
        count: usize,
    ) {
        self.count = count;
        self.moved = 0.0;
        for first in (0..count).step_by(8) {
            let mut eight = Eight::default();
            for lane in 0..8 {
                // The last group is filled up with its last ray again, which isn't alive.
                let Ray { origin, direction, t_min, t_max } = ray((first + lane).min(count - 1));
                for axis in 0..3 {
                    eight.origin[axis][lane] = origin[axis];
                    eight.direction[axis][lane] = direction[axis];
                }
                (eight.t_min[lane], eight.t_max[lane]) = (t_min, t_max);
            }
            self.set_up_eight(simd, extent, scale, &eight, first, (count - first).min(8));
        }
        // The rest of the last group may hold earlier rays.
        let whole = count.next_multiple_of(8);
        for dead in whole..count.next_multiple_of(LANES) {
            (self.enter[dead], self.leave[dead]) = (1.0, -1.0);
        }
        if !whole.is_multiple_of(LANES) {
            self.exhaustive[whole / LANES] &= 0xff;
        }
    }

    #[inline(always)]
    fn set_up_eight<S: Simd>(
        &mut self,
        simd: S,
        extent: &Extent,
        scale: &Scale,
        eight: &Eight,
        first: usize,
        members: usize,
    ) {
        let mut enter = f64x8::from_slice(simd, &eight.t_min);
        let mut leave = f64x8::from_slice(simd, &eight.t_max);
        let mut missed = mask64x8::splat(simd, false);
        let mut trusted = mask64x8::splat(simd, true);
        let mut longest = splat(simd, 0.0);
        for axis in 0..3 {
            let [low, high] = [extent.min[axis], extent.max[axis]].map(f64::from);
            let (low, high) = (splat(simd, low), splat(simd, high));
            let origin = f64x8::from_slice(simd, &eight.origin[axis]);
            let direction = f64x8::from_slice(simd, &eight.direction[axis]);
            longest = longest.max(direction.abs());
            let across = direction.simd_eq(splat(simd, 0.0));
            let inverse = splat(simd, 1.0) / across.select(splat(simd, 1.0), direction);
            let (a, b) = ((low - origin) * inverse, (high - origin) * inverse);
            trusted &= across | (inverse.is_finite() & a.is_finite() & b.is_finite());
            missed |= across & (origin.simd_lt(low) | origin.simd_gt(high));
            enter = across.select(enter, enter.max(a.min(b)));
            leave = across.select(leave, leave.min(a.max(b)));
        }
        // The same doubt as for single rays.
        const DOUBT: f64 = 1.0 / (1_u64 << 48) as f64;
        let size = enter.abs().max(leave.abs());
        let doubt = size * splat(simd, DOUBT) + splat(simd, 1e-300);
        let (enter, leave) = (enter - doubt, leave + doubt);
        let unit = splat(simd, f64::from(scale.unit));
        let rate = longest * unit;
        // Rounded up in f32: 16 ε are more than the roundings of a τ of four or less.
        let slack = doubt * splat(simd, 4.0) * rate + splat(simd, 16.0 * f64::from(HALF_ULP));
        trusted &= enter.is_finite() & leave.is_finite() & slack.simd_lt(splat(simd, 0.25));
        let shrink = splat(simd, 1.0) / longest;
        trusted &= shrink.is_finite();
        let mut moved = splat(simd, 0.0);
        let mut coordinates = [splat(simd, 0.0); 3];
        for (axis, coordinate) in coordinates.iter_mut().enumerate() {
            let origin = f64x8::from_slice(simd, &eight.origin[axis]);
            let step = f64x8::from_slice(simd, &eight.direction[axis]) * enter;
            moved = moved.max(origin.abs() + step.abs());
            *coordinate = (origin + step - splat(simd, f64::from(scale.middle[axis]))) * unit;
        }
        // Four roundings, relative to the sum above or to twice as much.
        const MOVED: f64 = 1.0 / (1_u64 << 50) as f64;
        let moved = moved * splat(simd, MOVED) * unit;
        trusted &= moved.simd_lt(splat(simd, 0.25));
        let [zero, one] = [splat(simd, 0.0), splat(simd, 1.0)];
        let alive = trusted & enter.simd_le(leave) & !missed & mask64x8::from_bitmask(simd, (1 << members) - 1);
        let margin = moved + splat(simd, 32.0 * f64::from(HALF_ULP));
        let (group, half) = (first / LANES, first % LANES / 8);
        for (axis, coordinate) in coordinates.into_iter().enumerate() {
            let direction = alive.select(f64x8::from_slice(simd, &eight.direction[axis]) * shrink, one);
            let steep = direction.abs().max(splat(simd, LEAST_COMPONENT)).copysign(direction);
            let inverse = one / steep;
            store(alive.select(coordinate, zero), &mut self.origin[axis], first);
            store(direction, &mut self.direction[axis], first);
            store(inverse, &mut self.inverse[axis], first);
            store(alive.select(inverse.abs() * margin, zero), &mut self.doubt[axis], first);
            set_byte(&mut self.backward[axis][group], half, steep.simd_lt(zero).to_bitmask());
        }
        let width = (leave - enter) * rate;
        store(alive.select(-slack, one), &mut self.enter, first);
        store(alive.select(width + slack, -one), &mut self.leave, first);
        store(slack, &mut self.slack, first);
        enter.store_slice(&mut self.start[first..first + 8]);
        rate.store_slice(&mut self.rate[first..first + 8]);
        self.moved = self.moved.max(alive.select(moved, zero).reduce_max() as f32);
        let exhaustive = !trusted & !missed & mask64x8::from_bitmask(simd, (1 << members) - 1);
        set_byte(&mut self.exhaustive[group], half, exhaustive.to_bitmask());
    }

    /// Ends a ray: nothing at this t or later matters to it.
    #[inline(always)]
    pub fn end(&mut self, index: usize, t: f64) {
        if t < f64::INFINITY {
            let end = ((t - self.start[index]) * self.rate[index]) as f32 + self.slack[index];
            // Never later than before: a node that no longer matters isn't visited again.
            self.leave[index] = self.leave[index].min(end);
        }
    }
}

/// Eight rays as they are given.
#[derive(Default)]
struct Eight {
    origin: [[f64; 8]; 3],
    direction: [[f64; 8]; 3],
    t_min: [f64; 8],
    t_max: [f64; 8],
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f64) -> f64x8<S> {
    f64x8::splat(simd, value)
}

#[inline(always)]
fn store<S: Simd>(values: f64x8<S>, to: &mut Numbers, first: usize) {
    let narrow: [f32; 16] = values.narrow(values).into();
    to[first..first + 8].copy_from_slice(&narrow[..8]);
}

#[inline(always)]
fn set_byte(word: &mut u16, half: usize, byte: u64) {
    *word = *word & !(0xff << (8 * half)) | (byte as u16) << (8 * half);
}
