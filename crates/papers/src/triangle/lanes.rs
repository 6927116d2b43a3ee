//! One number or sixteen, so that each test is written once.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16, u32x16};
use glam::Vec3;

/// An `f32` for each ray: one, or the sixteen of an [`f32x16`].
///
/// Every operation rounds once in each lane, so sixteen rays get the same bits as each ray alone, at any SIMD level.
pub trait Lanes:
    Copy
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f32, Output = Self>
    + Sub<f32, Output = Self>
    + Mul<f32, Output = Self>
{
    /// A boolean for each ray.
    type Mask: LaneMask;

    /// `value` for as many rays as `self` has.
    fn splat(self, value: f32) -> Self;
    /// One with the sign of `self`.
    fn sign(self) -> Self;
    /// Whether `self < other`; false for NaN.
    fn is_below(self, other: Self) -> Self::Mask;
    /// Whether `self <= other`; false for NaN.
    fn is_at_most(self, other: Self) -> Self::Mask;

    /// Whether `self` is from 0 to `other`, which is positive; false for −0 and NaN. As unsigned numbers, bits of these
    /// are larger than those of all other numbers, so one comparison of integers is enough.
    fn is_up_to(self, other: Self) -> Self::Mask;
    /// Whether `self` is above 0 and below `other`, which is positive, by one comparison of integers as well.
    fn is_within(self, other: Self) -> Self::Mask;

    /// Whether `self >= 0`; false for NaN.
    #[inline(always)]
    fn is_at_least_zero(self) -> Self::Mask {
        self.splat(0.0).is_at_most(self)
    }

    /// Whether `self <= 0`; false for NaN.
    #[inline(always)]
    fn is_at_most_zero(self) -> Self::Mask {
        self.is_at_most(self.splat(0.0))
    }
}

/// A boolean for each ray.
pub trait LaneMask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> {
    /// Whether it is true for any ray.
    fn any(self) -> bool;
}

impl LaneMask for bool {
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
}

impl<S: Simd> LaneMask for mask32x16<S> {
    #[inline(always)]
    fn any(self) -> bool {
        self.any_true()
    }
}

impl Lanes for f32 {
    type Mask = bool;

    #[inline(always)]
    fn splat(self, value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn sign(self) -> Self {
        1.0_f32.copysign(self)
    }

    #[inline(always)]
    fn is_below(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn is_at_most(self, other: Self) -> bool {
        self <= other
    }

    #[inline(always)]
    fn is_up_to(self, other: Self) -> bool {
        self.to_bits() <= other.to_bits()
    }

    #[inline(always)]
    fn is_within(self, other: Self) -> bool {
        self.to_bits().wrapping_sub(1) < other.to_bits().wrapping_sub(1)
    }
}

impl<S: Simd> Lanes for f32x16<S> {
    type Mask = mask32x16<S>;

    #[inline(always)]
    fn splat(self, value: f32) -> Self {
        SimdBase::splat(self.token(), value)
    }

    #[inline(always)]
    fn sign(self) -> Self {
        Lanes::splat(self, 1.0).copysign(self)
    }

    #[inline(always)]
    fn is_below(self, other: Self) -> mask32x16<S> {
        self.simd_lt(other)
    }

    #[inline(always)]
    fn is_at_most(self, other: Self) -> mask32x16<S> {
        self.simd_le(other)
    }

    #[inline(always)]
    fn is_up_to(self, other: Self) -> mask32x16<S> {
        self.bitcast::<u32x16<S>>().simd_le(other.bitcast::<u32x16<S>>())
    }

    #[inline(always)]
    fn is_within(self, other: Self) -> mask32x16<S> {
        (self.bitcast::<u32x16<S>>() - 1).simd_lt(other.bitcast::<u32x16<S>>() - 1)
    }
}

/// a · b.
#[inline(always)]
pub(super) fn dot<L: Lanes>(a: [L; 3], b: [L; 3]) -> L {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a · b, where all rays have the same b.
#[inline(always)]
pub(super) fn dot_all<L: Lanes>(a: [L; 3], b: Vec3) -> L {
    a[0] * b.x + a[1] * b.y + a[2] * b.z
}

/// a × b.
#[inline(always)]
pub(super) fn cross<L: Lanes>(a: [L; 3], b: [L; 3]) -> [L; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a × b, where all rays have the same b.
#[inline(always)]
pub(super) fn cross_all<L: Lanes>(a: [L; 3], b: Vec3) -> [L; 3] {
    [a[1] * b.z - a[2] * b.y, a[2] * b.x - a[0] * b.z, a[0] * b.y - a[1] * b.x]
}

/// a − b, where all rays have the same b.
#[inline(always)]
pub(super) fn minus_all<L: Lanes>(a: [L; 3], b: Vec3) -> [L; 3] {
    [a[0] - b.x, a[1] - b.y, a[2] - b.z]
}

/// a times a number for each ray.
#[inline(always)]
pub(super) fn scaled<L: Lanes>(a: [L; 3], factor: L) -> [L; 3] {
    [a[0] * factor, a[1] * factor, a[2] * factor]
}

/// The axis along which a triangle's projection is largest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axis {
    X,
    Y,
    Z,
}

impl Axis {
    /// The axis of the largest component; the last of equal ones.
    #[inline]
    pub(super) fn largest(vector: Vec3) -> Self {
        let Vec3 { x, y, z } = vector.abs();
        if x > y && x > z {
            Self::X
        } else if y > z {
            Self::Y
        } else {
            Self::Z
        }
    }

    /// The two axes after it, in a cycle, and the axis itself.
    #[inline(always)]
    pub(super) fn order(self) -> [usize; 3] {
        match self {
            Self::X => [1, 2, 0],
            Self::Y => [2, 0, 1],
            Self::Z => [0, 1, 2],
        }
    }
}
