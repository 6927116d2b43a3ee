use glam::DVec3;

/// A ray: `origin + t · direction` for t in the open interval (`t_min`, `t_max`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The point at t = 0.
    pub origin: DVec3,
    /// Any direction with a length from 10⁻¹⁰⁰ to 10¹⁰⁰; its length is the unit of t.
    pub direction: DVec3,
    /// Triangles at or before this t aren't hit.
    pub t_min: f64,
    /// Triangles at or after this t aren't hit.
    pub t_max: f64,
}

impl Ray {
    /// The ray for all t above zero.
    #[must_use]
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f64::INFINITY }
    }

    /// Whether it can hit anything: its origin is finite, its direction finite and not zero, its interval not empty.
    #[doc(hidden)]
    #[inline]
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.origin.is_finite() && self.goes_somewhere() && self.t_min < self.t_max
    }

    /// Whether the direction is finite and not zero.
    pub(crate) fn goes_somewhere(&self) -> bool {
        self.direction.is_finite() && self.direction != DVec3::ZERO
    }
}

/// The point at which a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, in lengths of the ray's direction.
    pub t: f64,
    /// The triangle's id: its index in [`Triangles::indices`](crate::Triangles).
    pub triangle: u32,
    /// Weights of the triangle's second and third vertex, each in [0, 1].
    pub barycentric: [f32; 2],
}
