//! Distances by their definitions in real numbers, and every SIMD level's answers beside them.
//!
//! - **Distance.** That of a point from a triangle is the least of those from its corners, from the feet on its edges that
//!   are between their ends, and from the foot on its plane if that is inside. A triangle without area has no plane.
//!   Triangles with a corner that isn't finite, or doesn't exist, have no distance.
//! - **Nearest.** The triangle at the least distance below the limit, of equal ones the lowest id.
//! - **Inside.** The point moved by (2⁻²⁰⁰⁰, 2⁻⁸⁰⁰, 2⁻¹⁴⁰⁰) is inside if the ray from it along x crosses an odd number of
//!   triangles. Edge functions and heights that aren't zero at the point itself are at least 2⁻⁴⁴⁷, and the move changes them
//!   by at most 2²⁶⁰ times its length: so it decides only between what is zero, along y first, then z, then x.

use std::cmp::Ordering;

use glam::Vec3;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use umbrage_rays::{Closest, ClosestPoints, Nearest, SimdLevel, Triangles, Within};

use super::real::{Big, Real, nearest_quotient};
use super::{Vector, corners, cross, dot, minus};
use crate::{Case, Random};

/// A quotient of real numbers, the second above zero.
#[derive(Clone)]
struct Quotient(Big, Big);

impl Quotient {
    fn compare(&self, other: &Self) -> Ordering {
        order(&self.0.times(&other.1), &other.0.times(&self.1))
    }
}

fn order(a: &Big, b: &Big) -> Ordering {
    a.minus(b).sign().expect("big numbers have signs")
}

fn sign(number: &Big) -> Ordering {
    number.sign().expect("big numbers have signs")
}

fn vector(v: Vec3) -> Vector<Big> {
    v.to_array().map(|coordinate| Big::of(f64::from(coordinate)))
}

/// The square of a point's distance from a triangle of finite corners.
fn squared_distance(point: Vec3, corners: [Vec3; 3]) -> Quotient {
    let point = vector(point);
    let [a, b, c] = corners.map(|corner| minus(&vector(corner), &point));
    let mut squares: Vec<Quotient> = [&a, &b, &c].map(|corner| Quotient(dot(corner, corner), Big::of(1.0))).into();
    for [start, end] in [[&a, &b], [&b, &c], [&c, &a]] {
        let edge = minus(end, start);
        let (length, along) = (dot(&edge, &edge), Big::of(0.0).minus(&dot(start, &edge)));
        if sign(&along) == Ordering::Greater && order(&along, &length) == Ordering::Less {
            squares.push(Quotient(dot(start, start).times(&length).minus(&along.times(&along)), length));
        }
    }
    let normal = cross(&minus(&b, &a), &minus(&c, &a));
    let area = dot(&normal, &normal);
    // The origin's foot is inside if it is on the inner side of each edge.
    let is_inner = |[p, q]: [&Vector<Big>; 2]| sign(&dot(&normal, &cross(p, q))) != Ordering::Less;
    if sign(&area) == Ordering::Greater && [[&a, &b], [&b, &c], [&c, &a]].into_iter().all(is_inner) {
        let height = dot(&normal, &a);
        squares.push(Quotient(height.times(&height), area));
    }
    squares.into_iter().min_by(Quotient::compare).expect("three corners")
}

/// Whether the ray along x from a point, moved as above, crosses a triangle of finite corners.
fn crosses(point: Vec3, corners: [Vec3; 3]) -> bool {
    for axis in [1, 2] {
        let of_axis = corners.map(|corner| corner[axis]);
        if of_axis.iter().all(|&end| end < point[axis]) || of_axis.iter().all(|&end| end > point[axis]) {
            return false;
        }
    }
    let mut at = vector(point);
    for (coordinate, exponent) in at.iter_mut().zip([-2000, -800, -1400]) {
        *coordinate = coordinate.plus(&Big::power_of_two(exponent));
    }
    let [a, b, c] = corners.map(|corner| minus(&vector(corner), &at));
    let side = |[p, q]: [&Vector<Big>; 2]| sign(&p[1].times(&q[2]).minus(&p[2].times(&q[1])));
    let sides = [[&a, &b], [&b, &c], [&c, &a]].map(side);
    if sides[0] == Ordering::Equal || sides.iter().any(|side| *side != sides[0]) {
        return false;
    }
    // The plane is met at x = n · a ÷ nₓ, and nₓ has the sides' sign.
    let normal = cross(&minus(&b, &a), &minus(&c, &a));
    sign(&dot(&normal, &a)) == sides[0]
}

/// The truth about a point.
pub struct DistanceTruth {
    /// Each triangle that has a distance, from the lowest id on, with its square.
    squares: Vec<(u32, Quotient)>,
    /// The nearest one's index in these.
    nearest: Option<usize>,
    is_inside: bool,
}

impl DistanceTruth {
    /// The truth about a finite point.
    fn new(triangles: Triangles<'_>, point: Vec3) -> Self {
        let usable = (0..triangles.len() as u32).filter_map(|id| {
            let corners = corners(triangles, id)?;
            corners.iter().all(|corner| corner.is_finite()).then_some((id, corners))
        });
        let (mut squares, mut is_inside) = (Vec::new(), false);
        for (id, corners) in usable {
            squares.push((id, squared_distance(point, corners)));
            is_inside ^= crosses(point, corners);
        }
        // The first of equal ones.
        let nearest = (0..squares.len()).min_by(|&one, &other| squares[one].1.compare(&squares[other].1));
        Self { squares, nearest, is_inside }
    }

    fn is_below(square: &Quotient, max: f64) -> bool {
        let max = Big::of(max);
        square.compare(&Quotient(max.times(&max), Big::of(1.0))) == Ordering::Less
    }
}

/// The truth about each point, which must be finite.
#[must_use]
pub fn distances(triangles: Triangles<'_>, points: &[Vec3]) -> Vec<DistanceTruth> {
    points.par_iter().map(|&point| DistanceTruth::new(triangles, point)).collect()
}

/// Finite points on, beside, between and far from a case's triangles.
#[must_use]
pub fn random_points(seed: u64, case: &Case) -> Vec<Vec3> {
    const COUNT: usize = 20;
    let random = &mut Random::new(seed ^ 0x6469_7374);
    let triangles = case.mesh.triangles();
    let vertices: Vec<Vec3> = case.mesh.positions.iter().copied().filter(|at| at.is_finite()).collect();
    let middle = vertices.get(random.below(vertices.len().max(1))).copied().unwrap_or_default();
    let other = vertices.get(random.below(vertices.len().max(1))).copied().unwrap_or_default();
    let size = (other - middle).abs().max_element().max(f32::MIN_POSITIVE);
    let point = |step: usize| {
        let ids = triangles.len().max(1);
        let corners = (!triangles.is_empty()).then(|| corners(triangles, random.below(ids) as u32)).flatten();
        let [a, b, c] = corners.unwrap_or([middle; 3]);
        let on_edge = a.lerp(b, random.unit());
        let inside = on_edge.lerp(c, random.unit());
        match step % 10 {
            0 => a,
            1 => a.midpoint(b),
            2 => on_edge,
            3 => inside,
            4 => inside + random.point() * size * 10.0_f32.powi(-(random.below(9) as i32)),
            5 => a + (b - a).cross(c - a).normalize_or_zero() * size * random.unit(),
            6 => Vec3::new(a.x, b.y, c.z),
            7 => middle + random.point() * size * 10.0_f32.powi(random.below(12) as i32),
            _ => middle + random.point() * size,
        }
    };
    let points: Vec<Vec3> = (0..COUNT).map(point).collect();
    points.into_iter().filter(|point| point.is_finite()).collect()
}

/// Kept [`Nearest`] of every SIMD level of the machine, on one, two and five threads.
pub struct DistanceTrial {
    kept: Vec<(SimdLevel, ThreadPool, Nearest)>,
    closest: ClosestPoints,
    inside: Vec<bool>,
    within: Within,
    /// Number of answers so far: the nearest triangle below each of two limits, whether it is inside, and a list.
    pub answers: u64,
}

impl DistanceTrial {
    /// Empty ones.
    ///
    /// # Panics
    /// If the machine can't start threads.
    #[must_use]
    pub fn new() -> Self {
        let kept = SimdLevel::available().into_iter().zip([1, 2, 5].into_iter().cycle()).map(|(level, threads)| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            (level, pool, Nearest::with_level(level))
        });
        Self {
            kept: kept.collect(),
            closest: ClosestPoints::default(),
            inside: Vec::new(),
            within: Within::default(),
            answers: 0,
        }
    }

    /// Compares all with the truth about points of a case's triangles; returns the disagreements.
    ///
    /// # Panics
    /// If there are fewer truths than points.
    pub fn disagreements(&mut self, case: &Case, points: &[Vec3], truths: &[DistanceTruth]) -> Vec<String> {
        let Self { kept, closest, inside, within, answers } = self;
        let triangles = case.mesh.triangles();
        // The distance of some triangle, to within a rounding: a limit that is hard to tell from it.
        let of_truth = |truth: &DistanceTruth| {
            let (_, Quotient(square, under)) = truth.squares.get(truth.squares.len() / 2)?;
            Some(nearest_quotient(square, under).sqrt())
        };
        let limit = truths.iter().find_map(of_truth).unwrap_or(1.0);
        let mut wrong = Vec::new();
        for (level, pool, nearest) in kept {
            pool.install(|| nearest.build(triangles));
            let mut report = |index: usize, how: &str| {
                let threads = pool.current_num_threads();
                wrong.push(format!("{level}, {threads} threads: {:?} {how}", points[index]));
            };
            for max in [f64::INFINITY, limit] {
                let query = Closest { max, ..Closest::new(triangles, points) };
                pool.install(|| nearest.closest_points(&query, closest));
                for (index, truth) in truths.iter().enumerate() {
                    if let Some(how) = fault(triangles, points[index], truth, max, closest, index) {
                        report(index, &how);
                    }
                }
            }
            let query = Closest { max: limit, ..Closest::new(triangles, points) };
            pool.install(|| {
                nearest.inside(triangles, points, inside);
                nearest.within(&query, within);
            });
            for (index, truth) in truths.iter().enumerate() {
                if inside[index] != truth.is_inside {
                    report(index, if inside[index] { "is inside" } else { "is outside" });
                }
                let below = truth.squares.iter().filter(|(_, square)| DistanceTruth::is_below(square, limit));
                if !below.map(|(id, _)| id).eq(within.of(index)) {
                    report(index, &format!("has {:?} within {limit:e}", within.of(index)));
                }
            }
            *answers += 4 * points.len() as u64;
        }
        wrong
    }
}

impl Default for DistanceTrial {
    fn default() -> Self {
        Self::new()
    }
}

/// How an answer below a limit differs from the truth, if it does.
fn fault(
    triangles: Triangles<'_>,
    point: Vec3,
    truth: &DistanceTruth,
    max: f64,
    found: &ClosestPoints,
    index: usize,
) -> Option<String> {
    let nearest = truth.nearest.map(|nearest| &truth.squares[nearest]);
    let nearest = nearest.filter(|(_, square)| max == f64::INFINITY || DistanceTruth::is_below(square, max));
    let (id, distance) = (found.triangle[index], found.distance[index]);
    let expected = nearest.map_or(ClosestPoints::NONE, |(id, _)| *id);
    if id != expected {
        return Some(format!("is nearest to {id} instead of {expected}, below {max:e}"));
    }
    let Some((_, Quotient(square, under))) = nearest else {
        let is_miss = distance == f64::INFINITY && found.position[index].is_nan();
        return (!is_miss).then(|| format!("has no triangle at {distance:e}"));
    };
    let exact = nearest_quotient(square, under).sqrt();
    let of_corners = triangles.corners(id).map(|corner| corner.as_dvec3().distance(point.as_dvec3()));
    let farthest = of_corners.into_iter().fold(0.0, f64::max);
    let error = (distance - exact).abs();
    // 45 roundings.
    (error > 1e-14 * farthest / 2.0).then(|| format!("is at {distance:e} instead of {exact:e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn root(point: Vec3, corners: [Vec3; 3]) -> f64 {
        let Quotient(square, under) = squared_distance(point, corners);
        nearest_quotient(&square, &under).sqrt()
    }

    #[test]
    fn distances_of_corners_edges_faces_and_triangles_without_area() {
        let corners = [Vec3::ZERO, Vec3::new(4.0, 0.0, 0.0), Vec3::new(0.0, 4.0, 0.0)];
        assert_eq!(root(Vec3::new(-3.0, -4.0, 0.0), corners), 5.0);
        assert_eq!(root(Vec3::new(2.0, -3.0, 4.0), corners), 5.0);
        assert_eq!(root(Vec3::new(1.0, 1.0, -7.0), corners), 7.0);
        assert_eq!(root(Vec3::new(4.0, 4.0, 1.0), corners), 3.0);
        let segment = [Vec3::ZERO, Vec3::X * 2.0, Vec3::X];
        assert_eq!(root(Vec3::new(1.5, 3.0, 4.0), segment), 5.0);
        assert_eq!(root(Vec3::new(5.0, 4.0, 0.0), segment), 5.0);
        assert_eq!(root(Vec3::new(3.0, 4.0, 0.0), [Vec3::ZERO; 3]), 5.0);
    }

    #[test]
    fn rays_through_edges_cross_one_of_two_triangles() {
        let square = [Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.0, 1.0, 1.0), Vec3::new(1.0, 0.0, 1.0)];
        let [a, b, c, d] = square;
        let crossings = |point: Vec3| [[a, b, c], [a, c, d]].iter().filter(|corners| crosses(point, **corners)).count();
        // On the diagonal, and on the square itself, which the point is moved beyond.
        assert_eq!(crossings(Vec3::new(0.0, 0.5, 0.5)), 1);
        assert_eq!(crossings(Vec3::new(1.0, 0.5, 0.25)), 0);
        // On the lowest edges, from which the point is moved inwards, and on the highest.
        assert_eq!((crossings(Vec3::ZERO), crossings(Vec3::new(0.0, 0.0, 0.5))), (1, 1));
        assert_eq!((crossings(Vec3::new(0.0, 1.0, 0.5)), crossings(Vec3::new(0.0, 0.5, 1.0))), (0, 0));
    }
}
