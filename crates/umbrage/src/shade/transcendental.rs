//! Exponentials, logarithms and cosines of sixteen numbers, from additions, multiplications and divisions alone: the same
//! bits from every set of instructions.

use std::f32::consts::{LN_2, PI};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

/// 2 to the power of `x`, with a relative error of about 2⁻²². Results are clamped to 2⁻¹²⁶ … 2¹²⁷.
#[inline(always)]
pub(crate) fn exp2<S: Simd>(x: f32x16<S>) -> f32x16<S> {
    let x = x.max(-126.0).min(127.0);
    let whole = (x + 0.5).floor();
    let part = (x - whole) * LN_2;
    // The series of e^part; part is within ±0.35.
    let mut power = part * (1.0 / 5040.0) + 1.0 / 720.0;
    for factor in [1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0] {
        power = power * part + factor;
    }
    let exponent: i32x16<S> = whole.to_int();
    power * ((exponent + 127) << 23).bitcast::<f32x16<S>>()
}

/// e to the power of `x`.
#[inline(always)]
pub(crate) fn exp<S: Simd>(x: f32x16<S>) -> f32x16<S> {
    exp2(x * std::f32::consts::LOG2_E)
}

/// The logarithm to the base 2 of numbers above zero, with an error of about 2⁻²²; smaller numbers count as the least normal
/// one.
#[inline(always)]
pub(crate) fn log2<S: Simd>(x: f32x16<S>) -> f32x16<S> {
    // From √½ to √2, so that numbers near one have exact logarithms near zero.
    const OFFSET: i32 = 0x3f35_04f3;
    let bits = x.max(f32::MIN_POSITIVE).bitcast::<i32x16<S>>();
    let exponent = (bits - OFFSET) >> 23;
    let mantissa = (bits - (exponent << 23)).bitcast::<f32x16<S>>();
    let ratio = (mantissa - 1.0) / (mantissa + 1.0);
    let squared = ratio * ratio;
    // Twice the inverse hyperbolic tangent; the ratio is within ±0.172.
    let series = ((squared * (1.0 / 9.0) + 1.0 / 7.0) * squared + 0.2) * squared + 1.0 / 3.0;
    let logarithm = ratio * (series * squared + 1.0) * 2.0;
    logarithm * std::f32::consts::LOG2_E + exponent.to_float::<f32x16<S>>()
}

/// `x`, not below zero, to the power of `y`; 0 counts as the least normal number.
#[inline(always)]
pub(crate) fn power<S: Simd>(x: f32x16<S>, y: f32x16<S>) -> f32x16<S> {
    exp2(log2(x) * y)
}

/// The cosine of radians, with an error of about 2⁻²¹; for large angles, of f32's precision in turns.
#[inline(always)]
pub(crate) fn cosine<S: Simd>(radians: f32x16<S>) -> f32x16<S> {
    let turns = radians * (0.5 / PI);
    // From half a turn, where the cosine is −1, to either side; then a quarter turn or less.
    let from_half = ((turns - turns.floor()) - 0.5).abs();
    let angle = (0.25 - from_half) * (2.0 * PI);
    let squared = angle * angle;
    let mut sine = squared * (-1.0 / 39_916_800.0) + 1.0 / 362_880.0;
    for factor in [-1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0, 1.0] {
        sine = sine * squared + factor;
    }
    -(sine * angle)
}

#[cfg(test)]
mod tests {
    use umbrage_rays::{SimdLevel, dispatch};

    use super::*;
    use crate::shade::lanes::{Each, LANES};

    /// The largest relative error of a function over numbers.
    fn largest_error(numbers: &[f32], of: impl Fn(&Each<f32>) -> Each<f32>, truth: impl Fn(f64) -> f64) -> f64 {
        let mut largest = 0.0_f64;
        for chunk in numbers.chunks_exact(LANES) {
            let chunk: Each<f32> = chunk.try_into().expect("as many");
            for (x, got) in chunk.iter().zip(of(&chunk)) {
                let truth = truth(f64::from(*x));
                largest = largest.max((f64::from(got) - truth).abs() / truth.abs().max(1e-30));
            }
        }
        largest
    }

    fn numbers(from: f32, to: f32) -> Vec<f32> {
        (0..160_000).map(|step| from + (to - from) * (step as f32 / 160_000.0)).collect()
    }

    #[test]
    fn they_are_those_of_mathematics() {
        let exponentials = largest_error(
            &numbers(-125.0, 126.0),
            |x| dispatch!(SimdLevel::default(), simd => exp2(f32x16::from_slice(simd, x)).into()),
            f64::exp2,
        );
        // f32's rounding of x, up to 127, times ln 2, and a few roundings.
        assert!(exponentials < 3e-7, "{exponentials}");
        let logarithms = largest_error(
            &numbers(1e-6, 9.0),
            |x| dispatch!(SimdLevel::default(), simd => log2(f32x16::from_slice(simd, x)).into()),
            f64::log2,
        );
        assert!(logarithms < 4e-7, "{logarithms}");
        let cosines = largest_error(
            &numbers(-30.0, 30.0),
            |x| {
                let raised: Each<f32> =
                    dispatch!(SimdLevel::default(), simd => (cosine(f32x16::from_slice(simd, x)) + 2.0).into());
                raised
            },
            |x| x.cos() + 2.0,
        );
        assert!(cosines < 4e-6, "{cosines}");
    }

    #[test]
    fn zero_is_as_little_as_there_is() {
        let least: [f32; 2] = dispatch!(SimdLevel::default(), simd => {
            let zero = f32x16::splat(simd, 0.0);
            [power(zero, f32x16::splat(simd, 2.0))[0], exp(f32x16::splat(simd, f32::NEG_INFINITY))[0]]
        });
        assert!(least.iter().all(|least| (0.0..1e-37).contains(least)), "{least:?}");
        let huge: f32 = dispatch!(SimdLevel::default(), simd => cosine(f32x16::splat(simd, 1e30))[0]);
        assert!(huge.abs() <= 1.000_001, "{huge}");
    }
}
