//! Rows of the film that one thread shades, and the values that it adds.

use std::array;

use glam::{Vec3, Vec4};
use umbrage_rays::TileOrder;

use super::onward::Onward;
use crate::Film;
use crate::shade::Block;
use crate::shade::lanes::{Each, LANES, lanes_of, put, vector_of};

/// Radiance that is shown without exposure and tone map.
pub(super) struct Flat {
    pub(super) color: [Each<f32>; 3],
    /// Share of the pixel.
    pub(super) part: Each<f32>,
}

/// Shading of a block's camera rays.
pub(super) struct Shaded {
    /// Radiance, without that of secondary rays.
    pub(super) color: [Each<f32>; 3],
    pub(super) flat: Option<Flat>,
    /// Coverage: the hidden part of the background.
    pub(super) coverage: Each<f32>,
    /// The lanes with a hit; the fields below hold nothing in the others.
    pub(super) shown: u16,
    pub(super) depth: Each<f32>,
    pub(super) normal: [Each<f32>; 3],
    pub(super) triangle: Each<u32>,
}

impl Flat {
    /// Clears all other lanes.
    pub(super) fn only(mut self, lanes: u16) -> Self {
        for lane in lanes_of(!lanes) {
            put(lane, Vec3::ZERO, &mut self.color);
            self.part[lane] = 0.0;
        }
        self
    }

    fn of_lane(&self, lane: usize) -> Vec4 {
        vector_of(lane, &self.color).extend(self.part[lane])
    }
}

impl Shaded {
    pub(super) const NOTHING: Self = Self {
        color: [[0.0; LANES]; 3],
        flat: None,
        coverage: [0.0; LANES],
        shown: 0,
        depth: [0.0; LANES],
        normal: [[0.0; LANES]; 3],
        triangle: [0; LANES],
    };
}

/// Some rows of the film, as many as a block has.
pub(super) struct Strip<'a> {
    pub(super) color: &'a mut [Vec4],
    pub(super) flat: Option<&'a mut [Vec4]>,
    pub(super) depth: &'a mut [f32],
    pub(super) normal: &'a mut [Vec3],
    pub(super) triangle: &'a mut [u32],
}

impl Strip<'_> {
    pub(super) fn clear(&mut self) {
        self.color.fill(Vec4::ZERO);
        self.flat.iter_mut().for_each(|flat| flat.fill(Vec4::ZERO));
        self.depth.fill(f32::INFINITY);
        self.normal.fill(Vec3::ZERO);
        self.triangle.fill(Film::NO_TRIANGLE);
    }

    /// Adds radiance and coverage to a pixel.
    pub(super) fn add(&mut self, pixel: u32, radiance: Vec3, coverage: f32) {
        self.color[pixel as usize] += radiance.extend(coverage);
    }

    /// Adds to a pixel of [`Film::flat`].
    pub(super) fn add_flat(&mut self, pixel: u32, flat: Vec4) {
        self.flat.iter_mut().for_each(|sum| sum[pixel as usize] += flat);
    }

    /// Adds a light's contribution. Its `coverage` is 0, or negative on a surface that catches shadows.
    pub(super) fn add_light(&mut self, pixel: u32, radiance: Vec3, coverage: f32, is_flat_around: bool) {
        self.add(pixel, radiance, coverage);
        if let Some(flat) = self.flat.as_mut().filter(|_| is_flat_around && coverage != 0.0) {
            flat[pixel as usize] += radiance.extend(-coverage);
        }
    }

    pub(super) fn add_lanes(
        &mut self,
        onward: &[Onward],
        color: &[Each<f32>; 3],
        flat: Option<&Flat>,
        coverage: &Each<f32>,
    ) {
        for (lane, onward) in onward.iter().enumerate() {
            self.add(onward.path.pixel, vector_of(lane, color), coverage[lane]);
            if let (Some(sum), Some(flat)) = (&mut self.flat, flat) {
                sum[onward.path.pixel as usize] += flat.of_lane(lane);
            }
        }
    }

    pub(super) fn add_block(&mut self, block: &Block<'_>, shaded: &Shaded) {
        const COLUMNS: usize = TileOrder::BLOCK as usize;
        let pixels: Each<usize> = array::from_fn(|lane| {
            let [column, row] = block.pixel(lane);
            ((row - block.corner[1]) * block.view.width + column) as usize
        });
        if block.pixels() == u16::MAX {
            for first in (0..LANES).step_by(COLUMNS) {
                let row = &mut self.color[pixels[first]..][..COLUMNS];
                for (lane, color) in (first..).zip(row) {
                    *color += vector_of(lane, &shaded.color).extend(shaded.coverage[lane]);
                }
            }
        } else {
            for lane in lanes_of(block.pixels()) {
                self.color[pixels[lane]] += vector_of(lane, &shaded.color).extend(shaded.coverage[lane]);
            }
        }
        if let (Some(sum), Some(flat)) = (&mut self.flat, &shaded.flat) {
            lanes_of(block.pixels()).for_each(|lane| sum[pixels[lane]] += flat.of_lane(lane));
        }
        if block.sample.index == 0 {
            for lane in lanes_of(shaded.shown) {
                let pixel = pixels[lane];
                self.depth[pixel] = shaded.depth[lane];
                self.normal[pixel] = vector_of(lane, &shaded.normal);
                self.triangle[pixel] = shaded.triangle[lane];
            }
        }
    }
}
