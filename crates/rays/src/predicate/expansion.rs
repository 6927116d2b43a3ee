//! Exact sums and products of f64: multi-term expansions.
//!
//! Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates*, 1997, §2.

use super::double::{Double, Number};

/// A real number as an unevaluated sum of at most `CAPACITY` f64, exact as long as nothing overflows or underflows.
///
/// Terms don't overlap and grow in magnitude; zeros are left out, so the last term has the number's sign. Capacities are the
/// most that the operands allow: a larger array would cost more to clear than the sums do.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expansion<const CAPACITY: usize> {
    terms: [f64; CAPACITY],
    len: usize,
}

impl<const CAPACITY: usize> Expansion<CAPACITY> {
    pub(super) const ZERO: Self = Self { terms: [0.0; CAPACITY], len: 0 };

    /// The nearest f64, or a neighbour of it; the sign is exact.
    pub(super) fn estimate(&self) -> f64 {
        self.terms().iter().sum()
    }

    /// Rounded to two terms.
    pub(super) fn rounded(&self) -> Double {
        let (mut high, mut low) = (0.0, 0.0);
        for &term in self.terms() {
            let (sum, error) = two_sum(high, term);
            (high, low) = (sum, low + error);
        }
        Double::from_terms(high, low)
    }

    /// Adds a · b.
    ///
    /// # Panics
    /// If the sum may have more than `CAPACITY` terms: twice the product of the numbers of terms, added to those here.
    pub(super) fn add_product<const A: usize, const B: usize>(&mut self, a: &Expansion<A>, b: &Expansion<B>) {
        for &a in a.terms() {
            for &b in b.terms() {
                let (high, low) = two_product(a, b);
                self.add(low);
                self.add(high);
            }
        }
    }

    /// Subtracts a · b.
    ///
    /// # Panics
    /// As [`add_product`](Self::add_product).
    pub(super) fn subtract_product<const A: usize, const B: usize>(&mut self, a: &Expansion<A>, b: &Expansion<B>) {
        for &a in a.terms() {
            for &b in b.terms() {
                let (high, low) = two_product(-a, b);
                self.add(low);
                self.add(high);
            }
        }
    }

    fn terms(&self) -> &[f64] {
        &self.terms[..self.len]
    }

    /// Grow-Expansion (Shewchuk, figure 6), leaving out zeros.
    fn add(&mut self, value: f64) {
        let mut carry = value;
        let mut len = 0;
        for index in 0..self.len {
            let (sum, error) = two_sum(carry, self.terms[index]);
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

impl Expansion<1> {
    pub(super) fn from_f64(value: f64) -> Self {
        let mut sum = Self::ZERO;
        sum.add(value);
        sum
    }
}

impl Expansion<2> {
    /// a − b.
    pub(super) fn difference(a: f64, b: f64) -> Self {
        let mut sum = Self::ZERO;
        sum.add(a);
        sum.add(-b);
        sum
    }
}

/// a + b as a rounded sum and its rounding error (Knuth).
#[inline(always)]
pub(crate) fn two_sum<N: Number>(a: N, b: N) -> (N, N) {
    let sum = a + b;
    let b_seen = sum - a;
    let a_seen = sum - b_seen;
    (sum, (a - a_seen) + (b - b_seen))
}

/// a · b as a rounded product and its rounding error (Dekker and Veltkamp; a fused multiply-add would be shorter but is a
/// library call where the target may lack it).
#[inline(always)]
pub(crate) fn two_product<N: Number>(a: N, b: N) -> (N, N) {
    let product = a * b;
    let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
    let error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
    (product, error)
}

/// A number as a sum of two with at most 26 significant bits each.
#[inline(always)]
fn split<N: Number>(a: N) -> (N, N) {
    const SPLITTER: f64 = ((1_u64 << 27) + 1) as f64;
    let shifted = a * SPLITTER;
    let high = shifted - (shifted - a);
    (high, a - high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_keep_every_bit() {
        let mut sum = Expansion::<3>::ZERO;
        [1e100, 1.0, 1e-100].into_iter().for_each(|term| sum.add(term));
        [-1e100, -1.0].into_iter().for_each(|term| sum.add(term));
        assert_eq!(sum.estimate(), 1e-100);
        sum.add(-1e-100);
        assert_eq!((sum.estimate(), sum.len), (0.0, 0));
    }

    #[test]
    fn products_keep_every_bit() {
        // (2⁵³ + 1)(2⁵³ − 1) = 2¹⁰⁶ − 1, which needs two terms on each side of the product.
        const BIG: f64 = 9_007_199_254_740_992.0;
        let (above, below) = (Expansion::difference(BIG, -1.0), Expansion::difference(BIG, 1.0));
        let mut product = Expansion::<10>::ZERO;
        product.add_product(&above, &below);
        product.subtract_product(&Expansion::from_f64(BIG), &Expansion::from_f64(BIG));
        assert_eq!(product.estimate(), -1.0);
    }

    #[test]
    fn two_product_recovers_the_rounding() {
        let (product, error) = two_product(1.0 + f64::EPSILON, 1.0 + f64::EPSILON);
        assert_eq!(product, 1.0 + 2.0 * f64::EPSILON);
        assert_eq!(error, f64::EPSILON * f64::EPSILON);
    }
}
