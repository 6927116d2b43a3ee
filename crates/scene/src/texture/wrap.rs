//! Texel indices at a coordinate along an axis.

use super::{Filter, Wrap};

/// At this magnitude and beyond, every f32 is an integer.
const WHOLE: f32 = (1 << 23) as f32;

/// The floor of a number that i32 holds. Not `f32::floor`, which is a function call where the target may lack the
/// instruction.
#[inline]
pub(super) fn floor(value: f32) -> i32 {
    let towards_zero = value as i32;
    towards_zero - i32::from(value < towards_zero as f32)
}

impl Wrap {
    /// The texel nearest to coordinate `at`, in texels, on a side of `side` texels, at most
    /// [`Texture::MAX_SIDE`](super::Texture::MAX_SIDE); texel 0 for NaN.
    #[inline]
    pub(super) fn nearest(self, at: f32, side: u32) -> usize {
        self.texel(self.floor(at, side).0, side)
    }

    /// The two texels to mix at coordinate `at`, and the second one's weight, 0 … 1; NaN where `at` isn't finite.
    #[inline]
    pub(super) fn mixed(self, at: f32, side: u32) -> ([usize; 2], f32) {
        let (whole, part) = self.floor(at - 0.5, side);
        (self.texels(whole, side), part)
    }

    /// Splits `value` into its floor, or another integer that wraps to the same texel, and the fraction.
    #[inline]
    fn floor(self, value: f32, side: u32) -> (i32, f32) {
        if value.abs() < WHOLE {
            let whole = floor(value);
            (whole, value - whole as f32)
        } else {
            (self.brought_near(value, side) as i32, if value.is_finite() { 0.0 } else { f32::NAN })
        }
    }

    /// Maps an integral `value` to one near the image that wraps to the same texel; NaN for NaN.
    #[cold]
    fn brought_near(self, value: f32, side: u32) -> f32 {
        match self {
            Self::Repeat | Self::MirroredRepeat => value % (2 * side) as f32,
            Self::ClampToEdge => value.clamp(-1.0, side as f32),
        }
    }

    /// Wraps index `at` to a side of `side` texels.
    #[inline]
    fn texel(self, at: i32, side: u32) -> usize {
        let side = side as i32;
        let texel = match self {
            Self::Repeat => at.rem_euclid(side),
            Self::MirroredRepeat => {
                let twice = at.rem_euclid(2 * side);
                twice.min(2 * side - 1 - twice)
            }
            Self::ClampToEdge => at.clamp(0, side - 1),
        };
        texel as usize
    }

    /// Wraps index `at` and the next one.
    #[inline]
    fn texels(self, at: i32, side: u32) -> [usize; 2] {
        if (0..side as i32 - 1).contains(&at) {
            return [at as usize, at as usize + 1];
        }
        [self.texel(at, side), self.texel(at + 1, side)]
    }

    /// The texel after texel `at` of `side` texels.
    pub(super) fn next(self, at: u32, side: u32) -> u32 {
        match self {
            Self::Repeat => (at + 1) % side,
            Self::MirroredRepeat | Self::ClampToEdge => (at + 1).min(side - 1),
        }
    }

    /// Wraps index `at` on a side of `side` texels to a cell: the texel read there or, with filtering, the lower of the two
    /// texels mixed at `at` and `at + 1`.
    #[inline]
    pub(super) fn cell(self, at: i32, side: u32, filter: Filter) -> usize {
        let length = side as i32;
        if (0..length).contains(&at) {
            return at as usize;
        }
        let texel = self.texel(at, side);
        let is_mirrored = self == Self::MirroredRepeat && at.rem_euclid(2 * length) >= length;
        // In the mirrored image, index `at + 1` is the lower texel; at the image's edge both are the same.
        if is_mirrored && filter == Filter::Linear { texel.saturating_sub(1) } else { texel }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];

    #[test]
    fn numbers_are_cut_below_also_left_of_zero() {
        for value in [0.0, 0.25, 3.0, -0.25, -3.0, -3.75, 1e6 + 0.5, -7.5, WHOLE - 0.5, 0.5 - WHOLE] {
            assert_eq!(Wrap::Repeat.floor(value, 7), (value.floor() as i32, value - value.floor()), "{value}");
        }
    }

    #[test]
    fn each_wrap_has_its_texels_beyond_the_edges() {
        let of_wrap = |wrap: Wrap| (-5..8).map(|at| wrap.texel(at, 3)).collect::<Vec<_>>();
        assert_eq!(of_wrap(Wrap::Repeat), [1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1]);
        assert_eq!(of_wrap(Wrap::MirroredRepeat), [1, 2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0, 1]);
        assert_eq!(of_wrap(Wrap::ClampToEdge), [0, 0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2, 2]);
        for wrap in WRAPS {
            for (at, side) in (-9..9).flat_map(|at| (1..5).map(move |side| (at, side))) {
                assert_eq!(wrap.texels(at, side), [wrap.texel(at, side), wrap.texel(at + 1, side)]);
            }
        }
    }

    #[test]
    fn far_coordinates_have_the_texel_that_whole_numbers_give() {
        for exponent in 0..80 {
            let at = f32::from_bits((127 + 23 + exponent) << 23 | 0x12_3457);
            for (at, side) in [at, -at].into_iter().flat_map(|at| [1, 6, 7, 16_384].map(|side| (at, side))) {
                let (whole, length) = (at as i128, i128::from(side));
                let twice = whole.rem_euclid(2 * length);
                let expected =
                    [whole.rem_euclid(length), twice.min(2 * length - 1 - twice), whole.clamp(0, length - 1)];
                for (wrap, expected) in WRAPS.into_iter().zip(expected) {
                    assert_eq!(wrap.nearest(at, side) as i128, expected, "{wrap:?} {at} of {side}");
                    let ([first, _], part) = wrap.mixed(at, side);
                    assert_eq!((first as i128, part), (wrap.nearest(at - 0.5, side) as i128, 0.0), "{wrap:?} {at}");
                }
            }
        }
    }

    #[test]
    fn what_is_no_finite_number_reads_some_texel() {
        for (wrap, at) in
            WRAPS.into_iter().flat_map(|wrap| [f32::NAN, f32::INFINITY, -f32::INFINITY].map(|at| (wrap, at)))
        {
            assert!(wrap.nearest(at, 7) < 7);
            let (texels, part) = wrap.mixed(at, 7);
            assert!(texels.into_iter().all(|texel| texel < 7) && part.is_nan(), "{wrap:?} {at}");
        }
    }
}
