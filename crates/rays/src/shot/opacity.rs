/// The opacity of triangles: which ones are opaque, and which points of the others stop a ray.
///
/// Camera rays and shadow rays may have different opacities: see [`Shot`](super::Shot). A closure with the signature of
/// [`stops`](Self::stops) is an opacity too, with no triangle opaque throughout.
pub trait Opacity: Sync {
    /// Whether every point of `triangle` stops rays. If so, no other method needs to be called for it.
    fn is_opaque(&self, triangle: u32) -> bool;

    /// Whether every triangle is opaque. Lets callers skip a call for each triangle.
    fn are_all_opaque(&self) -> bool {
        false
    }

    /// Whether a point of `triangle`, given by the weights of its second and third vertex, stops rays. Called only for
    /// triangles that aren't opaque.
    fn stops(&self, triangle: u32, barycentric: [f32; 2]) -> bool;

    /// Finds the points, of 16 of `triangle`, that certainly stop rays, and those that certainly don't; by default nothing
    /// is certain.
    ///
    /// An answer is certain if [`stops`](Self::stops) gives it for every barycentric within the point's error in each
    /// coordinate.
    fn which_stop(&self, _triangle: u32, _points: &MaskPoints) -> MaskAnswers {
        MaskAnswers::default()
    }
}

impl dyn Opacity + '_ {
    /// Whether a point of any triangle, opaque or not, stops rays.
    pub fn is_stopped_at(&self, triangle: u32, barycentric: [f32; 2]) -> bool {
        self.is_opaque(triangle) || self.stops(triangle, barycentric)
    }
}

/// 16 points of a triangle, with error bounds.
#[derive(Clone, Copy, Debug)]
pub struct MaskPoints {
    /// Weights of the triangle's second and third vertex at each point.
    pub barycentric: [[f32; 16]; 2],
    /// Error bound of the weights at each point, from 0 to 1; any other value, NaN included, means that nothing is known.
    pub error: [f32; 16],
    /// A bit for each lane that has a point; the others mean nothing.
    pub lanes: u16,
}

/// The certain answers for 16 points, a bit for each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MaskAnswers {
    /// Points that stop rays.
    pub opaque: u16,
    /// Points that let rays through.
    pub cut: u16,
}

/// The opacity of scenes without masks: everything stops rays.
#[derive(Clone, Copy, Debug, Default)]
pub struct Opaque;

impl Opacity for Opaque {
    fn is_opaque(&self, _: u32) -> bool {
        true
    }

    fn are_all_opaque(&self) -> bool {
        true
    }

    fn stops(&self, _: u32, _: [f32; 2]) -> bool {
        true
    }
}

impl<F: Fn(u32, [f32; 2]) -> bool + Sync> Opacity for F {
    fn is_opaque(&self, _: u32) -> bool {
        false
    }

    fn stops(&self, triangle: u32, barycentric: [f32; 2]) -> bool {
        self(triangle, barycentric)
    }
}
