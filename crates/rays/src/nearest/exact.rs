//! Compares distances of a point from triangles in real numbers.
//!
//! The nearest point of a triangle is a corner, on the line of an edge, or on the triangle's plane: its [`Feature`]. The
//! squared distance from each is a quotient N ÷ D of polynomials of coordinates, so two of them compare as N₁ D₂ and N₂ D₁.
//! Arithmetic is [`Bounded`] first, and of [`Integer`]s where that can't tell.

use std::cmp::Ordering;

use glam::Vec3;

use super::bounded::Bounded;
use super::integer::Integer;

/// A real number, or one with a bound of its error.
pub(super) trait Number: Clone {
    /// The power of two of which all coordinates are multiples, if the numbers are whole.
    fn unit(points: &[Vec3]) -> i32;
    /// a − b, in units.
    fn difference(a: f32, b: f32, unit: i32) -> Self;
    fn plus(&self, other: &Self) -> Self;
    fn minus(&self, other: &Self) -> Self;
    fn times(&self, other: &Self) -> Self;
    /// The sign; `None` where the error is too large to tell.
    fn sign(&self) -> Option<Ordering>;
}

type Vector<N> = [N; 3];

fn difference<N: Number>(a: &Vector<N>, b: &Vector<N>) -> Vector<N> {
    [a[0].minus(&b[0]), a[1].minus(&b[1]), a[2].minus(&b[2])]
}

fn dot<N: Number>(a: &Vector<N>, b: &Vector<N>) -> N {
    a[0].times(&b[0]).plus(&a[1].times(&b[1])).plus(&a[2].times(&b[2]))
}

fn cross<N: Number>(a: &Vector<N>, b: &Vector<N>) -> Vector<N> {
    let component = |next: usize, last: usize| a[next].times(&b[last]).minus(&a[last].times(&b[next]));
    [component(1, 2), component(2, 0), component(0, 1)]
}

/// The part of a triangle that its point nearest to another is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Feature {
    Corner(usize),
    /// The edge from a corner to the next one.
    Edge(usize),
    Face,
}

impl Feature {
    /// Whether it is at the same place as a feature of another triangle.
    fn is_same(self, corners: &[Vec3; 3], other: Self, others: &[Vec3; 3]) -> bool {
        let ends = |corners: &[Vec3; 3], first: usize| [corners[first], corners[(first + 1) % 3]];
        match (self, other) {
            (Self::Corner(of_this), Self::Corner(of_other)) => corners[of_this] == others[of_other],
            (Self::Edge(of_this), Self::Edge(of_other)) => {
                let ([a, b], [c, d]) = (ends(corners, of_this), ends(others, of_other));
                (a, b) == (c, d) || (a, b) == (d, c)
            }
            _ => false,
        }
    }
}

/// A triangle as seen from a point.
struct Seen<N> {
    /// Corners relative to the point.
    corners: [Vector<N>; 3],
    /// (xⱼ − xᵢ) · xᵢ for corners i and j.
    dots: [[N; 3]; 3],
}

impl<N: Number> Seen<N> {
    fn new(point: Vec3, corners: [Vec3; 3], unit: i32) -> Self {
        let corners = corners.map(|corner| [0, 1, 2].map(|axis| N::difference(corner[axis], point[axis], unit)));
        let dots = [0, 1, 2].map(|i| [0, 1, 2].map(|j| dot(&difference(&corners[j], &corners[i]), &corners[i])));
        Self { corners, dots }
    }

    /// The square of the length of an edge.
    fn length(&self, i: usize, j: usize) -> N {
        let [there, back] = [&self.dots[i][j], &self.dots[j][i]];
        N::difference(0.0, 0.0, 0).minus(&there.plus(back))
    }

    /// The feature with the nearest point: a point q of a triangle is the nearest to the origin if no corner x is on the
    /// origin's side of it, −q · (x − q) ≤ 0. Right for triangles without area too.
    fn feature(&self) -> Option<Feature> {
        let mut is_certain = true;
        // Whether a number is at least zero: only if that is certain.
        let mut check = |number: &N, wanted: Ordering| {
            let sign = number.sign();
            is_certain &= sign.is_some();
            sign.is_some_and(|sign| sign != wanted.reverse())
        };
        for i in [0, 1, 2] {
            let [j, k] = [(i + 1) % 3, (i + 2) % 3];
            if check(&self.dots[i][j], Ordering::Greater) && check(&self.dots[i][k], Ordering::Greater) {
                return Some(Feature::Corner(i));
            }
        }
        for i in [0, 1, 2] {
            let [j, k] = [(i + 1) % 3, (i + 2) % 3];
            if !check(&self.dots[i][j], Ordering::Less) || !check(&self.dots[j][i], Ordering::Less) {
                continue;
            }
            let length = self.length(i, j);
            let [edge, other] = [j, k].map(|end| difference(&self.corners[end], &self.corners[i]));
            // e² times −q · (xₖ − xᵢ), for the point q of the edge's line.
            let beside = dot(&edge, &other).times(&self.dots[i][j]).minus(&length.times(&self.dots[i][k]));
            if check(&beside, Ordering::Less)
                && check(&length, Ordering::Greater)
                && length.sign() != Some(Ordering::Equal)
            {
                return Some(Feature::Edge(i));
            }
        }
        is_certain.then_some(Feature::Face)
    }

    /// The numerator and the denominator of the squared distance; a denominator of one is left out.
    fn squared_distance(&self, feature: Feature) -> (N, Option<N>) {
        let square = |i: usize| dot(&self.corners[i], &self.corners[i]);
        match feature {
            Feature::Corner(i) => (square(i), None),
            Feature::Edge(i) => {
                let j = (i + 1) % 3;
                let (along, length) = (&self.dots[i][j], self.length(i, j));
                (square(i).times(&length).minus(&along.times(along)), Some(length))
            }
            Feature::Face => {
                let [a, b, c] = &self.corners;
                let normal = cross(&difference(b, a), &difference(c, a));
                let height = dot(&normal, a);
                (height.times(&height), Some(dot(&normal, &normal)))
            }
        }
    }
}

/// Compares a point's distances from two triangles.
#[cold]
#[inline(never)]
pub(super) fn compare(point: Vec3, triangles: [[Vec3; 3]; 2]) -> Ordering {
    let ordering = compare_by::<Bounded>(point, triangles).or_else(|| compare_by::<Integer>(point, triangles));
    ordering.expect("whole numbers have signs")
}

fn compare_by<N: Number>(point: Vec3, [first, second]: [[Vec3; 3]; 2]) -> Option<Ordering> {
    let unit = N::unit(&[point, first[0], first[1], first[2], second[0], second[1], second[2]]);
    let [of_first, of_second] = [first, second].map(|corners| Seen::<N>::new(point, corners, unit));
    let (feature, other) = (of_first.feature()?, of_second.feature()?);
    if feature.is_same(&first, other, &second) {
        return Some(Ordering::Equal);
    }
    let ((mut a, under_a), (mut b, under_b)) = (of_first.squared_distance(feature), of_second.squared_distance(other));
    if let Some(under) = under_b {
        a = a.times(&under);
    }
    if let Some(under) = under_a {
        b = b.times(&under);
    }
    a.minus(&b).sign()
}

/// Whether the ray from a point along x crosses a triangle, the point being moved by less than any number: along y, less
/// along z, and still less along x. Such a point is on no edge and in no plane of a triangle that the ray may cross.
#[cold]
#[inline(never)]
pub(super) fn crosses(point: Vec3, corners: [Vec3; 3]) -> bool {
    let crosses = crosses_by::<Bounded>(point, corners).or_else(|| crosses_by::<Integer>(point, corners));
    crosses.expect("whole numbers have signs")
}

fn crosses_by<N: Number>(point: Vec3, corners: [Vec3; 3]) -> Option<bool> {
    let unit = N::unit(&[point, corners[0], corners[1], corners[2]]);
    let relative = corners.map(|corner| [0, 1, 2].map(|axis| N::difference(corner[axis], point[axis], unit)));
    let mut side = Ordering::Equal;
    for (first, second) in [(0, 1), (1, 2), (2, 0)] {
        let [_, y0, z0] = &relative[first];
        let [_, y1, z1] = &relative[second];
        // Of the projections along x; changed by −δy (z₁ − z₀) + δz (y₁ − y₀) where the point is moved.
        let mut of_edge = y0.times(z1).minus(&z0.times(y1)).sign()?;
        if of_edge == Ordering::Equal {
            of_edge = z0.minus(z1).sign()?;
        }
        if of_edge == Ordering::Equal {
            of_edge = y1.minus(y0).sign()?;
        }
        // An edge along x, of a triangle that is seen edge-on.
        if of_edge == Ordering::Equal || side == of_edge.reverse() {
            return Some(false);
        }
        side = of_edge;
    }
    let [a, b, c] = &relative;
    let normal = cross(&difference(b, a), &difference(c, a));
    // The plane is at x = n · a ÷ nₓ. Where that is zero it changes by −(n · δ) ÷ nₓ.
    let height = dot(&normal, a).sign()?;
    let height = if height == Ordering::Equal {
        let [x, y, z] = [normal[0].sign()?, normal[1].sign()?, normal[2].sign()?];
        y.then(z).then(x).reverse()
    } else {
        height
    };
    // The edges' common side is the sign of nₓ.
    Some(height == side)
}

/// The side of a triangle's plane that a point is on: `Greater` behind it, where its corners are clockwise.
#[cold]
#[inline(never)]
pub(super) fn side(point: Vec3, corners: [Vec3; 3]) -> Ordering {
    let side = side_by::<Bounded>(point, corners).or_else(|| side_by::<Integer>(point, corners));
    side.expect("whole numbers have signs")
}

fn side_by<N: Number>(point: Vec3, corners: [Vec3; 3]) -> Option<Ordering> {
    let unit = N::unit(&[point, corners[0], corners[1], corners[2]]);
    let [a, b, c] = corners.map(|corner| [0, 1, 2].map(|axis| N::difference(corner[axis], point[axis], unit)));
    dot(&cross(&difference(&b, &a), &difference(&c, &a)), &a).sign()
}

/// Whether a triangle has a point in common with the box between two corners, which has the first one lowest. All are finite.
///
/// Two convex polytopes have none if the projections on a normal of a face of one, or on the cross product of an edge of each,
/// are apart (Gottschalk, Lin and Manocha, *`OBBTree`*, 1996). The caller has compared projections on the axes. Flat triangles
/// and boxes need no other axes: a box that is larger by less than any number isn't flat.
#[inline(never)]
pub(super) fn touches(ends: [Vec3; 2], corners: [Vec3; 3]) -> bool {
    let touches = touches_by::<Bounded>(ends, corners).or_else(|| touches_by::<Integer>(ends, corners));
    touches.expect("whole numbers have signs")
}

fn touches_by<N: Number>(ends: [Vec3; 2], corners: [Vec3; 3]) -> Option<bool> {
    let unit = N::unit(&[ends[0], ends[1], corners[0], corners[1], corners[2]]);
    let between = |to: Vec3, from: Vec3| [0, 1, 2].map(|axis| N::difference(to[axis], from[axis], unit));
    // The box's ends as seen from each corner.
    let seen = corners.map(|corner| ends.map(|end| between(end, corner)));
    let [a, b, c] = corners;
    let edges = [between(b, a), between(c, b), between(a, c)];
    let normal = cross(&edges[0], &edges[1]);
    let [from_a, ..] = &seen;
    let end = |corner: usize, axis: usize| &from_a[corner >> axis & 1][axis];
    let height = |corner: usize| {
        let [x, y, z] = [0, 1, 2].map(|axis| normal[axis].times(end(corner, axis)));
        x.plus(&y).plus(&z).sign()
    };
    if are_apart((0..8).map(height))? {
        return Some(false);
    }
    for (edge, start) in edges.iter().zip([0, 1, 2]) {
        // An end of the edge, and the corner opposite to it.
        let vertices = [&seen[start], &seen[(start + 2) % 3]];
        for axis in [0, 1, 2] {
            let [next, last] = [(axis + 1) % 3, (axis + 2) % 3];
            let across = |number: usize| {
                let [y, z] = [&vertices[number >> 2][number & 1][next], &vertices[number >> 2][number >> 1 & 1][last]];
                edge[next].times(z).minus(&edge[last].times(y)).sign()
            };
            if are_apart((0..8).map(across))? {
                return Some(false);
            }
        }
    }
    Some(true)
}

/// Whether all numbers are above zero, or all below; `None` if a sign that matters isn't known.
fn are_apart(mut signs: impl Iterator<Item = Option<Ordering>>) -> Option<bool> {
    let first = signs.next().flatten()?;
    if first == Ordering::Equal {
        return Some(false);
    }
    for sign in signs {
        if sign? != first {
            return Some(false);
        }
    }
    Some(true)
}

/// Whether a triangle is nearer to a point than `distance`, which is finite and above zero.
#[cold]
#[inline(never)]
pub(super) fn is_within(point: Vec3, corners: [Vec3; 3], distance: f64) -> bool {
    let unit = Integer::unit(&[point, corners[0], corners[1], corners[2]]);
    let seen = Seen::<Integer>::new(point, corners, unit);
    let feature = seen.feature().expect("whole numbers have signs");
    let (numerator, denominator) = seen.squared_distance(feature);
    let (distance, distance_unit) = Integer::of_f64(distance);
    let mut limit = distance.times(&distance);
    if let Some(denominator) = denominator {
        limit = limit.times(&denominator);
    }
    let least = unit.min(distance_unit);
    let shift = |unit: i32| 2 * (unit - least) as usize;
    numerator.cmp_shifted(shift(unit), &limit, shift(distance_unit)) == Ordering::Less
}
