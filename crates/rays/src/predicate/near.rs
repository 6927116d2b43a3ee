use fearless_simd::Simd;
use glam::{DVec3, Vec3};

use super::double::{Double, Number, is_fused};
use super::expansion::{two_product, two_sum};
use super::{EDGE_OPPOSITE, SMALLEST_TRUSTED_BOUND, barycentric, edge_bound, hit_of_near};
use crate::{Hit, Ray};

/// Answers [`hit_of_near`] bit for bit, about twice as fast. Cases it can't decide go to that function.
///
/// Weights are those of corners in canonical order up to their sign: exchanging two factors of a cross product changes no
/// other bit. t is rounded once from a number with a proven error, so it doesn't depend on how that number was computed.
#[inline(always)]
pub(crate) fn hit_of_near_at<S: Simd>(simd: S, ray: &Ray, corners: [Vec3; 3], id: u32) -> Option<Hit> {
    let (origin, direction) = (ray.origin, ray.direction);
    let [a, b, c] = [corners[0].as_dvec3(), corners[1].as_dvec3(), corners[2].as_dvec3()];
    let relative = [a - origin, b - origin, c - origin];
    let bound = edge_bound(direction, &relative);
    let weight = |opposite: usize| {
        let (first, second) = EDGE_OPPOSITE[opposite];
        direction.dot(relative[first].cross(relative[second]))
    };
    let weights = [weight(0), weight(1), weight(2)];
    let (lowest, highest) = (weights[0].min(weights[1]).min(weights[2]), weights[0].max(weights[1]).max(weights[2]));
    let is_trusted = (SMALLEST_TRUSTED_BOUND..LARGEST_TRUSTED_BOUND).contains(&bound);
    if is_trusted && lowest < -bound && highest > bound {
        return None;
    }
    let is_met = is_trusted && (lowest > bound || highest < -bound);
    let t = if is_met { quotient(simd, ray, [a, b, c]) } else { None };
    let Some(t) = t else { return hit_of_near(ray, corners, id) };
    let is_between = ray.t_min < t && t < ray.t_max;
    is_between.then(|| Hit { t, triangle: id, barycentric: barycentric(weights, [0, 1, 2]) })
}

/// With a bound below this and a direction of up to 10¹⁰⁰, no factor is large enough to make a product's loss to underflow
/// matter.
pub(super) const LARGEST_TRUSTED_BOUND: f64 = 1e100;

/// t as `Edges::t` computes it; `None` where that needs more precision.
#[inline(always)]
fn quotient<S: Simd>(simd: S, ray: &Ray, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let origin = ray.origin.to_array();
    let plane = TrianglePlane::new(simd, [a.to_array(), b.to_array(), c.to_array()], origin);
    let slope = plane.slope(simd, ray.direction.to_array());
    if !slope.is_precise() || !plane.height.is_precise() {
        return None;
    }
    let [low, high] = plane.height.quotient(simd, &slope);
    (low == high).then_some(low)
}

/// The plane of a triangle, or of eight.
pub(super) struct TrianglePlane<N> {
    normal: Split<N>,
    /// For each component of the normal, the sum of its terms' magnitudes.
    magnitudes: [N; 3],
    /// n · (A − o).
    pub(super) height: Sum<N>,
}

impl<N: Number> TrianglePlane<N> {
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, [a, b, c]: [[N; 3]; 3], origin: [N; 3]) -> Self {
        let (normal, magnitudes) = cross(simd, Split::difference(b, a), Split::difference(c, a));
        let height = dot(simd, normal, Split::difference(a, origin), magnitudes);
        Self { normal, magnitudes, height }
    }

    /// n · d.
    #[inline(always)]
    pub(super) fn slope<S: Simd>(&self, simd: S, direction: [N; 3]) -> Sum<N> {
        let zero = direction[0].zero();
        dot(simd, self.normal, Split { high: direction, low: [zero; 3] }, self.magnitudes)
    }
}

/// Three numbers, each a sum of two f64.
#[derive(Clone, Copy)]
struct Split<N> {
    high: [N; 3],
    low: [N; 3],
}

impl<N: Number> Split<N> {
    /// a − b, exactly.
    #[inline(always)]
    fn difference(a: [N; 3], b: [N; 3]) -> Self {
        let [x, y, z] = [two_sum(a[0], -b[0]), two_sum(a[1], -b[1]), two_sum(a[2], -b[2])];
        Self { high: [x.0, y.0, z.0], low: [x.1, y.1, z.1] }
    }
}

/// A sum, held as a sum of two numbers.
///
/// **Error bound.** Let u = 2⁻⁵³ and m the sum of magnitudes of the two products of a component of the normal. Its low part
/// is at most 4 u m, of seven operations, and omits products of two low parts: 32 u² m. In the sum of products with the
/// direction, or with the way to the first corner, M takes the place of m: low parts are at most 8 u M, of nine operations.
/// Together that is less than 128 u² M, or 2⁻⁷³ of a sum above 2⁻²⁶ M.
#[derive(Clone, Copy)]
pub(super) struct Sum<N> {
    pub(super) high: N,
    low: N,
    /// M.
    pub(super) magnitude: N,
}

/// The range of M in which the low parts of products neither overflow nor underflow.
pub(super) const RANGE: std::ops::Range<f64> = 1e-140..1e140;

impl Sum<f64> {
    /// Whether it is large enough relative to its terms' magnitudes.
    fn is_precise(&self) -> bool {
        RANGE.contains(&self.magnitude) && self.high.abs() > self.magnitude * Double::CANCELLATION
    }
}

impl<N: Number> Sum<N> {
    /// self ÷ divisor for precise sums, rounded to f64: once for the quotient minus its error and once plus it. If both are
    /// the same, that is the nearest f64.
    ///
    /// **Error bound.** The remainder of the first quotient is exact. All terms added to it are at most 3 u of the dividend,
    /// of three operations, and dividing by the high part alone omits another u of it: less than 16 u² of t. With the errors
    /// of the sums it is less than [`Double::PRECISION`].
    #[inline(always)]
    pub(super) fn quotient<S: Simd>(&self, simd: S, divisor: &Self) -> [N; 2] {
        let first = self.high / divisor.high;
        let (product, lost) = product(simd, first, divisor.high);
        let rest = ((self.high - product) - lost) + (self.low - first * divisor.low);
        let (second, error) = (rest / divisor.high, first.magnitude() * Double::PRECISION);
        [first + (second - error), first + (second + error)]
    }
}

/// a × b, and for each component the sum of its products' magnitudes.
#[inline(always)]
fn cross<S: Simd, N: Number>(simd: S, a: Split<N>, b: Split<N>) -> (Split<N>, [N; 3]) {
    let (x, y, z) = (determinant(simd, a, b, 1, 2), determinant(simd, a, b, 2, 0), determinant(simd, a, b, 0, 1));
    (Split { high: [x.high, y.high, z.high], low: [x.low, y.low, z.low] }, [x.magnitude, y.magnitude, z.magnitude])
}

#[inline(always)]
fn determinant<S: Simd, N: Number>(simd: S, a: Split<N>, b: Split<N>, next: usize, last: usize) -> Sum<N> {
    let (plus, plus_lost) = product(simd, a.high[next], b.high[last]);
    let (minus, minus_lost) = product(simd, a.high[last], b.high[next]);
    let (high, lost) = two_sum(plus, -minus);
    let plus_low = a.high[next] * b.low[last] + a.low[next] * b.high[last];
    let minus_low = a.high[last] * b.low[next] + a.low[last] * b.high[next];
    let low = (lost + (plus_lost - minus_lost)) + (plus_low - minus_low);
    Sum { high, low, magnitude: plus.magnitude() + minus.magnitude() }
}

/// n · v.
#[inline(always)]
fn dot<S: Simd, N: Number>(simd: S, n: Split<N>, v: Split<N>, magnitudes: [N; 3]) -> Sum<N> {
    let (x, x_lost) = product(simd, n.high[0], v.high[0]);
    let (y, y_lost) = product(simd, n.high[1], v.high[1]);
    let (z, z_lost) = product(simd, n.high[2], v.high[2]);
    let (sum, lost) = two_sum(x, y);
    let (sum, lost_too) = two_sum(sum, z);
    let of_n = n.low[0] * v.high[0] + n.low[1] * v.high[1] + n.low[2] * v.high[2];
    let of_v = n.high[0] * v.low[0] + n.high[1] * v.low[1] + n.high[2] * v.low[2];
    let low = ((lost + lost_too) + ((x_lost + y_lost) + z_lost)) + (of_n + of_v);
    let (high, low) = two_sum(sum, low);
    let magnitude = magnitudes[0] * v.high[0].magnitude()
        + magnitudes[1] * v.high[1].magnitude()
        + magnitudes[2] * v.high[2].magnitude();
    Sum { high, low, magnitude }
}

/// a · b as a rounded product and its rounding error.
#[inline(always)]
fn product<S: Simd, N: Number>(simd: S, a: N, b: N) -> (N, N) {
    if is_fused(simd) { a.fused_product(b) } else { two_product(a, b) }
}

#[cfg(test)]
mod tests {
    use crate::dispatch;

    use super::*;
    use crate::SimdLevel;
    use crate::predicate::Edges;
    use crate::random::Random;

    fn point(random: &mut Random) -> DVec3 {
        DVec3::new(random.signed(), random.signed(), random.signed())
    }

    /// Checks that all functions agree at all levels; returns how many levels found t without the fallback.
    fn told(ray: &Ray, corners: [Vec3; 3]) -> usize {
        let bits = |hit: Option<Hit>| hit.map(|hit| (hit.t.to_bits(), hit.barycentric.map(f32::to_bits)));
        let expected = hit_of_near(ray, corners, 7);
        let t = Edges::of_near(ray.origin, ray.direction, corners).map(|edges| edges.t().to_bits());
        let mut told = 0;
        for level in SimdLevel::available() {
            let hit = dispatch!(level, simd => hit_of_near_at(simd, ray, corners, 7));
            assert_eq!(bits(hit), bits(expected), "{ray:?} and {corners:?} at {level}");
            let quotient = dispatch!(level, simd => quotient(simd, ray, corners.map(Vec3::as_dvec3)));
            if let (Some(t), Some(quotient)) = (t, quotient) {
                assert_eq!(quotient.to_bits(), t, "{ray:?} and {corners:?} at {level}");
                told += 1;
            }
        }
        told
    }

    #[test]
    fn hits_have_the_reference_predicates_bits() {
        let levels = SimdLevel::available().len();
        let mut random = Random::new(9);
        let (mut hits, mut of_fast) = (0, 0);
        for round in 0..60_000 {
            // Scenes of all sizes, some beyond the range of f64 products; triangles far from their middle; slivers.
            let world = f64::exp2([30.0, 120.0][usize::from(round % 11 == 0)] * random.signed());
            let middle = point(&mut random) * world;
            let size = world * f64::exp2(-20.0 * random.unit());
            let [a, b, c] = [0; 3].map(|_| middle + point(&mut random) * size);
            let c = if round % 4 == 0 {
                a.lerp(b, random.signed()) + (c - a) * f64::exp2(-30.0 * random.unit())
            } else {
                c
            };
            let corners = [a, b, c].map(DVec3::as_vec3);
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            let (u, v) = (random.unit(), random.unit());
            let target = [a.lerp(b, u), c, a + (b - a) * (u * v) + (c - a) * (v - u * v)][round % 3];
            let mut origin = point(&mut random) * world;
            if round % 5 == 0 {
                // In the triangle's plane, or nearly so.
                origin = target + (b - a) * random.signed() + (c - a) * random.signed();
            }
            let ray =
                Ray::new(origin, (target - origin) * f64::exp2(300.0 * random.signed() * f64::from(round as u32 % 2)));
            hits += usize::from(hit_of_near(&ray, corners, 7).is_some());
            of_fast += told(&ray, corners);
        }
        assert!(hits > 20_000, "{hits}");
        assert!(4 * of_fast > 3 * hits * levels, "{of_fast} of {hits} hits at {levels} levels");
    }

    #[test]
    fn what_is_between_two_numbers_is_rounded_to_the_nearer_one() {
        let corners = [[-4.0, -4.0, 1.0], [4.0, -4.0, 1.0], [0.0, 4.0, 1.0]].map(Vec3::from_array);
        let half = f64::EPSILON / 2.0;
        for way in [0.0, half, half * (1.0 + 1.0 / 16_777_216.0), half * (1.0 - 1.0 / 16_777_216.0), 3.0 * half] {
            // Only the first 1 + way is an f64.
            let ray = Ray::new(DVec3::new(0.1, 0.2, -way), DVec3::Z);
            told(&ray, corners);
            let t = hit_of_near(&ray, corners, 7).expect("a hit").t;
            assert_eq!(t, 1.0 + way, "sums are rounded in the same way");
        }
    }
}
