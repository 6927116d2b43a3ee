//! Double-double arithmetic: numbers of 106 bits as sums of two f64, with a running bound on cancellation.
//!
//! Dekker, *A floating-point technique for extending the available precision*, 1971.

use std::ops::{Add, Div, Mul, Neg, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, f64x8};

use super::SMALLEST_TRUSTED_BOUND;
use super::expansion::{two_product, two_sum};

/// An f64, or eight. Every operation rounds once in each lane, so eight numbers give bit for bit the results of each alone.
pub(crate) trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Mul<f64, Output = Self>
    + Neg<Output = Self>
{
    /// Zero in each lane.
    fn zero(self) -> Self;
    fn magnitude(self) -> Self;
    /// self · other as a rounded product and its rounding error, for a token with [fused](is_fused) products and sums.
    fn fused_product(self, other: Self) -> (Self, Self);
}

/// Whether a product and a sum are rounded once, together, on a level.
#[inline(always)]
pub(super) fn is_fused<S: Simd>(simd: S) -> bool {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    let is_fused = matches!(simd.level(), Level::Avx2(_) | Level::Avx512(_));
    #[cfg(target_arch = "aarch64")]
    let is_fused = !matches!(simd.level(), Level::Fallback(_));
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64", target_arch = "aarch64")))]
    let is_fused = {
        let _: Level = simd.level();
        false
    };
    is_fused
}

impl Number for f64 {
    #[inline(always)]
    fn zero(self) -> Self {
        0.0
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn fused_product(self, other: Self) -> (Self, Self) {
        let product = self * other;
        (product, self.mul_add(other, -product))
    }
}

impl<S: Simd> Number for f64x8<S> {
    #[inline(always)]
    fn zero(self) -> Self {
        Self::splat(self.token(), 0.0)
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn fused_product(self, other: Self) -> (Self, Self) {
        let product = self * other;
        (product, self.mul_sub(other, product))
    }
}

/// The number `high + low`, and the sum of the magnitudes of all its terms.
#[derive(Clone, Copy, Debug)]
pub(super) struct Double {
    high: f64,
    low: f64,
    magnitude: f64,
}

impl From<f64> for Double {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self { high: value, low: 0.0, magnitude: value.abs() }
    }
}

impl Double {
    /// The threshold of cancellation. A sum of products of two or three numbers loses about 2⁻⁹⁸ of its terms at most; if
    /// 2⁻²⁶ of them are left, that is 2⁻⁷² of the result.
    pub(super) const CANCELLATION: f64 = 1.0 / (1_u64 << 26) as f64;

    /// The relative error of a quotient of two numbers that are [precise](Self::is_precise).
    pub(super) const PRECISION: f64 = 1.0 / (1_u128 << 70) as f64;

    /// The relative error of a quotient of two numbers that were [rounded](super::Expansion::rounded) to two terms.
    pub(super) const ROUNDED: f64 = 1.0 / (1_u128 << 100) as f64;

    pub(super) fn from_terms(high: f64, low: f64) -> Self {
        Self { high, low, magnitude: high.abs() }
    }

    /// Whether cancellation and underflow in the sums behind this number are so small that its sign is certain.
    pub(super) fn is_precise(self) -> bool {
        self.high.abs() > Self::CANCELLATION * self.magnitude && self.magnitude >= SMALLEST_TRUSTED_BOUND
    }

    /// a − b on each axis, exactly.
    #[inline(always)]
    pub(super) fn difference(a: [f64; 3], b: [f64; 3]) -> [Self; 3] {
        let component = |axis: usize| {
            let (high, low) = two_sum(a[axis], -b[axis]);
            Self { high, low, magnitude: high.abs() }
        };
        [component(0), component(1), component(2)]
    }

    #[inline(always)]
    pub(super) fn cross(a: [Self; 3], b: [Self; 3]) -> [Self; 3] {
        let component = |next: usize, last: usize| a[next].times(b[last]).plus(a[last].times(b[next]).negated());
        [component(1, 2), component(2, 0), component(0, 1)]
    }

    #[inline(always)]
    pub(super) fn dot(a: [Self; 3], b: [Self; 3]) -> Self {
        a[0].times(b[0]).plus(a[1].times(b[1])).plus(a[2].times(b[2]))
    }

    /// The nearest f64.
    #[inline(always)]
    pub(super) fn value(self) -> f64 {
        self.high
    }

    /// self ÷ divisor rounded to f64, once for the quotient minus `error` of itself and once plus it. If both are the same,
    /// that is the nearest f64 (Ziv, *Fast evaluation of elementary mathematical functions with correctly rounded last bit*,
    /// 1991).
    #[inline(always)]
    pub(super) fn quotient(self, divisor: Self, error: f64) -> [f64; 2] {
        let first = self.high / divisor.high;
        let rest = self.plus(divisor.times(Self::from(-first)));
        let (second, error) = (rest.high / divisor.high, first.abs() * error);
        [first + (second - error), first + (second + error)]
    }

    #[inline(always)]
    fn negated(self) -> Self {
        Self { high: -self.high, low: -self.low, magnitude: self.magnitude }
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        let (high, error) = two_sum(self.high, other.high);
        let (high, low) = two_sum(high, error + (self.low + other.low));
        Self { high, low, magnitude: self.magnitude + other.magnitude }
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        let (high, error) = two_product(self.high, other.high);
        let (high, low) = two_sum(high, error + (self.high * other.low + self.low * other.high));
        Self { high, low, magnitude: self.magnitude * other.magnitude }
    }
}
