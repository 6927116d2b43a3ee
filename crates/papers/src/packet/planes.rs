use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8};
use glam::Vec3;

use super::space::{Common, Space};
use super::{HALF_ULP, LANES, ROUNDING};
use umbrage_rays::Triangles;
use umbrage_rays::shot::MaskPoints;
use umbrage_rays::simd::vectors::{Vectors, largest, vectors};

/// Sixteen triangles as linear functions of a ray's coordinates (x, y) in a packet, in f32.
///
/// A function is `a x + (b y + c)`. Edge functions are scaled so that |a| + |b| + |c| = 1. Their sign is positive inside
/// where the triangle is `oriented`. 1280 bytes.
#[derive(Default)]
#[repr(align(64))]
pub(crate) struct Planes {
    a: [[f32; LANES]; 3],
    b: [[f32; LANES]; 3],
    c: [[f32; LANES]; 3],
    /// Error bound of each triangle's edge functions.
    bound: [f32; LANES],
    /// Nearness, larger in front.
    nearness: [[f32; LANES]; 3],
    /// Error bound of the nearness of a hit. For shadow rays it includes the predicate's allowance for the error of their
    /// end points.
    nearness_error: [f32; LANES],
    /// The largest nearness in the packet.
    nearest: [f32; LANES],
    /// The factors by which the edge functions were scaled down, as fractions of their sum.
    share: [[f32; LANES]; 3],
    /// Error bound of a barycentric coordinate, times the sum D of [`mask_points`](Self::mask_points).
    weight_error: [f32; LANES],
    /// Triangles whose orientation is certain, a bit for each.
    pub(crate) oriented: u64,
    /// Triangles that certainly no ray of the packet hits.
    pub(crate) missed: u64,
}

/// The values of a triangle's functions at sixteen rays.
pub(crate) struct Values<S: Simd> {
    pub(crate) edges: [f32x16<S>; 3],
    pub(crate) bound: f32x16<S>,
    /// Lowest and highest possible nearness of a hit.
    pub(crate) low: f32x16<S>,
    pub(crate) high: f32x16<S>,
}

impl Planes {
    /// Prepares the triangles with these ids, at most 16.
    #[inline(always)]
    pub(crate) fn set_up<S: Simd>(&mut self, simd: S, space: &Space, triangles: Triangles<'_>, ids: &[u32]) {
        let (low_ids, high_ids) = ids.split_at(ids.len().min(8));
        let low = Half::new(simd, space, triangles, low_ids);
        let high = Half::new(simd, space, triangles, high_ids);
        for edge in 0..3 {
            low.a[edge].narrow(high.a[edge]).store_slice(&mut self.a[edge]);
            low.b[edge].narrow(high.b[edge]).store_slice(&mut self.b[edge]);
            low.c[edge].narrow(high.c[edge]).store_slice(&mut self.c[edge]);
            low.nearness[edge].narrow(high.nearness[edge]).store_slice(&mut self.nearness[edge]);
            low.share[edge].narrow(high.share[edge]).store_slice(&mut self.share[edge]);
        }
        low.weight_error.narrow(high.weight_error).store_slice(&mut self.weight_error);
        let bound: f32x16<S> = low.bound.narrow(high.bound);
        bound.store_slice(&mut self.bound);
        low.nearness_error.narrow(high.nearness_error).store_slice(&mut self.nearness_error);
        low.nearest.narrow(high.nearest).store_slice(&mut self.nearest);
        self.oriented = low.oriented | high.oriented << 8;
        // The frustum's corner rays miss the triangle on the same edge (Wald et al. 2006, §2.3).
        let beyond =
            self.highest(simd, 0).min(self.highest(simd, 1)).min(self.highest(simd, 2)).simd_lt(-bound).to_bitmask();
        self.missed = beyond & self.oriented;
    }

    /// The triangles of `lanes` whose nearness may be at least `least`.
    #[inline(always)]
    pub(crate) fn reaching<S: Simd>(&self, simd: S, lanes: u64, least: f32) -> u64 {
        let nearest = f32x16::from_slice(simd, &self.nearest);
        lanes & !(nearest.simd_lt(f32x16::splat(simd, least)).to_bitmask() & self.oriented)
    }

    /// The boxes, of sixteen, all of whose rays certainly miss the triangle in `lane` or hit it at a nearness below `least`:
    /// a bit for each. Valid only where the triangle is oriented.
    #[inline(always)]
    pub(super) fn missed_boxes<S: Simd>(
        &self,
        simd: S,
        lane: usize,
        middle: [f32x16<S>; 2],
        half: [f32x16<S>; 2],
        least: f32x16<S>,
    ) -> u64 {
        let lane = lane % LANES;
        let Self { a, b, c, .. } = self;
        let edges = [
            highest_in(simd, [a[0][lane], b[0][lane], c[0][lane]], middle, half),
            highest_in(simd, [a[1][lane], b[1][lane], c[1][lane]], middle, half),
            highest_in(simd, [a[2][lane], b[2][lane], c[2][lane]], middle, half),
        ];
        // Ten roundings of sums of at most two.
        const ROUNDINGS: f32 = 20.0 * HALF_ULP as f32;
        let bound = f32x16::splat(simd, self.bound[lane] + ROUNDINGS);
        let [a, b, c] = &self.nearness;
        let (a, b, c) = (a[lane], b[lane], c[lane]);
        let error = self.nearness_error[lane] + (a.abs() + b.abs() + c.abs()) * ROUNDINGS;
        let nearest = highest_in(simd, [a, b, c], middle, half) + f32x16::splat(simd, error);
        let outside = edges[0].min(edges[1]).min(edges[2]).simd_lt(-bound);
        (outside | nearest.simd_lt(least)).to_bitmask()
    }

    /// The points of the triangle in `lane` with the edge functions `edges`, for a query of its mask.
    ///
    /// The weight of a corner is Eᵢ / D, with E an unscaled edge function and D the sum of all three. With sᵢ the fraction
    /// of an edge function's scale, that is eᵢ sᵢ over the sum of all eⱼ sⱼ. The error of eᵢ sᵢ is at most the bound of e
    /// times sᵢ. The predicate's is p = 64 roundings in f64 of d r², relative to the sum of the scales; d is the largest
    /// coordinate of a direction, of which the major axis has at least a quarter, and r the largest of a corner from the
    /// ray's origin. A weight is at most one, so its error is at most h / (D − h), with h = 2 bound + 4 p. Some ε are for
    /// roundings here and the predicate's own to f32.
    #[inline(always)]
    pub(super) fn mask_points<S: Simd>(&self, simd: S, lane: usize, edges: [f32x16<S>; 3], lanes: u16) -> MaskPoints {
        let lane = lane % LANES;
        let first = edges[0] * f32x16::splat(simd, self.share[0][lane]);
        let second = edges[1] * f32x16::splat(simd, self.share[1][lane]);
        let third = edges[2] * f32x16::splat(simd, self.share[2][lane]);
        let sum = first + second + third;
        let inverse = f32x16::splat(simd, 1.0) / sum;
        let error = f32x16::splat(simd, self.weight_error[lane]);
        let error = error / (sum - error) + f32x16::splat(simd, 12.0 * HALF_ULP as f32);
        MaskPoints { barycentric: [(second * inverse).into(), (third * inverse).into()], error: error.into(), lanes }
    }

    /// The largest value of an edge function in the packet.
    #[inline(always)]
    fn highest<S: Simd>(&self, simd: S, edge: usize) -> f32x16<S> {
        let a = f32x16::from_slice(simd, &self.a[edge]);
        let b = f32x16::from_slice(simd, &self.b[edge]);
        a.abs() + b.abs() + f32x16::from_slice(simd, &self.c[edge])
    }

    /// The values of the functions of the triangle in `lane`.
    #[inline(always)]
    pub(crate) fn at<S: Simd>(&self, simd: S, lane: usize, x: f32x16<S>, y: f32x16<S>) -> Values<S> {
        let lane = lane % LANES;
        let Self { a, b, c, .. } = self;
        let edges = [
            linear(simd, [a[0][lane], b[0][lane], c[0][lane]], x, y),
            linear(simd, [a[1][lane], b[1][lane], c[1][lane]], x, y),
            linear(simd, [a[2][lane], b[2][lane], c[2][lane]], x, y),
        ];
        let [a, b, c] = &self.nearness;
        let nearness = linear(simd, [a[lane], b[lane], c[lane]], x, y);
        let error = f32x16::splat(simd, self.nearness_error[lane]);
        let bound = f32x16::splat(simd, self.bound[lane]);
        Values { edges, bound, low: nearness - error, high: nearness + error }
    }
}

/// a x + (b y + c).
#[inline(always)]
fn linear<S: Simd>(simd: S, [a, b, c]: [f32; 3], x: f32x16<S>, y: f32x16<S>) -> f32x16<S> {
    f32x16::splat(simd, a) * x + (f32x16::splat(simd, b) * y + f32x16::splat(simd, c))
}

/// The largest value of a x + (b y + c) in each box.
#[inline(always)]
fn highest_in<S: Simd>(simd: S, [a, b, c]: [f32; 3], middle: [f32x16<S>; 2], half: [f32x16<S>; 2]) -> f32x16<S> {
    let spread = f32x16::splat(simd, a.abs()) * half[0] + f32x16::splat(simd, b.abs()) * half[1];
    linear(simd, [a, b, c], middle[0], middle[1]) + spread
}

/// The functions of eight triangles, in f64.
struct Half<S: Simd> {
    a: [f64x8<S>; 3],
    b: [f64x8<S>; 3],
    c: [f64x8<S>; 3],
    bound: f64x8<S>,
    nearness: [f64x8<S>; 3],
    nearness_error: f64x8<S>,
    nearest: f64x8<S>,
    share: [f64x8<S>; 3],
    weight_error: f64x8<S>,
    oriented: u64,
}

impl<S: Simd> Half<S> {
    /// With u half an ulp of an f64, ε half an ulp of an f32, r the reach of a corner (its largest coordinate, sheared
    /// and shifted) and ρ that of a difference of corners:
    /// - A sheared coordinate has four roundings, relative to r: 4 u r. A component of p × q is wrong by
    ///   2 (2 · 4 u + 2 u) rₚ rᵥ < 24 u rₚ rᵥ; a common direction's, made of differences of p and q, by
    ///   (8 + 4) u (rₚ + rᵥ) along u and v. That makes `of_corners`, over the function's size S.
    /// - Rounded to f32 and evaluated, terms have five roundings of their sizes, whose sum is one: 5 ε.
    /// - x and y are wrong by the packet's `ray_error`, and coefficients at most one.
    ///
    /// The bound takes 8 ε for the five, which covers its own roundings.
    ///
    /// A component of the normal, a product of differences, is wrong by 24 u ρ ρ', and its product with a corner by
    /// 3 (24 + 4 + 4 + 3) u ρ ρ' r < 128 u ρ ρ' r. The nearness is a quotient of those two; the relative error of its
    /// denominator is at most 1/8 where the triangle is oriented.
    #[inline(always)]
    fn new(simd: S, space: &Space, triangles: Triangles<'_>, ids: &[u32]) -> Self {
        let Corners { corners, reach, differences, lengths } = load(simd, space, triangles, ids);
        let [half_u, half_v] = [splat(simd, space.half[0]), splat(simd, space.half[1])];
        let extent = splat(simd, 1.0 + space.half[0] + space.half[1]);
        let is_parallel = space.common == Common::Direction;

        let normal = cross(differences[0], differences[1]);
        let size = lengths[0] * lengths[1];
        let offset = dot(normal, corners[0]);
        let (normal_error, offset_error) = (size * (24.0 * ROUNDING), size * reach[0] * (128.0 * ROUNDING));
        let (divisor, divisor_error, constant, constant_error) = if is_parallel {
            (normal[2], normal_error, -offset, offset_error)
        } else {
            (offset, offset_error, normal[2], normal_error)
        };
        let divisor_size = divisor.abs();
        let oriented = divisor_size.simd_gt(divisor_error * 8.0);
        let side = splat(simd, 1.0).copysign(divisor);

        let mut half = Self {
            a: [splat(simd, 0.0); 3],
            b: [splat(simd, 0.0); 3],
            c: [splat(simd, 0.0); 3],
            bound: splat(simd, 0.0),
            nearness: [splat(simd, 0.0); 3],
            nearness_error: splat(simd, 0.0),
            nearest: splat(simd, 0.0),
            share: [splat(simd, 0.0); 3],
            weight_error: splat(simd, 0.0),
            oriented: oriented.to_bitmask(),
        };
        for edge in 0..3 {
            let (p, q) = ((edge + 1) % 3, (edge + 2) % 3);
            let [across, along, middle] = cross(corners[p], corners[q]);
            let product = reach[p] * reach[q] * (24.0 * ROUNDING);
            let (across, along, of_corners) = if is_parallel {
                let sums = (reach[p] + reach[q]) * (12.0 * ROUNDING);
                (corners[p][1] - corners[q][1], corners[q][0] - corners[p][0], product + sums * (half_u + half_v))
            } else {
                (across, along, product * extent)
            };
            let (a, b) = (across * half_u, along * half_v);
            half.share[edge] = a.abs() + b.abs() + middle.abs();
            let inverse = splat(simd, 1.0) / half.share[edge];
            let scale = inverse * side;
            (half.a[edge], half.b[edge], half.c[edge]) = (a * scale, b * scale, middle * scale);
            half.bound += of_corners * inverse;
        }
        half.bound += splat(simd, 8.0 * HALF_ULP + space.ray_error);
        half.share_out(simd, space, reach);

        let inverse = splat(simd, 1.0) / divisor;
        half.nearness = [normal[0] * half_u * inverse, normal[1] * half_v * inverse, constant * inverse];
        let [a, b, c] = [half.nearness[0].abs(), half.nearness[1].abs(), half.nearness[2]];
        let largest = a + b + c.abs();
        let of_predicate = match space.points {
            None => splat(simd, 0.0),
            Some(points) => {
                // The predicate requires the point's box behind the plane: this is less than six products of differences
                // with ten roundings of the point's distance from a corner, and its error.
                let height = reach[0] + splat(simd, points.reach);
                let height = size * 6.1 * (height * (10.0 * ROUNDING) + splat(simd, points.error));
                if is_parallel { height } else { height * splat(simd, 1.0 / points.nearest) }
            }
        };
        let numerator_error = normal_error * extent + constant_error + of_predicate;
        half.nearness_error = numerator_error * inverse.abs() * 1.2
            + largest * (divisor_error * inverse.abs() * 1.2 + splat(simd, 8.0 * HALF_ULP + space.ray_error))
            // Underflow in f32.
            + splat(simd, f64::from(f32::MIN_POSITIVE));
        half.nearest = (c + a + b) + half.nearness_error * 1.01 + largest * HALF_ULP;
        half
    }

    /// Turns the scales of the edge functions into fractions of their sum; see [`Planes::mask_points`].
    #[inline(always)]
    fn share_out(&mut self, simd: S, space: &Space, reach: [f64x8<S>; 3]) {
        let inverse_sum = splat(simd, 1.0) / (self.share[0] + self.share[1] + self.share[2]);
        for share in &mut self.share {
            *share *= inverse_sum;
        }
        let reach = reach[0].max(reach[1]).max(reach[2]) + splat(simd, space.start_reach);
        let of_predicate = reach * reach * inverse_sum * (4.0 * 64.0 * ROUNDING);
        self.weight_error = (self.bound * 2.0 + of_predicate * 4.0) * 1.01;
    }
}

/// Corners of eight triangles along u, v and w.
struct Corners<S: Simd> {
    corners: [Vectors<S>; 3],
    /// The largest coordinate of each corner before shearing, times the steepness.
    reach: [f64x8<S>; 3],
    /// Differences of the other two corners from the first.
    differences: [Vectors<S>; 2],
    /// Their reach.
    lengths: [f64x8<S>; 2],
}

/// The corners of up to eight triangles.
#[inline(always)]
fn load<S: Simd>(simd: S, space: &Space, triangles: Triangles<'_>, ids: &[u32]) -> Corners<S> {
    // Unused lanes are NaN, so nothing is certain about them.
    let mut positions = [[[f64::NAN; 8]; 3]; 3];
    for (lane, &id) in ids.iter().take(8).enumerate() {
        for (corner, &vertex) in triangles.indices[id as usize].iter().enumerate() {
            let position: Vec3 = triangles.positions[vertex as usize];
            for axis in 0..3 {
                positions[corner][axis][lane] = f64::from(position[space.axes[axis]]);
            }
        }
    }
    let units = [space.unit, space.unit, space.unit * space.sign];
    let steepness = 1.0 + space.slope[0].abs().max(space.slope[1].abs());
    let farthest = space.shift[0].abs().max(space.shift[1].abs());
    let mut corners = [[splat(simd, 0.0); 3]; 3];
    let mut reach = [splat(simd, 0.0); 3];
    let mut differences = [[splat(simd, 0.0); 3]; 2];
    let mut lengths = [splat(simd, 0.0); 2];
    for corner in 0..3 {
        let [u, v, w] = vectors(simd, positions[corner]);
        let [from_u, from_v, from_w] = space.axes.map(|axis| space.origin[axis]);
        let relative = [(u - from_u) * units[0], (v - from_v) * units[1], (w - from_w) * units[2]];
        reach[corner] = largest(relative) * steepness + splat(simd, farthest);
        let [u, v, w] = shear(space, relative);
        corners[corner] = [u - space.shift[0], v - space.shift[1], w];
        if corner > 0 {
            let [u, v, w] = vectors(simd, positions[corner]);
            let [first_u, first_v, first_w] = vectors(simd, positions[0]);
            let difference = [(u - first_u) * units[0], (v - first_v) * units[1], (w - first_w) * units[2]];
            lengths[corner - 1] = largest(difference) * steepness;
            differences[corner - 1] = shear(space, difference);
        }
    }
    Corners { corners, reach, differences, lengths }
}

#[inline(always)]
fn cross<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> Vectors<S> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn dot<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> f64x8<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f64) -> f64x8<S> {
    f64x8::splat(simd, value)
}

/// Shears a vector so that the packet's middle ray runs along w.
#[inline(always)]
fn shear<S: Simd>(space: &Space, [u, v, w]: Vectors<S>) -> Vectors<S> {
    [u - w * space.slope[0], v - w * space.slope[1], w]
}
