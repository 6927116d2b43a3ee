use std::time::Instant;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f32x16, f64x8};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::lanes::{LANES, Vectors, absolute, dot, largest, minus, splat_vector, widen};
use super::{LightGrid, SeenImage};
use crate::grid::{SeenPixels, TileOrder};
use crate::predicate::crossing;
use crate::{Camera, Projection};

/// Pixels that share a box.
pub(super) const CHUNK_PIXELS: usize = 1024;

/// Half the distance from one to the next f64.
const ROUNDING: f64 = f64::EPSILON / 2.0;

/// How wrong a point's distance may be, in relation to it.
pub(super) const RELATIVE_ERROR: f64 = 1.0 / (1_u64 << 38) as f64;

/// Where along its camera ray each point is.
#[derive(Default)]
pub(super) struct Points {
    /// For each pixel the t of its ray, wrong by at most [`RELATIVE_ERROR`]; NaN where there is no point.
    pub(super) t: Vec<f64>,
    /// For each [`CHUNK_PIXELS`] pixels the box around their points.
    pub(super) boxes: Vec<PointBox>,
    pub(super) rays: CameraRays,
}

impl Points {
    pub(super) fn bytes(&self) -> usize {
        self.t.capacity() * size_of::<f64>() + self.boxes.capacity() * size_of::<PointBox>()
    }
}

/// The bounds of some points, to within their own rounding.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PointBox {
    pub(super) min: DVec3,
    pub(super) max: DVec3,
    pub(super) points: u32,
}

impl LightGrid {
    /// Finds the points that `image` shows; call it before [`LightGrid::shadow`], once for all lights.
    ///
    /// # Panics
    /// If `image.seen` isn't of the size of `image.view`.
    pub fn locate(&mut self, image: &SeenImage<'_>) {
        let start = Instant::now();
        let pixels = image.seen.triangle.len();
        let (size, seen) = ((image.view.width, image.view.height), image.seen.order().size());
        assert!(seen == size, "an image of {seen:?} pixels seen through a view of {size:?}");
        let Points { t, boxes, rays } = &mut self.points;
        *rays = CameraRays::new(image);
        t.resize(pixels, f64::NAN);
        boxes.resize(pixels.div_ceil(CHUNK_PIXELS), PointBox::default());
        let (level, rays) = (self.level.0, &*rays);
        t.par_chunks_mut(CHUNK_PIXELS).zip(boxes).enumerate().for_each(|(chunk, (t, bounds))| {
            let first = chunk * CHUNK_PIXELS;
            dispatch!(level, simd => locate(simd, image, rays, first, t));
            *bounds = dispatch!(level, simd => bound(simd, rays, first, t));
        });
        self.seconds.locate = start.elapsed().as_secs_f64();
    }
}

/// The constants of [`View::ray`](crate::View::ray).
#[derive(Clone, Copy, Default)]
pub(super) struct CameraRays {
    position: DVec3,
    /// What one pixel to the right adds to a perspective direction or an orthographic origin.
    step_x: DVec3,
    /// What one pixel downwards adds to it.
    step_y: DVec3,
    /// What it is at pixel (0, 0).
    corner: DVec3,
    forward: DVec3,
    is_perspective: bool,
    order: TileOrder,
    /// Largest component of any direction.
    pub(super) largest_direction: f64,
    /// Largest coordinate of any origin.
    pub(super) largest_origin: f64,
}

impl CameraRays {
    fn new(image: &SeenImage<'_>) -> Self {
        let Camera { position, right, up, forward, projection } = image.view.camera;
        let (width, height) = (f64::from(image.view.width), f64::from(image.view.height));
        let (is_perspective, half_height) = match projection {
            Projection::Perspective { tan_half_height } => (true, f64::from(tan_half_height)),
            Projection::Orthographic { half_height } => (false, f64::from(half_height)),
        };
        let step_x = right.as_dvec3() * (2.0 * half_height / height);
        let step_y = up.as_dvec3() * (-2.0 * half_height / height);
        let [offset_x, offset_y] = image.offset_pixels.to_array();
        let base = if is_perspective { forward.as_dvec3() } else { position.as_dvec3() };
        let corner = base + step_x * (offset_x - 0.5 * width) + step_y * (offset_y - 0.5 * height);
        // Twice the half width and height, which also covers offsets of up to half the image.
        let across = (step_x.abs() * (width + offset_x.abs()) + step_y.abs() * (height + offset_y.abs())).max_element();
        let (position, forward) = (position.as_dvec3(), forward.as_dvec3());
        let (origin, direction) = (position.abs().max_element(), forward.abs().max_element());
        Self {
            position,
            step_x,
            step_y,
            corner,
            forward,
            is_perspective,
            order: image.seen.order(),
            largest_direction: if is_perspective { direction + across } else { direction },
            largest_origin: if is_perspective { origin } else { origin + across },
        }
    }

    /// About the t of the ray through a world position.
    pub(super) fn depth(&self, position: DVec3) -> f64 {
        self.forward.dot(position - self.position)
    }

    /// Origins and directions of the rays of the eight places from `first`, half a block.
    ///
    /// Each component has four roundings: it is wrong by at most 4 × [`ROUNDING`] × the largest one.
    #[inline(always)]
    pub(super) fn eight<S: Simd>(&self, simd: S, first: usize) -> (Vectors<S>, Vectors<S>) {
        const COLUMNS: [f64; 8] = [0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0];
        const ROWS: [f64; 8] = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
        let (x, y) = self.order.column_and_row(first);
        let columns = f64x8::simd_from(simd, COLUMNS) + f64::from(x);
        let rows = f64x8::simd_from(simd, ROWS) + f64::from(y);
        let (step_x, step_y) = (splat_vector(simd, self.step_x), splat_vector(simd, self.step_y));
        let corner = splat_vector(simd, self.corner);
        let varying = [
            step_x[0].mul_add(columns, step_y[0].mul_add(rows, corner[0])),
            step_x[1].mul_add(columns, step_y[1].mul_add(rows, corner[1])),
            step_x[2].mul_add(columns, step_y[2].mul_add(rows, corner[2])),
        ];
        if self.is_perspective {
            (splat_vector(simd, self.position), varying)
        } else {
            (varying, splat_vector(simd, self.forward))
        }
    }
}

/// The distances of the points of a chunk of pixels from `first`.
#[inline(always)]
fn locate<S: Simd>(simd: S, image: &SeenImage<'_>, rays: &CameraRays, first: usize, t: &mut [f64]) {
    for (group, t) in t.chunks_mut(LANES).enumerate() {
        let first = first + group * LANES;
        let ids = &image.seen.triangle[first..first + t.len()];
        if ids.iter().all(|&id| id == SeenPixels::NONE) {
            t.fill(f64::NAN);
            continue;
        }
        let corners = Corners::load(simd, image, ids);
        for (half, t) in t.chunks_mut(8).enumerate() {
            let first = first + half * 8;
            let (origin, direction) = rays.eight(simd, first);
            let (found, certain) = corners.distances(simd, rays, half, origin, direction);
            t.copy_from_slice(&found.to_array()[..t.len()]);
            let mut uncertain = !certain.to_bitmask() & ((1 << t.len()) - 1);
            while uncertain != 0 {
                let lane = uncertain.trailing_zeros() as usize;
                uncertain &= uncertain - 1;
                t[lane] = exact_distance(image, first + lane);
            }
        }
    }
}

/// The box around the points of a chunk of pixels from `first`.
#[inline(always)]
fn bound<S: Simd>(simd: S, rays: &CameraRays, first: usize, t: &[f64]) -> PointBox {
    let infinity = f64x8::splat(simd, f64::INFINITY);
    let (mut min, mut max) = ([infinity; 3], [-infinity; 3]);
    let mut points = 0;
    for (group, t) in t.chunks(8).enumerate() {
        let (origin, direction) = rays.eight(simd, first + group * 8);
        let mut padded = [f64::NAN; 8];
        padded[..t.len()].copy_from_slice(t);
        let t = f64x8::simd_from(simd, padded);
        let is_point = t.simd_eq(t);
        points += is_point.to_bitmask().count_ones();
        for axis in 0..3 {
            let position = t.mul_add(direction[axis], origin[axis]);
            min[axis] = is_point.select(min[axis].min(position), min[axis]);
            max[axis] = is_point.select(max[axis].max(position), max[axis]);
        }
    }
    PointBox {
        min: DVec3::new(min[0].reduce_min(), min[1].reduce_min(), min[2].reduce_min()),
        max: DVec3::new(max[0].reduce_max(), max[1].reduce_max(), max[2].reduce_max()),
        points,
    }
}

/// The predicate's distance of a pixel's point; NaN where there is none.
#[cold]
fn exact_distance(image: &SeenImage<'_>, pixel: usize) -> f64 {
    let id = image.seen.triangle[pixel];
    let Some(corners) = (id != SeenPixels::NONE).then(|| image.triangles.usable_corners(id).ok()).flatten() else {
        return f64::NAN;
    };
    crossing(&image.camera_ray(pixel), corners).map_or(f64::NAN, |crossing| crossing.t)
}

#[inline(always)]
fn halves<S: Simd>(simd: S, [x, y, z]: [[f32; LANES]; 3]) -> [Vectors<S>; 2] {
    widen([f32x16::simd_from(simd, x), f32x16::simd_from(simd, y), f32x16::simd_from(simd, z)])
}

/// Corners of 16 pixels' triangles.
struct Corners<S: Simd> {
    /// For each corner, in two halves.
    halves: [[Vectors<S>; 2]; 3],
}

impl<S: Simd> Corners<S> {
    #[inline(always)]
    fn load(simd: S, image: &SeenImage<'_>, ids: &[u32]) -> Self {
        let mut positions = [[[f32::NAN; LANES]; 3]; 3];
        for (lane, &id) in ids.iter().enumerate() {
            let Some(triangle) = image.triangles.indices.get(id as usize) else { continue };
            for (corner, &vertex) in positions.iter_mut().zip(triangle) {
                let position = image.triangles.positions.get(vertex as usize).copied().unwrap_or(Vec3::NAN);
                corner[0][lane] = position.x;
                corner[1][lane] = position.y;
                corner[2][lane] = position.z;
            }
        }
        let [a, b, c] = positions;
        Self { halves: [halves(simd, a), halves(simd, b), halves(simd, c)] }
    }

    /// The distances of eight pixels, and for which of them they are wrong by at most [`RELATIVE_ERROR`].
    ///
    /// t = n · (a − o) / n · d with n = (b − a) × (c − a). A component of n has four roundings of its two products, the
    /// product with the other vector one more for each, the vector one, the sum two: eight, taken as sixteen. The ray
    /// itself is wrong by 4 roundings of its largest component.
    #[inline(always)]
    fn distances(
        &self,
        simd: S,
        rays: &CameraRays,
        half: usize,
        origin: Vectors<S>,
        direction: Vectors<S>,
    ) -> (f64x8<S>, fearless_simd::mask64x8<S>) {
        let [a, b, c] = [self.halves[0][half], self.halves[1][half], self.halves[2][half]];
        let (ab, ac, towards) = (minus(b, a), minus(c, a), minus(a, origin));
        let first = [ab[1] * ac[2], ab[2] * ac[0], ab[0] * ac[1]];
        let second = [ab[2] * ac[1], ab[0] * ac[2], ab[1] * ac[0]];
        let normal = minus(first, second);
        let (first, second) = (absolute(first), absolute(second));
        let magnitude = [first[0] + second[0], first[1] + second[1], first[2] + second[2]];
        let sum = magnitude[0] + magnitude[1] + magnitude[2];
        let (height, slope) = (dot(normal, towards), dot(normal, direction));
        let height_error =
            dot(magnitude, absolute(towards)) * (16.0 * ROUNDING) + sum * (4.0 * ROUNDING * rays.largest_origin);
        let slope_error =
            dot(magnitude, absolute(direction)) * (16.0 * ROUNDING) + sum * (4.0 * ROUNDING * rays.largest_direction);
        let t = height / slope;
        let bound = height.abs() * slope.abs() * RELATIVE_ERROR;
        let certain = (height_error * slope.abs() + slope_error * height.abs()).simd_le(bound);
        // Products that underflow have lost their bound.
        let trusted =
            largest([height, slope, t]).simd_lt(f64x8::splat(simd, 1e200)) & bound.simd_gt(f64x8::splat(simd, 1e-250));
        (t, certain & trusted)
    }
}
