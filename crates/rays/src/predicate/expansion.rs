//! Exact sums and products of f64: multi-term expansions.
//!
//! Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates*, 1997, §2.

/// A real number as an unevaluated sum of f64, exact as long as nothing overflows or underflows.
///
/// Terms don't overlap and grow in magnitude; zeros are left out, so the last term has the number's sign.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expansion {
    terms: [f64; Self::CAPACITY],
    len: usize,
}

impl From<f64> for Expansion {
    fn from(value: f64) -> Self {
        let mut sum = Self::ZERO;
        sum.add(value);
        sum
    }
}

impl Expansion {
    /// Enough for the largest product here, a difference (2 terms) dotted with a cross product of differences:
    /// 3 axes × 2 products × 2 · 2² · 2 · 2 terms.
    const CAPACITY: usize = 192;
    const ZERO: Self = Self { terms: [0.0; Self::CAPACITY], len: 0 };

    /// a − b.
    pub(super) fn difference(a: f64, b: f64) -> Self {
        let mut sum = Self::from(a);
        sum.add(-b);
        sum
    }

    pub(super) fn plus(mut self, other: &Self) -> Self {
        other.terms().iter().for_each(|&term| self.add(term));
        self
    }

    pub(super) fn minus(mut self, other: &Self) -> Self {
        other.terms().iter().for_each(|&term| self.add(-term));
        self
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        let mut product = Self::ZERO;
        for &a in self.terms() {
            for &b in other.terms() {
                let (high, low) = two_product(a, b);
                product.add(low);
                product.add(high);
            }
        }
        product
    }

    /// The nearest f64, or a neighbour of it; the sign is exact.
    pub(super) fn estimate(&self) -> f64 {
        self.terms().iter().sum()
    }

    fn terms(&self) -> &[f64] {
        &self.terms[..self.len]
    }

    /// Grow-Expansion (Shewchuk, figure 6), leaving out zeros.
    fn add(&mut self, value: f64) {
        let mut carry = value;
        let mut len = 0;
        for place in 0..self.len {
            let (sum, error) = two_sum(carry, self.terms[place]);
            carry = sum;
            if error != 0.0 {
                self.terms[len] = error;
                len += 1;
            }
        }
        if carry != 0.0 {
            self.terms[len] = carry;
            len += 1;
        }
        self.len = len;
    }
}

/// a + b as a rounded sum and what the rounding lost (Knuth).
pub(super) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_seen = sum - a;
    let a_seen = sum - b_seen;
    (sum, (a - a_seen) + (b - b_seen))
}

/// a · b as a rounded product and what the rounding lost (Dekker and Veltkamp; a fused multiply-add would be shorter
/// but is a library call where the target may lack it).
pub(super) fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
    let error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
    (product, error)
}

/// A number as a sum of two with at most 26 significant bits each.
fn split(a: f64) -> (f64, f64) {
    const SPLITTER: f64 = ((1_u64 << 27) + 1) as f64;
    let shifted = SPLITTER * a;
    let high = shifted - (shifted - a);
    (high, a - high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_keep_every_bit() {
        let sum = Expansion::from(1e100).plus(&Expansion::from(1.0)).plus(&Expansion::from(1e-100));
        let rest = sum.minus(&Expansion::from(1e100)).minus(&Expansion::from(1.0));
        assert_eq!(rest.estimate(), 1e-100);
        assert_eq!(rest.minus(&Expansion::from(1e-100)).estimate(), 0.0);
    }

    #[test]
    fn products_keep_every_bit() {
        // (2⁵³ + 1)(2⁵³ − 1) = 2¹⁰⁶ − 1, which needs two terms on each side of the product.
        let big = Expansion::from(9_007_199_254_740_992.0);
        let one = Expansion::from(1.0);
        let product = big.plus(&one).times(&big.minus(&one));
        assert_eq!(product.minus(&big.times(&big)).estimate(), -1.0);
    }

    #[test]
    fn two_product_recovers_the_rounding() {
        let (product, error) = two_product(1.0 + f64::EPSILON, 1.0 + f64::EPSILON);
        assert_eq!(product, 1.0 + 2.0 * f64::EPSILON);
        assert_eq!(error, f64::EPSILON * f64::EPSILON);
    }
}
