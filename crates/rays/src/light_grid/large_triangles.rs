use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::{DVec3, Vec3};

use super::boxes::{FaceBox, SplatBox};
use super::face::{FACE_LIMIT, Face, HALF_ULP, ROUNDING};
use super::set_up::Record;
use crate::edge_functions::EdgeFunctions;
use crate::shot::OpacityOfSides;
use crate::simd::lanes::bits_of;
use crate::simd::vectors::{LANES, splat};

/// Triangles of a face that reach behind the light or far outside of the face, as linear functions of X and Y in f64.
#[derive(Debug, Default)]
pub(crate) struct LargeTriangles {
    planes: Vec<LargeTriangle>,
    /// The same in f32, sixteen together, grown by their errors.
    sixteens: Vec<SixteenPlanes>,
}

/// A triangle as linear functions of X and Y: its `EdgeFunctions`, with signs turned so that all three are positive where
/// the triangle is hit in front of the light, and its nearness.
#[derive(Clone, Copy, Debug)]
pub struct LargeTriangle {
    id: u32,
    /// Factors of X, Y and 1, the magnitudes of which sum up to one; zero for an edge of which nothing is known.
    pub edges: [[f64; 3]; 3],
    /// Error bounds of the edge functions.
    pub edge_errors: [f64; 3],
    pub nearness: [f64; 3],
    /// Error bound of the difference in nearness to a point, with the margin by which the predicate wants points behind.
    /// Infinite, and the nearness zero, where nothing is known of it.
    pub depth_error: f64,
}

/// For each of the edge functions and the nearness of sixteen planes the factors of X and Y, and the constant.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct SixteenPlanes {
    a: [[f32; LANES]; 4],
    b: [[f32; LANES]; 4],
    c: [[f32; LANES]; 4],
}

impl LargeTriangles {
    /// Takes the triangles with these ids that may shadow a point of the face, for the side that the light falls on among
    /// others.
    pub(crate) fn find(&mut self, face: &Face, ids: impl Iterator<Item = u32>, opacity: &OpacityOfSides<'_>) {
        let Self { planes, sixteens } = self;
        planes.clear();
        for id in ids {
            if let Ok(corners) = opacity.triangles.usable_corners(id)
                && opacity.is_there(id)
            {
                planes.extend(LargeTriangle::of(face, corners, id).into_iter().flatten());
            }
        }
        sixteens.clear();
        sixteens.extend(planes.chunks(LANES).map(SixteenPlanes::new));
    }

    pub(crate) fn bytes(&self) -> usize {
        self.planes.capacity() * size_of::<LargeTriangle>() + self.sixteens.capacity() * size_of::<SixteenPlanes>()
    }

    /// Calls `visit` with the indices of the triangles that may shadow some of the points in a box.
    #[inline(always)]
    pub(crate) fn reaching<S: Simd>(&self, simd: S, points: &FaceBox, mut visit: impl FnMut(usize)) {
        let points = SplatBox::new(simd, points);
        let zero = splat(simd, 0.0);
        for (number, sixteen) in self.sixteens.iter().enumerate() {
            let mut reaching = 0xffff;
            for function in 0..4 {
                let a = f32x16::simd_from(simd, sixteen.a[function]);
                let b = f32x16::simd_from(simd, sixteen.b[function]);
                let c = f32x16::simd_from(simd, sixteen.c[function]);
                let x = a.simd_gt(zero).select(points.x[1], points.x[0]);
                let y = b.simd_gt(zero).select(points.y[1], points.y[0]);
                let most = a.mul_add(x, b.mul_add(y, c));
                let least = if function < 3 { zero } else { points.nearness };
                // Written so that NaN reaches.
                reaching &= !most.simd_lt(least).to_bitmask();
            }
            for lane in bits_of(reaching & 0xffff) {
                if number * LANES + lane < self.planes.len() {
                    visit(number * LANES + lane);
                }
            }
        }
    }

    /// Sets up a triangle for the points around `origin`, as [`SetUp`](super::set_up::SetUp) does for small ones. Points
    /// have errors of at most `errors` in X and Y, and in W. With these they are at most `reach` from the origin in X and Y,
    /// and `depth` in W.
    ///
    /// With ε = 2⁻²⁴, f = a x + b y + c has at most four roundings of a x and of b y, and three of c. Where f decides, at
    /// most the points' errors from zero, |c| is at most (|a| + |b|) `reach`: together seven ε of that. The nearness also
    /// has three of W, and where `reach` and `depth` are nothing but errors, six of them.
    pub(crate) fn record(&self, number: usize, origin: [f32; 3], [reach, depth]: [f32; 2], errors: [f32; 2]) -> Record {
        const ROUNDED: f64 = 8.0 * HALF_ULP;
        let plane = &self.planes[number];
        let [ox, oy, ow] = origin.map(f64::from);
        let [reach, depth] = [reach, depth].map(f64::from);
        let [position_error, nearness_error] = errors.map(f64::from);
        let mut quads = [[0.0; 4]; 3];
        let mut largest_error = 0.0_f64;
        for (quad, (&[a, b, c], &error)) in quads.iter_mut().zip(plane.edges.iter().zip(&plane.edge_errors)) {
            let c = a * ox + b * oy + c;
            let size = a.abs() + b.abs();
            let error = error + size * (position_error + ROUNDED * reach);
            largest_error = largest_error.max(error);
            *quad = [a as f32, b as f32, (c + error) as f32, 0.0];
        }
        let [p, q, r] = plane.nearness;
        let r = p * ox + q * oy + r - ow;
        let size = p.abs() + q.abs();
        let error = plane.depth_error + nearness_error + size * (position_error + ROUNDED * reach) + ROUNDED * depth;
        for (quad, value) in quads.iter_mut().zip([p, q, r + error]) {
            quad[3] = value as f32;
        }
        // Rounded up.
        Record { quads, id: plane.id, errors: [(2.001 * largest_error) as f32, (2.001 * error) as f32] }
    }
}

impl SixteenPlanes {
    fn new(planes: &[LargeTriangle]) -> Self {
        let nothing = [[0.0; LANES]; 4];
        let mut sixteen = Self { a: nothing, b: nothing, c: nothing };
        for (lane, plane) in planes.iter().enumerate() {
            let functions = plane.edges.iter().zip(&plane.edge_errors).chain([(&plane.nearness, &plane.depth_error)]);
            for (function, (&[a, b, c], &error)) in functions.enumerate() {
                // Where |X| and |Y| are hardly above one: factors are rounded, and so are products and sums.
                let rounded = 5.0 * HALF_ULP * (a.abs() + b.abs() + c.abs());
                sixteen.a[function][lane] = a as f32;
                sixteen.b[function][lane] = b as f32;
                sixteen.c[function][lane] = (c + error + rounded) as f32;
            }
        }
        sixteen
    }
}

/// A triangle's corners in a face's homogeneous coordinates, of which X and Y are quotients.
pub struct HomogeneousCorners {
    pub points: [DVec3; 3],
    /// Bounds of each corner's coordinates.
    pub sizes: [f64; 3],
    /// Nearness of each corner times its third coordinate.
    nearnesses: [f64; 3],
}

impl HomogeneousCorners {
    pub fn new(face: &Face, corners: [DVec3; 3]) -> Self {
        let mut points = corners.map(|corner| face.homogeneous(corner));
        // In parallel light all are at the homogeneous distance one, and nearness is interpolated.
        let nearnesses = points.map(|point| if face.is_parallel { point.z } else { face.near });
        if face.is_parallel {
            points.iter_mut().for_each(|point| point.z = 1.0);
        }
        let (norms, least) = (face.norms(), f64::from(u8::from(face.is_parallel)));
        let size = |corner: DVec3| (norms * (corner - face.origin).abs().max_element()).max_element().max(least);
        Self { points, sizes: corners.map(size), nearnesses }
    }
}

impl LargeTriangle {
    /// The planes of a triangle: none if it can't shadow a point of the face; two if the light may be in its plane, so that
    /// its side isn't known.
    ///
    /// With u = 2⁻⁵³, |X| and |Y| hardly above one, and sⱼ the largest coordinate that pⱼ may have: each coordinate's error
    /// is four u sⱼ, and in parallel light twenty more, since X and Y of the light's own direction may be that far from zero
    /// ([`across`](super::choose::across)). So the components of pⱼ × pₖ have an error of 20 u sⱼ sₖ, in parallel light of
    /// 100, and the function three times as much. Scaling it, and moving it to another origin, has five roundings of its
    /// largest value, 20 u sⱼ sₖ.
    ///
    /// With e the error of p₁ × p₂, the determinant, p₀ · (p₁ × p₂), has an error of 3 s₀ e, plus those of p₀ and of the
    /// sum: 42 u s₀ s₁ s₂, in parallel light 114. That is less than 4.2 s₀ e.
    ///
    /// The nearness is the sum of the edge functions, each times its corner's nearness or `near`, over the determinant. With
    /// S the magnitudes of its own factors, a corner's is at most sⱼ S. So each function's error makes 3 s₀ e S of it, also
    /// with the four roundings of the sum, 8 u sⱼ sₖ; and the determinant's 4.2 s₀ e S: together 3.15 times the latter.
    pub fn of(face: &Face, corners: [Vec3; 3], id: u32) -> [Option<Self>; 2] {
        let world = corners.map(Vec3::as_dvec3);
        let HomogeneousCorners { points, sizes, nearnesses } = HomogeneousCorners::new(face, world);
        let (norms, reach) = (face.norms(), world.map(|corner| (corner - face.origin).abs().max_element()));
        if is_outside(&points, sizes) {
            return [None; 2];
        }
        let opposite = [(1, 2), (2, 0), (0, 1)];
        let functions = EdgeFunctions::new(points);
        let EdgeFunctions { edges, determinant } = functions;
        let roundings = if face.is_parallel { 110.0 } else { 30.0 };
        let edge_errors = opposite.map(|(j, k)| roundings * ROUNDING * sizes[j] * sizes[k]);
        let determinant_error = 4.2 * sizes[0] * edge_errors[0];
        let is_certain = determinant.abs() > 4096.0 * determinant_error && determinant.is_finite();

        let mut plane = Self {
            id,
            edges: [[0.0; 3]; 3],
            edge_errors: [f64::INFINITY; 3],
            nearness: [0.0; 3],
            depth_error: f64::INFINITY,
        };
        let sign = if is_certain { determinant.signum() } else { 1.0 };
        for (index, (edge, error)) in edges.into_iter().zip(edge_errors).enumerate() {
            let size = edge.abs().element_sum();
            // Otherwise nothing is known about this edge.
            if size.is_finite() && size > 1e-250 {
                plane.edges[index] = (edge * (sign / size)).to_array();
                plane.edge_errors[index] = 3.0 * error / size;
            }
        }
        if !is_certain {
            let mut turned = plane;
            turned.edges.as_flattened_mut().iter_mut().for_each(|factor| *factor = -*factor);
            return [Some(plane), Some(turned)];
        }
        let slope = functions.through(nearnesses);
        let size = slope.abs().element_sum();
        // Four roundings of each corner's own nearness.
        let of_corner = |corner: usize| edges[corner].abs().max_element() * reach[corner];
        let of_nearness =
            if face.is_parallel { 15.0 * ROUNDING * norms.z * (0..3).map(of_corner).sum::<f64>() } else { 0.0 };
        let error = (of_nearness + 3.3 * size * determinant_error) / determinant.abs();
        // Underflow in f32 loses far less than the last term.
        let depth_error = error + predicate_error(face, world, determinant) + 1e-30;
        // The limits keep these from overflowing in f32.
        if depth_error < 1e30 && size < 1e30 {
            plane.nearness = slope.to_array();
            plane.depth_error = depth_error;
        }
        [Some(plane), None]
    }
}

/// Whether all corners of a triangle are outside of the same side of the face, or behind the light, by more than their
/// errors.
fn is_outside(points: &[DVec3; 3], sizes: [f64; 3]) -> bool {
    let beyond = |height: fn(DVec3) -> f64| {
        points.iter().zip(sizes).all(|(&point, size)| height(point) > 28.0 * ROUNDING * size)
    };
    beyond(|p| -p.z)
        || beyond(|p| p.x - FACE_LIMIT * p.z)
        || beyond(|p| -p.x - FACE_LIMIT * p.z)
        || beyond(|p| p.y - FACE_LIMIT * p.z)
        || beyond(|p| -p.y - FACE_LIMIT * p.z)
}

/// The predicate's margin, in nearness, by which a point must be behind the triangle.
///
/// It wants e times the sum of n's components of n · (P − a), for the unnormalised normal n, e being half the point's box:
/// at most twice its error, with the box's own rounding. That is at most 4 |ab| |ac| e, with largest components |·|: no
/// matrix of numbers up to one has a larger determinant than 4. And n · (P − a) is the determinant, taken back to world
/// lengths, times the difference in nearness times z / near; in parallel light it is n · d / s.z.
fn predicate_error(face: &Face, [a, b, c]: [DVec3; 3], determinant: f64) -> f64 {
    let (ab, ac) = ((b - a).abs().max_element(), (c - a).abs().max_element());
    let volume = determinant.abs() / (face.scale.x * face.scale.y);
    // The error is in relation to z in perspective, and z · W is `near`.
    let of_length = if face.is_parallel { face.scale.z } else { face.near };
    8.01 * ab * ac * face.point_error * of_length / volume
}

#[cfg(test)]
mod tests;
