use super::{MaskAnswers, MaskPoints, Opacity};

/// Masks of triangles and of rays, as a sensor has that doesn't see its own body: a triangle stops a ray only where
/// `triangle_mask & ray_mask != 0`. For any other ray it doesn't exist.
///
/// By default every ray is stopped by every triangle, at no cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Masks<'a> {
    /// Mask of each triangle. Triangles beyond the last one have all bits.
    pub triangles: &'a [u32],
    /// Masks of rays.
    pub rays: RayMasks<'a>,
}

/// Masks of the rays of a [`Trace`](crate::Trace), of the sweeps of a [`Scan`](crate::Scan) or of the lights of a
/// [`Lit`](crate::Lit).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayMasks<'a> {
    /// One for all.
    All(u32),
    /// One for each, at its index.
    Each(&'a [u32]),
}

impl Default for RayMasks<'_> {
    fn default() -> Self {
        Self::All(u32::MAX)
    }
}

impl RayMasks<'_> {
    /// The mask at an index.
    ///
    /// # Panics
    /// If there is one for each, but none at `index`.
    #[inline]
    #[must_use]
    pub fn at(&self, index: usize) -> u32 {
        match self {
            RayMasks::All(mask) => *mask,
            RayMasks::Each(masks) => masks[index],
        }
    }
}

impl<'a> Masks<'a> {
    /// Whether certainly every triangle stops every ray.
    #[must_use]
    pub fn hide_nothing(&self) -> bool {
        self.triangles.is_empty() && matches!(self.rays, RayMasks::All(mask) if mask != 0)
    }

    /// The mask of a ray, a sweep or a light.
    ///
    /// # Panics
    /// If there is one for each, but none at `index`.
    #[inline]
    #[must_use]
    pub fn of_ray(&self, index: usize) -> u32 {
        self.rays.at(index)
    }

    /// Whether a triangle exists for a ray with a mask.
    #[inline]
    #[must_use]
    pub fn sees(&self, ray_mask: u32, triangle: u32) -> bool {
        self.triangles.get(triangle as usize).unwrap_or(&u32::MAX) & ray_mask != 0
    }

    /// The opacity of triangles for rays with a mask.
    #[must_use]
    pub fn opacity(self, ray_mask: u32, opacity: &'a dyn Opacity) -> impl Opacity + 'a {
        OpacityOfMasks { masks: self, ray_mask, opacity }
    }
}

/// The opacity of triangles for rays with a mask.
struct OpacityOfMasks<'a> {
    masks: Masks<'a>,
    ray_mask: u32,
    opacity: &'a dyn Opacity,
}

impl Opacity for OpacityOfMasks<'_> {
    fn is_opaque(&self, triangle: u32) -> bool {
        self.masks.sees(self.ray_mask, triangle) && self.opacity.is_opaque(triangle)
    }

    fn are_all_opaque(&self) -> bool {
        self.masks.triangles.is_empty() && self.ray_mask != 0 && self.opacity.are_all_opaque()
    }

    fn stops(&self, triangle: u32, barycentric: [f32; 2]) -> bool {
        self.masks.sees(self.ray_mask, triangle) && self.opacity.is_stopped_at(triangle, barycentric)
    }

    fn which_stop(&self, triangle: u32, points: &MaskPoints) -> MaskAnswers {
        if !self.masks.sees(self.ray_mask, triangle) {
            MaskAnswers { opaque: 0, cut: points.lanes }
        } else if self.opacity.is_opaque(triangle) {
            MaskAnswers { opaque: points.lanes, cut: 0 }
        } else {
            self.opacity.which_stop(triangle, points)
        }
    }
}
