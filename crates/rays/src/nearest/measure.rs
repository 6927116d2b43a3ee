use glam::{DVec3, Vec3};

/// The point of a triangle that is nearest to another point, in f64.
///
/// Every operation rounds once and none is fused: the same bits on every machine, for the same corners and point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured {
    /// Weights of the second and third corner, each in [0, 1], with a sum of at most one.
    pub(super) weights: [f64; 2],
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
/// by less than 8 u r, and |q| by 3 u of itself. Rounding corners, products and sums moves the dot products by less than 6 u r |q|, and the quotient by
/// 4 u of itself. The bounds take 16 u r for all of it. No square underflows: coordinates are f32.
pub(super) fn measure(point: Vec3, [a, b, c]: [Vec3; 3]) -> Measured {
    let [p, a, b, c] = [point.as_dvec3(), a.as_dvec3(), b.as_dvec3(), c.as_dvec3()];
    let (a, ab, ac) = (a - p, b - a, c - a);
    let normal = ab.cross(ac);
    let area = normal.dot(normal);
    let weights = |q: DVec3| [normal.dot(ac.cross(q)) / area, normal.dot(q.cross(ab)) / area];
    let at = |[v, w]: [f64; 2]| a + (ab * v + ac * w);
    let [mut v, mut w] = weights(a);
    // False for a triangle without area.
    if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
        // Weights of slivers have lost digits; once more for the rest.
        let [more_v, more_w] = weights(at([v, w]));
        v = (v + more_v).clamp(0.0, 1.0);
        w = (w + more_w).clamp(0.0, 1.0 - v);
    } else {
        let bc = ac - ab;
        let along = |start: DVec3, edge: DVec3| {
            let share = -edge.dot(start) / edge.dot(edge);
            // An edge without length has NaN.
            if share > 0.0 { share.min(1.0) } else { 0.0 }
        };
        let (on_ab, on_ac, on_bc) = (along(a, ab), along(a, ac), along(a + ab, bc));
        let on_edges = [[on_ab, 0.0], [0.0, on_ac], [1.0 - on_bc, on_bc]];
        let mut nearest = f64::INFINITY;
        for on_edge in on_edges {
            let square = at(on_edge).length_squared();
            if square < nearest {
                nearest = square;
                [v, w] = on_edge;
            }
        }
    }
    let q = at([v, w]);
    let distance = q.dot(q).sqrt();
    let reach = sum_of(a) + (sum_of(ab) + sum_of(ac));
    let error = 16.0 * ROUNDING * reach;
    let behind = q.dot(a) + q.dot(ab).min(q.dot(ac)).min(0.0);
    let least = if distance > 0.0 { behind / distance - error } else { 0.0 };
    Measured { weights: [v, w], distance, least: least.max(0.0), most: distance + error }
}

fn sum_of(vector: DVec3) -> f64 {
    let DVec3 { x, y, z } = vector.abs();
    x + y + z
}

/// The point of a triangle with these weights of its second and third corner.
pub(super) fn position([a, b, c]: [Vec3; 3], [v, w]: [f64; 2]) -> DVec3 {
    a.as_dvec3() * (1.0 - v - w) + (b.as_dvec3() * v + c.as_dvec3() * w)
}
