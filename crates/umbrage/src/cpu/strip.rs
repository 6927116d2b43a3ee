//! Rows of the film that one thread shades, and the values that it adds.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16, u32x16};
use glam::{Vec3, Vec4};
use umbrage_rays::TileOrder;
use umbrage_rays::simd::lanes::quads;

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
    /// `None` without [`Settings::first_hits`](crate::Settings::first_hits).
    pub(super) hits: Option<FirstHits<'a>>,
}

/// Rows of the film's first hits.
pub(super) struct FirstHits<'a> {
    pub(super) depth: &'a mut [f32],
    pub(super) normal: &'a mut [Vec3],
    pub(super) triangle: &'a mut [u32],
}

impl Strip<'_> {
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

    /// Adds a block of pixels. Their first samples take the place of an earlier picture.
    #[inline(always)]
    pub(super) fn add_block<S: Simd>(&mut self, simd: S, block: &Block<'_>, shaded: &Shaded) {
        let is_first = block.sample.index == 0;
        let [red, green, blue] = &shaded.color;
        let color = quads([
            f32x16::from_slice(simd, red),
            f32x16::from_slice(simd, green),
            f32x16::from_slice(simd, blue),
            f32x16::from_slice(simd, &shaded.coverage),
        ]);
        let first = block.corner.x as usize;
        let width = block.view.width as usize;
        let columns = width.saturating_sub(first).min(COLUMNS);
        let rows = self.color.chunks_mut(width).zip(color).map(|(row, color)| (&mut row[first..], color));
        for (row, color) in rows {
            let color: [f32; LANES] = color.into();
            for (pixel, color) in row.iter_mut().zip(color.as_chunks().0).take(columns) {
                let color = Vec4::from_array(*color);
                *pixel = if is_first { color } else { *pixel + color };
            }
        }
        if let Some(sum) = &mut self.flat {
            let lanes = shaded.flat.iter().flat_map(|flat| (0..LANES).map(|lane| flat.of_lane(lane)));
            let mut of_lanes = [Vec4::ZERO; LANES];
            of_lanes.iter_mut().zip(lanes).for_each(|(to, flat)| *to = flat);
            for (row, flat) in sum.chunks_mut(width).zip(of_lanes.chunks(COLUMNS)) {
                for (pixel, flat) in row[first..].iter_mut().zip(flat).take(columns) {
                    *pixel = if is_first { *flat } else { *pixel + *flat };
                }
            }
        }
        if let (Some(hits), true) = (&mut self.hits, is_first) {
            hits.store(simd, shaded, [first, columns, width]);
        }
    }
}

impl FirstHits<'_> {
    /// Stores a block.
    #[inline(always)]
    fn store<S: Simd>(&mut self, simd: S, shaded: &Shaded, [first, columns, width]: [usize; 3]) {
        let shown = mask32x16::from_bitmask(simd, shaded.shown.into());
        let (zero, far) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, f32::INFINITY));
        let depth: Each<f32> = shown.select(f32x16::from_slice(simd, &shaded.depth), far).into();
        let none = u32x16::splat(simd, Film::NO_TRIANGLE);
        let triangle: Each<u32> = shown.select(u32x16::from_slice(simd, &shaded.triangle), none).into();
        let [x, y, z] = &shaded.normal;
        let normals = quads([
            shown.select(f32x16::from_slice(simd, x), zero),
            shown.select(f32x16::from_slice(simd, y), zero),
            shown.select(f32x16::from_slice(simd, z), zero),
            zero,
        ]);
        for (row, depth) in self.depth.chunks_mut(width).zip(depth.as_chunks().0) {
            copy_pixels(&mut row[first..first + columns], depth);
        }
        for (row, triangle) in self.triangle.chunks_mut(width).zip(triangle.as_chunks().0) {
            copy_pixels(&mut row[first..first + columns], triangle);
        }
        for (row, normals) in self.normal.chunks_mut(width).zip(normals) {
            let normals: [f32; LANES] = normals.into();
            for (pixel, normal) in row[first..].iter_mut().zip(normals.chunks(4)).take(columns) {
                *pixel = Vec3::from_slice(normal);
            }
        }
    }
}

const COLUMNS: usize = TileOrder::BLOCK as usize;

/// Copies a row of a block to its pixels; fewer where the image ends.
#[inline(always)]
fn copy_pixels<T: Copy>(to: &mut [T], from: &[T; COLUMNS]) {
    match <&mut [T; COLUMNS]>::try_from(&mut *to) {
        Ok(all) => *all = *from,
        Err(_) => to.iter_mut().zip(from).for_each(|(to, from)| *to = *from),
    }
}
