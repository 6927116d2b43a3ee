use std::cmp::Ordering;

use glam::Vec3;

use super::exact::Number;

/// A whole number of up to 3,072 bits.
///
/// Coordinates are multiples of one power of two, the unit. Differences of f32 have at most 278 bits then, and the comparison
/// of two squared distances is of degree ten in these: 2,791 bits with the carries of its sums.
#[derive(Clone, Debug)]
pub(super) struct Integer {
    is_negative: bool,
    /// The number of limbs up to the highest one that isn't zero.
    len: usize,
    /// The lowest limb first. Those beyond `len` are zero.
    limbs: [u64; LIMBS],
}

const LIMBS: usize = 48;

impl Integer {
    const ZERO: Self = Self { is_negative: false, len: 0, limbs: [0; LIMBS] };

    /// mantissa · 2^shift.
    fn shifted(mantissa: u64, shift: usize) -> Self {
        let mut number = Self::ZERO;
        if mantissa != 0 {
            let wide = u128::from(mantissa) << (shift % 64);
            let first = shift / 64;
            number.limbs[first] = wide as u64;
            number.limbs[first + 1] = (wide >> 64) as u64;
            number.len = first + 1 + usize::from(wide >> 64 != 0);
        }
        number
    }

    fn limbs(&self) -> &[u64] {
        &self.limbs[..self.len]
    }

    /// The number of bits of the magnitude.
    fn bits(&self) -> usize {
        self.limbs().last().map_or(0, |last| self.len * 64 - last.leading_zeros() as usize)
    }

    fn magnitude_cmp(&self, other: &Self) -> Ordering {
        self.len.cmp(&other.len).then_with(|| self.limbs().iter().rev().cmp(other.limbs().iter().rev()))
    }

    fn sum(&self, other: &Self, other_is_negative: bool) -> Self {
        if self.is_negative == other_is_negative {
            let mut sum = Self { is_negative: self.is_negative, ..Self::ZERO };
            let mut carry = false;
            let len = self.len.max(other.len);
            for index in 0..len {
                let (part, first) = self.limbs[index].overflowing_add(other.limbs[index]);
                let (part, second) = part.overflowing_add(u64::from(carry));
                (sum.limbs[index], carry) = (part, first | second);
            }
            if carry {
                sum.limbs[len] = 1;
            }
            sum.len = len + usize::from(carry);
            return sum;
        }
        let (large, small, is_negative) = match self.magnitude_cmp(other) {
            Ordering::Equal => return Self::ZERO,
            Ordering::Greater => (self, other, self.is_negative),
            Ordering::Less => (other, self, other_is_negative),
        };
        let mut difference = Self { is_negative, ..Self::ZERO };
        let mut borrow = false;
        for index in 0..large.len {
            let (part, first) = large.limbs[index].overflowing_sub(small.limbs[index]);
            let (part, second) = part.overflowing_sub(u64::from(borrow));
            (difference.limbs[index], borrow) = (part, first | second);
        }
        difference.len = difference.limbs[..large.len].iter().rposition(|&limb| limb != 0).map_or(0, |last| last + 1);
        difference
    }

    /// self · 2^`shift` compared with other · 2^`other_shift`, neither of them negative.
    pub(super) fn cmp_shifted(&self, shift: usize, other: &Self, other_shift: usize) -> Ordering {
        let by_bits = |bits: usize, shift: usize| if bits == 0 { 0 } else { bits + shift };
        let (bits, other_bits) = (self.bits(), other.bits());
        by_bits(bits, shift).cmp(&by_bits(other_bits, other_shift)).then_with(|| {
            // As many bits each, so shifting one of them by the difference needs no more than the other has.
            let least = shift.min(other_shift);
            let raised = |number: &Self, by: usize| {
                if number.len == 0 { Self::ZERO } else { number.times(&Self::shifted(1, by)) }
            };
            raised(self, shift - least).magnitude_cmp(&raised(other, other_shift - least))
        })
    }

    /// A positive f64 as a whole number and the power of two of its unit.
    pub(super) fn of_f64(value: f64) -> (Self, i32) {
        let bits = value.to_bits();
        let exponent = (bits >> 52) as i32 & 0x7ff;
        let fraction = bits & ((1 << 52) - 1);
        let mantissa = if exponent == 0 { fraction } else { fraction | 1 << 52 };
        (Self::shifted(mantissa, 0), exponent.max(1) - 1075)
    }
}

impl Number for Integer {
    fn unit(points: &[Vec3]) -> i32 {
        let coordinates = points.iter().flat_map(Vec3::to_array);
        let lowest_bits = coordinates.filter(|&coordinate| coordinate != 0.0).map(|coordinate| {
            let (mantissa, exponent) = parts(coordinate);
            exponent + mantissa.trailing_zeros() as i32
        });
        lowest_bits.min().unwrap_or(0)
    }

    fn difference(a: f32, b: f32, unit: i32) -> Self {
        let [a, b] = [a, b].map(|value| {
            let (mantissa, exponent) = parts(value);
            // Bits below the unit are zeros.
            let (mantissa, shift) =
                if exponent < unit { (mantissa >> (unit - exponent).min(63), 0) } else { (mantissa, exponent - unit) };
            Self { is_negative: value < 0.0, ..Self::shifted(mantissa, shift as usize) }
        });
        a.minus(&b)
    }

    fn plus(&self, other: &Self) -> Self {
        self.sum(other, other.is_negative)
    }

    fn minus(&self, other: &Self) -> Self {
        self.sum(other, !other.is_negative)
    }

    fn times(&self, other: &Self) -> Self {
        let mut product = Self::ZERO;
        if self.len == 0 || other.len == 0 {
            return product;
        }
        for (first, &a) in self.limbs().iter().enumerate() {
            let mut carry = 0;
            for (index, &b) in (first..).zip(other.limbs()) {
                // At most 2¹²⁸ − 1.
                let part = u128::from(a) * u128::from(b) + u128::from(product.limbs[index]) + carry;
                product.limbs[index] = part as u64;
                carry = part >> 64;
            }
            if carry != 0 {
                product.limbs[first + other.len] = carry as u64;
            }
        }
        let len = self.len + other.len;
        product.len = if len <= LIMBS && product.limbs[len - 1] != 0 { len } else { len - 1 };
        product.is_negative = self.is_negative != other.is_negative;
        product
    }

    fn sign(&self) -> Option<Ordering> {
        Some(match (self.len, self.is_negative) {
            (0, _) => Ordering::Equal,
            (_, true) => Ordering::Less,
            (_, false) => Ordering::Greater,
        })
    }
}

/// The magnitude of a finite f32 is the whole number times two to the power.
fn parts(value: f32) -> (u64, i32) {
    let bits = value.to_bits();
    let exponent = (bits >> 23) as i32 & 0xff;
    let fraction = u64::from(bits & ((1 << 23) - 1));
    (if exponent == 0 { fraction } else { fraction | 1 << 23 }, exponent.max(1) - 150)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whole(value: i64) -> Integer {
        Integer { is_negative: value < 0, ..Integer::shifted(value.unsigned_abs(), 0) }
    }

    #[test]
    fn sums_and_products_keep_every_bit() {
        let big = whole(i64::MAX).times(&whole(i64::MAX)).times(&whole(-7));
        assert_eq!(big.sign(), Some(Ordering::Less));
        assert_eq!(big.minus(&whole(1)).minus(&big).plus(&whole(1)).sign(), Some(Ordering::Equal));
        // (2⁶⁴ + 1)(2⁶⁴ − 1) + 1 = 2¹²⁸.
        let wide = Integer::shifted(1, 64);
        let product = wide.plus(&whole(1)).times(&wide.minus(&whole(1))).plus(&whole(1));
        assert_eq!(product.cmp_shifted(0, &whole(1), 128), Ordering::Equal);
        assert_eq!(product.minus(&whole(1)).cmp_shifted(0, &whole(1), 128), Ordering::Less);
        assert_eq!(product.plus(&whole(1)).cmp_shifted(5, &whole(1), 133), Ordering::Greater);
        assert_eq!(whole(0).cmp_shifted(900, &whole(1), 0), Ordering::Less);
    }

    #[test]
    fn the_largest_comparison_fits() {
        let points = [Vec3::splat(f32::MAX), Vec3::splat(-f32::MAX), Vec3::splat(f32::from_bits(1))];
        let unit = Integer::unit(&points);
        assert_eq!(unit, -149);
        let widest = Integer::difference(f32::MAX, -f32::MAX, unit);
        assert_eq!(widest.bits(), 278);
        let mut product = whole(1);
        for _ in 0..10 {
            product = product.times(&widest);
        }
        // Twelve products of degree two in three sums of three, and a sum: fewer than 2¹² times the product.
        assert!(product.bits() + 12 <= LIMBS * 64);
        let close =
            Integer::difference(1.5, f32::from_bits(1), unit).plus(&Integer::difference(f32::from_bits(1), 1.5, unit));
        assert_eq!(close.sign(), Some(Ordering::Equal));
    }

    #[test]
    fn numbers_are_those_of_floats() {
        for value in [1.0, 1.5, 3e-300, 5e-324, 1e300, std::f64::consts::PI] {
            let (number, unit) = Integer::of_f64(value);
            assert_eq!(
                number.limbs[0] as f64 * f64::exp2(f64::from(unit / 2)) * f64::exp2(f64::from(unit - unit / 2)),
                value
            );
        }
    }
}
