use std::ops::RangeInclusive;

use umbrage_rays::{Camera, View};
use umbrage_scene::{Frame, Light, check_camera, check_lights};

use crate::background::Surroundings;
use crate::engine::Staged;
use crate::film::{Coverage, Covered};
use crate::sampling::{Sample, Samples};
use crate::{Background, Error, Layer, Layers, Sides, Structure};

/// How a frame is rendered.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Width of the image in pixels, 1 to [`Settings::MAX_SIDE`].
    pub width: u32,
    /// Height of the image in pixels, 1 to [`Settings::MAX_SIDE`].
    pub height: u32,
    /// Camera rays for each pixel, spread evenly over it, 1 to [`Settings::MAX_SAMPLES`].
    ///
    /// They are spread over the lens, the time that the shutter is open, and the lights as well. A single one is in the
    /// middle of all of these, and so has everything sharp.
    pub samples: u32,
    /// Noise target, from 0, in levels of 255: the root mean square, over all pixels, of the picture's estimated
    /// standard error. Sampling stops after 16, 32, 64 and so on of the [samples](Self::samples), once the estimate is
    /// at most this. For films only, not for textures.
    pub noise: f32,
    /// Diameter of the camera's lens in world units, from 0, where everything is sharp. Parallel cameras have none.
    pub aperture: f32,
    /// Focus distance: the depth that the lens shows sharply, in world units, above 0. `None` focuses on the surface in
    /// the middle of the image, or else on the middle of the scene.
    pub focus: Option<f32>,
    /// Exposure time in seconds, from 0: half before and half after the frame's moment, but not beyond the animation's
    /// start and end. For scenes only.
    pub shutter_seconds: f64,
    /// Radius of the lights that have [no shape of their own](Light::shape), from 0: in world units, or in degrees for
    /// directional lights.
    pub light_radius: f32,
    /// Whether light from the surroundings casts shadows: each sample has one direction of it. With a single sample, it
    /// comes from all directions, without shadows.
    pub sky_shadows: bool,
    /// The camera.
    pub camera: CameraChoice,
    /// The lights; `None` for the scene's own.
    pub lights: Option<Vec<Light>>,
    /// Acceleration structure; all give the same picture.
    pub structure: Structure,
    /// Which sides of triangles stop rays.
    pub sides: Sides,
    /// Whether shadows begin on the smooth surface that the vertex normals describe, instead of with whole triangles
    /// that face away from a light. Shadow rays start at points moved to that surface, after Hanika (*Hacking the
    /// Shadow Terminator*, 2021). On the CPU.
    pub smooth_terminator: bool,
    /// Maximum number of mirrors and glass surfaces in a row on a path, 0 to [`Settings::MAX_BOUNCES`]. Smooth surfaces
    /// reflect the scene in front of them, and the boundaries of glass volumes refract the scene behind them. With 0,
    /// and at the last bounce, mirrors show the background alone, and all glass is as thin as a pane.
    pub bounces: u32,
    /// Minimum throughput, from 0: paths that contribute less are cut. The default is half a level, of 255, of a white
    /// pixel.
    pub least_contribution: f32,
    /// Whether rough surfaces reflect the scene, blurred: each sample of a pixel follows one direction of the
    /// highlight. Otherwise, and with a single sample, they reflect the background alone.
    pub gloss: bool,
    /// Ambient-occlusion radius, in world units, from 0: surfaces within it block light from the surroundings. Each
    /// sample of a pixel tests one direction. With 0, and with a single sample, nothing blocks it;
    /// [`sky_shadows`](Self::sky_shadows) tests as far as the scene reaches.
    pub ambient_occlusion: f32,
    /// Diameter of points in pixels, from [`Settings::MARK_SIZES`]. On the CPU.
    pub point_size: f32,
    /// Width of lines in pixels, from [`Settings::MARK_SIZES`]. On the CPU.
    pub line_width: f32,
    /// The background, behind and around the scene.
    pub background: Background,
    /// Brightness in photographic stops: each step doubles it.
    pub exposure_stops: f32,
    /// Tone map: from linear radiance to screen colours.
    pub tone_map: ToneMap,
    /// Whether the film has the depth, the normal and the triangle of each pixel's first hit. Pictures alone are made
    /// faster without them.
    pub first_hits: bool,
    /// Layers that the film has beside its picture.
    pub layers: Layers,
    /// Time span of [motion](Layer::Motion), in seconds from 0: usually the time to the next frame. It doesn't go
    /// beyond the animation's end; a camera of your own doesn't move. For scenes only.
    pub motion_seconds: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            samples: 1,
            noise: 0.0,
            aperture: 0.0,
            focus: None,
            shutter_seconds: 0.0,
            light_radius: 0.0,
            sky_shadows: false,
            camera: CameraChoice::Default,
            lights: None,
            structure: Structure::default(),
            sides: Sides::File,
            smooth_terminator: false,
            bounces: 0,
            least_contribution: 0.002,
            gloss: false,
            ambient_occlusion: 0.0,
            point_size: 2.0,
            line_width: 2.0,
            background: Background::Sky,
            exposure_stops: 0.0,
            tone_map: ToneMap::PbrNeutral,
            first_hits: true,
            layers: Layers::NONE,
            motion_seconds: 1.0 / 24.0,
        }
    }
}

impl Settings {
    /// The longest side of an image, in pixels.
    pub const MAX_SIDE: u32 = 16_384;
    /// The most camera rays for each pixel.
    pub const MAX_SAMPLES: u32 = 4_096;

    /// Default number of [samples](Self::samples) of a single picture in `umbrage render`: edges are smooth.
    pub const STILL_SAMPLES: u32 = 4;
    /// Default number of [bounces](Self::bounces) of a single picture in `umbrage render`: mirrors and glass show the
    /// scene.
    pub const STILL_BOUNCES: u32 = 2;

    /// The largest number of [bounces](Self::bounces).
    pub const MAX_BOUNCES: u32 = 1_024;

    /// The sizes that points and lines may have, in pixels.
    pub const MARK_SIZES: RangeInclusive<f32> = 0.5..=100.0;

    /// Bytes of memory for a pixel until its picture is written, as measured: the film has 36 of these.
    pub(crate) const BYTES_OF_PIXEL: usize = 96;

    /// Approximate memory of a picture until it is written, in bytes, without the scene's.
    #[must_use]
    pub fn picture_bytes(&self) -> u64 {
        // Hits of four samples that are traced together take 32 bytes instead of 8.
        let of_four = if self.samples < 4 { 0 } else { 24 };
        (Self::BYTES_OF_PIXEL as u64 + of_four + self.layer_bytes()) * u64::from(self.width) * u64::from(self.height)
    }

    /// Bytes of a pixel's layers, twice: to hold and to write them. The scene's own lights aren't counted yet and stand
    /// for one.
    fn layer_bytes(&self) -> u64 {
        let lights = self.lights.as_ref().map_or(1, Vec::len) as u64;
        let of = |layer: Layer, bytes: u64| if self.layers.has(layer) { 2 * bytes } else { 0 };
        of(Layer::Shadow, 4 * lights)
            + of(Layer::Motion, 8)
            + of(Layer::Barycentric, 8)
            + of(Layer::Ids, 4)
            + of(Layer::Cryptomatte, size_of::<[Covered; Coverage::RANKS]>() as u64)
    }

    /// The view of a frame: the chosen camera, with the image's size.
    ///
    /// # Errors
    /// [`Error::NoSuchCamera`], where the frame has no camera of the chosen index.
    pub fn view(&self, frame: &Frame) -> Result<View, Error> {
        let Self { width, height, .. } = *self;
        let camera = match self.camera {
            CameraChoice::Default => frame.camera(width as f32 / height as f32),
            CameraChoice::Own(camera) => camera,
            CameraChoice::Scene(camera) => {
                let missing = Error::NoSuchCamera { camera, cameras: frame.cameras.len() };
                frame.cameras.get(camera).ok_or(missing)?.camera
            }
        };
        Ok(View { camera, width, height })
    }

    /// The chosen camera; `None` if the frame doesn't have it, or a camera is made that sees the whole scene from
    /// outside.
    pub(crate) fn chosen_camera<'a>(&'a self, frame: &'a Frame) -> Option<&'a Camera> {
        let number = match &self.camera {
            CameraChoice::Own(camera) => return Some(camera),
            CameraChoice::Scene(camera) => *camera,
            CameraChoice::Default => 0,
        };
        frame.cameras.get(number).map(|named| &named.camera)
    }

    /// The lights: the settings' own, or else the frame's.
    pub(crate) fn lights<'a>(&'a self, frame: &'a Frame) -> &'a [Light] {
        self.lights.as_deref().unwrap_or(&frame.lights)
    }

    /// A frame with its view, lights and surroundings.
    pub(crate) fn stage<'a>(
        &'a self,
        frame: &'a Frame,
        surroundings: &'a Surroundings<'a>,
    ) -> Result<Staged<'a>, Error> {
        let view = self.view(frame)?;
        check_camera(&view.camera).map_err(Error::Camera)?;
        let (lights, samples) = (self.lights(frame), Samples::one(Sample::MIDDLE));
        Ok(Staged { frame, lights, sky_lights: 0, view, settings: self, surroundings, samples, band: 0 })
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        let Self { width, height, samples, bounces, .. } = *self;
        let sides = 1..=Self::MAX_SIDE;
        if !sides.contains(&width) || !sides.contains(&height) {
            return Err(Error::ImageSize { width, height });
        }
        self.structure.check()?;
        if !(1..=Self::MAX_SAMPLES).contains(&samples) {
            return Err(Error::Samples(samples));
        }
        for (what, number) in [
            ("the aperture", f64::from(self.aperture)),
            ("the noise", f64::from(self.noise)),
            ("the shutter's time", self.shutter_seconds),
            ("the lights' radius", f64::from(self.light_radius)),
            ("the reach of ambient occlusion", f64::from(self.ambient_occlusion)),
            ("the time of motion", self.motion_seconds),
            ("the least contribution", f64::from(self.least_contribution)),
        ] {
            if !(number.is_finite() && number >= 0.0) {
                return Err(Error::NotFromZero(what));
            }
        }
        for (what, size) in [("points", self.point_size), ("lines", self.line_width)] {
            if !Self::MARK_SIZES.contains(&size) {
                return Err(Error::MarkSize(what, size));
            }
        }
        if self.focus.is_some_and(|focus| !(focus.is_finite() && focus > 0.0)) {
            return Err(Error::Focus);
        }
        if bounces > Self::MAX_BOUNCES {
            return Err(Error::Bounces(bounces));
        }
        if let CameraChoice::Own(camera) = &self.camera {
            check_camera(camera).map_err(Error::Camera)?;
        }
        check_lights(self.lights.as_deref().unwrap_or_default())?;
        if !self.exposure_stops.is_finite() {
            return Err(Error::NotFinite("the exposure"));
        }
        match self.background {
            Background::Color(color) if !color.is_finite() => Err(Error::NotFinite("the background's colour")),
            Background::Color(_) | Background::Sky | Background::Transparent | Background::Image(_) => Ok(()),
        }
    }
}

/// The camera that sees a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum CameraChoice {
    /// The scene's own first camera, or else one that sees the whole scene.
    #[default]
    Default,
    /// One of the scene's own cameras, by its index from 0, as posed at the frame's moment.
    Scene(usize),
    /// A camera of your own.
    Own(Camera),
}

impl From<Camera> for CameraChoice {
    fn from(camera: Camera) -> Self {
        Self::Own(camera)
    }
}

/// Tone mapping: from linear radiance to screen colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// Khronos PBR Neutral: colours up to 0.8 keep their hue and contrast, brighter ones are compressed towards white.
    #[default]
    PbrNeutral,
    /// Everything above one is cut off.
    Clip,
}
