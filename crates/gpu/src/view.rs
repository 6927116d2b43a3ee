use bytemuck::{Pod, Zeroable};
use glam::DVec2;
use umbrage_rays::{Camera, Projection, View};

use crate::Band;
use crate::grid::words;

/// A camera and its image, as in `exact/camera.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct ExactView {
    position: [f32; 3],
    half_height: f32,
    right: [f32; 3],
    is_orthographic: u32,
    up: [f32; 3],
    width: u32,
    forward: [f32; 3],
    height: u32,
}

impl From<&View> for ExactView {
    fn from(view: &View) -> Self {
        let Camera { position, right, up, forward, projection } = view.camera;
        let (half_height, is_orthographic) = match projection {
            Projection::Perspective { tan_half_height } => (tan_half_height, 0),
            Projection::Orthographic { half_height } => (half_height, 1),
        };
        Self {
            position: position.to_array(),
            half_height,
            right: right.to_array(),
            is_orthographic,
            up: up.to_array(),
            width: view.width,
            forward: forward.to_array(),
            height: view.height,
        }
    }
}

/// The camera whose pixels, and points on them, are traced, as in `point_view.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct PointView {
    view: ExactView,
    x_offset: [u32; 2],
    y_offset: [u32; 2],
    slots: u32,
    first_row: u32,
    rows: u32,
    unused: u32,
}

impl PointView {
    /// Pixels of a band of rows, moved by an offset.
    #[must_use]
    pub fn new(band: &Band, offset_pixels: DVec2) -> Self {
        Self {
            view: (&band.view).into(),
            x_offset: words(offset_pixels.x),
            y_offset: words(offset_pixels.y),
            slots: band.order().slots() as u32,
            first_row: band.rows.start,
            rows: band.rows.len() as u32,
            unused: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{differences, layout, module};
    use crate::link::link;

    #[test]
    fn views_are_those_of_the_shaders() {
        let shader = module(&link("camera::settle"));
        for layout in [
            layout!(ExactView { position, half_height, right, is_orthographic, up, width, forward, height }),
            layout!(PointView { view, x_offset, y_offset, slots, first_row, rows }),
        ] {
            assert_eq!(differences(&shader, &layout), [""; 0]);
        }
    }
}
