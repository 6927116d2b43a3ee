use glam::{DVec3, Vec3};

use crate::Ray;

/// The lines of a sweep, between two t.
#[derive(Clone, Copy)]
pub(super) struct Lines<'a> {
    /// The number of lines of the sweeps before it.
    pub(super) before: usize,
    /// Factor for lengths: a power of two.
    pub(super) scale: f64,
    pub(super) origin: DVec3,
    pub(super) directions: &'a [Vec3],
    pub(super) t_min: f64,
    pub(super) t_max: f64,
}

/// A face of a cube around the origin: the lines through it have the same largest component, of one sign.
///
/// With Δ a position relative to the lines' origin, z = ± Δₖ is its depth along axis k. A line consists of the points with
/// Δᵢ − rᵢ z = 0 and Δⱼ − rⱼ z = 0, r being its slopes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// The axes i, j and k.
    pub(super) axes: [usize; 3],
    pub(super) sign: f64,
}

impl Face {
    /// The faces of a cube, two an axis, the positive one first.
    pub(super) const CUBE: [Self; 6] = [
        Self::new(0, 1.0),
        Self::new(0, -1.0),
        Self::new(1, 1.0),
        Self::new(1, -1.0),
        Self::new(2, 1.0),
        Self::new(2, -1.0),
    ];

    const fn new(k: usize, sign: f64) -> Self {
        Self { axes: [(k + 1) % 3, (k + 2) % 3, k], sign }
    }

    /// The face of a line; `None` for a direction that is zero or not finite.
    #[inline]
    pub(super) fn of(line: DVec3) -> Option<Self> {
        let goes_somewhere = line.is_finite() && line != DVec3::ZERO;
        goes_somewhere.then(|| {
            let axis = largest_axis(line);
            Self::CUBE[axis * 2 + usize::from(line[axis] < 0.0)]
        })
    }
}

/// The axis along which a vector is the longest, the first of equals.
#[inline(always)]
fn largest_axis(vector: DVec3) -> usize {
    let [x, y, z] = vector.abs().to_array();
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

impl Lines<'_> {
    /// The direction of a line.
    #[inline(always)]
    pub(super) fn get(&self, index: usize) -> DVec3 {
        self.directions[index].as_dvec3()
    }

    /// Whether a line can hit anything at all.
    pub(super) fn may_hit(&self) -> bool {
        self.origin.is_finite() && self.t_min < self.t_max
    }

    pub(super) fn ray(&self, index: usize) -> Ray {
        let Self { origin, t_min, t_max, .. } = *self;
        Ray { origin, direction: self.get(index), t_min, t_max }
    }
}
