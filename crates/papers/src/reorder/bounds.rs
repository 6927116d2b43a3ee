//! Bounds on all rays of a packet: intervals of their origins and of their slopes (Boulos et al. 2006; Overbeck et al.,
//! *Large ray packets for real-time Whitted ray tracing*, 2008).

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};
use umbrage_rays::internals::{BVH_WIDTH, BvhLine, BvhNode};

use super::rays::LANES;

/// Eight frusta. All of their rays have the same largest component of the direction, with the same sign: u is the
/// coordinate along it, times the sign. A frustum has intervals of its rays' positions in a near plane across that
/// axis, and of their slopes: steps along the other two axes for a step of u, one at most.
///
/// **Why no box is missed that a ray enters.** With ε = 2⁻²⁴ and r the largest of all coordinates of origins, plane and
/// crossings of the plane, and of distances to the plane: the crossings have an error of less than 8 ε r, and the
/// offset after w steps from there one of less than 8 ε w, with the roundings of slopes, products and sums. Boxes grow
/// by twice that.
pub(super) struct Bounds {
    /// The two other axes, and the axis of u.
    axes: [usize; 3],
    sign: f32,
    plane: [f32; LANES],
    /// Steps from the plane beyond which no hit matters to any ray.
    last: [f32; LANES],
    slack: [f32; LANES],
    low: [[f32; LANES]; 2],
    high: [[f32; LANES]; 2],
    /// The minimum and the maximum slope.
    least: [[f32; LANES]; 2],
    most: [[f32; LANES]; 2],
}

const ERROR: f32 = 16.0 / (1 << 24) as f32;
const SMALLEST: f32 = 1e-30;

impl Bounds {
    /// Bounds up to eight sets of rays, each ray with the t beyond which hits don't matter. `None` if the largest
    /// components of their directions differ in axis or sign, or if there are no rays.
    ///
    /// The near planes are at the first ray's origin, or at `face`, a box's near face, if that is farther: no ray needs
    /// hits before the box.
    pub(super) fn new<'a, R>(sets: impl Iterator<Item = R>, face: impl Fn(usize, f32) -> f32) -> Option<Self>
    where
        R: Iterator<Item = (&'a BvhLine, f32)> + Clone,
    {
        let mut bounds: Option<Self> = None;
        for (lane, set) in sets.enumerate() {
            let (first, _) = set.clone().next()?;
            let bounds = bounds.get_or_insert_with(|| Self::EMPTY.along(first));
            if set.clone().any(|(line, _)| line.axes != bounds.axes || line.sign != bounds.sign) {
                return None;
            }
            bounds.set(lane, set, face(bounds.axes[2], bounds.sign));
        }
        bounds
    }

    /// One set of rays, in all lanes.
    pub(super) fn of_one<'a>(
        set: &(impl Iterator<Item = (&'a BvhLine, f32)> + Clone),
        face: impl Fn(usize, f32) -> f32,
    ) -> Option<Self> {
        let mut bounds = Self::new(std::iter::once(set.clone()), face)?;
        for values in [&mut bounds.plane, &mut bounds.last, &mut bounds.slack] {
            *values = [values[0]; LANES];
        }
        for values in [&mut bounds.low, &mut bounds.high, &mut bounds.least, &mut bounds.most].into_iter().flatten() {
            *values = [values[0]; LANES];
        }
        Some(bounds)
    }

    const EMPTY: Self = Self {
        axes: [0; 3],
        sign: 0.0,
        plane: [f32::INFINITY; LANES],
        last: [f32::NEG_INFINITY; LANES],
        slack: [0.0; LANES],
        low: [[f32::INFINITY; LANES]; 2],
        high: [[f32::NEG_INFINITY; LANES]; 2],
        least: [[f32::INFINITY; LANES]; 2],
        most: [[f32::NEG_INFINITY; LANES]; 2],
    };

    fn along(self, line: &BvhLine) -> Self {
        Self { axes: line.axes, sign: line.sign, ..self }
    }

    fn set<'a>(&mut self, lane: usize, set: impl Iterator<Item = (&'a BvhLine, f32)> + Clone, face: f32) {
        let [i, j, k] = self.axes;
        let begin = |line: &BvhLine| line.origin[k] * self.sign;
        let plane = set.clone().map(|(line, _)| begin(line)).fold(f32::INFINITY, f32::min).max(face);
        let (mut last, mut reach) = (f32::NEG_INFINITY, plane.abs());
        for (line, far) in set {
            let steps = plane - begin(line);
            last = last.max(far - steps);
            reach = line.origin.iter().fold(reach.max(steps.abs()), |reach, at| reach.max(at.abs()));
            for (axis, origin) in [line.origin[i], line.origin[j]].into_iter().enumerate() {
                let slope = -line.slopes[axis] * self.sign;
                let at = origin + slope * steps;
                reach = reach.max(at.abs());
                self.low[axis][lane] = self.low[axis][lane].min(at);
                self.high[axis][lane] = self.high[axis][lane].max(at);
                self.least[axis][lane] = self.least[axis][lane].min(slope);
                self.most[axis][lane] = self.most[axis][lane].max(slope);
            }
        }
        self.plane[lane] = plane;
        self.slack[lane] = reach * ERROR + SMALLEST;
        self.last[lane] = last + self.slack[lane];
    }

    /// A bit for each child of a node that the first frustum may enter, if all frusta are the same.
    #[inline(always)]
    pub(super) fn children<S: Simd>(&self, simd: S, node: &BvhNode) -> u32 {
        self.entered(
            simd,
            #[inline(always)]
            |bound| f32x8::from_slice(simd, &node.bounds[bound]),
        )
    }

    /// A bit for each frustum that may enter a child.
    #[inline(always)]
    pub(super) fn entering<S: Simd>(&self, simd: S, node: &BvhNode, slot: usize) -> u32 {
        self.entered(
            simd,
            #[inline(always)]
            |bound| f32x8::splat(simd, node.bounds[bound][slot % BVH_WIDTH]),
        )
    }

    /// Distance along the rays at which each child begins.
    pub(super) fn order(&self, node: &BvhNode) -> [f32; BVH_WIDTH] {
        node.bounds[self.near_bound()].map(|bound| bound * self.sign)
    }

    fn near_bound(&self) -> usize {
        2 * self.axes[2] + usize::from(self.sign < 0.0)
    }

    #[inline(always)]
    fn entered<S: Simd>(&self, simd: S, bound: impl Fn(usize) -> f32x8<S>) -> u32 {
        let plane = f32x8::from_slice(simd, &self.plane);
        let slack = f32x8::from_slice(simd, &self.slack);
        let near = (bound(self.near_bound()) * self.sign - plane).max(0.0);
        let far = bound(self.near_bound() ^ 1) * self.sign - plane;
        let far = (far + slack + far.abs() * ERROR).min(f32x8::from_slice(simd, &self.last));
        let slack = far.abs().max(near).mul_add(ERROR, slack);
        let mut missed = (near - slack).simd_gt(far);
        for axis in 0..2 {
            let least = f32x8::from_slice(simd, &self.least[axis]);
            let most = f32x8::from_slice(simd, &self.most[axis]);
            let low = f32x8::from_slice(simd, &self.low[axis]) + (least * near).min(least * far) - slack;
            let high = f32x8::from_slice(simd, &self.high[axis]) + (most * near).max(most * far) + slack;
            let side = 2 * self.axes[axis];
            missed = missed | low.simd_gt(bound(side + 1)) | high.simd_lt(bound(side));
        }
        !(missed.to_bitmask() as u32) & 0xff
    }
}
