use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3, Vec3};
use umbrage_rays::{Camera, Projection};

use crate::Band;

/// Pixel space of a camera's image, or of a face of a light's grid; as in `space.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Space {
    /// The origin, the matrix rows for x, y and depth, and the terms added to x and y; two words for each f64.
    projection: [[u32; 2]; 14],
    pub(crate) raster: Raster,
}

/// How a space is cut into cells.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Raster {
    pub(crate) columns: i32,
    pub(crate) rows: i32,
    pub(crate) fraction_bits: u32,
    pub(crate) tile_bits: u32,
    pub(crate) tile_columns: u32,
    pub(crate) tile_rows: u32,
    pub(crate) slices: u32,
    pub(crate) first_cell: u32,
    pub(crate) is_orthographic: u32,
    pub(crate) has_samples: u32,
    pub(crate) is_mirrored: u32,
    pub(crate) position_error: u32,
    row_reach: f32,
    pub(crate) sees_behind: u32,
    depth_error: f32,
    depth_bits: u32,
}

impl Space {
    /// Bytes of a space.
    pub(crate) const BYTES: u64 = size_of::<Self>() as u64;

    /// The image of a band whose samples are at `offset_pixels` of each pixel's upper left corner.
    pub(crate) fn of_band(band: &Band, offset_pixels: DVec2, tile_bits: u32, slices: u32) -> Self {
        let view = &band.view;
        let Camera { position, right, up, forward, projection } = view.camera;
        let [right, up, forward] = [right, up, forward].map(Vec3::as_dvec3);
        let determinant = right.dot(up.cross(forward));
        let [right, up, depth] =
            [up.cross(forward), forward.cross(right), right.cross(up)].map(|row| row / determinant);
        let size = DVec2::new(f64::from(view.width), f64::from(view.height));
        // Half of the range of i32 is for positions beside the image.
        let fraction_bits = 29 - view.width.max(view.height).next_power_of_two().trailing_zeros();
        let unit = f64::from(1_u32 << fraction_bits);
        let (half_height, is_orthographic) = match projection {
            Projection::Perspective { tan_half_height } => (tan_half_height, false),
            Projection::Orthographic { half_height } => (half_height, true),
        };
        let scale = unit * size.y / (2.0 * f64::from(half_height));
        let first_row = DVec2::new(0.0, f64::from(band.rows.start));
        let middle = (0.5 * size - offset_pixels - first_row) * unit;
        let rows_of_band = band.rows.len() as u32;
        let (rows, added) = if is_orthographic {
            ([right * scale, up * -scale, depth], middle)
        } else {
            ([right * scale + depth * middle.x, up * -scale + depth * middle.y, depth], DVec2::ZERO)
        };
        let row_reach = rows[0].abs().max_element().max(rows[1].abs().max_element());
        // Fixed-point positions are below 2³⁰ units on each axis, depths have an error of 2⁻⁴⁹ of that; doubled for
        // comparisons.
        let depth_error = if is_orthographic { 2.0_f64.powi(32 - 49) / scale } else { 0.0 };
        // A vertex whose largest coordinate is at most 2ᵏ times its depth has an error of `row_reach` · 2ᵏ⁻⁴⁹ units: an
        // eighth at most, with k from 1 to 12; more for telescopes alone.
        let spare_bits = (46.0 - row_reach.log2()).floor();
        let telescope_error = if is_orthographic || spare_bits >= 1.0 { 0.0 } else { (1.0 - spare_bits).exp2() };
        let tile = 1 << tile_bits;
        let raster = Raster {
            columns: view.width as i32,
            rows: rows_of_band as i32,
            fraction_bits,
            tile_bits,
            tile_columns: view.width.div_ceil(tile),
            tile_rows: rows_of_band.div_ceil(tile),
            slices,
            first_cell: 0,
            is_orthographic: u32::from(is_orthographic),
            has_samples: 1,
            is_mirrored: u32::from(determinant > 0.0),
            position_error: telescope_error.min(f64::from(1 << 28)) as u32,
            row_reach: row_reach.min(f64::from(f32::MAX)) as f32,
            sees_behind: 0,
            depth_error: depth_error.min(f64::from(f32::MAX)) as f32,
            depth_bits: spare_bits.clamp(1.0, 12.0) as u32,
        };
        Self { projection: packed(position.as_dvec3(), rows, added), raster }
    }

    /// Number of cells.
    pub(crate) fn cells(&self) -> u32 {
        self.raster.tile_columns * self.raster.tile_rows * self.raster.slices
    }
}

fn packed(origin: DVec3, rows: [DVec3; 3], added: DVec2) -> [[u32; 2]; 14] {
    let mut projection = [[0; 2]; 14];
    let numbers = origin.to_array().into_iter().chain(rows.into_iter().flat_map(|row| row.to_array()));
    for (pair, number) in projection.iter_mut().zip(numbers.chain(added.to_array())) {
        *pair = words(number);
    }
    projection
}

/// The two words of an f64, the low one first.
pub(crate) fn words(number: f64) -> [u32; 2] {
    let bits = number.to_bits();
    [bits as u32, (bits >> 32) as u32]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{differences, layout, module};
    use crate::link::link;

    #[test]
    fn spaces_are_those_of_the_shaders() {
        let shader = module(&link("grid::project"));
        for layout in [
            layout!(Space { projection, raster }),
            layout!(Raster {
                columns,
                rows,
                fraction_bits,
                tile_bits,
                tile_columns,
                tile_rows,
                slices,
                first_cell,
                is_orthographic,
                has_samples,
                is_mirrored,
                position_error,
                row_reach,
                sees_behind,
                depth_error,
                depth_bits,
            }),
        ] {
            assert_eq!(differences(&shader, &layout), [""; 0]);
        }
    }
}
