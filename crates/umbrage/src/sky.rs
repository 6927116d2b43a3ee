//! Light from the surroundings as lights in single directions, which can cast shadows.

use std::f64::consts::PI;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::{DVec2, Vec3};
use umbrage_rays::LightSource;
use umbrage_rays::{SimdLevel, dispatch};
use umbrage_scene::Light;

use crate::background::Surroundings;
use crate::shade::lanes::{Each, LANES, Vector, vector_of};

/// Rows and columns of cells that divide the sphere, all of one solid angle: 1.4° wide and 0.9° high at the horizon. Smaller
/// details are blurred to a cell.
const ROWS: usize = 128;
const COLUMNS: usize = 2 * ROWS;

/// The directions of light from the surroundings, drawn in proportion to their brightness.
#[derive(Debug)]
pub(crate) struct SkyLights {
    /// Running sums over rows of cells, of their share of all luminance.
    rows: Vec<f64>,
    /// The same in each row for its cells.
    cells: Vec<f64>,
    /// Mean radiance of each cell.
    radiance: Vec<Vec3>,
    /// Factor, per colour, by which the drawn directions' irradiance from above becomes that of unshadowed light.
    scale: Vec3,
}

impl SkyLights {
    /// The light of the surroundings, in directions drawn at `points` of the unit square; `None` for dark surroundings.
    pub(crate) fn new(surroundings: &Surroundings<'_>, points: impl Iterator<Item = DVec2>) -> Option<Self> {
        let radiance = dispatch!(SimdLevel::default(), simd => radiance_of_cells(simd, surroundings));
        let mut cells: Vec<f64> = radiance.iter().map(|radiance| f64::from(luminance(*radiance).max(0.0))).collect();
        let mut rows: Vec<f64> = cells.chunks_exact_mut(COLUMNS).map(sum_up).collect();
        if sum_up(&mut rows) <= 0.0 {
            return None;
        }
        let mut lights = Self { rows, cells, radiance, scale: Vec3::ONE };
        let (mut count, mut from_above) = (0.0, Vec3::ZERO);
        for point in points {
            let (towards, irradiance) = lights.drawn(point);
            count += 1.0;
            from_above += irradiance * towards.y.max(0.0);
        }
        let scale = surroundings.irradiance_from_above() * count / from_above;
        let is_known = scale.is_finite_mask() & scale.cmpgt(Vec3::ZERO);
        lights.scale = Vec3::select(is_known, scale, Vec3::ONE);
        Some(lights)
    }

    /// All light of the surroundings as one light, in a direction drawn at a point of the unit square.
    pub(crate) fn light(&self, point: DVec2) -> Light {
        let (towards, irradiance) = self.drawn(point);
        Light {
            name: "surroundings".into(),
            color: irradiance * self.scale,
            ..Light::new(LightSource::Directional { direction: -towards }, 1.0)
        }
    }

    /// A direction, and its estimate of the irradiance of a surface that faces it: the cell's radiance times its solid angle
    /// over its probability.
    fn drawn(&self, point: DVec2) -> (Vec3, Vec3) {
        const SOLID_ANGLE: f64 = 4.0 * PI / (ROWS * COLUMNS) as f64;
        let (row, down, of_row) = find(&self.rows, point.x);
        let (column, across, of_cell) = find(&self.cells[row * COLUMNS..][..COLUMNS], point.y);
        let radiance = self.radiance[row * COLUMNS + column];
        (direction(row as f64 + down, column as f64 + across), radiance * (SOLID_ANGLE / (of_row * of_cell)) as f32)
    }
}

/// Replaces parts by their running sums, scaled to end with one, and returns the sum.
fn sum_up(parts: &mut [f64]) -> f64 {
    let mut sum = 0.0;
    for part in &mut *parts {
        sum += *part;
        *part = sum;
    }
    if sum > 0.0 {
        parts.iter_mut().for_each(|part| *part /= sum);
    }
    sum
}

/// The part at a point from 0 to 1, from such running sums: its index, the position in it from 0 to 1, and its share of the
/// whole.
fn find(sums: &[f64], point: f64) -> (usize, f64, f64) {
    let index = sums.partition_point(|&sum| sum <= point).min(sums.len() - 1);
    let before = if index == 0 { 0.0 } else { sums[index - 1] };
    let part = sums[index] - before;
    (index, ((point - before) / part).clamp(0.0, 1.0), part)
}

/// The unit direction of a position in the cells, in rows from below and columns.
fn direction(row: f64, column: f64) -> Vec3 {
    let height = row / ROWS as f64 * 2.0 - 1.0;
    let radius = (1.0 - height * height).max(0.0).sqrt();
    let (sine, cosine) = libm::sincos(column / COLUMNS as f64 * 2.0 * PI);
    Vec3::new((radius * cosine) as f32, height as f32, (radius * sine) as f32).normalize()
}

#[inline(always)]
fn radiance_of_cells<S: Simd>(simd: S, surroundings: &Surroundings<'_>) -> Vec<Vec3> {
    let mut of_cells = Vec::with_capacity(ROWS * COLUMNS);
    for row in 0..ROWS {
        for first in (0..COLUMNS).step_by(LANES) {
            let middle = |lane: usize| direction(row as f64 + 0.5, (first + lane) as f64 + 0.5);
            let directions: [Vec3; LANES] = std::array::from_fn(middle);
            let axis = |axis: usize| f32x16::from_slice(simd, &directions.map(|direction| direction[axis]));
            let direction = Vector { x: axis(0), y: axis(1), z: axis(2) };
            let radiance: [Each<f32>; 3] = surroundings.mean(simd, direction, 1.0 / ROWS as f32).store();
            of_cells.extend((0..LANES).map(|lane| vector_of(lane, &radiance).max(Vec3::ZERO)));
        }
    }
    of_cells
}

/// Luminance of linear colours with Rec. 709's primaries.
fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}
