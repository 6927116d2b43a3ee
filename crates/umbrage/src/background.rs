use std::f32::consts::PI;
use std::path::Path;
use std::sync::Arc;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::{Vec2, Vec3};
use umbrage_files::OpenOptions;
use umbrage_rays::{SimdLevel, dispatch};

use crate::Error;
use crate::panorama::Panorama;
use crate::shade::lanes::{Each, LANES, Vector, Vectors, put, vector_of};

/// The radiance that rays without a hit see, and that lights the scene from all around.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Background {
    /// One linear colour everywhere. Pictures show it as it is, without exposure and tone map.
    Color(Vec3),
    /// A soft sky: bluer towards the zenith, hazy at the horizon, grey below it.
    #[default]
    Sky,
    /// Nothing: rays without a hit leave their pixels uncovered, so that the picture can be put over another one by the
    /// [coverage](crate::Film::color) of its pixels. The scene is lit as by the sky, and mirrors that.
    Transparent,
    /// A latitude–longitude image.
    Image(Arc<Panorama>),
}

impl Background {
    /// Reads a latitude–longitude image with +Y at its upper edge and −Z in its middle: Radiance HDR, OpenEXR, PNG or
    /// JPEG.
    ///
    /// # Errors
    /// Where the file can't be read or isn't such an image, a texel is NaN or infinite, or it takes more memory than scenes
    /// may by default.
    pub fn open(path: &Path) -> Result<Self, Error> {
        Self::open_within(path, OpenOptions::default().max_memory)
    }

    /// As [`Background::open`], with a limit of `max_memory` bytes.
    ///
    /// # Errors
    /// As [`Background::open`].
    pub fn open_within(path: &Path, max_memory: u64) -> Result<Self, Error> {
        match Panorama::open(path, max_memory) {
            Ok(panorama) => Ok(Self::Image(Arc::new(panorama))),
            Err(cause) => Err(Error::Background { path: path.to_owned(), cause }),
        }
    }

    /// Mean radiance around unit directions: the sky with its horizon blurred over `softness`, or the image over about
    /// `width` of the sphere's circumference.
    #[inline(always)]
    fn around<S: Simd>(&self, simd: S, direction: Vectors<S>, softness: f32x16<S>, width: f32x16<S>) -> Vectors<S> {
        match self {
            Self::Color(color) => Vectors::splat(simd, *color),
            Self::Sky | Self::Transparent => sky(simd, direction.y, softness),
            Self::Image(panorama) => Vectors::load(simd, &read_each(panorama, &direction.store(), &width.into())),
        }
    }
}

/// An image's radiance in each lane's direction.
fn read_each(panorama: &Panorama, directions: &[Each<f32>; 3], widths: &Each<f32>) -> [Each<f32>; 3] {
    let mut radiance = [[0.0; LANES]; 3];
    for (lane, &width) in widths.iter().enumerate() {
        put(lane, panorama.radiance(vector_of(lane, directions), width), &mut radiance);
    }
    radiance
}

/// The least blur of the sky's horizon, in heights from −1 to 1.
const SHARPEST: f32 = 0.05;

/// The sky's radiance at heights between −1 and 1, its horizon blurred over `softness`.
#[inline(always)]
fn sky<S: Simd>(simd: S, height: f32x16<S>, softness: f32x16<S>) -> Vectors<S> {
    const ZENITH: Vec3 = Vec3::new(0.20, 0.27, 0.40);
    const HORIZON: Vec3 = Vec3::new(0.58, 0.63, 0.68);
    /// Just below the horizon, where haze hides the ground, and straight down.
    const HAZE: Vec3 = Vec3::new(0.38, 0.385, 0.39);
    const GROUND: Vec3 = Vec3::new(0.28, 0.28, 0.28);
    let (root, level) = (height.abs().sqrt(), f32x16::splat(simd, 0.0));
    let is_above = height.simd_gt(0.0);
    let above = Vectors::splat(simd, HORIZON).lerp(Vectors::splat(simd, ZENITH), is_above.select(root, level));
    let below = Vectors::splat(simd, HAZE).lerp(Vectors::splat(simd, GROUND), is_above.select(level, root));
    let part = ((height + softness) / (2.0 * softness)).max(0.0).min(1.0);
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
        /// Factors of the cosine lobe, for bands 0, 1 and 2, over π.
        const LOBE: [f32; 9] = [1.0, 2.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0, 0.25, 0.25, 0.25, 0.25, 0.25];
        const ROWS: u32 = 64;
        let mut irradiance = [Vec3::ZERO; 9];
        dispatch!(SimdLevel::default(), simd => project(simd, background, ROWS, &mut irradiance));
        let solid_angle = 4.0 * PI / (2 * ROWS * ROWS) as f32;
        for (coefficient, lobe) in irradiance.iter_mut().zip(LOBE) {
            *coefficient *= solid_angle * lobe * PI;
        }
        Self { background, irradiance }
    }

    /// The background that it was prepared from.
    #[cfg(feature = "gpu")]
    pub(crate) fn background(&self) -> &'a Background {
        self.background
    }

    /// The coefficients behind [`irradiance`](Self::irradiance).
    #[cfg(feature = "gpu")]
    pub(crate) fn irradiance_coefficients(&self) -> &[Vec3; 9] {
        &self.irradiance
    }

    /// Whether they are visible only in mirrors.
    #[inline(always)]
    pub(crate) fn are_transparent(&self) -> bool {
        matches!(self.background, Background::Transparent)
    }

    /// Whether pictures show them as they are, without exposure and tone map.
    #[inline(always)]
    pub(crate) fn are_flat(&self) -> bool {
        matches!(self.background, Background::Color(_))
    }

    /// Radiance from unit directions.
    #[inline(always)]
    pub(crate) fn radiance<S: Simd>(&self, simd: S, direction: Vectors<S>) -> Vectors<S> {
        self.background.around(simd, direction, f32x16::splat(simd, SHARPEST), f32x16::splat(simd, 0.0))
    }

    /// Mean radiance around unit directions, over about `width` of the circumference.
    #[inline(always)]
    pub(crate) fn mean<S: Simd>(&self, simd: S, direction: Vectors<S>, width: f32) -> Vectors<S> {
        self.background.around(simd, direction, f32x16::splat(simd, SHARPEST), f32x16::splat(simd, width))
    }

    /// Irradiance of surfaces that face upwards.
    pub(crate) fn irradiance_from_above(&self) -> Vec3 {
        let of_lanes: [Each<f32>; 3] = dispatch!(SimdLevel::default(), simd => {
            self.irradiance(simd, Vectors::splat(simd, Vec3::Y)).store()
        });
        vector_of(0, &of_lanes)
    }

    /// Irradiance of surfaces with unit normals, from all of the background above them.
    #[inline(always)]
    pub(crate) fn irradiance<S: Simd>(&self, simd: S, normal: Vectors<S>) -> Vectors<S> {
        let mut sum = Vectors::splat(simd, Vec3::ZERO);
        for (index, basis) in harmonics(simd, normal).into_iter().enumerate() {
            sum += Vectors::splat(simd, self.irradiance[index]).scaled(basis);
        }
        sum.at_least_zero()
    }

    /// Mean radiance around unit directions, over about the highlights of perceptual roughnesses.
    #[inline(always)]
    pub(crate) fn blurred<S: Simd>(&self, simd: S, direction: Vectors<S>, roughness: f32x16<S>) -> Vectors<S> {
        let squared = roughness * roughness;
        self.background.around(simd, direction, squared + SHARPEST, 0.5 * squared)
    }
}

/// The background's radiance times each harmonic, summed over `rows` of twice as many directions.
#[inline(always)]
fn project<S: Simd>(simd: S, background: &Background, rows: u32, sums: &mut [Vec3; 9]) {
    let mut in_lanes = [Vectors::splat(simd, Vec3::ZERO); 9];
    for first in (0..2 * rows).step_by(LANES) {
        let (mut cosines, mut sines) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let longitude = ((first as usize + lane) as f32 + 0.5) / rows as f32 * PI;
            (sines[lane], cosines[lane]) = libm::sincosf(longitude);
        }
        let (cosines, sines) = (f32x16::from_slice(simd, &cosines), f32x16::from_slice(simd, &sines));
        for row in 0..rows {
            // Equal steps of height are equal areas of the sphere.
            let height = (row as f32 + 0.5) / rows as f32 * 2.0 - 1.0;
            let radius = (1.0 - height * height).sqrt();
            let direction = Vector { x: cosines * radius, y: f32x16::splat(simd, height), z: sines * radius };
            let (softness, width) = (f32x16::splat(simd, SHARPEST), f32x16::splat(simd, 1.5 / rows as f32));
            let radiance = background.around(simd, direction, softness, width);
            for (index, basis) in harmonics(simd, direction).into_iter().enumerate() {
                in_lanes[index] += radiance.scaled(basis);
            }
        }
    }
    for (sum, in_lanes) in sums.iter_mut().zip(in_lanes) {
        *sum = Vec3::new(in_lanes.x.reduce_sum(), in_lanes.y.reduce_sum(), in_lanes.z.reduce_sum());
    }
}

/// The real spherical harmonics of bands 0 to 2 at unit directions.
#[inline(always)]
fn harmonics<S: Simd>(simd: S, Vector { x, y, z }: Vectors<S>) -> [f32x16<S>; 9] {
    [
        f32x16::splat(simd, 0.282_095),
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

/// The position of a unit direction in a latitude–longitude image: (0, 0) at its upper left, (1, 1) at its lower right.
pub(crate) fn panorama_coords(direction: Vec3) -> Vec2 {
    let longitude = libm::atan2f(direction.x, -direction.z);
    Vec2::new(0.5 + longitude / (2.0 * PI), libm::acosf(direction.y.clamp(-1.0, 1.0)) / PI)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shade::lanes::Each;

    fn irradiance(surroundings: &Surroundings<'_>, normal: Vec3) -> Vec3 {
        let of_lanes: [Each<f32>; 3] = dispatch!(SimdLevel::default(), simd => {
            surroundings.irradiance(simd, Vectors::splat(simd, normal)).store()
        });
        vector_of(0, &of_lanes)
    }

    #[test]
    fn even_surroundings_light_every_normal_by_pi_times_their_radiance() {
        let background = Background::Color(Vec3::new(1.0, 0.5, 0.25));
        let surroundings = Surroundings::new(&background);
        for normal in [Vec3::X, Vec3::NEG_Y, Vec3::new(0.6, 0.0, -0.8)] {
            assert!(irradiance(&surroundings, normal).distance(Vec3::new(1.0, 0.5, 0.25) * PI) < 2e-3);
        }
    }

    #[test]
    fn the_sky_lights_upward_normals_more_than_downward_ones() {
        let surroundings = Surroundings::new(&Background::Sky);
        assert!(irradiance(&surroundings, Vec3::Y).z > 1.5 * irradiance(&surroundings, Vec3::NEG_Y).z);
    }

    #[test]
    fn the_middle_of_a_panorama_is_straight_ahead() {
        assert!(panorama_coords(Vec3::NEG_Z).distance(Vec2::splat(0.5)) < 1e-6);
        assert!(panorama_coords(Vec3::X).distance(Vec2::new(0.75, 0.5)) < 1e-6);
        assert!(panorama_coords(Vec3::Y).y.abs() < 1e-3);
    }
}
