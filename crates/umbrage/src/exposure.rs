//! What is out of focus, moves, or is lit from more than a point: a picture is the mean of exact frames, each of which has
//! one point of the lens, one moment, and one point of every light.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec3};
use umbrage_rays::{Camera, LightSource, Projection, View};
use umbrage_scene::{Frame, Light};

use crate::engine::Staged;
use crate::probe::middle_depth;
use crate::sampling::Samples;
use crate::{Error, Settings};

/// What a frame's samples spread over, beside their pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread {
    shutter_seconds: f64,
    /// In place of a radius of zero.
    light_radius: f32,
    lens: Option<Lens>,
    has_wide_lights: bool,
}

/// A thin lens: what is at its focus is sharp.
#[derive(Clone, Copy, Debug)]
struct Lens {
    radius: f64,
    /// The depth of the plane that stays where it is.
    focus: f64,
}

impl Spread {
    /// That of a frame. `whole` gives the frame with its vertices, for what is in the middle of the picture.
    ///
    /// # Errors
    /// Where the camera has no lens, nothing says where its focus is, or a sun fills more than the sky.
    pub(crate) fn new<'a>(staged: &Staged<'_>, whole: impl FnOnce() -> &'a Frame) -> Result<Self, Error> {
        let Settings { samples, aperture, focus, shutter_seconds, light_radius, .. } = *staged.settings;
        let lens = (samples > 1 && aperture > 0.0).then(|| {
            if matches!(staged.view.camera.projection, Projection::Orthographic { .. }) {
                return Err(Error::ParallelLens);
            }
            let focus = focus.map(f64::from).or_else(|| middle_depth(whole(), &staged.view, staged.settings.sides));
            Ok(Lens { radius: 0.5 * f64::from(aperture), focus: focus.ok_or(Error::NoFocus)? })
        });
        let has_sun = staged.lights.iter().any(|light| matches!(light.source, LightSource::Directional { .. }));
        if has_sun && light_radius > Light::MAX_SUN_RADIUS_DEGREES {
            return Err(Error::SunRadius);
        }
        let has_wide_lights = staged.lights.iter().any(|light| light.radius.max(light_radius) > 0.0);
        Ok(Self { shutter_seconds, light_radius, lens: lens.transpose()?, has_wide_lights })
    }

    /// Whether there is anything to spread over. Then each sample is traced alone: of four that are traced together, all would
    /// be at the same point of it, which makes more noise in the same time but in small images (docs/effects.md).
    pub(crate) fn is_wide(&self) -> bool {
        self.lens.is_some() || self.has_wide_lights || self.shutter_seconds > 0.0
    }

    /// The radius of a light.
    fn radius_of(&self, light: &Light) -> f32 {
        if light.radius > 0.0 { light.radius } else { self.light_radius }
    }
}

/// One of the exact frames that make a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exposure {
    number: u32,
    /// Whether there is no other: then it is in the middle of everything.
    is_only: bool,
}

impl Exposure {
    /// Dimensions of samples: each pair of numbers for one purpose has one of its own.
    const LENS: u32 = 0;
    const MOMENT: u32 = 1;
    const FIRST_LIGHT: u32 = 2;

    /// Exposure `number` of some.
    pub(crate) fn new(number: u32, samples: &Samples) -> Self {
        let of = samples.as_slice()[0].of / samples.as_slice().len() as u32;
        Self { number, is_only: of == 1 }
    }

    /// How long before or after the frame's moment it is, in seconds.
    pub(crate) fn seconds(self, spread: &Spread) -> f64 {
        if self.is_only { 0.0 } else { spread.shutter_seconds * (pair(self.number, Self::MOMENT).x - 0.5) }
    }

    /// What it sees: the same scene from its point of the lens, with the lights, which are put into `lights`, at their
    /// points. And where the rays of its samples go through their pixels there.
    pub(crate) fn of<'a>(
        self,
        staged: &Staged<'a>,
        samples: &Samples,
        spread: &Spread,
        lights: &'a mut Vec<Light>,
    ) -> (Staged<'a>, Samples) {
        let (mut exposed, mut samples) = (*staged, *samples);
        if self.is_only {
            return (exposed, samples);
        }
        if let Some(lens) = spread.lens {
            let (view, shift_pixels) = lens.seen_through(disk(pair(self.number, Self::LENS)), &staged.view);
            (exposed.view, samples) = (view, samples.shifted(shift_pixels));
        }
        if spread.has_wide_lights {
            lights.clear();
            lights.extend(staged.lights.iter().zip((Self::FIRST_LIGHT..).step_by(2)).map(|(light, dimension)| {
                let source = self.point_of(light.source, spread.radius_of(light), dimension);
                Light { source, ..light.clone() }
            }));
            exposed.lights = lights;
        }
        (exposed, samples)
    }

    /// A point of a light's ball or, of a sun, of its disk in the sky.
    ///
    /// From each direction a ball should look like a disk that is equally bright everywhere, as a sphere does whose surface
    /// sends light equally in all directions. So points are as dense as 1/√(1 − r²) at r of its radius: the sphere in four
    /// dimensions, seen from the side. Without anything between, irradiance is the centre's: that of a point is a field as
    /// gravity's, and the field of a ball is that of its centre (Newton's shells).
    fn point_of(self, source: LightSource, radius: f32, dimension: u32) -> LightSource {
        if radius <= 0.0 {
            return source;
        }
        let (first, third) = (pair(self.number, dimension), pair(self.number, dimension + 1).x);
        let flat = disk(first);
        let moved = |position: Vec3| {
            let point = DVec3::new(flat.x, (1.0 - first.x).sqrt() * (TAU * third).cos(), flat.y);
            (position.as_dvec3() + point * f64::from(radius)).as_vec3().clamp(Vec3::MIN, Vec3::MAX)
        };
        match source {
            LightSource::Point { position } => LightSource::Point { position: moved(position) },
            LightSource::Spot { position, direction, inner_radians, outer_radians } => {
                LightSource::Spot { position: moved(position), direction, inner_radians, outer_radians }
            }
            LightSource::Directional { direction } => {
                let along = direction.as_dvec3().normalize();
                let (right, up) = along.any_orthonormal_pair();
                let off = f64::from(radius).to_radians().tan() * flat;
                let direction = (along + right * off.x + up * off.y).normalize().as_vec3();
                LightSource::Directional { direction }
            }
        }
    }
}

impl Lens {
    /// A view from a point of the unit disk that the lens is, and by how much rays are shifted in its image, in pixels.
    ///
    /// The camera moves across its axis and keeps its axes, so all structures know it as any other. That what is in focus
    /// stays in its pixels takes a frustum that isn't symmetric: its image is another part of the same plane.
    fn seen_through(self, point: DVec2, view: &View) -> (View, DVec2) {
        /// Shifts are whole multiples of this, so that sums with pixels are exact.
        const STEPS_PER_PIXEL: f64 = (1 << 20) as f64;
        let camera = view.camera;
        let Projection::Perspective { tan_half_height } = camera.projection else { return (*view, DVec2::ZERO) };
        let [right, up, middle] = [camera.right, camera.up, camera.position].map(Vec3::as_dvec3);
        let off = point * self.radius;
        let position = (middle + right * off.x + up * off.y).as_vec3();
        // As it was rounded.
        let moved = position.as_dvec3() - middle;
        let pixels_per_unit = f64::from(view.height) / (2.0 * f64::from(tan_half_height) * self.focus);
        let shift = DVec2::new(-moved.dot(right), moved.dot(up)) * pixels_per_unit;
        let shift = (shift * STEPS_PER_PIXEL).round() / STEPS_PER_PIXEL;
        (View { camera: Camera { position, ..camera }, ..*view }, shift)
    }
}

/// From the unit square to the unit disk, uniformly: the first number is the squared distance from its middle.
fn disk(square: DVec2) -> DVec2 {
    DVec2::from_angle(TAU * square.y) * square.x.sqrt()
}

/// Point `number` of a sequence in the unit square, another one for each dimension: Sobol's first two dimensions, scrambled
/// and in another order each time, by hashes that stand for Owen's random trees (Burley, Practical Hash-based Owen Scrambling,
/// JCGT 9(4), 2020). Each 2ᵏ points that follow each other from a multiple of 2ᵏ on are spread evenly.
fn pair(number: u32, dimension: u32) -> DVec2 {
    let seed = |purpose: u32| mixed(dimension.wrapping_mul(3).wrapping_add(purpose).wrapping_add(1));
    let number = scrambled(number, seed(0));
    let unit = |bits: u32| (f64::from(bits) + 0.5) / (1_u64 << u32::BITS) as f64;
    DVec2::new(unit(scrambled(number.reverse_bits(), seed(1))), unit(scrambled(second_sobol(number), seed(2))))
}

/// The second dimension of Sobol's sequence.
fn second_sobol(number: u32) -> u32 {
    let columns = std::iter::successors(Some(1_u32 << 31), |column| Some(column ^ (column >> 1)));
    let of_bits = (0..u32::BITS).zip(columns).filter(|(bit, _)| number >> bit & 1 == 1);
    of_bits.fold(0, |sum, (_, column)| sum ^ column)
}

/// Flips each bit or not, by a hash of those above it.
fn scrambled(bits: u32, seed: u32) -> u32 {
    let mut x = bits.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// A hash of a number (the finaliser of `MurmurHash3`).
fn mixed(number: u32) -> u32 {
    let mut x = number.wrapping_mul(0x9e37_79b9);
    x = (x ^ (x >> 16)).wrapping_mul(0x85eb_ca6b);
    x = (x ^ (x >> 13)).wrapping_mul(0xc2b2_ae35);
    x ^ (x >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::Sample;

    #[test]
    fn points_are_spread_evenly_in_every_dimension_and_apart() {
        for dimension in 0..9 {
            let points: Vec<DVec2> = (0..64).map(|number| pair(number, dimension)).collect();
            // Of 64 points, each of 8 × 8 squares, of 2 × 32 and of 64 × 1 stripes has one.
            for columns in [1.0, 2.0, 8.0, 32.0, 64.0] {
                let cell = |point: &DVec2| ((point.x * columns) as u32, (point.y * 64.0 / columns) as u32);
                let mut cells: Vec<_> = points.iter().map(cell).collect();
                cells.sort_unstable();
                cells.dedup();
                assert_eq!(cells.len(), 64, "{dimension}: {columns} columns");
            }
        }
        // Two dimensions aren't the same, nor each other's mirror images.
        for (one, other) in [(0, 1), (0, 2), (1, 2), (2, 3), (3, 4)] {
            let product = |number| (pair(number, one).x - 0.5) * (pair(number, other).x - 0.5);
            let correlation = 12.0 * (0..256).map(product).sum::<f64>() / 256.0;
            assert!(correlation.abs() < 0.25, "{one}, {other}: {correlation}");
        }
    }

    #[test]
    fn balls_look_like_even_disks_from_everywhere() {
        let (radius, count) = (2.0, 4096);
        let points: Vec<Vec3> = (0..count)
            .map(|number| {
                let exposure = Exposure { number, is_only: false };
                let centre = LightSource::Point { position: Vec3::ONE };
                let LightSource::Point { position } = exposure.point_of(centre, radius, 6) else { panic!("a point") };
                position - Vec3::ONE
            })
            .collect();
        for from in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(0.5, -0.3, 0.8).normalize()] {
            for part in [0.25, 0.5, 0.75, 1.0 + 1e-5] {
                // Of an even disk, the area inside.
                let inside =
                    |point: &&Vec3| point.reject_from_normalized(from).length_squared() <= part * radius * radius;
                let share = points.iter().filter(inside).count() as f32 / count as f32;
                assert!((share - part).abs() < 0.02, "{share} for {part} from {from}");
            }
        }
    }

    #[test]
    fn what_is_in_focus_stays_in_its_pixel() {
        let camera = Camera::look_at(Vec3::new(3.1, -1.7, 2.3), Vec3::ZERO, Vec3::Y, 0.83);
        let view = View { camera, width: 1921, height: 1083 };
        for (radius, focus) in [(0.1, 7.0), (3.0, 0.7), (0.001, 5000.0)] {
            for number in 0..20 {
                let (moved, shift) = Lens { radius, focus }.seen_through(disk(pair(number, 0)), &view);
                let off = moved.camera.position.distance(camera.position);
                assert!(f64::from(off) <= radius * 1.01 + 1e-4 && moved.camera.forward == camera.forward);
                for [x, y] in [[0, 0], [7, 1082], [1920, 511]] {
                    let through = Sample { offset_pixels: Sample::MIDDLE.offset_pixels + shift, ..Sample::MIDDLE };
                    let [from_middle, from_point] = [Sample::MIDDLE.ray(&view, x, y), through.ray(&moved, x, y)];
                    let [expected, point] = [from_middle, from_point].map(|ray| ray.origin + ray.direction * focus);
                    let pixel = focus * 2.0 * 0.44 / 1083.0;
                    assert!(point.distance(expected) < 1e-3 * pixel, "{point}, {expected}");
                }
            }
        }
    }

    #[test]
    fn a_single_exposure_is_in_the_middle() {
        for count in [1, 4, 16] {
            for (number, samples) in (0..).zip(Samples::all(count, true)) {
                assert_eq!(Exposure::new(number, &samples).is_only, count < 16, "{count}");
            }
        }
    }
}
