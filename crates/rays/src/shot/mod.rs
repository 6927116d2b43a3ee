//! Questions to a structure, and answers.
//!
//! A [`Shot`] is the question: triangles, the rays of a camera's pixels, and the opacity of triangles. [`SeenPixels`] and
//! [`LightMask`] are the answers, in [`TileOrder`]; [`Work`] counts and times them.

mod camera_rays;
mod cone;
mod eight_points;
mod light_mask;
mod masks;
mod opacity;
mod pixel_work;
mod seen;
mod shifts;
mod sides;
mod tile_order;
mod work;

use glam::DVec2;

use crate::predicate::{HitPoint, ShadowRay, crossing};
use crate::{LightSource, Ray, Triangles, View};
pub use camera_rays::CameraRays;
pub use cone::Cone;
pub use eight_points::{EightPoints, EightTriangles, cross};
pub use light_mask::LightMask;
pub use masks::{Masks, RayMasks};
pub use opacity::{MaskAnswers, MaskPoints, Opacity, Opaque};
pub use pixel_work::{Kind, TileWork};
pub use pixel_work::{PixelCounts, PixelWork};
pub use seen::SeenPixels;
pub use shifts::BlockSamples;
pub use shifts::Shifts;
pub use sides::OpacityOfSides;
pub use sides::Sides;
pub use tile_order::TileOrder;
pub use work::{Bytes, Counts, Seconds, Work};

/// A question to a structure: what does the ray through each pixel of an image hit, and which lights reach that point?
#[derive(Clone, Copy)]
pub struct Shot<'a> {
    /// The scene.
    pub triangles: Triangles<'a>,
    /// The camera and its image.
    pub view: View,
    /// The point of each pixel that its ray goes through: from (0, 0), the upper left corner, to (1, 1).
    pub offset_pixels: DVec2,
    /// Additional shift of each ray, by even and odd columns and rows.
    pub shifts: Shifts,
    /// Opacity of triangles for camera rays.
    pub opacity: &'a dyn Opacity,
    /// Opacity of triangles for shadow rays.
    pub shadow_opacity: &'a dyn Opacity,
    /// The sides of triangles that stop rays of either kind.
    pub sides: Sides<'a>,
}

impl std::fmt::Debug for Shot<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Shot")
            .field("triangles", &self.triangles.len())
            .field("view", &self.view)
            .field("offset_pixels", &self.offset_pixels)
            .field("shifts", &self.shifts)
            .field("sides", &self.sides)
            .finish_non_exhaustive()
    }
}

impl<'a> Shot<'a> {
    /// Rays through the middle of each pixel, with opaque triangles of two sides.
    #[must_use]
    pub fn new(triangles: Triangles<'a>, view: View) -> Self {
        Self {
            triangles,
            view,
            offset_pixels: DVec2::splat(0.5),
            shifts: Shifts::NONE,
            opacity: &Opaque,
            shadow_opacity: &Opaque,
            sides: Sides::Both,
        }
    }

    /// The ray through the pixel in column `x` and row `y`.
    #[must_use]
    pub fn ray(&self, x: u32, y: u32) -> Ray {
        let shift = self.shifts.at(x, y);
        self.view.ray(f64::from(x) + self.offset_pixels.x + shift.x, f64::from(y) + self.offset_pixels.y + shift.y)
    }

    /// The segment between `light` and the point shown by the pixel at this [index](TileOrder::index); `None` where it shows
    /// no triangle.
    #[must_use]
    pub fn shadow_ray(&self, seen: &SeenPixels, index: usize, light: &LightSource) -> Option<ShadowRay> {
        let own = seen.triangle[index];
        if own == SeenPixels::NONE {
            return None;
        }
        let (x, y) = seen.order().column_and_row(index);
        let ray = self.ray(x, y);
        let crossing = crossing(&ray, self.triangles.usable_corners(own).ok()?)?;
        Some(ShadowRay::new(light, HitPoint::new(&ray, crossing.t)))
    }

    /// Checks that there is a mask for each light, and that `seen` belongs to this image.
    ///
    /// # Panics
    /// If there are more or fewer, or `seen` has another size.
    pub fn expect_masks(&self, seen: &SeenPixels, lights: &[LightSource], masks: &[LightMask]) {
        assert!(lights.len() == masks.len(), "{} masks for {} lights", masks.len(), lights.len());
        self.expect_size(seen);
    }

    /// Checks that `seen` belongs to this image.
    ///
    /// # Panics
    /// If it has another size.
    pub fn expect_size(&self, seen: &SeenPixels) {
        let (size, found) = ((self.view.width, self.view.height), seen.order().size());
        assert!(found == size, "an image of {found:?} pixels seen through a view of {size:?}");
    }
}

/// A shot and the triangles that its pixels see: together the points to be lit.
#[derive(Clone, Copy, Debug)]
pub struct SeenImage<'a> {
    pub shot: &'a Shot<'a>,
    pub seen: &'a SeenPixels,
}
