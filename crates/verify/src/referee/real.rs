//! Real numbers, enclosed by intervals of f64, or as big integers times powers of two.

use std::cmp::Ordering;

use num_bigint::{BigInt, Sign};

/// Operations of formulas.
pub(super) trait Real {
    fn of(value: f64) -> Self;
    fn plus(&self, other: &Self) -> Self;
    fn minus(&self, other: &Self) -> Self;
    fn times(&self, other: &Self) -> Self;
    /// The sign, if it is known.
    fn sign(&self) -> Option<Ordering>;
}

/// A lowest and a highest value.
pub(super) struct Interval(f64, f64);

impl Interval {
    /// The interval between two rounded bounds.
    fn around(low: f64, high: f64) -> Self {
        Self(low.next_down(), high.next_up())
    }
}

impl Real for Interval {
    fn of(value: f64) -> Self {
        Self(value, value)
    }

    fn plus(&self, other: &Self) -> Self {
        Self::around(self.0 + other.0, self.1 + other.1)
    }

    fn minus(&self, other: &Self) -> Self {
        Self::around(self.0 - other.1, self.1 - other.0)
    }

    fn times(&self, other: &Self) -> Self {
        let ends = [self.0 * other.0, self.0 * other.1, self.1 * other.0, self.1 * other.1];
        // Zero times infinity may be any number.
        if ends.iter().any(|end| end.is_nan()) {
            return Self(f64::NEG_INFINITY, f64::INFINITY);
        }
        Self::around(ends.into_iter().fold(f64::INFINITY, f64::min), ends.into_iter().fold(f64::NEG_INFINITY, f64::max))
    }

    fn sign(&self) -> Option<Ordering> {
        if self.0 > 0.0 {
            Some(Ordering::Greater)
        } else if self.1 < 0.0 {
            Some(Ordering::Less)
        } else {
            None
        }
    }
}

/// `mantissa` · 2^`exponent`.
#[derive(Clone)]
pub(super) struct Big {
    mantissa: BigInt,
    exponent: i64,
}

impl Big {
    /// 2^`exponent`, of any size.
    pub(super) fn power_of_two(exponent: i64) -> Self {
        Self { mantissa: BigInt::from(1), exponent }
    }

    /// Both mantissas at the lower exponent.
    fn aligned(&self, other: &Self) -> (BigInt, BigInt, i64) {
        let exponent = self.exponent.min(other.exponent);
        let at = |number: &Self| &number.mantissa << (number.exponent - exponent) as u64;
        (at(self), at(other), exponent)
    }
}

impl Real for Big {
    fn of(value: f64) -> Self {
        assert!(value.is_finite(), "the referee judges numbers only");
        let (bits, sign) = (value.to_bits(), if value.is_sign_negative() { -1_i64 } else { 1 });
        let (field, fraction) = ((bits >> 52 & 0x7ff) as i64, (bits & ((1 << 52) - 1)) as i64);
        let significand = if field == 0 { fraction } else { fraction | 1 << 52 };
        // Trailing zeros would make alignment longer.
        let zeros = significand.trailing_zeros() % 64;
        Self { mantissa: BigInt::from(sign * (significand >> zeros)), exponent: field.max(1) - 1075 + i64::from(zeros) }
    }

    fn plus(&self, other: &Self) -> Self {
        let (first, second, exponent) = self.aligned(other);
        Self { mantissa: first + second, exponent }
    }

    fn minus(&self, other: &Self) -> Self {
        let (first, second, exponent) = self.aligned(other);
        Self { mantissa: first - second, exponent }
    }

    fn times(&self, other: &Self) -> Self {
        Self { mantissa: &self.mantissa * &other.mantissa, exponent: self.exponent + other.exponent }
    }

    fn sign(&self) -> Option<Ordering> {
        Some(match self.mantissa.sign() {
            Sign::Minus => Ordering::Less,
            Sign::NoSign => Ordering::Equal,
            Sign::Plus => Ordering::Greater,
        })
    }
}

/// The f64 nearest to a ÷ b, ties to even; for quotients in the range of normal numbers.
pub(super) fn nearest_quotient(a: &Big, b: &Big) -> f64 {
    if a.mantissa.sign() == Sign::NoSign {
        return 0.0;
    }
    let sign = if a.mantissa.sign() == b.mantissa.sign() { 1.0 } else { -1.0 };
    let (a_bits, b_bits) = (a.mantissa.magnitude(), b.mantissa.magnitude());
    // 54 or 55 bits of the quotient, and whether the rest isn't zero.
    let shift = b_bits.bits() as i64 + 54 - a_bits.bits() as i64;
    let (dividend, divisor) = (a_bits << shift.max(0) as u64, b_bits << (-shift).max(0) as u64);
    let quotient = &dividend / &divisor;
    let is_more = &quotient * &divisor != dividend;
    let mut quotient = u64::try_from(&quotient).expect("55 bits");
    let mut exponent = a.exponent - b.exponent - shift;
    // One bit below the last of an f64, and a sticky bit for the rest.
    let spare = 64 - i64::from(quotient.leading_zeros()) - 54;
    let is_below = quotient & ((1 << spare) - 1) != 0 || is_more;
    (quotient, exponent) = (quotient >> spare, exponent + spare);
    let rounded = (quotient >> 1) + u64::from(quotient & 1 == 1 && (is_below || quotient >> 1 & 1 == 1));
    sign * scaled(rounded as f64, exponent + 1)
}

/// `value` · 2^`exponent`, in two steps, since the power alone may be out of range.
fn scaled(value: f64, exponent: i64) -> f64 {
    let power = |exponent: i64| 2.0_f64.powi(exponent as i32);
    let half = exponent / 2;
    value * power(half) * power(exponent - half)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotients_are_rounded_as_f64_rounds() {
        let mut random = crate::Random::new(5);
        for step in 0..20_000 {
            // Also with few bits, so that some quotients are exact and some are ties.
            let bits = [1, 20, 27, 53][step % 4];
            let [a, b] = [(); 2]
                .map(|()| (random.bits() >> (64 - bits) | 1) as f64 * 2.0_f64.powi(random.below(90) as i32 - 45));
            assert_eq!(nearest_quotient(&Big::of(a), &Big::of(b)), a / b, "{a:e} / {b:e}");
            assert_eq!(nearest_quotient(&Big::of(-a), &Big::of(b)), -a / b);
        }
    }

    #[test]
    fn sums_and_products_keep_every_bit() {
        let (large, small) = (Big::of(1e300), Big::of(f64::from_bits(1)));
        let sum = large.plus(&small);
        assert_eq!(sum.minus(&large).minus(&small).sign(), Some(Ordering::Equal));
        assert_eq!(sum.minus(&large).sign(), Some(Ordering::Greater));
        let product = sum.times(&small).minus(&large.times(&small)).minus(&small.times(&small));
        assert_eq!(product.sign(), Some(Ordering::Equal));
        assert!(Interval::of(0.1).times(&Interval::of(3.0)).minus(&Interval::of(0.1 * 3.0)).sign().is_none());
    }
}
