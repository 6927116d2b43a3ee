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
/// **Bounds.** Let u be the relative error of a rounding, and r = |a|₁ + |b − a|₁ + |c − a|₁ with corners a, b, c
/// relative to the point. Any weights give a point q = a + v (b − a) + w (c − a) of the triangle, so |q| is an upper bound of
/// the distance. The triangle is beyond the plane across q through its corner least along q: so min(q · a, q · b, q · c) ÷ |q|
/// is a lower bound, for any q. Rounding a, b − a, c − a, two products, two sums, and a sum v + w that is above one move q
/// by less than 8 u r, and |q| by 3 u of itself. Rounding corners, products and sums moves the dot products by less than
/// 6 u r |q|, and the quotient by 4 u of itself. The bounds take 16 u r for all of it. No square underflows: coordinates are
/// f32.
pub(super) fn measure(point: Vec3, corners: [Vec3; 3]) -> Measured {
    let [p, x, y, z] = [point.as_dvec3(), corners[0].as_dvec3(), corners[1].as_dvec3(), corners[2].as_dvec3()];
    let [xy, yz, zx] = [y - x, z - y, x - z];
    let squares = [yz.length_squared(), zx.length_squared(), xy.length_squared()];
    // A is opposite to the longest edge. With a corner far away, the others would lose most digits of the normal.
    let longest = if squares[0] >= squares[1] && squares[0] >= squares[2] { 0 } else { 1 + usize::from(squares[2] > squares[1]) };
    let (a, ab, ac) = match longest {
        0 => (x - p, xy, -zx),
        1 => (y - p, yz, -xy),
        _ => (z - p, zx, -yz),
    };
    let normal = ab.cross(ac);
    let area = normal.dot(normal);
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
        let bc = ac - ab;
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
    let reach = sum_of(a) + (sum_of(ab) + sum_of(ac));
    let error = 16.0 * ROUNDING * reach;
    let behind = q.dot(a) + q.dot(ab).min(q.dot(ac)).min(0.0);
    let least = if distance > 0.0 { behind / distance - error } else { 0.0 };
    let weights = match longest {
        0 => [u, v, w],
        1 => [w, u, v],
        _ => [v, w, u],
    };
    Measured { weights, distance, least: least.max(0.0), most: distance + error }
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
