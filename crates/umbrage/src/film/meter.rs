//! Automatic exposure: the brightness of a picture, from its pixels.

use glam::{Vec3, Vec4};
use umbrage_scene::Frame;

use crate::{Film, Layers, Settings};

/// Luminance of linear Rec. 709.
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

impl Settings {
    /// Settings of a small, quick picture for [`Film::metered_stops`], in place of these.
    #[must_use]
    pub fn for_metering(&self) -> Self {
        const HEIGHT: u32 = 180;
        let height = self.height.min(HEIGHT);
        let width = (u64::from(self.width) * u64::from(height) / u64::from(self.height.max(1))).max(1) as u32;
        let (samples, noise, aperture, shutter_seconds, light_radius) = (1, 0.0, 0.0, 0.0, 0.0);
        let small = Self { width, height, samples, noise, aperture, shutter_seconds, light_radius, ..self.clone() };
        let small = Self { first_hits: true, ..small };
        Self { sky_shadows: false, gloss: false, ambient_occlusion: 0.0, layers: Layers::default(), ..small }
    }
}

impl Film {
    /// The [exposure](Settings::exposure_stops), from −20 to 4 stops, that suits a film of `frame`.
    ///
    /// The brightest twentieth of the pixels that show the scene, without its ground, starts nearly at the screen's white.
    /// Dark scenes are brightened only until their ground and background reach it too. Unlit surfaces don't count, and a
    /// film that shows none of the scene, or has no [first hits](Settings::first_hits), gets 0.
    #[must_use]
    pub fn metered_stops(&self, frame: &Frame) -> f32 {
        const BRIGHT: f32 = 0.8;
        let ground = frame.mesh.triangles.len().saturating_sub(frame.mesh.ground_triangles);
        let (mut scene, mut around) = (Vec::new(), Vec::new());
        for (pixel, (color, &triangle)) in self.color.iter().zip(&self.triangle).enumerate() {
            let flat = self.flat.get(pixel).copied().unwrap_or(Vec4::ZERO);
            let luminance = (*color - flat).truncate().max(Vec3::ZERO).dot(LUMINANCE);
            if (triangle as usize) < ground {
                if flat.w < 0.5 {
                    scene.push(luminance);
                }
            } else if flat.w < 0.5 {
                around.push(luminance);
            }
        }
        let stops_to = |bright: f32| libm::log2f(BRIGHT / bright).clamp(-20.0, 4.0);
        let Some(bright) = brightest_twentieth(&mut scene) else { return 0.0 };
        let stops = if bright > 0.0 { stops_to(bright) } else { 4.0 };
        let most = match brightest_twentieth(&mut around) {
            Some(bright) if bright > 0.0 => stops_to(bright).max(0.0),
            _ if bright > 0.0 => 4.0,
            _ => 0.0,
        };
        stops.min(most)
    }
}

/// The lowest luminance in the brightest twentieth of some pixels.
fn brightest_twentieth(luminances: &mut [f32]) -> Option<f32> {
    let index = luminances.len().checked_sub(1)? * 19 / 20;
    Some(*luminances.select_nth_unstable_by(index, f32::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half of the pixels show a triangle, half of the others the ground.
    fn film(scene: f32, ground: f32, sky: f32) -> Film {
        let pixels = [(scene, 0), (scene, 0), (ground, 1), (sky, Film::NO_TRIANGLE)].repeat(50);
        let (color, triangle) = pixels.into_iter().map(|(grey, id)| (Vec3::splat(grey).extend(1.0), id)).unzip();
        Film { width: 200, height: 1, color, triangle, ..Film::default() }
    }

    fn frame() -> Frame {
        let mut frame = Frame::from_triangles(vec![Vec3::ZERO; 3], vec![[0, 1, 2]; 2]);
        std::sync::Arc::make_mut(&mut frame.mesh).ground_triangles = 1;
        frame
    }

    #[test]
    fn what_the_scene_shows_becomes_nearly_white() {
        let stops = |scene, ground, sky| film(scene, ground, sky).metered_stops(&frame());
        for (scene, expected) in [(1.6, -1.0), (0.8, 0.0), (8192.0 * 0.8, -13.0)] {
            assert!((stops(scene, 0.3, 0.5) - expected).abs() < 1e-3, "{scene}: {}", stops(scene, 0.3, 0.5));
        }
        // The surroundings don't turn white, nor does a scene without any light.
        assert!((stops(0.01, 0.1, 0.4) - 1.0).abs() < 1e-3);
        assert_eq!([stops(0.01, 3.0, 2.0), stops(0.0, 0.0, 0.0)], [0.0; 2]);
        assert!((stops(0.2, 0.0, 0.0) - 2.0).abs() < 1e-3 && stops(1e-9, 0.0, 0.0) == 4.0);
        assert_eq!(stops(1e30, 0.0, 0.0), -20.0);
    }

    #[test]
    fn neither_highlights_nor_unlit_surfaces_count() {
        let mut film = film(0.8, 0.3, 0.3);
        film.color[0] = Vec4::splat(1e9);
        assert!(film.metered_stops(&frame()).abs() < 1e-3);
        film.flat = film.color.clone();
        assert_eq!(film.metered_stops(&frame()), 0.0);
        assert_eq!(Film::default().metered_stops(&frame()), 0.0);
    }

    #[test]
    fn pictures_to_measure_are_small_and_of_the_same_shape() {
        let small = Settings { width: 1920, height: 1080, samples: 64, sky_shadows: true, ..Settings::default() }
            .for_metering();
        assert_eq!((small.width, small.height, small.samples, small.sky_shadows), (320, 180, 1, false));
        let tiny = Settings { width: 1, height: 4000, ..Settings::default() }.for_metering();
        assert_eq!((tiny.width, tiny.height), (1, 180));
    }
}
