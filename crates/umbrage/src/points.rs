//! Evenly spread points: of a lens, of time, of lights, of highlights.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

/// Maps the unit square to the unit disk, uniformly: the first number is the squared distance from its middle.
pub fn disk(square: DVec2) -> DVec2 {
    DVec2::from_angle(TAU * square.y) * square.x.sqrt()
}

/// Point `number` of a sequence in the unit square, with a different sequence for each dimension: Sobol's first two
/// dimensions, scrambled and reordered each time by hashes in place of Owen's random trees (Burley, Practical Hash-based
/// Owen Scrambling, JCGT 9(4), 2020). Every 2ᵏ successive points from a multiple of 2ᵏ on are spread evenly.
pub fn pair(number: u32, dimension: u32) -> DVec2 {
    let number = scrambled(number, seed(dimension, 0));
    let [first, second] = [number.reverse_bits(), second_sobol(number)];
    DVec2::new(unit(scrambled(first, seed(dimension, 1))), unit(scrambled(second, seed(dimension, 2))))
}

/// The same with a third number: the points are spread evenly in the unit cube. It takes the next dimension as well.
pub fn triple(number: u32, dimension: u32) -> DVec3 {
    let shuffled = scrambled(number, seed(dimension, 0));
    pair(number, dimension).extend(unit(scrambled(third_sobol(shuffled), seed(dimension, 3))))
}

/// The seed that scrambles a dimension: purpose 0 is its order, 1 to 3 are its first to third number.
fn seed(dimension: u32, purpose: u32) -> u32 {
    mixed(dimension.wrapping_mul(3).wrapping_add(purpose).wrapping_add(1))
}

/// The middle of the interval of numbers from 0 to 1 that start with these bits.
fn unit(bits: u32) -> f64 {
    (f64::from(bits) + 0.5) / (1_u64 << u32::BITS) as f64
}

/// Point `number` of a sequence that belongs to one pixel and purpose.
pub(crate) fn pair_of_pixel(number: u32, pixel: u32, purpose: u32) -> DVec2 {
    pair(number, mixed(pixel).wrapping_add(purpose))
}

/// The second dimension of Sobol's sequence.
fn second_sobol(number: u32) -> u32 {
    sum_of_columns(number, std::iter::successors(Some(1 << 31), |column| Some(column ^ (column >> 1))))
}

/// The third one: x² + x + 1 with 1 and 3, in the numbers of Joe and Kuo (2008).
fn third_sobol(number: u32) -> u32 {
    let pairs =
        std::iter::successors(Some([1 << 31, 3 << 30]), |&[last, column]| Some([column, column ^ last ^ (last >> 2)]));
    sum_of_columns(number, pairs.map(|[column, _]| column))
}

/// The sum, without carries, of the columns of a matrix of bits for the bits set in `number`.
fn sum_of_columns(number: u32, columns: impl Iterator<Item = u32>) -> u32 {
    let of_bits = (0..u32::BITS).zip(columns).filter(|(bit, _)| number >> bit & 1 == 1);
    of_bits.fold(0, |sum, (_, column)| sum ^ column)
}

/// Flips bits, each by a hash of the bits above it.
fn scrambled(bits: u32, seed: u32) -> u32 {
    let mut x = bits.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// A hash of a number (the finaliser of `MurmurHash3`).
fn mixed(number: u32) -> u32 {
    let mut x = number.wrapping_mul(0x9e37_79b9);
    x = (x ^ (x >> 16)).wrapping_mul(0x85eb_ca6b);
    x = (x ^ (x >> 13)).wrapping_mul(0xc2b2_ae35);
    x ^ (x >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_spread_evenly_in_every_dimension_and_apart() {
        for dimension in 0..9 {
            let points: Vec<DVec2> = (0..64).map(|number| pair(number, dimension)).collect();
            // Of 64 points, each of 8 × 8 squares, of 2 × 32 and of 64 × 1 stripes has one.
            for columns in [1.0, 2.0, 8.0, 32.0, 64.0] {
                let cell = |point: &DVec2| ((point.x * columns) as u32, (point.y * 64.0 / columns) as u32);
                let mut cells: Vec<_> = points.iter().map(cell).collect();
                cells.sort_unstable();
                cells.dedup();
                assert_eq!(cells.len(), 64, "{dimension}: {columns} columns");
            }
        }
        // Two dimensions aren't the same, nor each other's mirror images.
        for (one, other) in [(0, 1), (0, 2), (1, 2), (2, 3), (3, 4)] {
            let product = |number| (pair(number, one).x - 0.5) * (pair(number, other).x - 0.5);
            let correlation = 12.0 * (0..256).map(product).sum::<f64>() / 256.0;
            assert!(correlation.abs() < 0.25, "{one}, {other}: {correlation}");
        }
    }
}
