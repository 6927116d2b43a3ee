use std::f32::consts::PI;
use std::path::Path;
use std::sync::Arc;

use glam::{Vec2, Vec3};

use crate::Error;
use crate::panorama::Panorama;

/// What rays that hit nothing see, and what lights the scene from all around.
#[derive(Clone, Debug, Default)]
pub enum Background {
    /// One linear colour everywhere.
    Color(Vec3),
    /// A soft sky: bluer towards the zenith, hazy at the horizon, grey below it.
    #[default]
    Sky,
    /// A latitude–longitude image.
    Image(Arc<Panorama>),
}

impl Background {
    /// Reads a latitude–longitude image with +Y at its upper edge and −Z in its middle: Radiance HDR, OpenEXR, PNG or
    /// JPEG.
    ///
    /// # Errors
    /// Where the file can't be read or isn't such an image.
    pub fn open(path: &Path) -> Result<Self, Error> {
        match Panorama::open(path) {
            Ok(panorama) => Ok(Self::Image(Arc::new(panorama))),
            Err(cause) => Err(Error::Background { path: path.to_owned(), cause }),
        }
    }

    /// Radiance from a unit direction.
    fn radiance(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Color(color) => *color,
            Self::Sky => sky(direction.y, 0.05),
            Self::Image(panorama) => panorama.radiance(direction, 0.0),
        }
    }
}

/// The sky's radiance at a height between −1 and 1, its horizon blurred over `softness`.
fn sky(height: f32, softness: f32) -> Vec3 {
    const ZENITH: Vec3 = Vec3::new(0.16, 0.26, 0.46);
    const HORIZON: Vec3 = Vec3::new(0.56, 0.63, 0.70);
    /// Just below the horizon, where haze hides the ground, and straight down.
    const HAZE: Vec3 = Vec3::new(0.46, 0.47, 0.48);
    const GROUND: Vec3 = Vec3::new(0.16, 0.15, 0.145);
    let above = HORIZON.lerp(ZENITH, height.max(0.0).sqrt());
    let below = HAZE.lerp(GROUND, (-height).max(0.0).sqrt());
    let part = ((height + softness) / (2.0 * softness)).clamp(0.0, 1.0);
    below.lerp(above, part * part * (3.0 - 2.0 * part))
}

/// A background prepared for shading.
#[derive(Debug)]
pub(crate) struct Surroundings<'a> {
    background: &'a Background,
    /// Irradiance by direction: nine coefficients of real spherical harmonics, already convolved with the cosine lobe
    /// (Ramamoorthi and Hanrahan, *An Efficient Representation for Irradiance Environment Maps*, 2001).
    irradiance: [Vec3; 9],
}

impl<'a> Surroundings<'a> {
    pub(crate) fn new(background: &'a Background) -> Self {
        /// Of the cosine lobe, for bands 0, 1 and 2, over π.
        const LOBE: [f32; 9] = [1.0, 2.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0, 0.25, 0.25, 0.25, 0.25, 0.25];
        const ROWS: u32 = 64;
        let mut irradiance = [Vec3::ZERO; 9];
        for row in 0..ROWS {
            // Equal steps of height are equal areas of the sphere.
            let height = (row as f32 + 0.5) / ROWS as f32 * 2.0 - 1.0;
            for column in 0..2 * ROWS {
                let (sin, cos) = ((column as f32 + 0.5) / ROWS as f32 * PI).sin_cos();
                let radius = (1.0 - height * height).sqrt();
                let direction = Vec3::new(radius * cos, height, radius * sin);
                let radiance = match background {
                    Background::Image(panorama) => panorama.radiance(direction, 1.5 / ROWS as f32),
                    Background::Color(_) | Background::Sky => background.radiance(direction),
                };
                for (coefficient, basis) in irradiance.iter_mut().zip(harmonics(direction)) {
                    *coefficient += radiance * basis;
                }
            }
        }
        let solid_angle = 4.0 * PI / (2 * ROWS * ROWS) as f32;
        for (coefficient, lobe) in irradiance.iter_mut().zip(LOBE) {
            *coefficient *= solid_angle * lobe * PI;
        }
        Self { background, irradiance }
    }

    /// What it was prepared from.
    #[cfg(feature = "gpu")]
    pub(crate) fn background(&self) -> &'a Background {
        self.background
    }

    /// The coefficients that [`irradiance`](Self::irradiance) is made of.
    #[cfg(feature = "gpu")]
    pub(crate) fn irradiance_coefficients(&self) -> &[Vec3; 9] {
        &self.irradiance
    }

    /// Radiance from a unit direction.
    pub(crate) fn radiance(&self, direction: Vec3) -> Vec3 {
        self.background.radiance(direction)
    }

    /// Irradiance of a surface with a unit normal, from all of the background above it.
    pub(crate) fn irradiance(&self, normal: Vec3) -> Vec3 {
        let harmonics = harmonics(normal);
        let sum: Vec3 = self.irradiance.iter().zip(harmonics).map(|(coefficient, basis)| *coefficient * basis).sum();
        sum.max(Vec3::ZERO)
    }

    /// Mean radiance around a unit direction, over about the highlight of a perceptual roughness.
    pub(crate) fn blurred(&self, direction: Vec3, roughness: f32) -> Vec3 {
        match self.background {
            Background::Color(color) => *color,
            Background::Sky => sky(direction.y, 0.05 + roughness * roughness),
            Background::Image(panorama) => panorama.radiance(direction, 0.5 * roughness * roughness),
        }
    }
}

/// The real spherical harmonics of bands 0 to 2 at a unit direction.
fn harmonics(Vec3 { x, y, z }: Vec3) -> [f32; 9] {
    [
        0.282_095,
        0.488_603 * y,
        0.488_603 * z,
        0.488_603 * x,
        1.092_548 * x * y,
        1.092_548 * y * z,
        0.315_392 * (3.0 * z * z - 1.0),
        1.092_548 * x * z,
        0.546_274 * (x * x - y * y),
    ]
}

/// Where a unit direction is in a latitude–longitude image: (0, 0) at its upper left, (1, 1) at its lower right.
pub(crate) fn panorama_coords(direction: Vec3) -> Vec2 {
    let longitude = direction.x.atan2(-direction.z);
    Vec2::new(0.5 + longitude / (2.0 * PI), direction.y.clamp(-1.0, 1.0).acos() / PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_surroundings_light_every_normal_by_pi_times_their_radiance() {
        let background = Background::Color(Vec3::new(1.0, 0.5, 0.25));
        let surroundings = Surroundings::new(&background);
        for normal in [Vec3::X, Vec3::NEG_Y, Vec3::new(0.6, 0.0, -0.8)] {
            assert!(surroundings.irradiance(normal).distance(Vec3::new(1.0, 0.5, 0.25) * PI) < 2e-3);
        }
    }

    #[test]
    fn the_sky_lights_upward_normals_more_than_downward_ones() {
        let surroundings = Surroundings::new(&Background::Sky);
        assert!(surroundings.irradiance(Vec3::Y).z > 1.5 * surroundings.irradiance(Vec3::NEG_Y).z);
    }

    #[test]
    fn the_middle_of_a_panorama_is_straight_ahead() {
        assert_eq!(panorama_coords(Vec3::NEG_Z), Vec2::splat(0.5));
        assert!(panorama_coords(Vec3::X).distance(Vec2::new(0.75, 0.5)) < 1e-6);
        assert!(panorama_coords(Vec3::Y).y.abs() < 1e-3);
    }
}
