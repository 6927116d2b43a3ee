//! The reference predicate: which triangles a ray meets, where, and which triangles shadow a point.
//!
//! Every structure settles its undecided cases with these functions, so every structure gives their answer.
//!
//! The edge functions E(p, q) = d · ((p − o) × (q − o)) of Plücker's test are evaluated in f64. Where the result is
//! smaller than its error bound, the sign is taken from exact arithmetic. So signs are those of real numbers:
//! neighbours agree about their shared edge and fans about their vertex, and no ray slips between them.

mod double;
mod eight;
mod expansion;
mod near;
#[doc(hidden)]
pub mod settle;
mod shadow;

use glam::{DVec3, Vec3};

use crate::{Hit, Ray, Triangles};
use double::Double;
#[doc(hidden)]
pub use eight::hits;
pub(crate) use eight::{RayList, hits_of};
use expansion::Expansion;
pub(crate) use expansion::{two_product, two_sum};
pub(crate) use near::hit_of_near_at;

pub use shadow::{HitPoint, ShadowRay};

/// Half the distance from one to the next f64: the relative error of one rounding.
pub const ROUNDING: f64 = f64::EPSILON / 2.0;

/// A ray and a triangle that meet.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// Distance along the ray's line, in lengths of its direction: the f64 that is nearest to the real number.
    pub t: f64,
    /// Weights of the triangle's second and third vertex, each in [0, 1].
    pub barycentric: [f32; 2],
    /// Whether the ray comes from the front, where the corners are seen counterclockwise.
    pub front: bool,
}

/// Returns the crossing of the whole line through `ray` and the triangle `corners`, regardless of the ray's interval; `None`
/// for a miss.
///
/// It meets the triangle when the three edge functions have no two opposite signs and aren't all zero. A triangle
/// seen exactly edge-on is a miss, and so is one with a corner that isn't finite.
#[inline]
#[must_use]
pub fn crossing(ray: &Ray, corners: [Vec3; 3]) -> Option<Crossing> {
    let edges = Edges::new(ray.origin, ray.direction, corners)?;
    Some(Crossing { t: edges.t(), barycentric: edges.barycentric(), front: edges.is_front() })
}

/// Returns the hit of `ray` on triangle `id` inside the ray's interval; `None` for a miss.
///
/// # Panics
/// If `id` or one of the triangle's vertices is out of range.
#[inline]
#[must_use]
pub fn hit(ray: &Ray, triangles: Triangles<'_>, id: u32) -> Option<Hit> {
    let corners = triangles.corners(id);
    if is_missed(ray.origin, ray.direction, corners) { None } else { hit_of_near(ray, corners, id) }
}

/// The weights of a triangle's second and third corner where the whole line through `ray` meets it, as in [`hit`]; `None`
/// for a miss.
#[inline]
#[must_use]
pub fn barycentric_of(ray: &Ray, corners: [Vec3; 3]) -> Option<[f32; 2]> {
    Edges::of_near(ray.origin, ray.direction, corners).map(|edges| edges.barycentric())
}

/// As [`hit`], without a first check for clear misses: for triangles that the ray probably meets.
#[inline]
pub(crate) fn hit_of_near(ray: &Ray, corners: [Vec3; 3], id: u32) -> Option<Hit> {
    let edges = Edges::of_near(ray.origin, ray.direction, corners)?;
    let t = edges.t();
    (ray.t_min < t && t < ray.t_max).then(|| Hit { t, triangle: id, barycentric: edges.barycentric() })
}

/// Whether rays along `direction` meet a triangle from its front, where its corners are seen counterclockwise; false for
/// rays in its plane. For a ray that hits it, this is [`Crossing::front`].
#[must_use]
pub fn is_front_along(direction: DVec3, corners: [Vec3; 3]) -> bool {
    let direction = direction * scale_to_one(direction);
    is_against_normal(corners, direction.to_array().map(Double::from), || exact_vector(direction))
}

/// Whether a triangle's corners are seen counterclockwise from a `point`; false for a point in the triangle's plane. For
/// rays from there that hit it, this is [`Crossing::front`].
#[must_use]
pub fn is_front_from(point: DVec3, corners: [Vec3; 3]) -> bool {
    let corner = corners[0].as_dvec3();
    is_against_normal(corners, Double::difference(corner.to_array(), point.to_array()), || {
        exact_difference(corner, point)
    })
}

/// Whether n · v < 0 for the unnormalised normal n of a triangle and a vector v, given both as doubles and exactly.
fn is_against_normal<const N: usize>(
    corners: [Vec3; 3],
    vector: [Double; 3],
    exact: impl FnOnce() -> [Expansion<N>; 3],
) -> bool {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let normal = normal([a, b, c].map(|corner| corner.to_array()));
    let product = Double::dot(normal, vector);
    if product.is_precise() {
        product.value() < 0.0
    } else {
        exact_dot(&exact_normal(a, b, c), &exact()).estimate() < 0.0
    }
}

/// A triangle that a line meets, with its corners in canonical order.
///
/// Corners are sorted by position: a triangle gives bit for bit the same result however its corners are listed.
#[derive(Clone, Copy, Debug)]
struct Edges {
    origin: DVec3,
    direction: DVec3,
    /// Corners in canonical order.
    corners: [Vec3; 3],
    /// The index of each of `corners` in the caller's list.
    order: [usize; 3],
    /// Weights of `corners`, not yet divided by their sum.
    weights: [f64; 3],
    /// The common sign of the edge functions: 1 or −1.
    side: f64,
}

impl Edges {
    /// `None` where the line misses the triangle.
    #[inline(always)]
    fn new(origin: DVec3, direction: DVec3, corners: [Vec3; 3]) -> Option<Self> {
        // Most triangles end here, before their corners are sorted.
        if is_missed(origin, direction, corners) { None } else { Self::of_near(origin, direction, corners) }
    }

    #[inline(never)]
    fn of_near(origin: DVec3, direction: DVec3, corners: [Vec3; 3]) -> Option<Self> {
        let order = canonical_order(&corners);
        let corners = order.map(|index| corners[index]);
        let relative = corners.map(|corner| corner.as_dvec3() - origin);

        let bound = edge_bound(direction, &relative);

        let mut weights = [0.0; 3];
        let mut undecided = [false; 3];
        let mut signs = Signs::default();
        for (opposite, weight) in weights.iter_mut().enumerate() {
            let (first, second) = EDGE_OPPOSITE[opposite];
            *weight = direction.dot(relative[first].cross(relative[second]));
            undecided[opposite] = weight.abs() <= bound || bound < SMALLEST_TRUSTED_BOUND;
            if !undecided[opposite] {
                signs.note(*weight);
            }
        }
        let finite = weights.iter().all(|weight| weight.is_finite());
        if signs.disagree() || !finite {
            return None;
        }
        if undecided.contains(&true) {
            // All weights get the scale of the exact ones, so that their ratios are right. Decided weights are far above the
            // smallest number, so a power of two changes none of their bits.
            let scale = scale_to_one(direction);
            for opposite in 0..3 {
                if !undecided[opposite] {
                    weights[opposite] *= scale;
                    continue;
                }
                let (first, second) = EDGE_OPPOSITE[opposite];
                weights[opposite] = exact_edge(origin, direction * scale, corners[first], corners[second]);
                signs.note(weights[opposite]);
                if signs.disagree() {
                    return None;
                }
            }
        }
        let side = signs.common()?;
        Some(Self { origin, direction, corners, order, weights, side })
    }

    /// t, rounded to the nearest f64: n · (A − o) over n · d for the unnormalised normal n.
    ///
    /// It is computed in double-double arithmetic where that is certain, else exactly. A t within 2⁻⁴⁵ units in the last
    /// place of the middle between two f64 is rounded to the even one.
    fn t(&self) -> f64 {
        let [a, b, c] = self.corners.map(Vec3::as_dvec3);
        let corners = [a, b, c].map(|corner| corner.to_array());
        let (slope, height) = slope_and_height(corners, self.origin.to_array(), self.direction.to_array());
        let [low, high] = height.quotient(slope, Double::PRECISION);
        if slope.is_precise() && height.is_precise() && low == high {
            return low;
        }
        let normal = exact_normal(a, b, c);
        let scale = scale_to_one(self.direction);
        let slope = exact_dot(&normal, &exact_vector(self.direction * scale)).rounded();
        let height = exact_dot(&normal, &exact_difference(a, self.origin)).rounded();
        let [low, high] = height.quotient(slope, Double::ROUNDED);
        (if low.to_bits() & 1 == 0 { low } else { high }) * scale
    }

    fn barycentric(&self) -> [f32; 2] {
        barycentric(self.weights, self.order)
    }

    /// Each exchange of two corners turns the triangle around.
    fn is_front(&self) -> bool {
        let is_even = matches!(self.order, [0, 1, 2] | [1, 2, 0] | [2, 0, 1]);
        // A counterclockwise triangle has its normal towards the ray's origin, so n · d is negative; the sum of the
        // edge functions is n · d.
        (self.side < 0.0) == is_even
    }
}

/// Weights of a triangle's second and third corner, from undivided weights of its corners in canonical order.
fn barycentric(weights: [f64; 3], order: [usize; 3]) -> [f32; 2] {
    let mut of_caller = [0.0; 3];
    for (weight, index) in weights.iter().zip(order) {
        // The signs are exact, so no weight is negative; a weight decided by the filter is never zero.
        of_caller[index] = weight.abs();
    }
    let sum: f64 = of_caller.iter().sum();
    [(of_caller[1] / sum) as f32, (of_caller[2] / sum) as f32]
}

/// The unnormalised normal n of a triangle.
#[inline(always)]
fn normal([a, b, c]: [[f64; 3]; 3]) -> [Double; 3] {
    Double::cross(Double::difference(b, a), Double::difference(c, a))
}

/// n · d and n · (A − o) for the unnormalised normal n.
#[inline(always)]
fn slope_and_height(corners: [[f64; 3]; 3], origin: [f64; 3], direction: [f64; 3]) -> (Double, Double) {
    let normal = normal(corners);
    let [x, y, z] = direction;
    let slope = Double::dot(normal, [Double::from(x), Double::from(y), Double::from(z)]);
    (slope, Double::dot(normal, Double::difference(corners[0], origin)))
}

/// Error bound of edge functions, for corners `relative` to a line's origin.
///
/// Seven roundings on a path from input to result and six products in the sum: 42 roundings of the largest possible
/// product, taken as 64. It also covers the bound's own roundings.
#[inline(always)]
fn edge_bound(direction: DVec3, relative: &[DVec3; 3]) -> f64 {
    let reach = relative[0].abs().max(relative[1].abs()).max(relative[2].abs()).max_element();
    64.0 * ROUNDING * direction.abs().max_element() * reach * reach
}

/// Whether two edge functions certainly have opposite signs, in any order of the corners: then the line misses.
#[inline(always)]
fn is_missed(origin: DVec3, direction: DVec3, [a, b, c]: [Vec3; 3]) -> bool {
    // Not by `array::map`, which is a call here.
    let relative = [a.as_dvec3() - origin, b.as_dvec3() - origin, c.as_dvec3() - origin];
    let bound = edge_bound(direction, &relative);
    let edge = |first: usize, second: usize| direction.dot(relative[first].cross(relative[second]));
    let (a, b, c) = (edge(1, 2), edge(2, 0), edge(0, 1));
    let (lowest, highest) = (a.min(b).min(c), a.max(b).max(c));
    // A triangle with a NaN edge function is never hit. Bounds that are NaN or too small are left to the full test.
    bound >= SMALLEST_TRUSTED_BOUND && lowest < -bound && highest > bound
}

/// For each corner the other two, in the order in which their edge function is the corner's weight.
const EDGE_OPPOSITE: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

/// Below this, an error bound may itself have lost bits to underflow.
const SMALLEST_TRUSTED_BOUND: f64 = 1e-250;

/// The indices of the corners, sorted by x, then y, then z.
fn canonical_order(corners: &[Vec3; 3]) -> [usize; 3] {
    let after = |first: usize, second: usize| {
        let (first, second) = (corners[first], corners[second]);
        (first.x, first.y, first.z) > (second.x, second.y, second.z)
    };
    let mut order = [0, 1, 2];
    if after(order[0], order[1]) {
        order.swap(0, 1);
    }
    if after(order[1], order[2]) {
        order.swap(1, 2);
    }
    if after(order[0], order[1]) {
        order.swap(0, 1);
    }
    order
}

/// The signs of the edge functions so far; zero has none.
#[derive(Default)]
struct Signs {
    positive: bool,
    negative: bool,
}

impl Signs {
    fn note(&mut self, value: f64) {
        self.positive |= value > 0.0;
        self.negative |= value < 0.0;
    }

    fn disagree(&self) -> bool {
        self.positive && self.negative
    }

    fn common(&self) -> Option<f64> {
        match (self.positive, self.negative) {
            (true, false) => Some(1.0),
            (false, true) => Some(-1.0),
            _ => None,
        }
    }
}

/// d · ((p − o) × (q − o)) to within one rounding, with the exact sign.
#[cold]
fn exact_edge(origin: DVec3, direction: DVec3, p: Vec3, q: Vec3) -> f64 {
    let p = exact_difference(p.as_dvec3(), origin);
    let q = exact_difference(q.as_dvec3(), origin);
    exact_dot(&exact_cross(&p, &q), &exact_vector(direction)).estimate()
}

/// The power of two that brings the largest component of `direction` between one and two, so that products with it
/// don't underflow; one where there is no such normal number.
fn scale_to_one(direction: DVec3) -> f64 {
    // The exponent bits give it exactly; a logarithm may round up to the next power.
    let exponent_bits = direction.abs().max_element().to_bits() >> 52;
    if (1..LARGEST_EXPONENT_BITS).contains(&exponent_bits) {
        f64::from_bits((LARGEST_EXPONENT_BITS - exponent_bits) << 52)
    } else {
        1.0
    }
}

/// The exponent bits of the largest finite f64; those of x and 1 / x, for a power of two, add up to them.
const LARGEST_EXPONENT_BITS: u64 = 2046;

/// The components of a − b.
#[inline]
fn exact_difference(a: DVec3, b: DVec3) -> [Expansion<2>; 3] {
    [Expansion::difference(a.x, b.x), Expansion::difference(a.y, b.y), Expansion::difference(a.z, b.z)]
}

#[inline]
fn exact_vector(a: DVec3) -> [Expansion<1>; 3] {
    [Expansion::from_f64(a.x), Expansion::from_f64(a.y), Expansion::from_f64(a.z)]
}

/// (b − a) × (c − a).
fn exact_normal(a: DVec3, b: DVec3, c: DVec3) -> [Expansion<16>; 3] {
    exact_cross(&exact_difference(b, a), &exact_difference(c, a))
}

/// a × b: two products of 2 · 2 · 2 terms for each component.
#[inline]
fn exact_cross(a: &[Expansion<2>; 3], b: &[Expansion<2>; 3]) -> [Expansion<16>; 3] {
    // Filled in place: moving its bytes would take longer than the sums.
    let mut product = [Expansion::ZERO; 3];
    for (axis, component) in product.iter_mut().enumerate() {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        component.add_product(&a[next], &b[last]);
        component.subtract_product(&a[last], &b[next]);
    }
    product
}

/// a · b: three products of 2 · 16 · 2 terms at most.
fn exact_dot<const B: usize>(a: &[Expansion<16>; 3], b: &[Expansion<B>; 3]) -> Expansion<192> {
    const { assert!(B <= 2) };
    let mut sum = Expansion::ZERO;
    for (a, b) in a.iter().zip(b) {
        sum.add_product(a, b);
    }
    sum
}
