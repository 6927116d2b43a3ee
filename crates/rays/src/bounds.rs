use glam::Vec3;

/// An axis-aligned box, in world units.
///
/// The empty box has `min` above `max` on every axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The lowest corner.
    pub min: Vec3,
    /// The highest corner.
    pub max: Vec3,
}

impl Default for Bounds {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Bounds {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box around all finite `points`; [`Bounds::EMPTY`] when there are none.
    #[must_use]
    pub fn of_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        let finite = points.into_iter().filter(|point| point.is_finite());
        finite.fold(Self::EMPTY, |bounds, point| Self { min: bounds.min.min(point), max: bounds.max.max(point) })
    }

    /// Whether the box holds no point at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// The smallest box around both boxes.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The middle of the box; the origin for an empty box.
    #[must_use]
    pub fn center(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.min * 0.5 + self.max * 0.5 }
    }

    /// The lengths of the box's sides; zero for an empty box.
    #[must_use]
    pub fn size(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.max - self.min }
    }

    /// The box's eight corners, `min` first and `max` last.
    #[must_use]
    pub fn corners(&self) -> [Vec3; 8] {
        let pick = |high: usize, axis: usize| if high & (1 << axis) == 0 { self.min[axis] } else { self.max[axis] };
        std::array::from_fn(|corner| Vec3::new(pick(corner, 0), pick(corner, 1), pick(corner, 2)))
    }
}
