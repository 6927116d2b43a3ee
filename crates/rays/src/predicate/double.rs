//! Double-double arithmetic: numbers of 106 bits as sums of two f64, with a running bound on what cancelled.
//!
//! Dekker, *A floating-point technique for extending the available precision*, 1971.

use glam::DVec3;

use super::expansion::{two_product, two_sum};

/// `high + low`, and the sum of the magnitudes of everything that was added up to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Double {
    high: f64,
    low: f64,
    magnitude: f64,
}

impl From<f64> for Double {
    fn from(value: f64) -> Self {
        Self { high: value, low: 0.0, magnitude: value.abs() }
    }
}

impl Double {
    /// a − b on each axis, exactly.
    pub(super) fn difference(a: DVec3, b: DVec3) -> [Self; 3] {
        std::array::from_fn(|axis| {
            let (high, low) = two_sum(a[axis], -b[axis]);
            Self { high, low, magnitude: high.abs() }
        })
    }

    pub(super) fn cross(a: [Self; 3], b: [Self; 3]) -> [Self; 3] {
        std::array::from_fn(|axis| {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            a[next].times(b[last]).plus(a[last].times(b[next]).negated())
        })
    }

    pub(super) fn dot(a: [Self; 3], b: [Self; 3]) -> Self {
        a[0].times(b[0]).plus(a[1].times(b[1])).plus(a[2].times(b[2]))
    }

    /// The nearest f64.
    pub(super) fn value(self) -> f64 {
        self.high
    }

    /// An upper bound, to a few roundings, of the magnitudes that cancelled in the sums behind this number.
    pub(super) fn magnitude(self) -> f64 {
        self.magnitude
    }

    /// self ÷ divisor as an f64, to about one unit in the last place.
    pub(super) fn quotient(self, divisor: Self) -> f64 {
        let first = self.high / divisor.high;
        let rest = self.plus(divisor.times(Self::from(-first)));
        first + rest.high / divisor.high
    }

    fn negated(self) -> Self {
        Self { high: -self.high, low: -self.low, magnitude: self.magnitude }
    }

    fn plus(self, other: Self) -> Self {
        let (high, error) = two_sum(self.high, other.high);
        let (high, low) = two_sum(high, error + (self.low + other.low));
        Self { high, low, magnitude: self.magnitude + other.magnitude }
    }

    fn times(self, other: Self) -> Self {
        let (high, error) = two_product(self.high, other.high);
        let (high, low) = two_sum(high, error + (self.high * other.low + self.low * other.high));
        Self { high, low, magnitude: self.magnitude * other.magnitude }
    }
}
