//! Numbers of about 104 bits for tests, to compare f64 and f32 results with.

use std::ops::{Add, Div, Mul, Neg, Sub};

use glam::DVec3;

/// The sum of two f64, the second at most half an ulp of the first. The error of a result is at most 2⁻¹⁰² of it, or of the
/// terms of a sum.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Precise {
    high: f64,
    low: f64,
}

impl Precise {
    /// The nearest f64.
    pub(crate) fn to_f64(self) -> f64 {
        self.high
    }

    pub(crate) fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }

    /// The number `high` + `low`, where `low` is the rounding error of a sum `high`.
    fn renormalized(high: f64, low: f64) -> Self {
        let sum = high + low;
        Self { high: sum, low: low - (sum - high) }
    }
}

impl From<f64> for Precise {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Neg for Precise {
    type Output = Self;

    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Add for Precise {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let of = |a: f64, b: f64| {
            let sum = a + b;
            let of_b = sum - a;
            (sum, (a - (sum - of_b)) + (b - of_b))
        };
        let (high, high_loss) = of(self.high, other.high);
        let (low, low_loss) = of(self.low, other.low);
        let sum = Self::renormalized(high, high_loss + low);
        Self::renormalized(sum.high, sum.low + low_loss)
    }
}

impl Sub for Precise {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Precise {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let high = self.high * other.high;
        let loss = self.high.mul_add(other.high, -high);
        Self::renormalized(high, loss + (self.high * other.low + self.low * other.high))
    }
}

impl Div for Precise {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        let rest = self - other * first.into();
        let second = rest.high / other.high;
        let rest = rest - other * second.into();
        Self::renormalized(first, second) + (rest.high / other.high).into()
    }
}

impl PartialEq for Precise {
    fn eq(&self, other: &Self) -> bool {
        (*self - *other).high == 0.0
    }
}

impl PartialOrd for Precise {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        (*self - *other).high.partial_cmp(&0.0)
    }
}

/// A vector of precise numbers.
pub(crate) type PreciseVector = [Precise; 3];

pub(crate) fn precise(vector: DVec3) -> PreciseVector {
    vector.to_array().map(Precise::from)
}

pub(crate) fn difference([a, b, c]: PreciseVector, [x, y, z]: PreciseVector) -> PreciseVector {
    [a - x, b - y, c - z]
}

pub(crate) fn dot([a, b, c]: PreciseVector, [x, y, z]: PreciseVector) -> Precise {
    a * x + b * y + c * z
}

pub(crate) fn cross([a, b, c]: PreciseVector, [x, y, z]: PreciseVector) -> PreciseVector {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

#[test]
fn results_have_twice_as_many_bits() {
    let one_and_little = Precise::from(1.0) + (2.0_f64.powi(-90)).into();
    assert_eq!((one_and_little * one_and_little - 1.0.into()).to_f64(), 2.0_f64.powi(-89));
    let third = Precise::from(1.0) / 3.0.into();
    assert!((third * 3.0.into() - 1.0.into()).to_f64().abs() < 2.0_f64.powi(-102));
    assert!(third < (1.0 / 3.0 + 1e-16).into() && third != (1.0_f64 / 3.0).into());
    let at = precise(DVec3::new(0.1, 0.2, 0.3));
    assert!(dot(at, cross(at, precise(DVec3::X))).abs() < 2.0_f64.powi(-104).into());
}
