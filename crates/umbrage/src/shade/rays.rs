use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8};
use glam::UVec2;
use umbrage_rays::{Projection, Ray, TileOrder, View};

use super::lanes::{Each, LANES, Vectors, Wide};
use crate::sampling::Sample;

/// A block of pixels in [`TileOrder`] at one sample.
#[derive(Clone, Copy)]
pub(crate) struct Block<'a> {
    pub(crate) view: &'a View,
    pub(crate) sample: &'a Sample,
    /// Column and row of its upper left pixel.
    // Not an array, which would be loaded whole right after its halves are stored, and wait for all stores before.
    pub(crate) corner: UVec2,
}

impl Block<'_> {
    /// Column and row of a lane's pixel; beyond the image's border for a lane without a pixel.
    #[inline(always)]
    pub(crate) fn pixel(&self, lane: usize) -> [u32; 2] {
        let UVec2 { x, y } = self.corner;
        [x + lane as u32 % TileOrder::BLOCK, y + lane as u32 / TileOrder::BLOCK]
    }

    /// The lanes with a pixel, the first in the lowest bit.
    #[inline(always)]
    pub(crate) fn pixels(&self) -> u16 {
        let [columns, rows] = [self.view.width - self.corner.x, self.view.height - self.corner.y];
        let in_row = 0xf_u16 >> TileOrder::BLOCK.saturating_sub(columns);
        (in_row * 0x1111) & (u16::MAX >> (TileOrder::BLOCK * TileOrder::BLOCK.saturating_sub(rows)))
    }

    /// The camera ray of a lane's pixel.
    pub(crate) fn ray(&self, lane: usize) -> Ray {
        let [x, y] = self.pixel(lane);
        self.sample.ray(self.view, x, y)
    }
}

/// Sixteen rays, eight by eight.
#[derive(Clone, Copy)]
pub(crate) struct BlockRays<S: Simd> {
    pub(super) origin: [Wide<S>; 2],
    pub(super) direction: [Wide<S>; 2],
    /// Unit vectors towards the origin.
    pub(super) towards_origin: Vectors<S>,
    /// Distance from the origin to the camera, by way of mirrors.
    pub(crate) travelled: f32x16<S>,
}

impl<S: Simd> BlockRays<S> {
    /// The camera rays of a block of pixels: bit for bit those of [`Sample::ray`].
    #[inline(always)]
    pub(crate) fn new(simd: S, block: &Block<'_>) -> Self {
        let (right_by, up_by) = steps(simd, block);
        let low = eight_rays(simd, block, right_by, up_by[0]);
        let high = eight_rays(simd, block, right_by, up_by[1]);
        let direction = [low.1, high.1];
        let backwards = -Vectors::narrow(direction);
        let towards_origin = backwards.scaled(1.0 / backwards.length());
        Self { origin: [low.0, high.0], direction, towards_origin, travelled: f32x16::splat(simd, 0.0) }
    }

    /// Any rays, of about unit length.
    #[inline(always)]
    pub(crate) fn of_rays(simd: S, rays: &Each<Ray>, travelled: f32x16<S>) -> Self {
        let [[o0, o1], [d0, d1]] = lanes_of_rays(rays);
        let origin = [Wide::load(simd, &o0), Wide::load(simd, &o1)];
        let direction = [Wide::load(simd, &d0), Wide::load(simd, &d1)];
        let backwards = -Vectors::narrow(direction);
        let towards_origin = backwards.scaled(1.0 / backwards.length());
        Self { origin, direction, towards_origin, travelled }
    }

    /// Unit directions of the rays.
    #[inline(always)]
    pub(crate) fn unit_direction(&self) -> Vectors<S> {
        -self.towards_origin
    }
}

/// Origins and directions, in halves, by axis.
fn lanes_of_rays(rays: &Each<Ray>) -> [[[[f64; LANES / 2]; 3]; 2]; 2] {
    let mut lanes = [[[[0.0; LANES / 2]; 3]; 2]; 2];
    for (lane, ray) in rays.iter().enumerate() {
        for (halves, vector) in lanes.iter_mut().zip([ray.origin, ray.direction]) {
            let half = &mut halves[lane / (LANES / 2)];
            half.iter_mut().zip(vector.to_array()).for_each(|(axis, value)| axis[lane % (LANES / 2)] = value);
        }
    }
    lanes
}

/// The steps to the right of a block's columns, twice, and the steps up of its first two rows and its last two.
#[inline(always)]
fn steps<S: Simd>(simd: S, block: &Block<'_>) -> (f64x8<S>, [f64x8<S>; 2]) {
    // Columns, then rows, so that one division serves both.
    const AT: [f64; LANES / 2] = [0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0];
    let Block { view, sample, corner: UVec2 { x, y } } = *block;
    let [width, height] = [view.width, view.height].map(f64::from);
    let half = |column: f64, row: f64| f64x8::from_slice(simd, &[column, column, column, column, row, row, row, row]);
    let at = f64x8::from_slice(simd, &AT) + half(f64::from(x), f64::from(y));
    let twice = (at + half(sample.offset_pixels.x, sample.offset_pixels.y)) * 2.0;
    let half_height = match view.camera.projection {
        Projection::Perspective { tan_half_height } => tan_half_height,
        Projection::Orthographic { half_height } => half_height,
    };
    // Rows count downwards; a sign changes no rounding.
    let by = (twice - half(width, height)) / half(height, -height) * f64::from(half_height);
    let [a, b, c, d, e, f, g, h]: [f64; LANES / 2] = by.into();
    let right_by = f64x8::from_slice(simd, &[a, b, c, d, a, b, c, d]);
    let [upper, lower] = [[e, e, e, e, f, f, f, f], [g, g, g, g, h, h, h, h]];
    (right_by, [f64x8::from_slice(simd, &upper), f64x8::from_slice(simd, &lower)])
}

/// Origins and directions of two rows of a block.
#[inline(always)]
fn eight_rays<S: Simd>(simd: S, block: &Block<'_>, right_by: f64x8<S>, up_by: f64x8<S>) -> (Wide<S>, Wide<S>) {
    let camera = &block.view.camera;
    let right = Wide::splat(simd, camera.right.as_dvec3()).scaled(right_by);
    let across = right + Wide::splat(simd, camera.up.as_dvec3()).scaled(up_by);
    let position = Wide::splat(simd, camera.position.as_dvec3());
    let forward = Wide::splat(simd, camera.forward.as_dvec3());
    match camera.projection {
        Projection::Perspective { .. } => (position, forward + across),
        Projection::Orthographic { .. } => (position + across, forward),
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};
    use umbrage_rays::Camera;
    use umbrage_rays::{SimdLevel, dispatch};

    use super::*;

    #[test]
    fn rays_are_those_of_the_view_bit_for_bit() {
        let camera = Camera::look_at(Vec3::new(3.1, -1.7, 2.3), Vec3::new(0.2, 0.1, -0.4), Vec3::Y, 0.83);
        let parallel = Camera { projection: Projection::Orthographic { half_height: 1.7 }, ..camera };
        for camera in [camera, parallel] {
            let view = View { camera, width: 301, height: 203 };
            for sample in Sample::all(3) {
                let block = Block { view: &view, sample: &sample, corner: UVec2::new(132, 68) };
                let rays: [[Vec<[f64; 3]>; 2]; 2] = dispatch!(SimdLevel::default(), simd => {
                    let rays = BlockRays::new(simd, &block);
                    [rays.origin, rays.direction].map(|halves| halves.map(|half| {
                        (0..8).map(|lane| [half.x[lane], half.y[lane], half.z[lane]]).collect()
                    }))
                });
                for lane in 0..LANES {
                    let ray = sample.ray(&view, 132 + lane as u32 % 4, 68 + lane as u32 / 4);
                    assert_eq!(ray, block.ray(lane));
                    assert_eq!(DVec3::from(rays[0][lane / 8][lane % 8]), ray.origin, "lane {lane}");
                    assert_eq!(DVec3::from(rays[1][lane / 8][lane % 8]), ray.direction, "lane {lane}");
                }
            }
        }
    }

    #[test]
    fn pixels_beyond_the_border_are_none() {
        let camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 0.8);
        let sample = Sample::all(1).next().unwrap();
        for (width, height) in [(9, 6), (8, 8), (11, 7), (1, 1)] {
            let view = View { camera, width, height };
            for corner in (0..height).step_by(4).flat_map(|y| (0..width).step_by(4).map(move |x| UVec2::new(x, y))) {
                let block = Block { view: &view, sample: &sample, corner };
                for lane in 0..LANES {
                    let [x, y] = block.pixel(lane);
                    assert_eq!(block.pixels() >> lane & 1 == 1, x < width && y < height, "{x}, {y}");
                }
            }
        }
    }
}
