use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8};
use glam::{DVec2, DVec3, IVec2, Vec3};

use crate::predicate::{is_front_along, is_front_from};
use crate::shot::{Shifts, Shot};
use crate::simd::lanes::{LANES, quads, sixteen_of, splat};
use crate::simd::vectors::{Vectors, narrow, widen};
use crate::{Camera, Projection, Sides, View};

/// Half the distance from one to the next f32: the relative error of one rounding.
pub const HALF_ULP: f32 = f32::EPSILON / 2.0;

/// A vertex in pixel space: x, y, inverse depth and a zero that pads it to a quarter of a 16-wide register. 16 bytes.
///
/// x and y count in pixels to the right and downwards from the sample at [`PixelSpace::middle`], so that samples have
/// integer coordinates plus the image's [`Shifts`], which are exact. Their error is at most |x| · [`HALF_ULP`]
/// (|y| · `HALF_ULP`) + `Vertex::ERROR_PIXELS`.
///
/// The inverse depth has a relative error below 1.01 `HALF_ULP`. It is `Vertex::BEHIND` for a vertex certainly behind the
/// eye. It is another negative number for a vertex near the eye's plane, too far to the side or not finite. In both cases x
/// and y mean nothing, except that vertices at one point behind the eye have the same.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct Vertex(pub(crate) [f32; 4]);

impl From<Vertex> for [f32; 4] {
    #[inline(always)]
    fn from(vertex: Vertex) -> Self {
        vertex.0
    }
}

impl Vertex {
    /// The vertex that replaces every vertex the fast path can't take.
    pub const AWKWARD: Self = Self([0.0, 0.0, -1.0, 0.0]);

    /// The inverse depth of vertices that are certainly behind the eye. No ray hits a triangle with three of them.
    pub(crate) const BEHIND: f32 = -2.0;

    /// Error bound of a vertex relative to a sample, for the transform before the rounding to f32 and for the rounding of
    /// the rays' own directions.
    ///
    /// Camera coordinates are wrong by 2⁻⁴⁵ of the largest coordinate r of the vertex relative to the eye (see
    /// [`PixelSpace::camera_point`]), and r ≤ 1.01 z (1 + 2 g), where g bounds |x/z| and |y/z|. With s pixels a unit of x/z,
    /// that makes 1.02 s (1 + 2g)(1 + g) 2⁻⁴⁵ pixels. A ray's direction is wrong by ten f64 roundings an axis (two of them
    /// for its position in the pixel), which makes s (1 + g)(1 + 2g) 2⁻⁴⁸ pixels. Since [`PixelSpace::guard`] keeps s
    /// (1 + 2g)² below 2²⁴, the sum is below 2⁻²⁰; the doubled bound also covers the few f64 roundings of coordinates below
    /// 2²³ pixels.
    pub(crate) const ERROR_PIXELS: f32 = 1.0 / (1 << 19) as f32;
}

/// The rays of one frame's camera as points in a plane: integer points plus shifts of at most a half.
#[derive(Clone, Copy, Debug)]
pub struct PixelSpace {
    view: View,
    /// Distances of samples from integer points.
    pub(crate) shifts: Shifts,
    pub(super) eye: DVec3,
    /// Rows of the inverse of the matrix of the camera's axes.
    pub(super) camera_from_world: [DVec3; 3],
    /// Pixels a unit of x/z; in an orthographic view, pixels a unit of x.
    pub(crate) scale: f64,
    /// The camera's forward axis in pixel space.
    pub(crate) axis_pixels: DVec2,
    /// The pixel whose sample has the coordinates (0, 0).
    pub middle: IVec2,
    /// Largest |x/z| and |y/z| that a vertex may have on the fast path; negative where no vertex may take it.
    pub(super) guard: f64,
    /// T of [`RELATIVE_EDGE_ERROR`](Self::RELATIVE_EDGE_ERROR), in pixels.
    pub(crate) extent: f64,
    /// Error of the edge functions of [`HomogeneousTriangle`](super::homogeneous::HomogeneousTriangle) for vertices with a reach of one.
    pub(crate) edge_error: f64,
    /// The reaches of [`camera_point`](Self::camera_point) for each world unit.
    pub(super) reach_per_unit: f64,
    /// The least reach in an orthographic view.
    least_reach: f64,
}

impl PixelSpace {
    pub fn new(shot: &Shot<'_>) -> Self {
        let &Shot { ref view, offset_pixels, shifts, .. } = shot;
        let Camera { position, right, up, forward, projection } = view.camera;
        let [right, up, forward] = [right, up, forward].map(Vec3::as_dvec3);
        let determinant = right.dot(up.cross(forward));
        let camera_from_world = [up.cross(forward), forward.cross(right), right.cross(up)].map(|row| row / determinant);
        let (width, height) = (f64::from(view.width), f64::from(view.height));
        let middle = IVec2::new((view.width / 2) as i32, (view.height / 2) as i32);
        let axis_pixels = DVec2::new(0.5 * width, 0.5 * height) - offset_pixels - middle.as_dvec2();
        let scale = match projection {
            Projection::Perspective { tan_half_height } => 0.5 * height / f64::from(tan_half_height),
            Projection::Orthographic { half_height } => 0.5 * height / f64::from(half_height),
        };

        // The error bounds hold for cameras as `Camera` describes them. For any other camera every filter is uncertain, so
        // all answers come straight from the predicate.
        let unit = |axis: DVec3| axis.abs().max_element() <= 1.01;
        let rigid = [right, up, forward].into_iter().chain(camera_from_world).all(unit)
            && (0.98..1.02).contains(&determinant.abs());
        let farthest = DVec2::new(width, height) + axis_pixels.abs();
        let is_perspective = matches!(projection, Projection::Perspective { .. });
        let eye = position.as_dvec3();
        let bounds = if is_perspective {
            EdgeBounds::of_perspective(scale.abs(), farthest)
        } else {
            EdgeBounds::of_orthographic(scale.abs(), farthest, eye.abs().max_element())
        };
        let bounds = if rigid && bounds.is_usable() { bounds } else { EdgeBounds::NONE };
        let EdgeBounds { extent, edge_error, reach_per_unit, least_reach } = bounds;

        const LARGEST_ERROR_PRODUCT: f64 = (1 << 24) as f64;
        let guard = 0.5 * ((LARGEST_ERROR_PRODUCT / scale).sqrt() - 1.0);
        let sees_inside_guard = farthest.max_element() / scale <= guard;
        let guard = if rigid && is_perspective && scale > 0.0 && sees_inside_guard { guard } else { -1.0 };
        Self {
            view: *view,
            shifts,
            eye,
            camera_from_world,
            scale,
            axis_pixels,
            middle,
            guard,
            extent,
            edge_error,
            reach_per_unit,
            least_reach,
        }
    }

    /// Relative error of edge functions, to T² (1 + x/z + y/z) rⱼ rₖ in a perspective view, where T is the extent of pixel
    /// space (scale, image and offset together) and r the largest coordinate of a vertex relative to the eye.
    ///
    /// With q = (s·x + a·z, s·y + b·z, z) for a vertex, coordinates are at most 2 T r, 2 T r and 2 r and wrong by
    /// 2⁻⁴⁴·⁹ T r, 2⁻⁴⁴·⁹ T r and 2⁻⁴⁵ r. That makes 8.3 · 2⁻⁴⁵ T rⱼ rₖ in x and y of the cross product, 8.6 · 2⁻⁴⁵ T²
    /// rⱼ rₖ in z, and 25 · 2⁻⁴⁵ T² rⱼ rₖ in the edge function of a sample, whose coordinates are at most T. Its six
    /// roundings on a path add 144 · 2⁻⁵³, and the rays' own (see [`Vertex::ERROR_PIXELS`]) 2⁻⁴⁴ (1 + x/z + y/z): less
    /// than 2⁻⁴⁰, doubled for the bound's own roundings and sums of three. [`EdgeBounds::of_orthographic`] derives the
    /// same number for an orthographic view.
    const RELATIVE_EDGE_ERROR: f64 = 1.0 / (1_u64 << 39) as f64;

    /// A point along the camera's right, up and forward axes, and its reach: the largest coordinate r of its offset from the
    /// eye, in an orthographic view times a factor of at least one.
    ///
    /// Each coordinate is wrong by at most 2⁻⁴⁵ r: the inverse matrix by 64 f64 roundings (its cofactors have 6, its
    /// determinant 30), the offset, product and sums by five, on each of three axes.
    #[inline(always)]
    pub fn camera_point(&self, point: Vec3) -> (DVec3, f64) {
        let offset = DVec3::new(f64::from(point.x), f64::from(point.y), f64::from(point.z)) - self.eye;
        let [right, up, forward] = self.camera_from_world;
        let point = DVec3::new(dot(right, offset), dot(up, offset), dot(forward, offset));
        (point, self.reach_per_unit * offset.x.abs().max(offset.y.abs()).max(offset.z.abs()))
    }

    /// The sign of the area in pixel space, where y goes down, of triangles that show their front; zero where all have both
    /// sides.
    pub fn facing(&self, sides: Sides<'_>) -> f32 {
        if sides == Sides::Both {
            return 0.0;
        }
        let Camera { right, up, forward, .. } = self.view.camera;
        // Negative for a camera in a right-handed world, whose image isn't mirrored: there y down turns the sign.
        right.as_dvec3().dot(up.as_dvec3().cross(forward.as_dvec3())).signum() as f32
    }

    /// Whether rays that hit a triangle see its front.
    pub(crate) fn sees_front(&self, corners: [Vec3; 3]) -> bool {
        if self.is_perspective() {
            is_front_from(self.eye, corners)
        } else {
            is_front_along(self.view.camera.forward.as_dvec3(), corners)
        }
    }

    /// Whether all rays start at the eye.
    pub fn is_perspective(&self) -> bool {
        matches!(self.view.camera.projection, Projection::Perspective { .. })
    }

    /// The least reach in an orthographic view, where rays start all over the camera's plane.
    pub(crate) fn eye_reach(&self) -> f64 {
        self.least_reach
    }

    /// Image width and height in pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.view.width, self.view.height)
    }

    /// The range of inverse depths of ordinary vertices: neither it nor its slopes, at most 10¹² times as large, come near
    /// the limits of f32.
    pub(super) const RANGE: std::ops::RangeInclusive<f64> = 1e-24..=1e24;

    /// The distance behind the eye, relative to its reach, at which a vertex is certainly behind: its error is 2⁻⁴⁵ of the
    /// reach. Directions of rays have a depth of one, up to a few roundings.
    pub(super) const DOUBT: f64 = 1.0 / (1_u64 << 40) as f64;

    /// Transforms positions to the same number of vertices.
    #[inline(always)]
    pub fn project<S: Simd>(&self, simd: S, positions: &[Vec3], vertices: &mut [Vertex]) {
        for (positions, vertices) in positions.chunks(LANES).zip(vertices.chunks_mut(LANES)) {
            let mut sixteen = [Vertex::AWKWARD; LANES];
            self.project_sixteen(simd, sixteen_of(simd, positions), &mut sixteen);
            vertices.copy_from_slice(&sixteen[..vertices.len()]);
        }
    }

    /// x, y and inverse depth of sixteen ordinary positions (see [`box_in_image`](Self::box_in_image)).
    #[inline(always)]
    pub(super) fn project_ordinary<S: Simd>(&self, simd: S, positions: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
        let [low, high] = widen(positions);
        let (low, high) = (self.camera_points(simd, low).0, self.camera_points(simd, high).0);
        narrow(self.pixels(simd, low), self.pixels(simd, high))
    }

    /// Transforms sixteen positions to vertices.
    #[inline(always)]
    pub(crate) fn project_sixteen<S: Simd>(&self, simd: S, positions: [f32x16<S>; 3], vertices: &mut [Vertex]) {
        let [low, high] = widen(positions);
        let [x, y, inverse_depth] = narrow(self.project_eight(simd, low), self.project_eight(simd, high));
        for (four, quad) in vertices.chunks_exact_mut(4).zip(quads([x, y, inverse_depth, splat(simd, 0.0)])) {
            let quad: [f32; LANES] = quad.into();
            for (vertex, of) in four.iter_mut().zip(quad.as_chunks().0) {
                *vertex = Vertex(*of);
            }
        }
    }

    #[inline(always)]
    fn project_eight<S: Simd>(&self, simd: S, positions: Vectors<S>) -> Vectors<S> {
        let (at, reach) = self.camera_points(simd, positions);
        let constant = |value: f64| f64x8::splat(simd, value);
        let inverse_depth = constant(1.0) / at[2];
        let (x, y, guard) = (at[0] * inverse_depth, at[1] * inverse_depth, constant(self.guard));
        let ordinary = x.abs().simd_le(guard)
            & y.abs().simd_le(guard)
            & inverse_depth.simd_ge(constant(*Self::RANGE.start()))
            & inverse_depth.simd_le(constant(*Self::RANGE.end()));
        let behind = at[2].simd_lt(reach * -Self::DOUBT) & guard.simd_ge(constant(0.0));
        let [x, y, inverse_depth] = self.pixels(simd, at);
        let [awkward_x, awkward_y, awkward, _] = Vertex::AWKWARD.0.map(f64::from);
        let other = behind.select(constant(Vertex::BEHIND.into()), constant(awkward));
        let known = ordinary | behind;
        [
            known.select(x, constant(awkward_x)),
            known.select(y, constant(awkward_y)),
            ordinary.select(inverse_depth, other),
        ]
    }

    /// x, y and inverse depth of eight points given along the camera's axes.
    #[inline(always)]
    pub(super) fn pixels<S: Simd>(&self, simd: S, [x, y, z]: Vectors<S>) -> Vectors<S> {
        let inverse_depth = f64x8::splat(simd, 1.0) / z;
        let x = (x * inverse_depth) * self.scale + self.axis_pixels.x;
        let y = (y * inverse_depth) * -self.scale + self.axis_pixels.y;
        [x, y, inverse_depth]
    }
}

/// The factors that bound the edge functions of a view: `edge_error` · ρⱼ ρₖ, where ρ is the reach of a vertex.
#[derive(Clone, Copy, Debug)]
struct EdgeBounds {
    extent: f64,
    edge_error: f64,
    reach_per_unit: f64,
    least_reach: f64,
}

impl EdgeBounds {
    /// Bounds that make nothing certain.
    const NONE: Self = Self { extent: 1.0, edge_error: f64::INFINITY, reach_per_unit: 1.0, least_reach: 1.0 };

    /// Bounds for `scale` pixels a unit of x/z, and samples and axis at most `farthest` from the middle.
    fn of_perspective(scale: f64, farthest: DVec2) -> Self {
        let extent = scale + farthest.x + farthest.y + 64.0;
        let steepness = 1.0 + (farthest.x + farthest.y) / scale;
        let edge_error = PixelSpace::RELATIVE_EDGE_ERROR * extent * extent * steepness;
        Self { extent, edge_error, reach_per_unit: 1.0, least_reach: 0.0 }
    }

    /// Bounds for `scale` pixels a world unit, samples and axis at most `farthest` from the middle, and the eye `eye_reach`
    /// from the world's origin.
    ///
    /// Let s be the scale, T the extent (the sum of `farthest`), r the largest coordinate of a vertex relative to the eye, e
    /// that of the eye, and M = max(T, s r), all s r and T in pixels.
    /// - A vertex in pixels, s x + a, is wrong by s r 2⁻⁴⁵ (see [`PixelSpace::camera_point`]) and a few f64 roundings:
    ///   2⁻⁴⁴·⁹ s r + 2⁻⁵¹ T.
    /// - A ray's start has one rounding of e and seven of each of two axes' T/s on the way to each world coordinate, three
    ///   of which make one of the camera's: 2⁻⁵¹·⁴ s e + 2⁻⁴⁷·⁵ T pixels. Its direction is exact.
    /// - Together that is at most 2⁻⁴⁴·⁶ M + 2⁻⁵¹·⁴ s e. Vertices are at most 3.1 s r + T ≤ 4.1 M from a sample, so in the
    ///   edge function (Xⱼ − x)(Yₖ − y) − (Xₖ − x)(Yⱼ − y) it makes 16.4 Mⱼ Mₖ (2⁻⁴⁴·⁶ + 2⁻⁵¹·⁴ s e / T). Five roundings
    ///   on each path to its value add 2⁻⁴⁵ Mⱼ Mₖ.
    ///
    /// The sum is below Mⱼ Mₖ 2⁻⁴⁰ (1 + 2⁻⁷ s e / T) · 0.8; doubled as in [`PixelSpace::RELATIVE_EDGE_ERROR`].
    ///
    /// The reach ρ = M u / s turns into M, with any unit u. It must not be below r, by which
    /// [`HomogeneousTriangle`](super::homogeneous::HomogeneousTriangle) bounds depths, nor below one. With T/s the image's extent in world units, u
    /// is the least unit for which it isn't. So depths are wrong by at most three of `HomogeneousTriangle`'s four Σ bounds · ρ / area:
    /// 1.6 for the edge functions (z ≤ 3.1 r, and half of each bound is true), 0.6 for the depths (edge functions are below
    /// 34 Mⱼ Mₖ, and depths wrong by 2⁻⁴⁵ r), and far below one for the ray's start (the area is below 34 Σ Mⱼ Mₖ). For
    /// views far narrower than one unit this bounds depths poorly, and much is left to the predicate.
    fn of_orthographic(scale: f64, farthest: DVec2, eye_reach: f64) -> Self {
        let extent = farthest.x + farthest.y;
        let across = extent / scale;
        let unit = across.min(1.0);
        let relative = PixelSpace::RELATIVE_EDGE_ERROR * (1.0 + eye_reach / across / 128.0);
        let pixels = scale * unit;
        Self {
            extent,
            edge_error: relative * pixels * pixels,
            reach_per_unit: unit.recip(),
            least_reach: across / unit,
        }
    }

    /// Whether all numbers are normal and positive; the least reach may be zero.
    fn is_usable(&self) -> bool {
        [self.extent, self.edge_error, self.reach_per_unit].iter().all(|bound| bound.is_normal())
            && self.least_reach.is_finite()
    }
}

fn dot(a: DVec3, b: DVec3) -> f64 {
    a.x * b.x + a.y * b.y + a.z * b.z
}
