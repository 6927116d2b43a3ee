use glam::{DVec3, Vec3};

/// The point of a triangle that is nearest to another point, in f64.
///
/// Every operation rounds once and none is fused: the same bits on every machine, for the same corners and point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured {
    /// Weights of the corners, each in [0, 1]. Those of corners beside an edge or a corner with the nearest point are zero.
    pub(super) weights: [f64; 3],
    pub(super) distance: f64,
    /// Bounds of the distance in real numbers.
    pub(super) least: f64,
    pub(super) most: f64,
}

const ROUNDING: f64 = f64::EPSILON / 2.0;

/// Measures the distance of a point from a triangle; corners and point are finite.
///
/// **Bounds.** Let u be the relative error of a rounding, a, b, c the corners relative to the point, e = b − a and f = c − a.
/// Any weights give a point q of the triangle, so |q| is an upper bound of the distance. Points a + x e + y f of the triangle
/// with y |f| > R, for R = |q| + |a| + |e|, are farther than q. The others are in the hull of a, a + e, a + t f and
/// a + e + t (f − e) with t = min(1, R ÷ |f|), which is beyond the plane across q through its corner least along q: so the
/// least product of q and these ÷ |q| is a lower bound. Let r be |a|₁ + |e|₁ + s |f|₁, where s is the
/// larger of t and the weight of f: a corner that is far away doesn't count in it. Rounding a, e, f, two products, two sums, and
/// a sum of weights that is above one move q by less than 8 u r, and |q| by 3 u of itself. Rounding corners, products and sums
/// moves the dot products by less than 8 u r |q|, and the quotient by 4 u of itself. The bounds take 16 u r for all of it, and
/// twice R. No square underflows: coordinates are f32.
pub(super) fn measure(point: Vec3, corners: [Vec3; 3]) -> Measured {
    let corners = [corners[0].as_dvec3(), corners[1].as_dvec3(), corners[2].as_dvec3()];
    let edges = Edges::new(corners);
    let [ab, ac, bc] = edges.sizes;
    let (least, most) = (ab.min(ac).min(bc), ab.max(ac).max(bc));
    // Any order will do for others, and to choose one takes half as long as all the rest.
    const SLENDER: f64 = 256.0;
    if most > SLENDER * least {
        measure_slender(point.as_dvec3(), corners, [bc, ac, ab])
    } else {
        measure_in_order(corners[0] - point.as_dvec3(), edges)
    }
}

/// The edges from A to B, from A to C, and from B to C, and the sums of their components' magnitudes.
#[derive(Clone, Copy)]
struct Edges {
    edges: [DVec3; 3],
    sizes: [f64; 3],
}

impl Edges {
    #[inline(always)]
    fn new([a, b, c]: [DVec3; 3]) -> Self {
        let [ab, ac] = [b - a, c - a];
        // From B to C as it is between these: points on it are found by both.
        let bc = ac - ab;
        Self { edges: [ab, ac, bc], sizes: [sum_of(ab), sum_of(ac), sum_of(bc)] }
    }
}

/// Measures with the corners in the order in which only the third is far away, if one is: otherwise most digits of the normal
/// and of shares of edges would be lost. Sizes are those of the edges opposite to the corners.
#[cold]
#[inline(never)]
fn measure_slender(point: DVec3, corners: [DVec3; 3], sizes: [f64; 3]) -> Measured {
    // The first is opposite to the longest edge, the third to the shortest.
    let mut order = [0, 1, 2];
    order.sort_by(|&one, &other| sizes[other].total_cmp(&sizes[one]));
    let corners = order.map(|index: usize| corners[index]);
    let measured = measure_in_order(corners[0] - point, Edges::new(corners));
    let mut weights = [0.0; 3];
    for (weight, index) in measured.weights.into_iter().zip(order) {
        weights[index] = weight;
    }
    Measured { weights, ..measured }
}

#[inline(always)]
fn measure_in_order(a: DVec3, edges: Edges) -> Measured {
    let Edges { edges: [ab, ac, bc], sizes: [size_ab, size_ac, _] } = edges;
    let normal = ab.cross(ac);
    let area = normal.dot(normal);
    // Quotients are exactly one at corners.
    let weights = |q: DVec3| [normal.dot(ac.cross(q)) / area, normal.dot(q.cross(ab)) / area];
    let at = |[v, w]: [f64; 2]| a + (ab * v + ac * w);
    let [mut v, mut w] = weights(a);
    let mut u = 0.0;
    // False for a triangle without area.
    if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
        // Weights of slivers have lost digits; once more for the rest.
        let [more_v, more_w] = weights(at([v, w]));
        v = (v + more_v).clamp(0.0, 1.0);
        w = (w + more_w).clamp(0.0, 1.0 - v);
        u = 1.0 - v - w;
    } else {
        let along = |start: DVec3, edge: DVec3| {
            let share = -edge.dot(start) / edge.dot(edge);
            // An edge without length has NaN.
            if share > 0.0 { share.min(1.0) } else { 0.0 }
        };
        let (on_ab, on_ac, on_bc) = (along(a, ab), along(a, ac), along(a + ab, bc));
        let on_edges = [[1.0 - on_ab, on_ab, 0.0], [1.0 - on_ac, 0.0, on_ac], [0.0, 1.0 - on_bc, on_bc]];
        let mut nearest = f64::INFINITY;
        for on_edge in on_edges {
            let square = at([on_edge[1], on_edge[2]]).length_squared();
            if square < nearest {
                nearest = square;
                [u, v, w] = on_edge;
            }
        }
    }
    let q = at([v, w]);
    let distance = q.dot(q).sqrt();
    let near = sum_of(a) + size_ab;
    let (limit, longest) = (2.0 * (distance + near), ac.abs().max_element());
    let kept = if longest > limit { limit / longest } else { 1.0 };
    let error = 16.0 * ROUNDING * (near + kept.max(w) * size_ac);
    let (of_ab, of_ac) = (q.dot(ab), kept * q.dot(ac));
    let behind = q.dot(a) + of_ab.min(of_ac).min(of_ac + (1.0 - kept) * of_ab).min(0.0);
    let least = if distance > 0.0 { behind / distance - error } else { 0.0 };
    Measured { weights: [u, v, w], distance, least: least.max(0.0), most: distance + error }
}

fn sum_of(vector: DVec3) -> f64 {
    let DVec3 { x, y, z } = vector.abs();
    x + y + z
}

/// The point of a triangle with these weights of its corners.
pub(super) fn position([a, b, c]: [Vec3; 3], [u, v, w]: [f64; 3]) -> DVec3 {
    a.as_dvec3() * u + (b.as_dvec3() * v + c.as_dvec3() * w)
}

/// Whether the point of two triangles that is nearest to another one is certainly the same corner, or on the same edge, of
/// both. Most triangles that are equally near are neighbours of that kind.
pub(super) fn is_shared(point: Vec3, triangles: [(&[Vec3; 3], &Measured); 2]) -> bool {
    let [first, second] = triangles.map(|(corners, measured)| Ends::new(corners, measured));
    let (Some(first), Some(second)) = (first, second) else { return false };
    first.is_same(&second) && first.is_certain(point) && second.is_certain(point)
}

/// The corner or the ends of the edge with a triangle's nearest point, and its other corners.
struct Ends {
    ends: [Vec3; 2],
    /// Twice the same for an edge.
    others: [Vec3; 2],
    is_corner: bool,
}

impl Ends {
    /// `None` for a point inside of the face.
    fn new(&[a, b, c]: &[Vec3; 3], measured: &Measured) -> Option<Self> {
        let (ends, others) = match measured.weights.map(|weight| weight > 0.0) {
            [true, false, false] => ([a, a], [b, c]),
            [false, true, false] => ([b, b], [c, a]),
            [false, false, true] => ([c, c], [a, b]),
            [true, true, false] => ([a, b], [c, c]),
            [false, true, true] => ([b, c], [a, a]),
            [true, false, true] => ([c, a], [b, b]),
            _ => return None,
        };
        Some(Self { ends, others, is_corner: ends[0] == ends[1] })
    }

    fn is_same(&self, other: &Self) -> bool {
        let ([a, b], [c, d]) = (self.ends, other.ends);
        (a, b) == (c, d) || (a, b) == (d, c)
    }

    /// Whether the triangle's nearest point is certainly at these ends or between them: no corner is on the point's side of
    /// it, as in [`exact`](super::exact).
    fn is_certain(&self, point: Vec3) -> bool {
        let [start, end] = [self.ends[0].as_dvec3(), self.ends[1].as_dvec3()];
        let from = start - point.as_dvec3();
        if self.is_corner {
            let is_behind = |other: Vec3| {
                let (along, error) = product(other.as_dvec3() - start, from);
                along > error || error == 0.0
            };
            return is_behind(self.others[0]) && is_behind(self.others[1]);
        }
        let (edge, other) = (end - start, self.others[0].as_dvec3() - start);
        let ((share, share_error), (along, along_error)) = (product(edge, from), product(other, from));
        let ((across, across_error), length) = (product(edge, other), edge.length_squared());
        let beside = across * share - length * along;
        let of_shares = across_error * share.abs() + across.abs() * share_error + across_error * share_error;
        let of_lengths = length * along_error + ERROR * length * (along.abs() + along_error);
        let error = 2.0 * (of_shares + of_lengths) + ERROR * (across * share).abs();
        // Between the ends.
        share < -share_error && share + length > share_error + ERROR * length && beside < -error
    }
}

/// More than the rounding errors of a sum of three products, of the sum of their magnitudes.
const ERROR: f64 = 16.0 * ROUNDING;

/// a · b, with a bound of its error.
fn product(a: DVec3, b: DVec3) -> (f64, f64) {
    (a.dot(b), ERROR * a.abs().dot(b.abs()))
}
