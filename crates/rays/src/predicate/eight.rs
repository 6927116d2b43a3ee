use crate::{SimdLevel, dispatch};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16, f64x8, mask64x8};
use glam::{DVec3, Vec3};

use super::double::Double;
use super::near::{LARGEST_TRUSTED_BOUND, RANGE, Sum, TrianglePlane};
use super::{EDGE_OPPOSITE, ROUNDING, SMALLEST_TRUSTED_BOUND, hit};
use crate::simd::vectors::{Vectors, largest, minus, splat_vector, vectors};
use crate::vectorized;
use crate::{Hit, Ray, Triangles};

/// Pairs per vector.
const LANES: usize = 8;

/// The fewest pairs that are answered together: eight take as long as about four alone.
const FEWEST: usize = 5;

/// A list of rays, each given by an index.
pub(crate) trait RayList {
    fn ray(&self, index: u32) -> Ray;

    fn origin(&self, index: u32) -> DVec3;

    fn direction(&self, index: u32) -> DVec3;

    /// Distances along the ray between which hits count.
    fn interval(&self, index: u32) -> [f64; 2];
}

impl RayList for [Ray] {
    #[inline(always)]
    fn ray(&self, index: u32) -> Ray {
        self[index as usize]
    }

    #[inline(always)]
    fn origin(&self, index: u32) -> DVec3 {
        self[index as usize].origin
    }

    #[inline(always)]
    fn direction(&self, index: u32) -> DVec3 {
        self[index as usize].direction
    }

    #[inline(always)]
    fn interval(&self, index: u32) -> [f64; 2] {
        let Ray { t_min, t_max, .. } = self[index as usize];
        [t_min, t_max]
    }
}

/// Answers [`hit`] for each pair of a ray's index and a triangle, bit for bit, eight at a time where there are enough. Pairs
/// that f64 leaves undecided are settled one by one.
///
/// It is faster where consecutive pairs have the same triangle, and rays with the same origin.
///
/// # Panics
/// If an index, an id or one of a triangle's vertices is out of range, or if there are fewer `hits` than `pairs`.
pub fn hits(level: SimdLevel, triangles: Triangles<'_>, rays: &[Ray], pairs: &[(u32, u32)], hits: &mut [Option<Hit>]) {
    hits_of(level, triangles, rays, pairs, hits);
}

/// As [`hits`], of rays that aren't in a slice.
pub(crate) fn hits_of<R: RayList + ?Sized>(
    level: SimdLevel,
    triangles: Triangles<'_>,
    rays: &R,
    pairs: &[(u32, u32)],
    hits: &mut [Option<Hit>],
) {
    let mut all = All { triangles, rays, pairs, hits };
    dispatch!(level, simd => all.answer(simd));
}

/// Pairs with room for their answers.
struct All<'a, R: ?Sized> {
    triangles: Triangles<'a>,
    rays: &'a R,
    pairs: &'a [(u32, u32)],
    hits: &'a mut [Option<Hit>],
}

impl<R: RayList + ?Sized> All<'_, R> {
    #[inline(always)]
    fn answer<S: Simd>(&mut self, simd: S) {
        let (mut start, mut waiting, mut count) = (0, [0; LANES], 0);
        while start < self.pairs.len() {
            let end = self.end_of_like(start);
            if end - start >= FEWEST {
                vectorized!(simd => self.answer_one(simd, start..end));
            } else {
                for index in start..end {
                    waiting[count] = index;
                    count += 1;
                    if count == LANES {
                        vectorized!(simd => self.answer_eight(simd, &waiting, count));
                        count = 0;
                    }
                }
            }
            start = end;
        }
        if count >= FEWEST {
            let first = waiting[0];
            waiting[count..].fill(first);
            vectorized!(simd => self.answer_eight(simd, &waiting, count));
        } else {
            for &index in &waiting[..count] {
                self.answer_alone(index);
            }
        }
    }

    /// The end of the run of pairs with the triangle and the origin of the pair at `start`.
    #[inline(always)]
    fn end_of_like(&self, start: usize) -> usize {
        let (ray, id) = self.pairs[start];
        let is_like = |&(of, other): &(u32, u32)| other == id && self.rays.origin(of) == self.rays.origin(ray);
        self.pairs[start + 1..]
            .iter()
            .position(|pair| !is_like(pair))
            .map_or(self.pairs.len(), |count| start + 1 + count)
    }

    fn answer_alone(&mut self, index: usize) {
        let (ray, id) = self.pairs[index];
        self.hits[index] = hit(&self.rays.ray(ray), self.triangles, id);
    }

    /// Answers pairs of one triangle and rays from one origin.
    #[inline(always)]
    fn answer_one<S: Simd>(&mut self, simd: S, pairs: std::ops::Range<usize>) {
        let (ray, id) = self.pairs[pairs.start];
        let [a, b, c] = self.triangles.corners(id).map(Vec3::as_dvec3);
        let corners = [splat_vector(simd, a), splat_vector(simd, b), splat_vector(simd, c)];
        let eight = Eight::new(simd, corners, splat_vector(simd, self.rays.origin(ray)));
        let mut start = pairs.start;
        while start < pairs.end {
            let count = (pairs.end - start).min(LANES);
            let mut direction = [[0.0; LANES]; 3];
            for (lane, &(ray, _)) in self.pairs[start..start + count].iter().enumerate() {
                let DVec3 { x, y, z } = self.rays.direction(ray);
                (direction[0][lane], direction[1][lane], direction[2][lane]) = (x, y, z);
            }
            let values = eight.meet(simd, vectors(simd, direction));
            for lane in 0..count {
                self.note(start + lane, &values, lane);
            }
            start += LANES;
        }
    }

    /// Answers the first `count` of eight pairs of any triangles and rays.
    #[inline(always)]
    fn answer_eight<S: Simd>(&mut self, simd: S, indices: &[usize; LANES], count: usize) {
        let (mut origin, mut direction) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        let mut corners = [[Vec3::ZERO; LANES]; 3];
        for (lane, &index) in indices.iter().enumerate() {
            let (ray, id) = self.pairs[index];
            let (from, along) = (self.rays.origin(ray), self.rays.direction(ray));
            (origin[0][lane], origin[1][lane], origin[2][lane]) = (from.x, from.y, from.z);
            (direction[0][lane], direction[1][lane], direction[2][lane]) = (along.x, along.y, along.z);
            [corners[0][lane], corners[1][lane], corners[2][lane]] = self.triangles.corners(id);
        }
        let corners = [eight_of(simd, &corners[0]), eight_of(simd, &corners[1]), eight_of(simd, &corners[2])];
        let values = Eight::new(simd, corners, vectors(simd, origin)).meet(simd, vectors(simd, direction));
        for (lane, &index) in indices[..count].iter().enumerate() {
            self.note(index, &values, lane);
        }
    }

    #[inline(always)]
    fn note(&mut self, index: usize, values: &Values, lane: usize) {
        if values.undecided >> lane & 1 == 1 {
            self.answer_alone(index);
            return;
        }
        let (ray, triangle) = self.pairs[index];
        let ([t_min, t_max], t) = (self.rays.interval(ray), values.t[lane]);
        let is_hit = values.met >> lane & 1 == 1 && t_min < t && t < t_max;
        let barycentric = values.barycentric;
        self.hits[index] = is_hit.then(|| Hit {
            t,
            triangle,
            barycentric: [barycentric[0][lane] as f32, barycentric[1][lane] as f32],
        });
    }
}

// Functions instead of closures: code that isn't inlined is compiled without the instruction set.

/// Eight triangles, each relative to an origin.
struct Eight<S: Simd> {
    /// The cross product of the corners at each edge's ends.
    edges: [[f64x8<S>; 3]; 3],
    /// The bound of edge functions, divided by the largest component of a direction.
    bound: f64x8<S>,
    plane: TrianglePlane<f64x8<S>>,
}

/// The results of eight pairs.
struct Values {
    barycentric: [[f64; LANES]; 2],
    t: [f64; LANES],
    /// Lines that meet their triangle, a bit for each.
    met: u64,
    /// Pairs that these f64 results don't decide.
    undecided: u64,
}

impl<S: Simd> Eight<S> {
    #[inline(always)]
    fn new(simd: S, corners: [Vectors<S>; 3], origin: Vectors<S>) -> Self {
        let relative = [minus(corners[0], origin), minus(corners[1], origin), minus(corners[2], origin)];
        // As for single pairs.
        let reach = largest(relative[0]).max(largest(relative[1])).max(largest(relative[2]));
        Self {
            edges: [edge(&relative, 0), edge(&relative, 1), edge(&relative, 2)],
            bound: reach * reach * (64.0 * ROUNDING),
            plane: TrianglePlane::new(simd, corners, origin),
        }
    }

    /// Computes the same as [`hit_of_near_at`](super::hit_of_near_at): weights are those of corners in canonical order up to
    /// their signs, and t is rounded from a number with a proven error.
    #[inline(always)]
    fn meet(&self, simd: S, direction: Vectors<S>) -> Values {
        let weights =
            [unfused(direction, self.edges[0]), unfused(direction, self.edges[1]), unfused(direction, self.edges[2])];
        let bound = largest(direction) * self.bound;
        let lowest = weights[0].min(weights[1]).min(weights[2]);
        let highest = weights[0].max(weights[1]).max(weights[2]);
        let is_trusted = bound.simd_ge(f64x8::splat(simd, SMALLEST_TRUSTED_BOUND))
            & bound.simd_lt(f64x8::splat(simd, LARGEST_TRUSTED_BOUND))
            & weights[0].is_finite()
            & weights[1].is_finite()
            & weights[2].is_finite();
        let missed = is_trusted & lowest.simd_lt(-bound) & highest.simd_gt(bound);
        let met = is_trusted & (lowest.simd_gt(bound) | highest.simd_lt(-bound));
        let (slope, height) = (self.plane.slope(simd, direction), self.plane.height);
        let [t, other] = height.quotient(simd, &slope);
        let is_precise = are_precise(simd, &slope) & are_precise(simd, &height) & t.simd_eq(other);
        let shares = [weights[0].abs(), weights[1].abs(), weights[2].abs()];
        let sum = shares[0] + shares[1] + shares[2];
        Values {
            barycentric: [(shares[1] / sum).into(), (shares[2] / sum).into()],
            t: t.into(),
            met: met.to_bitmask(),
            undecided: (!(missed | (met & is_precise))).to_bitmask(),
        }
    }
}

/// [`Sum::is_precise`] for each lane.
#[inline(always)]
fn are_precise<S: Simd>(simd: S, sum: &Sum<f64x8<S>>) -> mask64x8<S> {
    sum.high.abs().simd_gt(sum.magnitude * Double::CANCELLATION)
        & sum.magnitude.simd_ge(f64x8::splat(simd, RANGE.start))
        & sum.magnitude.simd_lt(f64x8::splat(simd, RANGE.end))
}

#[inline(always)]
fn edge<S: Simd>(relative: &[[f64x8<S>; 3]; 3], opposite: usize) -> [f64x8<S>; 3] {
    let (first, second) = EDGE_OPPOSITE[opposite];
    let [[px, py, pz], [qx, qy, qz]] = [relative[first], relative[second]];
    [py * qz - qy * pz, pz * qx - qz * px, px * qy - qx * py]
}

/// The dot product, rounded as for single pairs.
#[inline(always)]
fn unfused<S: Simd>([x, y, z]: [f64x8<S>; 3], [a, b, c]: [f64x8<S>; 3]) -> f64x8<S> {
    x * a + y * b + z * c
}

/// Eight points. They are transposed in registers: numbers stored one by one aren't forwarded to the load of a vector.
#[inline(always)]
fn eight_of<S: Simd>(simd: S, points: &[Vec3; LANES]) -> Vectors<S> {
    let [a, b] = [four_of(simd, points, 0), four_of(simd, points, 4)];
    let (even, odd) = (a.unzip_low(b), a.unzip_high(b));
    let ((x, y), (z, _)) = (even.unzip_low(odd).widen(), even.unzip_high(odd).widen());
    [x, y, z]
}

/// The coordinates of four points, each with a fourth number.
#[inline(always)]
fn four_of<S: Simd>(simd: S, points: &[Vec3; LANES], first: usize) -> f32x16<S> {
    let quad = |lane: usize| f32x4::simd_from(simd, points[first + lane].extend(0.0).to_array());
    quad(0).combine(quad(1)).combine(quad(2).combine(quad(3)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_get_what_each_gets_alone() {
        let mut seed = 1_u64;
        let mut number = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 40) as f32 / (1 << 23) as f32 - 1.0
        };
        let mut positions: Vec<Vec3> = (0..90).map(|_| Vec3::new(number(), number(), number())).collect();
        // Coinciding corners, corners on a line, a far one and a NaN.
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
            // Targets inside, outside, on edges and at corners; some rays start in the plane.
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
        for level in SimdLevel::available() {
            for together in [1, 5, 8, 21] {
                let mut found = vec![None; pairs.len()];
                for (pairs, found) in pairs.chunks(together).zip(found.chunks_mut(together)) {
                    hits(level, triangles, &rays, pairs, found);
                }
                let bits = |hit: &Option<Hit>| hit.map(|hit| (hit.t.to_bits(), hit.triangle, hit.barycentric));
                assert!(found.iter().map(bits).eq(alone.iter().map(bits)), "{level}");
            }
        }
    }
}
