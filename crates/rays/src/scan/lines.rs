use glam::{DVec3, Vec3};

use crate::Ray;

/// Lines from an origin in these directions, between two t.
#[derive(Clone, Copy)]
pub(super) struct Lines<'a> {
    pub(super) origin: DVec3,
    pub(super) directions: &'a [Vec3],
    pub(super) t_min: f64,
    pub(super) t_max: f64,
}

/// A side of a cube around the origin: lines go through it that have the same largest component, of one sign.
///
/// With Δ a position in relation to the lines' origin, z = ± Δₖ is how far it is along axis k, and a line is where Δᵢ − rᵢ z and
/// Δⱼ − rⱼ z are zero, r being its slopes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// i, j and k.
    pub(super) axes: [usize; 3],
    pub(super) sign: f64,
}

impl Face {
    /// The sides of a cube: those of each axis follow each other, the positive one first.
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

    /// Which one a line goes through, by its number; `None` where it goes nowhere.
    #[inline]
    pub(super) fn of(line: DVec3) -> Option<usize> {
        let goes_somewhere = line.is_finite() && line != DVec3::ZERO;
        goes_somewhere.then(|| {
            let axis = largest_axis(line);
            axis * 2 + usize::from(line[axis] < 0.0)
        })
    }

    /// A vector's components along i, j and k: one branch that is always the same, where three indices would be looked up.
    #[inline(always)]
    fn turned(&self, DVec3 { x, y, z }: DVec3) -> [f64; 3] {
        match self.axes[2] {
            0 => [y, z, x],
            1 => [z, x, y],
            _ => [x, y, z],
        }
    }

    /// How far a position in relation to the origin is along the face's axis.
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

    /// Where along its face a line begins and ends.
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
