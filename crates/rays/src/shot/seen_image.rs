use glam::DVec2;

use super::SeenPixels;
use crate::{Ray, Triangles, View};

/// What a camera sees: the points that a [`LightGrid`] decides about.
#[derive(Clone, Copy, Debug)]
pub struct SeenImage<'a> {
    /// The scene.
    pub triangles: Triangles<'a>,
    /// The camera.
    pub view: View,
    /// Where in each pixel its ray goes through, from (0, 0) for the upper left corner to (1, 1).
    pub offset_pixels: DVec2,
    /// What the ray through each pixel hits.
    pub seen: &'a SeenPixels,
}

impl SeenImage<'_> {
    /// The ray through the pixel at a place.
    pub(crate) fn camera_ray(&self, place: usize) -> Ray {
        let (x, y) = self.seen.order().column_and_row(place);
        let (x, y) = (f64::from(x), f64::from(y));
        self.view.ray(x + self.offset_pixels.x, y + self.offset_pixels.y)
    }
}
