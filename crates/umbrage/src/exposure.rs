//! Depth of field, motion blur and lights with a size: a picture is the mean of exact frames, each of which has one point of
//! the lens, one moment, and one point of every light.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec3};
use umbrage_rays::{Camera, LightSource, Projection, View};
use umbrage_scene::{Frame, Light, LightShape};

use crate::engine::{Passes, Staged};
use crate::noise::NoiseMeter;
use crate::points::{disk, pair, triple};
use crate::probe::middle_depth;
use crate::sampling::Samples;
use crate::sky::SkyLights;
use crate::{Error, Film, Settings};

/// The dimensions, beside their pixels, that a frame's samples spread over.
#[derive(Debug)]
pub(crate) struct Spread {
    shutter_seconds: f64,
    /// Replaces a radius of zero.
    light_radius: f32,
    lens: Option<Lens>,
    has_wide_lights: bool,
    sky: Option<SkyLights>,
}

/// A thin lens: points in its focal plane are sharp.
#[derive(Clone, Copy, Debug)]
struct Lens {
    radius: f64,
    /// The depth of the focal plane.
    focus: f64,
}

impl Spread {
    /// The dimensions of a frame. `whole` gives the frame with its vertices, to find the hit in the middle of the picture.
    ///
    /// # Errors
    /// Where the camera has no lens, its focus is unknown, or a sun fills more than the sky.
    pub(crate) fn new<'a>(staged: &Staged<'_>, whole: impl FnOnce() -> &'a Frame) -> Result<Self, Error> {
        let Settings { samples, aperture, focus, shutter_seconds, light_radius, sky_shadows, .. } = *staged.settings;
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
        let has_wide_lights = staged.lights.iter().any(|light| light.shape.is_wide() || light_radius > 0.0);
        let points = (0..samples).map(|number| pair(number, Exposure::SKY));
        let has_sky = sky_shadows && samples > 1;
        let sky = has_sky.then(|| SkyLights::new(staged.surroundings, points)).flatten();
        Ok(Self { shutter_seconds, light_radius, lens: lens.transpose()?, has_wide_lights, sky })
    }

    /// Whether there is any such dimension. Then each sample is traced alone: four that are traced together would share one
    /// point of it, which makes more noise in the same time except in small images (docs/effects.md).
    pub(crate) fn is_wide(&self) -> bool {
        self.lens.is_some() || self.has_wide_lights || self.sky.is_some() || self.shutter_seconds > 0.0
    }

    /// The shape of a light.
    fn shape_of(&self, light: &Light) -> LightShape {
        if light.shape == LightShape::POINT { LightShape::Ball(self.light_radius) } else { light.shape }
    }
}

/// The exposures of a frame, band by band, until there are as many as the settings ask for or their noise is low enough.
#[derive(Debug)]
pub(crate) struct Exposures<'a> {
    settings: &'a Settings,
    spread: Spread,
    passes: Passes,
    /// Number of groups of samples in each band.
    groups: u32,
    band: usize,
    /// Number of the band's groups that were taken.
    taken: u32,
    /// Seconds of the last exposure.
    seconds: f64,
    noise: NoiseMeter,
    is_even: bool,
}

impl<'a> Exposures<'a> {
    /// The exposures of a frame whose first moment is built.
    pub(crate) fn new(settings: &'a Settings, spread: Spread, passes: Passes) -> Self {
        let by_four = passes.by_four && !spread.is_wide() && Samples::can_be_four(settings.samples);
        Self {
            settings,
            spread,
            passes: Passes { by_four, ..passes },
            groups: if by_four { settings.samples / 4 } else { settings.samples },
            band: 0,
            taken: 0,
            seconds: 0.0,
            noise: NoiseMeter::default(),
            is_even: false,
        }
    }

    /// The next exposure; `None` once there are enough.
    pub(crate) fn next(&mut self) -> Option<Exposure> {
        if self.taken == self.groups && self.band + 1 < self.passes.bands {
            (self.band, self.taken) = (self.band + 1, 0);
        }
        if self.is_even || self.taken == self.groups {
            return None;
        }
        // A single exposure is in the middle of every dimension.
        let number = (self.groups > 1).then_some(self.taken);
        let samples = Samples::group(self.taken, self.settings.samples, self.passes.by_four);
        let from_middle = |number| pair(number, Exposure::MOMENT).x - 0.5;
        let seconds = number.map_or(0.0, |number| self.spread.shutter_seconds * from_middle(number));
        let is_posed = seconds == self.seconds;
        (self.seconds, self.taken) = (seconds, self.taken + 1);
        Some(Exposure { number, samples, band: self.band, seconds, is_posed })
    }

    /// The exposure's own view: the same scene from its point of the lens, with each light at one point, stored in `lights`.
    /// Its samples' rays are shifted in their pixels for it.
    pub(crate) fn expose<'b>(
        &self,
        exposure: &Exposure,
        staged: &Staged<'b>,
        lights: &'b mut Vec<Light>,
    ) -> Staged<'b> {
        let Self { spread, .. } = self;
        let Exposure { samples, band, .. } = *exposure;
        let mut exposed = Staged { samples, band, ..*staged };
        let Some(number) = exposure.number else { return exposed };
        if let Some(lens) = spread.lens {
            let (view, shift_pixels) = lens.seen_through(disk(pair(number, Exposure::LENS)), &staged.view);
            (exposed.view, exposed.samples) = (view, samples.shifted(shift_pixels));
        }
        if spread.has_wide_lights || spread.sky.is_some() {
            lights.extend(staged.lights.iter().zip((Exposure::FIRST_LIGHT..).step_by(2)).map(|(light, dimension)| {
                let source = point_of(light.source, spread.shape_of(light), number, dimension);
                Light { source, ..light.clone() }
            }));
            if let Some(sky) = &spread.sky {
                lights.push(sky.light(pair(number, Exposure::SKY)));
                exposed.sky_lights = 1;
            }
            exposed.lights = lights;
        }
        exposed
    }

    /// Whether the film has to be complete now: at the end of a band, and where its noise is measured.
    pub(crate) fn need_film(&self) -> bool {
        self.taken == self.groups || NoiseMeter::looks_at(self.samples(), self.settings)
    }

    /// Measures the noise of a film that is the sum of all exposures so far.
    pub(crate) fn measure(&mut self, film: &Film) {
        self.is_even = self.noise.is_even(film, self.samples(), self.settings);
    }

    /// Number of samples of the band that were taken.
    pub(crate) fn samples(&self) -> u32 {
        self.taken * if self.passes.by_four { 4 } else { 1 }
    }

    /// The part of the frame that was taken, 0 to 1.
    pub(crate) fn part(&self) -> f32 {
        (self.band as f32 + self.taken as f32 / self.groups as f32) / self.passes.bands as f32
    }
}

/// One of the exact frames that make a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exposure {
    /// Its index in its band; `None` for the only one.
    number: Option<u32>,
    samples: Samples,
    band: usize,
    /// The time from the frame's moment to this exposure, negative before it.
    pub(crate) seconds: f64,
    /// Whether the exposure before was at the same time.
    pub(crate) is_posed: bool,
}

impl Exposure {
    /// Dimensions of samples: each purpose has a pair of numbers of its own.
    const LENS: u32 = 0;
    const MOMENT: u32 = 1;
    const FIRST_LIGHT: u32 = 2;
    const SKY: u32 = u32::MAX / 4;

    /// Whether it is the first one of its band.
    pub(crate) fn is_first(&self) -> bool {
        self.number.is_none_or(|number| number == 0)
    }
}

/// Point `number` of a light's shape.
///
/// A flat light's points are equally dense everywhere. From each direction a ball should look like a disk that is
/// equally bright everywhere, as does a sphere whose surface sends light equally in all directions. So points are as
/// dense as 1/√(1 − r²) at r of its radius: the sphere in four dimensions, seen from the side. Without occlusion,
/// irradiance is the centre's: that of a point is a field as gravity's, and the field of a ball is that of its centre
/// (Newton's shells).
fn point_of(source: LightSource, shape: LightShape, number: u32, dimension: u32) -> LightSource {
    if !shape.is_wide() {
        return source;
    }
    let drawn = triple(number, dimension);
    let flat = disk(drawn.truncate());
    // Offset from the light's middle; a flat light faces `direction`.
    let off = |direction: Vec3| {
        let in_plane = |point: DVec2| {
            let [across, up] = Light::axes(direction);
            across * point.x + up * point.y
        };
        match shape {
            LightShape::Ball(radius) => {
                let point = DVec3::new(flat.x, (1.0 - drawn.x).sqrt() * libm::cos(TAU * drawn.z), flat.y);
                point * f64::from(radius)
            }
            LightShape::Disk(radius) => in_plane(flat * f64::from(radius)),
            LightShape::Rectangle { width, height } => {
                in_plane((drawn.truncate() - 0.5) * DVec2::new(width.into(), height.into()))
            }
        }
    };
    let moved =
        |position: Vec3, direction: Vec3| (position.as_dvec3() + off(direction)).as_vec3().clamp(Vec3::MIN, Vec3::MAX);
    match source {
        LightSource::Point { position } => LightSource::Point { position: moved(position, Vec3::NEG_Y) },
        LightSource::Spot { position, direction, inner_radians, outer_radians } => {
            let position = moved(position, direction);
            LightSource::Spot { position, direction, inner_radians, outer_radians }
        }
        LightSource::Directional { direction } => {
            // A flat light is a lamp, which has a position.
            let LightShape::Ball(degrees) = shape else { return source };
            let along = direction.as_dvec3().normalize();
            let (right, up) = along.any_orthonormal_pair();
            let off = libm::tan(f64::from(degrees).to_radians()) * flat;
            let direction = (along + right * off.x + up * off.y).normalize().as_vec3();
            LightSource::Directional { direction }
        }
    }
}

impl Lens {
    /// A view from a point of the lens, as a unit disk, and the shift of its rays in the image, in pixels.
    ///
    /// The camera moves across its axis and keeps its axes, so to structures it is like any other. Points in focus stay in
    /// their pixels through a frustum that isn't symmetric: its image is another part of the same plane.
    fn seen_through(self, point: DVec2, view: &View) -> (View, DVec2) {
        /// Shifts are whole multiples of this, so that sums with pixels are exact.
        const STEPS_PER_PIXEL: f64 = (1 << 20) as f64;
        let camera = view.camera;
        let Projection::Perspective { tan_half_height } = camera.projection else { return (*view, DVec2::ZERO) };
        let [right, up, middle] = [camera.right, camera.up, camera.position].map(Vec3::as_dvec3);
        let off = point * self.radius;
        let position = (middle + right * off.x + up * off.y).as_vec3();
        // The offset after rounding.
        let moved = position.as_dvec3() - middle;
        let pixels_per_unit = f64::from(view.height) / (2.0 * f64::from(tan_half_height) * self.focus);
        let shift = DVec2::new(-moved.dot(right), moved.dot(up)) * pixels_per_unit;
        let shift = (shift * STEPS_PER_PIXEL).round() / STEPS_PER_PIXEL;
        (View { camera: Camera { position, ..camera }, ..*view }, shift)
    }
}

#[cfg(test)]
mod tests {
    use std::iter;

    use super::*;
    use crate::sampling::Sample;

    #[test]
    fn balls_look_like_even_disks_from_everywhere() {
        let (radius, count) = (2.0, 4096);
        let points: Vec<Vec3> = (0..count)
            .map(|number| {
                let centre = LightSource::Point { position: Vec3::ONE };
                let LightSource::Point { position } = point_of(centre, LightShape::Ball(radius), number, 6) else {
                    panic!("a point")
                };
                position - Vec3::ONE
            })
            .collect();
        for from in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(0.5, -0.3, 0.8).normalize()] {
            for part in [0.25, 0.5, 0.75, 1.0 + 1e-5] {
                // The share of an even disk's area inside.
                let inside =
                    |point: &&Vec3| point.reject_from_normalized(from).length_squared() <= part * radius * radius;
                let share = points.iter().filter(inside).count() as f32 / count as f32;
                assert!((share - part).abs() < 0.02, "{share} for {part} from {from}");
            }
        }
    }

    #[test]
    fn few_points_of_a_ball_are_as_bright_as_its_middle() {
        let centre = LightSource::Point { position: Vec3::ZERO };
        for count in [16, 64, 256] {
            for dimension in [2, 4, 6, 8] {
                let mut irradiance = DVec3::ZERO;
                for number in 0..count {
                    let LightSource::Point { position } = point_of(centre, LightShape::Ball(1.0), number, dimension)
                    else {
                        panic!()
                    };
                    let towards = position.as_dvec3() + DVec3::new(3.0, 6.0, 2.0);
                    irradiance += towards / towards.length().powi(3) / f64::from(count);
                }
                // As a point's, except for the error of so few points.
                let error = (irradiance.length() * 49.0 - 1.0).abs();
                assert!(error < 0.2 / f64::from(count), "{count}, {dimension}: {error}");
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

    fn spread(shutter_seconds: f64) -> Spread {
        Spread { shutter_seconds, light_radius: 0.0, lens: None, has_wide_lights: false, sky: None }
    }

    #[test]
    fn a_single_exposure_is_in_the_middle() {
        for samples in [1, 4, 16] {
            let settings = Settings { samples, ..Settings::default() };
            let passes = Passes { bands: 1, by_four: true };
            let mut exposures = Exposures::new(&settings, spread(0.0), passes);
            while let Some(exposure) = exposures.next() {
                assert_eq!(exposure.number.is_none(), samples < 16, "{samples}");
            }
            let mut exposures = Exposures::new(&settings, spread(0.5), passes);
            let moves = iter::from_fn(|| exposures.next()).filter(|exposure| !exposure.is_posed).count();
            assert_eq!(moves as u32, if samples == 1 { 0 } else { samples }, "four moments aren't traced together");
        }
    }

    #[test]
    fn every_band_takes_every_sample_and_is_then_complete() {
        let settings = Settings { samples: 6, ..Settings::default() };
        let mut exposures = Exposures::new(&settings, spread(0.0), Passes { bands: 2, by_four: true });
        for (step, (band, index)) in
            [0, 1].into_iter().flat_map(|band| (0..6).map(move |index| (band, index))).enumerate()
        {
            let exposure = exposures.next().expect("one for each sample of each band");
            assert_eq!((exposure.band, exposure.samples.as_slice()[0].index), (band, index));
            assert_eq!((exposure.is_first(), exposures.need_film()), (index == 0, index == 5));
            assert!((exposures.part() - (step + 1) as f32 / 12.0).abs() < 1e-6);
        }
        assert!(exposures.next().is_none() && exposures.samples() == 6);
    }
}
