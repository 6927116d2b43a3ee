use std::cmp::Ordering;

use glam::Vec3;

use super::exact::Number;
use crate::predicate::{two_product, two_sum};

/// An f64 with a bound of its error, which is zero where nothing has been rounded.
///
/// The errors of sums and products are found exactly, and so are zero for numbers with few digits: the right angles of
/// meshes made by hand and of regular grids of points are certain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounded {
    value: f64,
    error: f64,
}

/// Below this, a product's rounding error, or the bound of an error, may itself have lost bits to underflow.
const SMALLEST: f64 = 1e-250;

/// More than the error of an error bound, which is a sum of at most four products.
const OF_BOUNDS: f64 = 1.0 + 16.0 * f64::EPSILON;

impl Bounded {
    /// Whether it is certainly zero.
    fn is_zero(&self) -> bool {
        self.value == 0.0 && self.error == 0.0
    }
}

impl Number for Bounded {
    fn unit(_: &[Vec3]) -> i32 {
        0
    }

    fn difference(a: f32, b: f32, _: i32) -> Self {
        let (value, error) = two_sum(f64::from(a), -f64::from(b));
        Self { value, error: error.abs() }
    }

    #[inline]
    fn plus(&self, other: &Self) -> Self {
        let (value, error) = two_sum(self.value, other.value);
        Self { value, error: (error.abs() + self.error + other.error) * OF_BOUNDS }
    }

    #[inline]
    fn minus(&self, other: &Self) -> Self {
        self.plus(&Self { value: -other.value, ..*other })
    }

    #[inline]
    fn times(&self, other: &Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return Self { value: 0.0, error: 0.0 };
        }
        let (value, error) = two_product(self.value, other.value);
        let of_factors = self.value.abs() * other.error + other.value.abs() * self.error + self.error * other.error;
        let has_underflowed = (self.value != 0.0 && other.value != 0.0 && value.abs() < SMALLEST)
            || (self.error + other.error != 0.0 && of_factors < SMALLEST);
        Self { value, error: if has_underflowed { f64::NAN } else { (error.abs() + of_factors) * OF_BOUNDS } }
    }

    #[inline]
    fn sign(&self) -> Option<Ordering> {
        // NaN, of numbers that overflow, has no sign.
        if self.value.abs() > self.error {
            self.value.partial_cmp(&0.0)
        } else {
            self.is_zero().then_some(Ordering::Equal)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(value: f32) -> Bounded {
        Bounded::difference(value, 0.0, 0)
    }

    #[test]
    fn signs_are_certain_or_unknown() {
        let [third, tenth] = [1.0 / 3.0, 0.1].map(number);
        assert_eq!(third.minus(&tenth).sign(), Some(Ordering::Greater));
        assert_eq!(
            third.times(&tenth).minus(&tenth.times(&third)).sign(),
            Some(Ordering::Equal),
            "products of f32 are exact"
        );
        let cube = third.times(&tenth).times(&third);
        assert_eq!(cube.minus(&third.times(&third).times(&tenth)).sign(), None);
        assert_eq!(cube.sign(), Some(Ordering::Greater));
        let close = Bounded::difference(1.0, 1e-30, 0);
        assert_eq!(close.minus(&number(1.0)).sign(), None, "the difference was rounded");
        assert_eq!(number(1e-38).times(&number(1e-38)).sign(), Some(Ordering::Greater));
        let mut small = number(1e-38);
        for _ in 0..4 {
            small = small.times(&small);
        }
        assert_eq!(small.sign(), None, "underflow");
        let mut large = number(-1e38);
        for _ in 0..4 {
            large = large.times(&large);
        }
        assert_eq!(large.sign(), None, "overflow");
    }
}
