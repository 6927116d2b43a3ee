use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f64x8};

use super::double::{Double, Number};
use super::{EDGE_OPPOSITE, ROUNDING, SMALLEST_TRUSTED_BOUND, barycentric, canonical_order, hit, slope_and_height};
use crate::{Hit, Ray, Triangles};

/// Pairs at once.
const LANES: usize = 8;

/// Fewest pairs that are answered together: eight take as long as about four alone.
const FEWEST: usize = 5;

/// Answers [`hit`] for each pair of a ray's index and a triangle, bit for bit, eight at a time where there are enough. What
/// f64 leaves undecided is settled one by one.
///
/// # Panics
/// If an index, an id or one of a triangle's vertices is out of range, or if there are fewer `hits` than `pairs`.
pub(crate) fn hits(
    level: Level,
    triangles: Triangles<'_>,
    rays: &[Ray],
    pairs: &[(u32, u32)],
    hits: &mut [Option<Hit>],
) {
    for (pairs, hits) in pairs.chunks(LANES).zip(hits.chunks_mut(LANES)) {
        if pairs.len() < FEWEST {
            for (&(ray, id), answer) in pairs.iter().zip(hits) {
                *answer = hit(&rays[ray as usize], triangles, id);
            }
        } else {
            dispatch!(level, simd => hits_of_eight(simd, triangles, rays, pairs, hits));
        }
    }
}

/// Eight pairs, with corners in canonical order.
struct Eight {
    corners: [[[f64; LANES]; 3]; 3],
    origin: [[f64; LANES]; 3],
    direction: [[f64; LANES]; 3],
    /// The index of each corner in the triangle.
    orders: [[usize; 3]; LANES],
}

impl Eight {
    #[inline(always)]
    fn new(triangles: Triangles<'_>, rays: &[Ray], pairs: &[(u32, u32)]) -> Self {
        let mut eight = Self {
            corners: [[[0.0; LANES]; 3]; 3],
            origin: [[0.0; LANES]; 3],
            direction: [[0.0; LANES]; 3],
            orders: [[0; 3]; LANES],
        };
        for (lane, &(ray, id)) in pairs.iter().enumerate() {
            let ray = &rays[ray as usize];
            let corners = triangles.corners(id);
            let order = canonical_order(&corners);
            for axis in [0, 1, 2] {
                eight.origin[axis][lane] = ray.origin[axis];
                eight.direction[axis][lane] = ray.direction[axis];
                for (corner, &index) in order.iter().enumerate() {
                    eight.corners[corner][axis][lane] = f64::from(corners[index][axis]);
                }
            }
            eight.orders[lane] = order;
        }
        eight
    }
}

#[inline(always)]
fn hits_of_eight<S: Simd>(
    simd: S,
    triangles: Triangles<'_>,
    rays: &[Ray],
    pairs: &[(u32, u32)],
    hits: &mut [Option<Hit>],
) {
    let eight = Eight::new(triangles, rays, pairs);
    let Values { weights, t, met, undecided } = values(simd, &eight);
    for (lane, (&(ray, id), answer)) in pairs.iter().zip(hits).enumerate() {
        let ray = &rays[ray as usize];
        *answer = if undecided >> lane & 1 == 1 {
            hit(ray, triangles, id)
        } else if met >> lane & 1 == 1 && ray.t_min < t[lane] && t[lane] < ray.t_max {
            let weights = [weights[0][lane], weights[1][lane], weights[2][lane]];
            Some(Hit { t: t[lane], triangle: id, barycentric: barycentric(weights, eight.orders[lane]) })
        } else {
            None
        };
    }
}

/// What the predicate computes for eight pairs.
struct Values {
    weights: [[f64; LANES]; 3],
    t: [f64; LANES],
    /// Lines that meet their triangle, a bit for each.
    met: u64,
    /// Pairs that take more than this.
    undecided: u64,
}

#[inline(always)]
fn values<S: Simd>(simd: S, eight: &Eight) -> Values {
    let corners = [three(simd, &eight.corners[0]), three(simd, &eight.corners[1]), three(simd, &eight.corners[2])];
    let (origin, direction) = (three(simd, &eight.origin), three(simd, &eight.direction));
    let relative = [minus(corners[0], origin), minus(corners[1], origin), minus(corners[2], origin)];
    // As of single pairs.
    let reach = largest(relative[0]).max(largest(relative[1])).max(largest(relative[2]));
    let bound = largest(direction) * (64.0 * ROUNDING) * reach * reach;
    let weight = |opposite: usize| {
        let (first, second) = EDGE_OPPOSITE[opposite];
        let [[px, py, pz], [qx, qy, qz]] = [relative[first], relative[second]];
        let [x, y, z] = direction;
        x * (py * qz - qy * pz) + y * (pz * qx - qz * px) + z * (px * qy - qx * py)
    };
    let weights = [weight(0), weight(1), weight(2)];
    let zero = f64x8::splat(simd, 0.0);
    let (lowest, highest) = (weights[0].min(weights[1]).min(weights[2]), weights[0].max(weights[1]).max(weights[2]));
    let smallest = weights[0].abs().min(weights[1].abs()).min(weights[2].abs());
    let decided = smallest.simd_gt(bound)
        & bound.simd_ge(f64x8::splat(simd, SMALLEST_TRUSTED_BOUND))
        & weights[0].is_finite()
        & weights[1].is_finite()
        & weights[2].is_finite();
    let met = lowest.simd_gt(zero) | highest.simd_lt(zero);
    let (slope, height) = slope_and_height(corners, origin, direction);
    let [t, other] = height.quotient(slope, Double::PRECISION);
    let smallest_trusted = f64x8::splat(simd, SMALLEST_TRUSTED_BOUND);
    let is_precise = |value: Double<f64x8<S>>| {
        value.value().abs().simd_gt(value.magnitude() * Double::CANCELLATION)
            & value.magnitude().simd_ge(smallest_trusted)
    };
    let undecided = !decided | (met & !(is_precise(slope) & is_precise(height) & t.simd_eq(other)));
    Values {
        weights: [weights[0].into(), weights[1].into(), weights[2].into()],
        t: t.into(),
        met: met.to_bitmask(),
        undecided: undecided.to_bitmask(),
    }
}

#[inline(always)]
fn three<S: Simd>(simd: S, numbers: &[[f64; LANES]; 3]) -> [f64x8<S>; 3] {
    let [x, y, z] = numbers;
    [f64x8::from_slice(simd, x), f64x8::from_slice(simd, y), f64x8::from_slice(simd, z)]
}

#[inline(always)]
fn minus<N: Number>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn largest<S: Simd>([x, y, z]: [f64x8<S>; 3]) -> f64x8<S> {
    x.abs().max(y.abs()).max(z.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, Vec3};

    #[test]
    fn pairs_get_what_each_gets_alone() {
        let mut seed = 1_u64;
        let mut number = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 40) as f32 / (1 << 23) as f32 - 1.0
        };
        let mut positions: Vec<Vec3> = (0..90).map(|_| Vec3::new(number(), number(), number())).collect();
        // Corners at one point, on a line, far away and nowhere.
        positions[10] = positions[9];
        positions[14] = positions[12] * 0.5 + positions[13] * 0.5;
        positions[17] *= 1e30;
        positions[20].y = f32::NAN;
        let indices: Vec<[u32; 3]> = (0..30).map(|id| [id * 3, id * 3 + 1, id * 3 + 2]).collect();
        let triangles = Triangles { positions: &positions, indices: &indices };
        let (mut rays, mut pairs) = (Vec::new(), Vec::new());
        for step in 0..3000 {
            let id = step % 30;
            let [a, b, c] = triangles.corners(id).map(Vec3::as_dvec3);
            let weights = [number(), number()].map(|weight| f64::from(weight) * 0.7);
            // Inside, outside, through edges and corners; to some in their planes.
            let target = match step / 30 % 4 {
                0 => a,
                1 => a + (b - a) * weights[0].abs(),
                _ => a + (b - a) * weights[0] + (c - a) * weights[1],
            };
            let origin = if step % 7 == 0 { b + (b - c) } else { DVec3::splat(weights[1] * 3.0) };
            let mut ray = Ray::new(origin, target - origin);
            if step % 5 == 0 {
                (ray.t_min, ray.t_max) = (1.0, 1.5);
            }
            pairs.push((rays.len() as u32, id));
            rays.push(ray);
        }
        let alone: Vec<_> = pairs.iter().map(|&(ray, id)| hit(&rays[ray as usize], triangles, id)).collect();
        assert!((500..2500).contains(&alone.iter().flatten().count()));
        for level in crate::SimdLevel::available() {
            for together in [1, 5, 8, 21] {
                let mut found = vec![None; pairs.len()];
                for (pairs, found) in pairs.chunks(together).zip(found.chunks_mut(together)) {
                    hits(level.into(), triangles, &rays, pairs, found);
                }
                let bits = |hit: &Option<Hit>| hit.map(|hit| (hit.t.to_bits(), hit.triangle, hit.barycentric));
                assert!(found.iter().map(bits).eq(alone.iter().map(bits)), "{level}");
            }
        }
    }
}
