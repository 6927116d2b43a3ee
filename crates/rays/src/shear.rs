//! The filter for a line and a triangle in f32: edge functions and the depth of a hit, with error bounds.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, f32x16, mask32x8, mask32x16};

use crate::simd::each;

const EPSILON: f32 = 1.0 / (1 << 24) as f32;

/// More than products lose to underflow.
pub const SMALLEST: f32 = 1e-36;

/// An f32, or a vector with one in each lane.
pub trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// A truth value for each lane.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask>;

    /// A vector with `value` in all lanes.
    fn all(self, value: f32) -> Self;
    fn magnitude(self) -> Self;
    fn least(self, other: Self) -> Self;
    fn most(self, other: Self) -> Self;
    /// self · factor + term, rounded once or twice.
    fn times_plus(self, factor: Self, term: Self) -> Self;
    fn is_below(self, other: Self) -> Self::Mask;
    fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self;
}

/// A triangle in the coordinates of a line, or one for each lane.
///
/// **Coordinates.** Depth z is along an axis k, and i and j are the other two. A corner is at (Δᵢ, Δⱼ, z) relative to the
/// line's origin. The line moves by slopes u and v per unit of z, of magnitude up to H. So a corner is
/// beside the line by x = Δᵢ − u z and y = Δⱼ − v z: space is sheared along i and j until the line is the axis k.
///
/// **Misses.** The edge functions of the predicate are, up to a common factor, E = x₁ y₂ − x₂ y₁. A triangle is missed if
/// two of them have certain and opposite signs, and certainly met if all three have the same certain sign.
///
/// **Error bounds.** Let ε = 2⁻²⁴ and a = |x| + |y| of a corner. Δᵢ, Δⱼ and z may be wrong by ε of themselves and another
/// ε b, where b is the `blur`, and slopes by ε H. Of x, the rounding of Δᵢ is ε |Δᵢ| ≤ ε (|x| + H |z|), those of u, of z and
/// of their product ε H |z| each, that of the difference ε |x|; the blur's are ε b (1 + H), and H is hardly above one.
/// Together they are at most 4 ε (a + H |z| + b), less than a third of e = 16 ε (a + H |z| + b), which is taken for the
/// largest of the three corners. So an edge function is wrong by at most e (a₁ + a₂ + e) / 3. Its own roundings are at most
/// 2 ε a₁ a₂ ≤ e (a₁ + a₂) / 16. Both are less than half of δ = e (a₁ + a₂ + a₃ + 3 e), whose own roundings are far less
/// than the rest. Where products and sums are fused, there is a rounding less. A product lost to underflow is less than
/// [`SMALLEST`].
#[derive(Clone, Copy, Debug)]
pub struct Sheared<V> {
    /// The edge functions opposite to the corners.
    edges: [V; 3],
    lowest: V,
    highest: V,
    /// e: three times the error bound of x and y of any corner.
    pub error: V,
    /// δ: twice the error bound of an edge function.
    doubt: V,
}

impl<V: Lanes> Sheared<V> {
    const ERROR: f32 = 16.0 * EPSILON;

    /// Shears triangles with Δᵢ, Δⱼ and z of their corners along lines with slopes u and v, given as −u and −v; `wide` is H.
    #[inline(always)]
    pub fn new([across, down, z]: [[V; 3]; 3], [u, v]: [V; 2], wide: f32, blur: f32) -> Self {
        let (x, y) = (beside(across, z, u), beside(down, z, v));
        let edges = [cross(x, y, 1, 2), cross(x, y, 2, 0), cross(x, y, 0, 1)];
        let aside = each!((x, y) in pairs(x, y) => x.magnitude() + y.magnitude());
        let [a, b, c] = each!((aside, z) in pairs(aside, z) => z.magnitude().times_plus(z.all(wide), aside));
        let error = a.most(b).most(c).times_plus(a.all(Self::ERROR), a.all(blur * Self::ERROR));
        // NaN of any corner is in this sum, and so rules nothing out.
        let size = error.times_plus(a.all(3.0), aside[0] + aside[1] + aside[2]);
        let doubt = size.times_plus(error, a.all(SMALLEST));
        let lowest = edges[0].least(edges[1]).least(edges[2]);
        let highest = edges[0].most(edges[1]).most(edges[2]);
        Self { edges, lowest, highest, error, doubt }
    }

    /// Whether the line certainly misses the triangle.
    #[inline(always)]
    pub fn is_missed(&self) -> V::Mask {
        self.lowest.is_below(-self.doubt) & self.doubt.is_below(self.highest)
    }

    /// Whether the line certainly meets the triangle.
    #[inline(always)]
    pub fn is_met(&self) -> V::Mask {
        self.doubt.is_below(self.lowest) | self.highest.is_below(-self.doubt)
    }

    /// Bounds of the depth of a hit, given the corners' depths along the line, each wrong by at most 1/16 of `error`, which
    /// is at least 16 ε of the largest.
    ///
    /// The depth is t = Σ E z / Σ E. A triangle that is met has it between the least and the largest z, whose difference is
    /// s. Errors d of the edge functions move it by Σ d (z − t) / Σ E, with Σ E as found, since Σ E (z − t) is zero without
    /// errors. Of three z, one may be s away from t, or two together, so Σ |z − t| is at most 2 s: as d is at most δ / 2, t
    /// moves by at most δ s / |Σ E|. A hundredth more covers the roundings of that. Those of sums, products and quotient are
    /// at most 8 ε of the largest z, half of `error`; twice `error` covers these and the errors of z.
    #[inline(always)]
    pub fn depth(&self, z: [V; 3], error: V) -> [V; 2] {
        let (first, last) = (z[0].least(z[1]).least(z[2]), z[0].most(z[1]).most(z[2]));
        let inverse = error.all(1.0) / (self.edges[0] + self.edges[1] + self.edges[2]);
        // Each E is divided first: products E z may underflow, and weights don't matter where they do.
        let [a, b, c] = each!((edge, z) in pairs(self.edges, z) => (edge * inverse) * z);
        let depth = a + b + c;
        let moved = (last - first).times_plus(self.doubt * inverse.magnitude() * error.all(1.01), error + error);
        let is_met = self.is_met();
        [V::choose(is_met, depth - moved, first - error), V::choose(is_met, depth + moved, last + error)]
    }
}

/// The corners' x, or y.
#[inline(always)]
fn beside<V: Lanes>(offsets: [V; 3], z: [V; 3], slope: V) -> [V; 3] {
    each!((offset, z) in pairs(offsets, z) => z.times_plus(slope, offset))
}

/// The edge function of two corners.
#[inline(always)]
fn cross<V: Lanes>(x: [V; 3], y: [V; 3], first: usize, second: usize) -> V {
    x[first].times_plus(y[second], -(x[second] * y[first]))
}

#[inline(always)]
fn pairs<T: Copy>(a: [T; 3], b: [T; 3]) -> [(T, T); 3] {
    [(a[0], b[0]), (a[1], b[1]), (a[2], b[2])]
}

impl Lanes for f32 {
    type Mask = bool;

    #[inline(always)]
    fn all(self, value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        self.abs()
    }

    // One instruction each; `f32::min` and `max` take five to pass over NaN. A filter for single rays takes a sixth less time
    // than with those. Where a coordinate is NaN, so is the doubt, and either number will do.
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn most(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn times_plus(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }

    #[inline(always)]
    fn is_below(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn choose(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}

macro_rules! lanes {
    ($vector:ident, $mask:ident) => {
        impl<S: Simd> Lanes for $vector<S> {
            type Mask = $mask<S>;

            #[inline(always)]
            fn all(self, value: f32) -> Self {
                Self::splat(self.token(), value)
            }

            #[inline(always)]
            fn magnitude(self) -> Self {
                self.abs()
            }

            #[inline(always)]
            fn least(self, other: Self) -> Self {
                self.min(other)
            }

            #[inline(always)]
            fn most(self, other: Self) -> Self {
                self.max(other)
            }

            #[inline(always)]
            fn times_plus(self, factor: Self, term: Self) -> Self {
                self.mul_add(factor, term)
            }

            #[inline(always)]
            fn is_below(self, other: Self) -> Self::Mask {
                self.simd_lt(other)
            }

            #[inline(always)]
            fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self {
                mask.select(yes, no)
            }
        }
    };
}

lanes!(f32x8, mask32x8);
lanes!(f32x16, mask32x16);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::{SimdLevel, dispatch};

    /// A line and a triangle in real numbers: Δᵢ, Δⱼ and z of the corners, and the slopes u and v.
    struct Pair {
        offsets: [[f64; 3]; 3],
        slopes: [f64; 2],
        wide: f64,
        /// The rounding of the origin on each axis, in f64.
        moved: [f64; 3],
        blur: f64,
    }

    impl Pair {
        /// Triangles of all sizes and shapes, lines that pass near them, and beams of all widths.
        fn new(random: &mut Random) -> Self {
            let world = f64::exp2(20.0 * random.signed());
            let wide = f64::exp2(-20.0 * random.unit());
            let slopes = [wide * random.signed(), wide * random.signed()];
            let size = world * f64::exp2(-20.0 * random.unit());
            let depth = world * random.signed();
            let corner = |random: &mut Random| {
                let z = depth + size * random.signed();
                [slopes[0] * z + size * random.signed(), slopes[1] * z + size * random.signed(), z]
            };
            let (a, b, mut c) = (corner(random), corner(random), corner(random));
            if random.unit() < 0.3 {
                let (along, thin) = (random.unit(), f64::exp2(-20.0 * random.unit()));
                c = [0, 1, 2].map(|axis| a[axis] + (b[axis] - a[axis]) * along + (c[axis] - a[axis]) * thin);
            }
            let blur = if random.unit() < 0.5 { 0.0 } else { world * f64::exp2(-10.0 * random.unit()) };
            let moved = [0; 3].map(|_| random.signed() * blur * f64::from(EPSILON));
            let offsets = [0, 1, 2].map(|axis| [a[axis], b[axis], c[axis]]);
            Self { offsets, slopes, wide: wide + 1.0 / f64::from(1 << 20), moved, blur }
        }

        /// The pair's test, rounded, in all lanes of vectors like `like`.
        #[inline(always)]
        fn test<V: Lanes>(&self, like: V) -> Tested<V> {
            let offset = |axis: usize| each!(at in self.offsets[axis] => like.all((at + self.moved[axis]) as f32));
            let [u, v] = [like.all(-self.slopes[0] as f32), like.all(-self.slopes[1] as f32)];
            let (offsets, wide, blur) = ([offset(0), offset(1), offset(2)], self.wide as f32, self.blur as f32);
            let sheared = Sheared::new(offsets, [u, v], wide, blur);
            let z = offsets[2];
            let largest = z[0].magnitude().most(z[1].magnitude()).most(z[2].magnitude());
            let error = largest.times_plus(like.all(16.0 * EPSILON), like.all(blur * 16.0 * EPSILON + SMALLEST));
            let [earliest, latest] = sheared.depth(z, error);
            let Sheared { edges, lowest, highest, error, doubt } = sheared;
            let ([a, b, c], x, y) = (edges, beside(offsets[0], z, u), beside(offsets[1], z, v));
            Tested([a, b, c, lowest, highest, error, doubt, earliest, latest, x[0], x[1], x[2], y[0], y[1], y[2]])
        }

        /// x and y of the corners, the edge functions and the depth of a hit. f64 is wrong by 2⁻²⁹ of the bounds in f32.
        fn truth(&self) -> ([[f64; 3]; 2], [f64; 3], f64) {
            let [across, down, z] = self.offsets;
            let x = [0, 1, 2].map(|corner| across[corner] - self.slopes[0] * z[corner]);
            let y = [0, 1, 2].map(|corner| down[corner] - self.slopes[1] * z[corner]);
            let edges = [(1, 2), (2, 0), (0, 1)].map(|(j, k)| x[j] * y[k] - x[k] * y[j]);
            let sum: f64 = edges.iter().sum();
            ([x, y], edges, (0..3).map(|corner| edges[corner] / sum * z[corner]).sum())
        }
    }

    /// The numbers of a [`Sheared`], bounds of the depth, and x and y of the corners.
    struct Tested<V>([V; 15]);

    /// The largest errors seen, relative to their bounds.
    #[derive(Default)]
    struct Largest {
        corner: f64,
        edge: f64,
        depth: f64,
        met: usize,
        missed: usize,
    }

    impl Largest {
        fn add(&mut self, pair: &Pair, Tested(numbers): Tested<f32>) {
            let [a, b, c, lowest, highest, error, doubt, earliest, latest, rest @ ..] = numbers;
            let sheared = Sheared { edges: [a, b, c], lowest, highest, error, doubt };
            let (beside, edges, depth) = pair.truth();
            let compare = |largest: &mut f64, found: &[f32], truth: &[f64], bound: f64| {
                for (&found, &truth) in found.iter().zip(truth) {
                    *largest = largest.max((f64::from(found) - truth).abs() / bound);
                }
            };
            compare(&mut self.corner, &rest, beside.as_flattened(), f64::from(error) / 3.0);
            compare(&mut self.edge, &sheared.edges, &edges, 0.5 * f64::from(doubt));
            let is_met =
                edges.iter().all(|edge| edge.is_sign_positive()) || edges.iter().all(|edge| edge.is_sign_negative());
            assert!(!(is_met && sheared.is_missed()) && (is_met || !sheared.is_met()), "{edges:?}: {sheared:?}");
            self.missed += usize::from(sheared.is_missed());
            let (earliest, latest) = (f64::from(earliest), f64::from(latest));
            if sheared.is_met() {
                self.met += 1;
                let off = (depth - 0.5 * (earliest + latest)).abs() / (0.5 * (latest - earliest));
                self.depth = self.depth.max(off);
            } else if is_met {
                assert!((earliest..=latest).contains(&depth), "{depth}: {earliest} to {latest}");
            }
        }

        fn check(&self, lanes: &str) {
            let Self { corner, edge, depth, met, missed } = *self;
            assert!(met > 2_000 && missed > 2_000, "{met} met, {missed} missed of {lanes}");
            assert!((0.3..1.0).contains(&corner), "{corner} of the bound of a corner, of {lanes}");
            assert!((0.1..1.0).contains(&edge), "{edge} of the bound of an edge function, of {lanes}");
            assert!((0.05..1.0).contains(&depth), "{depth} of the bound of a depth, of {lanes}");
        }
    }

    #[test]
    fn depths_are_within_their_bounds_with_the_largest_errors_of_edge_functions() {
        let mut random = Random::new(61);
        let mut largest = 0.0_f64;
        for _ in 0..10_000 {
            let doubt = f64::exp2(-10.0 * random.unit()) as f32;
            let edges = [0; 3].map(|_| doubt * (1.001 + f64::exp2(10.0 * random.unit())) as f32);
            let z = [0; 3].map(|_| random.signed() as f32);
            let error = 16.0 * EPSILON;
            let lowest = edges.into_iter().fold(f32::INFINITY, f32::min);
            let sheared = Sheared { edges, lowest, highest: f32::MAX, error, doubt };
            let (wide_edges, wide_z) = (edges.map(f64::from), z.map(f64::from));
            let depth = |edges: [f64; 3]| {
                let sum: f64 = edges.iter().sum();
                edges.iter().zip(wide_z).map(|(edge, z)| edge / sum * z).sum::<f64>()
            };
            let middle = depth(wide_edges);
            // All errors bring the depth nearer to the eye, or all take it farther away.
            for way in [-0.5, 0.5] {
                let wrong = [0, 1, 2].map(|corner| {
                    wide_edges[corner] - (way * f64::from(doubt)).copysign(way * (wide_z[corner] - middle))
                });
                let truth = depth(wrong);
                let [earliest, latest] = sheared.depth(z, error).map(f64::from);
                largest = largest.max((truth - 0.5 * (earliest + latest)).abs() / (0.5 * (latest - earliest)));
            }
            // Where nothing is certain, the depth may be a corner's, which has an error of its own.
            let unknown = Sheared { doubt: f32::INFINITY, ..sheared };
            let [earliest, latest] = unknown.depth(z, error).map(f64::from);
            let of_corner = f64::from(error) / 16.0;
            assert!(wide_z.iter().all(|z| earliest <= z - of_corner && z + of_corner <= latest));
        }
        assert!((0.8..1.0).contains(&largest), "{largest} of the bound");
    }

    #[test]
    fn errors_come_near_their_bounds_and_stay_below_them() {
        let mut random = Random::new(60);
        let pairs: Vec<Pair> = (0..40_000).map(|_| Pair::new(&mut random)).collect();
        let mut largest = Largest::default();
        pairs.iter().for_each(|pair| largest.add(pair, pair.test(0.0)));
        largest.check("one lane");
        for level in SimdLevel::available() {
            let (mut of_eight, mut of_sixteen) = (Largest::default(), Largest::default());
            for pair in &pairs {
                let (eight, sixteen) = dispatch!(level, simd => {
                    let Tested(eight) = pair.test(f32x8::splat(simd, 0.0));
                    let Tested(sixteen) = pair.test(f32x16::splat(simd, 0.0));
                    (Tested(eight.map(|lanes| lanes[0])), Tested(sixteen.map(|lanes| lanes[15])))
                });
                of_eight.add(pair, eight);
                of_sixteen.add(pair, sixteen);
            }
            of_eight.check(&format!("eight lanes at {level}"));
            of_sixteen.check(&format!("sixteen lanes at {level}"));
        }
    }
}
