use crate::Hit;

/// Says which points of masked triangles are there.
///
/// A function of a hit is a mask that knows nothing of the points around it.
pub trait Mask: Sync {
    /// Whether a hit counts. Hits on triangles without a mask always do.
    fn is_solid(&self, hit: &Hit) -> bool;

    /// Which of 16 points of `triangle` are certain to be there, and which are certain not to be.
    ///
    /// Certain means that [`is_solid`](Self::is_solid) says the same for every barycentric that is within the point's
    /// error of its own, in each coordinate.
    fn are_solid(&self, triangle: u32, points: &MaskPoints) -> MaskAnswers;
}

/// 16 points of a triangle that are roughly known.
#[derive(Clone, Copy, Debug)]
pub struct MaskPoints {
    /// Weights of the triangle's second and third vertex at each point.
    pub barycentric: [[f32; 16]; 2],
    /// How wrong each of the weights may be at each point; anything that isn't a number from 0 to 1 says that nothing is
    /// known.
    pub error: [f32; 16],
    /// A bit for each point that is asked for; the others mean nothing.
    pub asked: u16,
}

/// What is certain about 16 points, a bit for each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MaskAnswers {
    /// They are there.
    pub solid: u16,
    /// They are cut away.
    pub cut: u16,
}

impl<F: Fn(&Hit) -> bool + Sync> Mask for F {
    fn is_solid(&self, hit: &Hit) -> bool {
        self(hit)
    }

    fn are_solid(&self, _: u32, _: &MaskPoints) -> MaskAnswers {
        MaskAnswers::default()
    }
}

/// The mask of scenes that have none: everything is there.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unmasked;

impl Mask for Unmasked {
    fn is_solid(&self, _: &Hit) -> bool {
        true
    }

    fn are_solid(&self, _: u32, points: &MaskPoints) -> MaskAnswers {
        MaskAnswers { solid: points.asked, cut: 0 }
    }
}

/// Says which points of triangles that aren't opaque keep light off what is behind them.
///
/// A function of a triangle and the weights of its second and third vertex is one that knows nothing of the points
/// around.
pub trait ShadowMask: Sync {
    /// Whether a point, given by the weights of the triangle's second and third vertex, casts a shadow.
    fn casts(&self, triangle: u32, barycentric: [f32; 2]) -> bool;

    /// Which of 16 points of `triangle` are certain to cast one, and which are certain not to: `solid` and `cut`.
    ///
    /// Certain as in [`Mask::are_solid`].
    fn which_cast(&self, triangle: u32, points: &MaskPoints) -> MaskAnswers;
}

impl<F: Fn(u32, [f32; 2]) -> bool + Sync> ShadowMask for F {
    fn casts(&self, triangle: u32, barycentric: [f32; 2]) -> bool {
        self(triangle, barycentric)
    }

    fn which_cast(&self, _: u32, _: &MaskPoints) -> MaskAnswers {
        MaskAnswers::default()
    }
}

impl ShadowMask for Unmasked {
    fn casts(&self, _: u32, _: [f32; 2]) -> bool {
        true
    }

    fn which_cast(&self, _: u32, points: &MaskPoints) -> MaskAnswers {
        MaskAnswers { solid: points.asked, cut: 0 }
    }
}
