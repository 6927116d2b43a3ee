use fearless_simd::{Simd, f64x8};
use glam::DVec3;

use super::ROUNDING;

/// The common property of a packet's rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Common {
    /// A common start, or for rays towards a light a common end: the space's origin.
    Origin,
    /// A common direction along the space's slope.
    Direction,
}

/// Coordinates in which a packet's rays are points of a plane.
///
/// Let p be a world position relative to `origin`, times `unit`, with its axes in the order of `axes`. The last of these,
/// the *major axis*, counts along the rays: (u, v, w) = (p.u − s.u p.w − shift.u, p.v − s.v p.w − shift.v, p.w).
/// - With a common origin a ray is the line through the origin and (x h.u, y h.v, 1), and the nearness of a point is
///   1 / w.
/// - With a common direction it is the line through (x h.u, y h.v, 0) along w, and the nearness of a point is −w.
///
/// x and y are from −1 to 1 for all rays of the packet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Space {
    pub(crate) common: Common,
    pub(crate) origin: DVec3,
    /// A power of two.
    pub(crate) unit: f64,
    pub(crate) axes: [usize; 3],
    /// 1 where rays run towards higher coordinates of the major axis, else −1.
    pub(crate) sign: f64,
    /// Slope of the middle ray: u and v per unit of w.
    pub(crate) slope: [f64; 2],
    pub(crate) shift: [f64; 2],
    /// Half the extent of the packet along u and v, error of the rays included.
    pub(crate) half: [f64; 2],
    /// Error bound of x and y, apart from one rounding to f32.
    pub(crate) ray_error: f64,
    /// Largest distance on any axis between `origin` and a ray's origin for the predicate, times `unit`.
    pub(crate) start_reach: f64,
    /// The end points of shadow rays: the predicate's error for them, their largest distance from the origin on any axis,
    /// both times `unit`, and their least w.
    pub(crate) points: Option<Points>,
}

/// The end points of a packet's shadow rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Points {
    pub(crate) error: f64,
    pub(crate) reach: f64,
    pub(crate) nearest: f64,
}

/// The dominant axis and sign of rays that are traced together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Group {
    /// The world axes of u, v and w; w is the major one.
    pub(crate) axes: [usize; 3],
    /// −1 where rays run towards lower coordinates of the major axis, else 1.
    pub(crate) sign: f64,
}

impl Group {
    /// The least component of a ray's direction along the major axis, relative to its largest along any other.
    pub(crate) const LEAST: f64 = 0.25;

    /// The group of a ray's direction: along its dominant axis (Wald et al. 2006, §2.2).
    pub(crate) fn of(direction: DVec3) -> Self {
        let size = direction.abs();
        let major = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        // Neighbouring cells along u are neighbours in memory where u is x.
        let axes = [[1, 2, 0], [0, 2, 1], [0, 1, 2]][major];
        Self { axes, sign: if direction[major] < 0.0 { -1.0 } else { 1.0 } }
    }

    /// Whether a ray of this direction can join the group: rays must agree about the sign of the major axis, and none may
    /// run almost across it.
    #[inline(always)]
    pub(crate) fn has(&self, direction: DVec3) -> bool {
        direction[self.axes[2]] * self.sign > Self::LEAST * direction.abs().max_element()
    }

    /// The components of a vector along u, v and w.
    #[inline(always)]
    pub(crate) fn turned(&self, vector: DVec3) -> [f64; 3] {
        let [u, v, w] = self.axes.map(|axis| vector[axis]);
        [u, v, w * self.sign]
    }
}

/// The lowest and the highest of some numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Range {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Range {
    pub(crate) fn middle(self) -> f64 {
        0.5 * (self.low + self.high)
    }
}

impl Space {
    /// The smallest extent, so that a packet of one ray has an extent too.
    const LEAST_HALF: f64 = 1.0 / (1 << 20) as f64;

    /// The space of rays from `origin` with slopes in `slopes`, each with an error of up to `error`.
    pub(crate) fn of_origin(group: Group, origin: DVec3, unit: f64, slopes: [Range; 2], error: f64) -> Self {
        let slope = slopes.map(Range::middle);
        Self::new(Common::Origin, group, origin, unit, slope).with_extent(slopes, slope, error)
    }

    /// The space of rays along `direction`. `positions` are their ranges along u and v at w = 0, relative to `origin` and in
    /// its unit, each with an error of up to `error`.
    pub(crate) fn of_direction(
        group: Group,
        direction: DVec3,
        origin: DVec3,
        unit: f64,
        positions: [Range; 2],
        error: f64,
    ) -> Self {
        let shift = positions.map(Range::middle);
        let space = Self::new(Common::Direction, group, origin, unit, Self::slope_of(group, direction));
        Self { shift, ..space }.with_extent(positions, shift, error)
    }

    /// A space without an extent.
    fn new(common: Common, Group { axes, sign }: Group, origin: DVec3, unit: f64, slope: [f64; 2]) -> Self {
        let (shift, half) = ([0.0; 2], [1.0; 2]);
        Self { common, origin, unit, axes, sign, slope, shift, half, ray_error: 0.0, start_reach: 0.0, points: None }
    }

    /// The slopes of a direction along u and v, each with one rounding.
    pub(crate) fn slope_of(group: Group, direction: DVec3) -> [f64; 2] {
        let [u, v, w] = group.turned(direction);
        [u / w, v / w]
    }

    fn with_extent(mut self, ranges: [Range; 2], middle: [f64; 2], error: f64) -> Self {
        // Differences from the middle are rounded once, and their quotients by the half extent twice.
        let size = ranges.iter().fold(0.0_f64, |size, range| size.max(range.low.abs()).max(range.high.abs()));
        let error = error + 2.0 * ROUNDING * size;
        for axis in 0..2 {
            let half = (ranges[axis].high - middle[axis]).max(middle[axis] - ranges[axis].low);
            self.half[axis] = (half * (1.0 + 1e-12) + error).max(Self::LEAST_HALF);
        }
        self.ray_error = error / self.half[0].min(self.half[1]) + 4.0 * ROUNDING;
        self
    }

    /// The middle and the scale that turn slopes or positions of rays into coordinates in the packet: distance from the
    /// middle times the scale.
    pub(crate) fn middle_and_scale(&self) -> ([f64; 2], [f64; 2]) {
        let middle = if self.common == Common::Origin { self.slope } else { self.shift };
        (middle, self.half.map(f64::recip))
    }

    /// The nearness of points at eight w.
    #[inline(always)]
    pub(crate) fn nearness_of_eight<S: Simd>(&self, w: f64x8<S>) -> f64x8<S> {
        match self.common {
            Common::Origin => 1.0 / w,
            Common::Direction => -w,
        }
    }
}
