//! Errors of numbers of 64 bits.

use super::{Random, common, kernel, map};

/// Words that the kernel writes for each pair.
const RESULT_WORDS: usize = 34;

#[test]
fn wide_numbers_are_as_exact_as_they_say() {
    let Some(gpu) = common::gpu() else { return };
    let kernel = kernel(&gpu, include_str!("wide.wgsl"), "operations");
    let mut random = Random(7);
    for _ in 0..4 {
        let pairs: Vec<_> = (0..1 << 17).map(|index| random_pair(&mut random, index)).collect();
        let bits: Vec<_> = pairs.iter().map(|pair| pair.map(f64::to_bits)).collect();
        let results = map(&gpu, &kernel, &bits, RESULT_WORDS);
        for (&[a, b], words) in pairs.iter().zip(results.chunks_exact(RESULT_WORDS)) {
            check(a, b, words);
        }
    }
}

/// Numbers with normal products and rounding errors, some of them integers, close to each other, or zero.
fn random_pair(random: &mut Random, index: u64) -> [f64; 2] {
    let near = |random: &mut Random, exponent: u64| {
        f64::from_bits((random.bits() & 0x800f_ffff_ffff_ffff) | ((exponent + random.below(200)) << 52))
    };
    let ordinary = near(random, 923);
    match index % 6 {
        0 => [ordinary, near(random, 923)],
        // Of about the same size, or with few bits that differ.
        1 => [ordinary, f64::from_bits((random.bits() & 0x800f_ffff_ffff_ffff) | (ordinary.to_bits() & 0x7ff0 << 48))],
        2 => [ordinary, -f64::from_bits(ordinary.to_bits() ^ (1 << random.below(52)) ^ random.below(4))],
        // f32, within 2³⁸ of each other: 24 bits each.
        3 => [f64::from(random.bits() as f32), f64::from((random.bits() >> random.below(38)) as f32)],
        4 => [random.below(1 << 31) as f64 * 0.5 - 1e8, random.below(3) as f64],
        _ => [f64::from(f32::from_bits(random.bits() as u32 & 0x807f_ffff)), ordinary],
    }
}

fn check(a: f64, b: f64, words: &[u32]) {
    let wide = |word: usize| Wide::of(&words[word..]);
    let near = |what: &str, found: Wide, expected: [f64; 2], error: f64| {
        let off = (found.high - expected[0]) + (found.low - expected[1]);
        assert!(off.abs() <= error, "{what} of {a:e} and {b:e}: {found:?}, not {expected:?}: {off:e} beyond {error:e}");
        assert!(found.is_whole, "{what} of {a:e} and {b:e} hasn't its highest bit: {found:?}");
    };
    let (largest, smallest) = (a.abs().max(b.abs()), a.abs().min(b.abs()));
    let are_single = [a, b].iter().all(|&number| f64::from(number as f32) == number);
    let is_exact = are_single && smallest * 2.0_f64.powi(38) > largest;
    let error = if is_exact { 0.0 } else { largest * 2.0_f64.powi(-61) };
    near("sum", wide(0), two_sum(a, b), error);
    near("difference", wide(4), two_sum(a, -b), error);
    let product = a * b;
    near("product", wide(8), [product, a.mul_add(b, -product)], product.abs() * 2.0_f64.powi(-60));
    if a.abs() > 1e-200 {
        let inverse = wide(12);
        let rest = (-a).mul_add(inverse.high, 1.0) - a * inverse.low;
        assert!(rest.abs() < 2.0_f64.powi(-57), "1 / {a:e} is {inverse:?}: {rest:e}");
    }
    let single = f32::from_bits(a.to_bits() as u32 & 0xff7f_ffff);
    near("f32", wide(16), [f64::from(single), 0.0], 0.0);
    let kept = f64::from_bits(u64::from(words[20]) | (u64::from(words[21]) << 32));
    assert!(kept == a || (kept == 0.0 && a.is_subnormal()), "{a:e} kept as {kept:e}");
    let rounded = f32::from_bits(words[22]);
    // The nearest, or the other one of a tie.
    let off = (f64::from(rounded) - a).abs() - (f64::from(a as f32) - a).abs();
    assert!(rounded == a as f32 || off == 0.0, "{a:e} as f32: {rounded:e}");
    assert_eq!(words[23] == 1, a.abs() < 2.0_f64.powi(30), "{a:e} as a fixed-point number");
    if a.abs() < 2.0_f64.powi(30) {
        let off = f64::from(words[24] as i32) - a;
        assert!(off.abs() <= 0.5, "{a:e} as a fixed-point number: {}", words[24] as i32);
    }
    // ab + ba + 1, and b² − a.
    let [rounded, lost] = [product, a.mul_add(b, -product)];
    let sum = two_sum(2.0 * rounded, 1.0);
    let error = product.abs().max(1.0) * 2.0_f64.powi(-57) + lost.abs() * 2.0_f64.powi(-51);
    near("dot product", wide(26), [sum[0], sum[1] + 2.0 * lost], error);
    let square = b * b;
    let difference = two_sum(square, -a);
    let error = square.max(a.abs()) * 2.0_f64.powi(-59);
    near("cross product", wide(30), [difference[0], difference[1] + b.mul_add(b, -square)], error);
    assert_eq!(words[25] == 1, a.abs() < b.abs(), "{a:e} and {b:e} compared");
}

/// The sum of two f64, and its rounding error.
fn two_sum(a: f64, b: f64) -> [f64; 2] {
    let sum = a + b;
    let b_seen = sum - a;
    [sum, (a - (sum - b_seen)) + (b - b_seen)]
}

/// A wide number as two f64.
#[derive(Clone, Copy, Debug)]
struct Wide {
    high: f64,
    low: f64,
    /// Whether its highest bit is set, or it is zero.
    is_whole: bool,
}

impl Wide {
    fn of(words: &[u32]) -> Self {
        let bits = u64::from(words[0]) | (u64::from(words[1]) << 32);
        let exponent = (words[2] as i32).max(-1000);
        let sign = if words[3] == 0 { 1.0 } else { -1.0 };
        let scaled = |bits: u64| sign * bits as f64 * 2.0_f64.powi(exponent);
        Self { high: scaled(bits & !0x7ff), low: scaled(bits & 0x7ff), is_whole: bits == 0 || bits >> 63 == 1 }
    }
}
