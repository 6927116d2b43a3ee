use glam::DVec3;

use super::{SeenPixels, Shifts, Shot, TileOrder};
use crate::{Camera, Projection};

/// The constants of [`View::ray`](crate::View::ray).
#[derive(Clone, Copy, Default)]
pub struct CameraRays {
    pub position: DVec3,
    /// Change of a perspective direction, or of an orthographic origin, per pixel to the right.
    pub step_x: DVec3,
    /// Its change per pixel downwards.
    pub step_y: DVec3,
    /// Its value at pixel (0, 0).
    pub corner: DVec3,
    pub forward: DVec3,
    pub is_perspective: bool,
    pub order: TileOrder,
    pub shifts: Shifts,
    /// Largest component of any direction.
    pub largest_direction: f64,
    /// Largest coordinate of any origin.
    pub largest_origin: f64,
}

impl CameraRays {
    pub fn new(shot: &Shot<'_>) -> Self {
        let Camera { position, right, up, forward, projection } = shot.view.camera;
        let (width, height) = (f64::from(shot.view.width), f64::from(shot.view.height));
        let (is_perspective, half_height) = match projection {
            Projection::Perspective { tan_half_height } => (true, f64::from(tan_half_height)),
            Projection::Orthographic { half_height } => (false, f64::from(half_height)),
        };
        let step_x = right.as_dvec3() * (2.0 * half_height / height);
        let step_y = up.as_dvec3() * (-2.0 * half_height / height);
        let [offset_x, offset_y] = shot.offset_pixels.to_array();
        let base = if is_perspective { forward.as_dvec3() } else { position.as_dvec3() };
        let corner = base + step_x * (offset_x - 0.5 * width) + step_y * (offset_y - 0.5 * height);
        // Twice the half width and height of the image, and the part of its last tiles beyond the border.
        let tile = f64::from(TileOrder::TILE);
        let (width, height) = (width + 2.0 * tile + offset_x.abs(), height + 2.0 * tile + offset_y.abs());
        let across = (step_x.abs() * width + step_y.abs() * height).max_element();
        let (position, forward) = (position.as_dvec3(), forward.as_dvec3());
        let (origin, direction) = (position.abs().max_element(), forward.abs().max_element());
        Self {
            position,
            step_x,
            step_y,
            corner,
            forward,
            is_perspective,
            order: TileOrder::new(shot.view.width, shot.view.height),
            shifts: shot.shifts,
            largest_direction: if is_perspective { direction + across } else { direction },
            largest_origin: if is_perspective { origin } else { origin + across },
        }
    }

    /// The origin and the direction of the ray of the pixel at `column` and `row`, its shift included in these.
    ///
    /// Each component has four roundings: it is wrong by at most 4 half ulps of the largest one.
    pub fn ray(&self, column: f64, row: f64) -> (DVec3, DVec3) {
        let varying = self.step_x * column + (self.step_y * row + self.corner);
        if self.is_perspective { (self.position, varying) } else { (varying, self.forward) }
    }

    /// The corners of the view frustum of the tile that begins at index `first`, between two inverse depths.
    pub fn frustum(&self, first: usize, depths: [f32; 2]) -> [DVec3; 8] {
        let (x, y) = self.order.column_and_row(first);
        let last = f64::from(TileOrder::TILE - 1);
        // The tile's own border, so that rounding can't lose a point; depths are widened by their error.
        let border = 0.25 + f64::from(self.shifts.reach());
        let columns = [f64::from(x) - border, f64::from(x) + last + border];
        let rows = [f64::from(y) - border, f64::from(y) + last + border];
        const ERROR: f64 = 2.0 * SeenPixels::RELATIVE_ERROR as f64;
        let t = [(1.0 - ERROR) / f64::from(depths[1]), (1.0 + ERROR) / f64::from(depths[0])];
        std::array::from_fn(|corner| {
            let (origin, direction) = self.ray(columns[corner & 1], rows[corner >> 1 & 1]);
            origin + direction * t[corner >> 2]
        })
    }
}
