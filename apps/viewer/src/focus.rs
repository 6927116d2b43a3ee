//! The focus of a picture: the centre of the visible surfaces rather than of the scene, whose floor may go on for miles.

use glam::Vec3;
use umbrage::Film;
use umbrage::rays::{Bounds, Camera, Projection, View};

/// A point, and the extent of the view around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Focus {
    pub(crate) center: Vec3,
    /// Extent in world units, above zero.
    pub(crate) size: f32,
}

impl Default for Focus {
    fn default() -> Self {
        Self { center: Vec3::ZERO, size: 1.0 }
    }
}

impl Focus {
    /// The point in front of the camera at the picture's median depth; the whole scene for an empty picture.
    pub(crate) fn new(film: &Film, view: &View, bounds: Bounds) -> Self {
        const MOST_PIXELS: usize = 4096;
        let step = (film.depth.len() / MOST_PIXELS).max(1);
        let mut depths: Vec<f32> = film.depth.iter().copied().step_by(step).filter(|depth| depth.is_finite()).collect();
        let Camera { position, forward, projection, .. } = view.camera;
        if depths.is_empty() {
            return Self::whole(bounds);
        }
        let middle = depths.len() / 2;
        let depth = *depths.select_nth_unstable_by(middle, f32::total_cmp).1;
        let size = match projection {
            Projection::Perspective { tan_half_height } => 2.0 * tan_half_height * depth,
            Projection::Orthographic { half_height } => 2.0 * half_height,
        };
        let focus = Self { center: position + forward * depth, size };
        if focus.center.is_finite() && size.is_finite() && size > 0.0 { focus } else { Self::whole(bounds) }
    }

    fn whole(bounds: Bounds) -> Self {
        let size = bounds.size().length();
        if size.is_finite() && size > 0.0 { Self { center: bounds.center(), size } } else { Self::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_where_half_of_the_picture_is() {
        let camera = Camera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, Vec3::Y, 1.0);
        let view = View { camera, width: 5, height: 1 };
        let film = |depth: [f32; 5]| Film { width: 5, height: 1, depth: depth.to_vec(), ..Film::default() };
        let bounds = Bounds { min: Vec3::splat(-1000.0), max: Vec3::splat(1000.0) };
        let focus = Focus::new(&film([4.0, 4.0, 900.0, f32::INFINITY, f32::INFINITY]), &view, bounds);
        assert!(focus.center.distance(Vec3::Z) < 1e-5 && (focus.size - 8.0 * 0.5_f32.tan()).abs() < 1e-4, "{focus:?}");
        let nothing = Focus::new(&film([f32::INFINITY; 5]), &view, bounds);
        assert!(nothing.center == Vec3::ZERO && nothing.size > 3000.0);
        assert_eq!(Focus::new(&film([f32::INFINITY; 5]), &view, Bounds::EMPTY), Focus::default());
    }
}
