//! Distances from triangles in big numbers, by their definition: the least of a face and three segments; and triangles in
//! boxes, by clipping. No code is shared with the library.

use std::cmp::Ordering;

use glam::Vec3;
use num_bigint::BigInt;
use umbrage_rays::{Bounds, Triangles};

use crate::support::is_usable;

type Vector = [BigInt; 3];

/// A fraction with a positive denominator. A squared distance is in squares of 2⁻¹⁴⁹.
#[derive(Clone, Debug)]
pub(crate) struct Fraction {
    numerator: BigInt,
    denominator: BigInt,
}

impl Fraction {
    fn new(numerator: BigInt, denominator: BigInt) -> Self {
        Self { numerator, denominator }
    }

    pub(crate) fn compare(&self, other: &Self) -> Ordering {
        (&self.numerator * &other.denominator).cmp(&(&other.numerator * &self.denominator))
    }

    /// The square of a positive f64.
    pub(crate) fn square_of(distance: f64) -> Self {
        let bits = distance.to_bits();
        let exponent = (bits >> 52).max(1) as i32;
        let mantissa = BigInt::from(if bits >> 52 == 0 { bits } else { bits & ((1 << 52) - 1) | 1 << 52 });
        // The lowest bit is worth 2^(exponent − 1075), and the unit is 2⁻¹⁴⁹.
        Self::new((&mantissa * &mantissa) << (2 * exponent), BigInt::from(1) << (2 * (1075 - 149)))
    }

    /// The root of a squared distance, to about 60 bits.
    pub(crate) fn root(&self) -> f64 {
        let bits = self.numerator.bits() as i64 - self.denominator.bits() as i64;
        let shift = (128 - bits).max(0) / 2 * 2;
        let root = ((&self.numerator << shift) / &self.denominator).sqrt();
        let excess = root.bits().saturating_sub(60);
        let leading = i64::try_from(&root >> excess).expect("60 bits") as f64;
        let power = excess as i32 - (shift / 2) as i32 - 149;
        leading * f64::exp2(f64::from(power / 2)) * f64::exp2(f64::from(power - power / 2))
    }
}

fn whole(value: f32) -> BigInt {
    let bits = value.to_bits();
    let exponent = bits >> 23 & 0xff;
    let mantissa = BigInt::from(bits & 0x7f_ffff | if exponent == 0 { 0 } else { 1 << 23 });
    (if value < 0.0 { -mantissa } else { mantissa }) << (exponent.max(1) - 1)
}

fn minus(a: &Vector, b: &Vector) -> Vector {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

fn dot(a: &Vector, b: &Vector) -> BigInt {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    [&a[1] * &b[2] - &a[2] * &b[1], &a[2] * &b[0] - &a[0] * &b[2], &a[0] * &b[1] - &a[1] * &b[0]]
}

/// The squared distance of the origin from a segment.
fn from_segment(start: &Vector, end: &Vector) -> Fraction {
    let along = minus(end, start);
    let (share, length) = (-dot(start, &along), dot(&along, &along));
    let one = BigInt::from(1);
    if share <= BigInt::ZERO {
        Fraction::new(dot(start, start), one)
    } else if share >= length {
        Fraction::new(dot(end, end), one)
    } else {
        Fraction::new(dot(start, start) * &length - &share * &share, length)
    }
}

/// The squared distance of a point from a triangle.
pub(crate) fn squared_distance(point: Vec3, corners: [Vec3; 3]) -> Fraction {
    let point = point.to_array().map(whole);
    let [a, b, c] = corners.map(|corner| minus(&corner.to_array().map(whole), &point));
    let normal = cross(&minus(&b, &a), &minus(&c, &a));
    let is_inside = |from: &Vector, to: &Vector| dot(&normal, &cross(&minus(to, from), from)) <= BigInt::ZERO;
    let area = dot(&normal, &normal);
    if area > BigInt::ZERO && is_inside(&a, &b) && is_inside(&b, &c) && is_inside(&c, &a) {
        let height = dot(&normal, &a);
        return Fraction::new(&height * &height, area);
    }
    let segments = [from_segment(&a, &b), from_segment(&b, &c), from_segment(&c, &a)];
    segments.into_iter().min_by(Fraction::compare).expect("three")
}

/// The nearest triangle, the lowest id of equals, and its squared distance.
pub(crate) fn closest(triangles: Triangles<'_>, point: Vec3) -> Option<(u32, Fraction)> {
    let usable = (0..triangles.len() as u32).filter(|&id| is_usable(triangles, id));
    usable
        .map(|id| (id, squared_distance(point, triangles.corners(id))))
        .min_by(|(id, a), (other, b)| a.compare(b).then(id.cmp(other)))
}

/// The side of a triangle's plane that a point is on: `Greater` where its corners are seen counterclockwise.
pub(crate) fn side(point: Vec3, corners: [Vec3; 3]) -> Ordering {
    let point = point.to_array().map(whole);
    let [a, b, c] = corners.map(|corner| minus(&corner.to_array().map(whole), &point));
    BigInt::ZERO.cmp(&dot(&cross(&minus(&b, &a), &minus(&c, &a)), &a))
}

/// Whether a triangle has a point in common with a box, by clipping it on the six sides in homogeneous coordinates.
pub(crate) fn meets_box(corners: [Vec3; 3], bounds: Bounds) -> bool {
    let mut polygon: Vec<[BigInt; 4]> = corners
        .map(|corner| {
            let [x, y, z] = corner.to_array().map(whole);
            [x, y, z, BigInt::from(1)]
        })
        .into();
    for axis in 0..3 {
        for (end, is_low) in [(bounds.min, true), (bounds.max, false)] {
            let end = whole(end[axis]);
            let above = |at: &[BigInt; 4]| {
                let beyond = &at[axis] - &end * &at[3];
                if is_low { beyond } else { -beyond }
            };
            let mut clipped = Vec::new();
            for (index, at) in polygon.iter().enumerate() {
                let next = &polygon[(index + 1) % polygon.len()];
                let (of_at, of_next) = (above(at), above(next));
                if of_at >= BigInt::ZERO {
                    clipped.push(at.clone());
                }
                if (of_at > BigInt::ZERO && of_next < BigInt::ZERO) || (of_at < BigInt::ZERO && of_next > BigInt::ZERO)
                {
                    let (far, near) = (of_at.magnitude().clone().into(), of_next.magnitude().clone().into());
                    let (far, near): (BigInt, BigInt) = (far, near);
                    clipped.push([0, 1, 2, 3].map(|part| &at[part] * &near + &next[part] * &far));
                }
            }
            polygon = clipped;
        }
    }
    !polygon.is_empty()
}
