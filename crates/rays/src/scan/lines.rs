use glam::{DVec3, Vec3};

use crate::Ray;

/// Lines from one origin in these directions, between two t.
#[derive(Clone, Copy)]
pub(super) struct Lines<'a> {
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

    /// The number of a line's face; `None` for a direction that is zero or not finite.
    #[inline]
    pub(super) fn of(line: DVec3) -> Option<usize> {
        let goes_somewhere = line.is_finite() && line != DVec3::ZERO;
        goes_somewhere.then(|| {
            let axis = largest_axis(line);
            axis * 2 + usize::from(line[axis] < 0.0)
        })
    }

    /// A vector's components along i, j and k, by one predictable branch instead of three indexed loads.
    #[inline(always)]
    fn turned(&self, DVec3 { x, y, z }: DVec3) -> [f64; 3] {
        match self.axes[2] {
            0 => [y, z, x],
            1 => [z, x, y],
            _ => [x, y, z],
        }
    }

    /// The depth along the face's axis of a position relative to the origin.
    #[inline(always)]
    pub(super) fn depth(&self, position: DVec3) -> f64 {
        self.turned(position)[2] * self.sign
    }

    /// The slopes of a line.
    #[inline(always)]
    pub(super) fn across(&self, line: DVec3) -> [f64; 2] {
        let [i, j, k] = self.turned(line);
        let inverse = 1.0 / k.abs();
        [i * inverse, j * inverse]
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

    /// Depths of a line's start and end.
    #[inline(always)]
    pub(super) fn ends(&self, face: &Face, line: DVec3) -> [f64; 2] {
        let unit = face.depth(line);
        [self.t_min * unit, self.t_max * unit]
    }

    pub(super) fn ray(&self, index: usize) -> Ray {
        let Self { origin, t_min, t_max, .. } = *self;
        Ray { origin, direction: self.get(index), t_min, t_max }
    }
}
