use glam::{DVec3, Vec3};

use super::lit::Receiver;
use crate::predicate::ShadowRay;
use crate::{LightSource, Ray};

/// Lines that have a point or a direction in common, one after the other.
#[derive(Clone, Copy)]
pub(super) enum Lines<'a> {
    /// From an origin in these directions, between two t.
    Directions { origin: DVec3, directions: &'a [Vec3], t_min: f64, t_max: f64 },
    /// From a light to points.
    Points { light: &'a LightSource, points: &'a [Receiver], source: Source },
}

/// Where a light's lines come from.
#[derive(Clone, Copy)]
pub(super) enum Source {
    Point(DVec3),
    /// In parallel, with positions in relation to the second.
    Along(DVec3, DVec3),
}

impl Source {
    /// `None` for a light that shines nowhere. Positions are in relation to the `middle` where light is parallel.
    pub(super) fn new(light: &LightSource, middle: DVec3) -> Option<Self> {
        match *light {
            LightSource::Point { position } | LightSource::Spot { position, .. } => {
                position.is_finite().then(|| Self::Point(position.as_dvec3()))
            }
            LightSource::Directional { direction } => {
                let is_somewhere = direction.is_finite() && direction != Vec3::ZERO;
                is_somewhere.then(|| Self::Along(direction.as_dvec3(), middle))
            }
        }
    }
}

/// A rectangle that lines go through: those with the same largest component, of one sign.
///
/// With Δ a position in relation to the lines' origin, z = ± Δₖ is how far it is along axis k, and lines are where
/// Δᵢ − rᵢ z and Δⱼ − rⱼ z are constant. Those from a point have a slope r each and go through zero; parallel ones have the same
/// slope and go through somewhere.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// i, j and k.
    pub(super) axes: [usize; 3],
    pub(super) sign: f64,
    /// Of parallel lines.
    pub(super) slope: Option<[f64; 2]>,
}

impl Face {
    const CUBE: [Self; 6] = [
        Self::new(0, 1.0),
        Self::new(0, -1.0),
        Self::new(1, 1.0),
        Self::new(1, -1.0),
        Self::new(2, 1.0),
        Self::new(2, -1.0),
    ];

    const fn new(k: usize, sign: f64) -> Self {
        Self { axes: [(k + 1) % 3, (k + 2) % 3, k], sign, slope: None }
    }

    fn along(direction: DVec3) -> Self {
        let k = largest_axis(direction);
        let face = Self::new(k, if direction[k] < 0.0 { -1.0 } else { 1.0 });
        let [i, j, _] = face.axes;
        Self { slope: Some([direction[i], direction[j]].map(|value| value / direction[k].abs())), ..face }
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

    /// Where on the face a line is: its slopes, or where a parallel line goes through.
    #[inline(always)]
    pub(super) fn across(&self, line: DVec3) -> [f64; 2] {
        let [i, j, k] = self.turned(line);
        match self.slope {
            None => {
                let inverse = 1.0 / k.abs();
                [i * inverse, j * inverse]
            }
            Some([u, v]) => {
                let depth = k * self.sign;
                [i - u * depth, j - v * depth]
            }
        }
    }
}

/// The axis along which a vector is the longest, the first of equals.
#[inline(always)]
pub(super) fn largest_axis(vector: DVec3) -> usize {
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
    /// What lines are in relation to.
    pub(super) fn origin(&self) -> DVec3 {
        match *self {
            Self::Directions { origin, .. }
            | Self::Points { source: Source::Point(origin) | Source::Along(_, origin), .. } => origin,
        }
    }

    /// The direction of a line; of parallel ones, a position on it.
    #[inline(always)]
    pub(super) fn get(&self, index: usize) -> DVec3 {
        match self {
            Self::Directions { directions, .. } => directions[index].as_dvec3(),
            Self::Points { points, source: Source::Point(origin) | Source::Along(_, origin), .. } => {
                points[index].point.position - *origin
            }
        }
    }

    /// Faces that lines may go through: all of a cube in its order, or one.
    pub(super) fn faces(&self) -> Faces {
        match self {
            Self::Points { source: Source::Along(direction, _), .. } => {
                Faces { faces: [Face::along(*direction); 6], count: 1 }
            }
            _ => Faces { faces: Face::CUBE, count: 6 },
        }
    }

    /// Where along its face a line begins and ends.
    #[inline(always)]
    pub(super) fn ends(&self, face: &Face, line: DVec3) -> [f64; 2] {
        match self {
            Self::Directions { t_min, t_max, .. } => {
                let unit = face.depth(line);
                [t_min * unit, t_max * unit]
            }
            Self::Points { .. } if face.slope.is_some() => [f64::NEG_INFINITY, face.depth(line)],
            Self::Points { .. } => [0.0, face.depth(line)],
        }
    }

    pub(super) fn ray(&self, index: usize) -> Ray {
        match self {
            Self::Directions { origin, directions, t_min, t_max } => {
                Ray { origin: *origin, direction: directions[index].as_dvec3(), t_min: *t_min, t_max: *t_max }
            }
            Self::Points { light, points, .. } => ShadowRay::new(light, points[index].point).ray,
        }
    }
}

/// As many faces as lines go through.
pub(super) struct Faces {
    faces: [Face; 6],
    count: usize,
}

impl std::ops::Deref for Faces {
    type Target = [Face];

    fn deref(&self) -> &[Face] {
        &self.faces[..self.count]
    }
}
