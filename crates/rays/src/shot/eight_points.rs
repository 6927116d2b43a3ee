use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8, mask64x8};
use glam::{DVec2, DVec3, Vec3};

use super::{CameraRays, SeenImage, SeenPixels};
use crate::Triangles;
use crate::predicate::{HitPoint, ROUNDING};
use crate::simd::vectors::{Vectors, absolute, dot, largest, minus, splat_vector, vectors};

/// The points that eight pixels show, found in f64 from the planes of their triangles.
pub struct EightPoints<S: Simd> {
    /// Offset from the light.
    pub offset: Vectors<S>,
    /// Bound on each axis for the distance to the predicate's point, `predicate_error` included, with 0.5 % to spare.
    pub error: f64x8<S>,
    /// The error that the predicate assumes for its own point.
    pub predicate_error: f64x8<S>,
    /// The lanes for which these bounds hold.
    pub certain: mask64x8<S>,
}

/// Corners of eight triangles; NaN where there is no such corner.
pub struct EightTriangles<S: Simd> {
    pub corners: [Vectors<S>; 3],
}

impl<S: Simd> EightTriangles<S> {
    #[inline(always)]
    pub fn load(simd: S, triangles: Triangles<'_>, ids: [u32; 8]) -> Self {
        let mut positions = [[[f64::NAN; 8]; 3]; 3];
        for (lane, id) in ids.into_iter().enumerate() {
            let Some(triangle) = triangles.indices.get(id as usize) else { continue };
            for (corner, &vertex) in positions.iter_mut().zip(triangle) {
                let position = triangles.positions.get(vertex as usize).copied().unwrap_or(Vec3::NAN);
                corner[0][lane] = f64::from(position.x);
                corner[1][lane] = f64::from(position.y);
                corner[2][lane] = f64::from(position.z);
            }
        }
        let [a, b, c] = positions;
        Self { corners: [vectors(simd, a), vectors(simd, b), vectors(simd, c)] }
    }
}

/// a × b, and the sums of the magnitudes of each component's two products.
#[inline(always)]
pub fn cross<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> (Vectors<S>, Vectors<S>) {
    let first = [a[1] * b[2], a[2] * b[0], a[0] * b[1]];
    let second = [a[2] * b[1], a[0] * b[2], a[1] * b[0]];
    let (first_size, second_size) = (absolute(first), absolute(second));
    let size = [first_size[0] + second_size[0], first_size[1] + second_size[1], first_size[2] + second_size[2]];
    (minus(first, second), size)
}

impl<S: Simd> EightPoints<S> {
    /// Known points, relative to `light`: only the difference and the corners of the predicate's box are rounded.
    #[inline(always)]
    pub fn new(simd: S, points: [HitPoint; 8], light: DVec3) -> Self {
        let mut positions = [[0.0; 8]; 3];
        for (lane, point) in points.iter().enumerate() {
            let [x, y, z] = point.position.to_array();
            (positions[0][lane], positions[1][lane], positions[2][lane]) = (x, y, z);
        }
        let positions = vectors(simd, positions);
        let predicate_error = f64x8::simd_from(simd, points.map(|point| point.error));
        let size = largest(positions);
        let offset = minus(positions, splat_vector(simd, light));
        let error = ((largest(offset) + size) * ROUNDING + predicate_error) * 1.01;
        Self { offset, error, predicate_error, certain: size.simd_lt(f64x8::splat(simd, 1e200)) }
    }

    /// Finds the points that the pixels at `indices` show, relative to `light`.
    ///
    /// t = n · (a − o) / n · d with n = (b − a) × (c − a). A component of n has four roundings of its two products, the
    /// product with the other vector one more, the sum two: seven, and a − o one of its own. A ray has up to seven roundings
    /// of its largest component, and the predicate's up to five: together they may differ by twelve, in the direction in
    /// perspective, else in the origin.
    ///
    /// With t known, the step along the ray is wrong by those twelve roundings and by three of quotient, product and sum.
    /// The predicate's step is wrong by four of t, product, sum and its box's corners. With that box, which is as wide as
    /// four roundings of step and position, these are 27. The origin's are no more: twelve, two of differences and sums, the
    /// predicate's two, the box's four. The light's are two.
    #[inline(always)]
    pub fn find(simd: S, image: &SeenImage<'_>, rays: &CameraRays, indices: [u32; 8], light: DVec3) -> Self {
        let own = EightTriangles::load(
            simd,
            image.shot.triangles,
            indices.map(|index| image.seen.triangle.get(index as usize).copied().unwrap_or(SeenPixels::NONE)),
        );
        let (origin, direction) = eight_rays(simd, rays, indices);
        let [a, b, c] = own.corners;
        let (normal, magnitude) = cross(minus(b, a), minus(c, a));
        let towards = minus(a, origin);
        let sum = magnitude[0] + magnitude[1] + magnitude[2];
        let (height, slope) = (dot(normal, towards), dot(normal, direction));
        let height_error =
            dot(magnitude, absolute(towards)) * (8.1 * ROUNDING) + sum * (12.1 * ROUNDING * rays.largest_origin);
        let slope_error = sum * (19.1 * ROUNDING * rays.largest_direction);
        let t = height / slope;
        let slope_size = slope.abs();
        // A slope error this far below the slope keeps the quotient's own error bounded.
        const SMALL: f64 = 1.0 / (1 << 10) as f64;
        let certain = slope_error.simd_lt(slope_size * SMALL);
        // |dt| = |dh − t ds| / |s + ds|.
        let distance = t.abs();
        let t_error = (height_error + distance * slope_error) / slope_size;
        let step = distance * rays.largest_direction;
        let from = minus(origin, splat_vector(simd, light));
        let offset =
            [t.mul_add(direction[0], from[0]), t.mul_add(direction[1], from[1]), t.mul_add(direction[2], from[2])];
        let largest_coordinate = rays.largest_origin + light.abs().max_element();
        let error = (t_error * rays.largest_direction + (step + largest_coordinate) * (27.0 * ROUNDING)) * 1.01;
        // The predicate's own step is longer by at most `error`.
        let predicate_error = ((step + error) * 2.0 + rays.largest_origin) * (4.1 * ROUNDING);
        Self { offset, error, predicate_error, certain }
    }
}

/// Origins and directions of the rays through eight pixels.
#[inline(always)]
fn eight_rays<S: Simd>(simd: S, rays: &CameraRays, indices: [u32; 8]) -> (Vectors<S>, Vectors<S>) {
    // Sums with shifts are exact.
    let pixels = indices.map(|index| {
        let (column, row) = rays.order.column_and_row(index as usize);
        DVec2::new(f64::from(column), f64::from(row)) + rays.shifts.at(column, row)
    });
    let columns = f64x8::simd_from(simd, pixels.map(|pixel| pixel.x));
    let rows = f64x8::simd_from(simd, pixels.map(|pixel| pixel.y));
    let (step_x, step_y) = (splat_vector(simd, rays.step_x), splat_vector(simd, rays.step_y));
    let corner = splat_vector(simd, rays.corner);
    let varying = [
        step_x[0].mul_add(columns, step_y[0].mul_add(rows, corner[0])),
        step_x[1].mul_add(columns, step_y[1].mul_add(rows, corner[1])),
        step_x[2].mul_add(columns, step_y[2].mul_add(rows, corner[2])),
    ];
    if rays.is_perspective {
        (splat_vector(simd, rays.position), varying)
    } else {
        (varying, splat_vector(simd, rays.forward))
    }
}

#[cfg(test)]
mod tests;
