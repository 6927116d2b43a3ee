//! The arithmetic itself.

use super::{Random, common, kernel, map};

/// Words that the kernel writes for each pair.
const RESULT_WORDS: usize = 24;

#[test]
fn operations_have_the_bits_of_f64() {
    let Some(gpu) = common::gpu() else { return };
    let kernel = kernel(&gpu, include_str!("double.wgsl"), "operations");
    let mut random = Random(1);
    let special = special_pairs();
    for batch in 0..9 {
        let generated = (0..1 << 18).map(|index| random_pair(&mut random, index));
        let pairs: Vec<_> = if batch == 0 { special.clone() } else { generated.collect() };
        let bits: Vec<_> = pairs.iter().map(|pair| pair.map(f64::to_bits)).collect();
        let results = map(&gpu, &kernel, &bits, RESULT_WORDS);
        for (&[a, b], words) in pairs.iter().zip(results.chunks_exact(RESULT_WORDS)) {
            check(a, b, words);
        }
    }
}

fn check(a: f64, b: f64, words: &[u32]) {
    let number = |index: usize| f64::from_bits(u64::from(words[index]) | (u64::from(words[index + 1]) << 32));
    let low_word = a.to_bits() as u32;
    let expect = |operation: &str, index: usize, expected: f64| {
        let found = number(index);
        assert!(same(found, expected), "{operation} of {a:e} and {b:e}: {found:e}, not {expected:e}");
    };
    expect("sum", 0, a + b);
    // Knuth's differences overflow close to the largest number.
    if a.abs().max(b.abs()) < 2.0_f64.powi(1022) || !(a + b).is_finite() {
        expect("loss of the sum", 2, knuth(a, b));
    }
    expect("difference", 4, a - b);
    expect("product", 6, a * b);
    if dekker_is_exact(a, b) {
        expect("loss of the product", 8, dekker(a, b));
    } else if (a * b).is_subnormal() {
        expect("loss of the product", 8, 0.0);
    } else if !(a * b).is_finite() {
        assert!(number(8).is_nan(), "loss of the product of {a:e} and {b:e}: {:e}", number(8));
    }
    expect("quotient", 10, a / b);
    expect("f32", 12, f64::from(f32::from_bits(low_word)));
    expect("u32", 14, f64::from(low_word));
    expect("i32", 16, f64::from(low_word as i32));
    expect("larger magnitude", 18, if a.abs() > b.abs() { a.abs() } else { b.abs() });
    expect("magnitude", 22, a.abs());
    let single = f32::from_bits(words[20]);
    let rounded = a as f32;
    assert!(
        single.to_bits() == rounded.to_bits() || single.is_nan() && rounded.is_nan(),
        "{a:e} as f32: {single:e}, not {rounded:e}"
    );
    let flags = [a < b, a == b, a.is_finite(), a.is_nan(), a == 0.0, a.abs() < b.abs(), a < 0.0, a > 0.0];
    let expected = flags.iter().rev().fold(0, |bits, &flag| 2 * bits + u32::from(flag));
    assert_eq!(words[21], expected, "comparisons of {a:e} and {b:e}: {:b}, not {expected:b}", words[21]);
}

/// All NaN are one.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}

fn knuth(a: f64, b: f64) -> f64 {
    let sum = a + b;
    let b_seen = sum - a;
    (a - (sum - b_seen)) + (b - b_seen)
}

fn dekker(a: f64, b: f64) -> f64 {
    let split = |a: f64| {
        let shifted = 134_217_729.0 * a;
        let high = shifted - (shifted - a);
        (high, a - high)
    };
    let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
    ((a_high * b_high - a * b) + a_high * b_low + a_low * b_high) + a_low * b_low
}

/// Dekker's products are exact if the splitting doesn't overflow and the last of their 106 bits isn't below the
/// smallest number.
fn dekker_is_exact(a: f64, b: f64) -> bool {
    let product = (a * b).abs();
    let splits = a.abs().max(b.abs()) < 2.0_f64.powi(996);
    splits && product < 2.0_f64.powi(1020) && (product > 2.0_f64.powi(-960) || a == 0.0 || b == 0.0)
}

/// All pairs of numbers at limits of f32 and f64, and of their neighbours.
fn special_pairs() -> Vec<[f64; 2]> {
    let powers = [-1074, -1073, -1022, -1021, -960, -537, -150, -149, -126, -54, -53, -52, -1, 0, 1, 52, 53, 54, 127];
    let powers = powers.into_iter().chain([128, 511, 512, 970, 1022, 1023]);
    let mut numbers = vec![0.0, f64::INFINITY, f64::NAN, f64::from_bits(0x7ff0_0000_0000_0001)];
    for power in powers {
        let number = 2.0_f64.powi(power).max(f64::from_bits(1));
        numbers.extend([number, 1.5 * number]);
        numbers.extend([number.next_down(), number.next_up()]);
        // Halfway between two f32, and its neighbours.
        let halfway = number * (1.0 + 2.0_f64.powi(-24));
        numbers.extend([halfway.next_down(), halfway, halfway.next_up(), number * (1.0 + 3.0 * 2.0_f64.powi(-24))]);
    }
    numbers.push(f64::MAX);
    let negated: Vec<_> = numbers.iter().map(|number| -number).collect();
    numbers.extend(negated);
    numbers.iter().flat_map(|&a| numbers.iter().map(move |&b| [a, b])).collect()
}

/// A random pair of the kind of `index`.
fn random_pair(random: &mut Random, index: u64) -> [f64; 2] {
    let any = f64::from_bits(random.bits());
    let sparse = f64::from_bits(random.bits() & random.bits() & random.bits());
    let near = |random: &mut Random, of: f64, distance: u64| {
        let exponent = (of.to_bits() >> 52) & 0x7ff;
        let moved = (exponent + distance).saturating_sub(random.below(2 * distance + 1)).min(0x7fe);
        f64::from_bits((random.bits() & 0x800f_ffff_ffff_ffff) | (moved << 52))
    };
    let ordinary = f64::from_bits((random.bits() & 0x800f_ffff_ffff_ffff) | ((923 + random.below(200)) << 52));
    match index % 8 {
        0 => [any, f64::from_bits(random.bits())],
        1 => [any, near(random, any, 2)],
        2 => [ordinary, near(random, ordinary, 60)],
        // A sum that cancels to a few bits.
        3 => [ordinary, -f64::from_bits(ordinary.to_bits() ^ (1 << random.below(54)) ^ random.below(4))],
        // Halfway cases: few bits set, or a half of the last place.
        4 => [sparse, f64::from_bits(random.bits() & random.bits() & random.bits())],
        5 => {
            let half = ordinary * 2.0_f64.powi(-53 - random.below(2) as i32);
            [ordinary, f64::from_bits(half.to_bits() & 0xfff0_0000_0000_0000 | random.below(2))]
        }
        // Products near the smallest number.
        6 => [any, near(random, 1.0 / any, 3) * 2.0_f64.powi(-1000 - random.below(80) as i32)],
        _ => {
            let whole =
                |random: &mut Random| (random.below(1 << 28) as f64) * if random.below(2) == 0 { 1.0 } else { -1.0 };
            [whole(random), whole(random)]
        }
    }
}
