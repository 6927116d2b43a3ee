use std::ops::RangeInclusive;

use umbrage_rays::{Camera, View};
use umbrage_scene::{Frame, Light, check_camera, check_lights};

use crate::background::Surroundings;
use crate::engine::Staged;
use crate::film::{Coverage, Covered};
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
    /// How noisy a picture may be, in levels of 255, from 0: it is done with fewer [samples](Self::samples), 16, 32, 64 and so on,
    /// where the standard error of what it shows is estimated to be at most that, in the mean of all pixels' squares. Of
    /// films, not of textures.
    pub noise: f32,
    /// Diameter of the camera's lens in world units, from 0, where everything is sharp. Parallel cameras have none.
    pub aperture: f32,
    /// Depth at which the lens has everything sharp, in world units, above 0; `None` for that of what is in the middle of
    /// the image, or else of the middle of the scene.
    pub focus: Option<f32>,
    /// How long the shutter is open, in seconds from 0: half of that before the frame's moment, and half after it, but not
    /// beyond the animation's start and end. Of scenes alone.
    pub shutter_seconds: f64,
    /// Radius of the lights that have [no shape of their own](Light::shape), from 0: in world units, of directional lights in
    /// degrees.
    pub light_radius: f32,
    /// Whether light from all around casts shadows, too: each sample has one direction of it. With a single sample, it comes
    /// from everywhere without any.
    pub sky_shadows: bool,
    /// From where the scene is seen.
    pub camera: CameraChoice,
    /// The lights; `None` for the scene's own.
    pub lights: Option<Vec<Light>>,
    /// What finds the triangles that rays hit; the picture is the same either way.
    pub structure: Structure,
    /// Which sides of triangles stop rays.
    pub sides: Sides,
    /// Whether shadows begin where they would on the smooth surfaces that the vertices' normals stand for, instead of with whole
    /// triangles that face away from a light: points are moved there before lights are asked about them, as Hanika describes it
    /// (*Hacking the Shadow Terminator*, 2021). On the CPU.
    pub smooth_terminator: bool,
    /// How many mirrors, and surfaces of glass, one after the other, light may come by to the camera, 0 to
    /// [`Settings::MAX_BOUNCES`]: smooth surfaces show what is before them, and what bounds a volume of glass refracts what is
    /// behind it. With 0, and in the last of them, mirrors show the background alone, and all glass is as thin as a pane.
    pub bounces: u32,
    /// What less than this part of would reach the camera isn't followed, from 0: by default half of what a picture of 8 bits can
    /// show of white.
    pub least_contribution: f32,
    /// Whether rough surfaces show what is around them as smooth ones do, but blurred: each sample of a pixel follows one
    /// direction of the highlight. Otherwise, and with a single sample, they show the background alone.
    pub gloss: bool,
    /// How near something must be to keep light from all around away, in world units: each sample of a pixel looks that far in one
    /// direction. With 0, and with a single sample, nothing does; [`sky_shadows`](Self::sky_shadows) looks as
    /// far as the scene reaches.
    pub ambient_occlusion: f32,
    /// Diameter of points in pixels, from [`Settings::MARK_SIZES`]. On the CPU.
    pub point_size: f32,
    /// Width of lines in pixels, from [`Settings::MARK_SIZES`]. On the CPU.
    pub line_width: f32,
    /// What is behind and around the scene.
    pub background: Background,
    /// Brightness in photographic stops: each step doubles it.
    pub exposure_stops: f32,
    /// From linear radiance to what a screen can show.
    pub tone_map: ToneMap,
    /// What the film has beside its picture.
    pub layers: Layers,
    /// After how long [motion](Layer::Motion) ends, in seconds from 0: usually the time to the next frame. It doesn't go beyond
    /// the animation's end; a camera of your own stays where it is. Of scenes alone.
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

    /// Camera rays for each pixel of a single picture, and mirrors that light may come by, where `umbrage render` isn't told
    /// otherwise: edges are smooth, and mirrors and glass show the scene.
    pub const STILL_SAMPLES: u32 = 4;
    /// See [`STILL_SAMPLES`](Self::STILL_SAMPLES).
    pub const STILL_BOUNCES: u32 = 2;

    /// The most mirrors that light may come by.
    pub const MAX_BOUNCES: u32 = 1_024;

    /// The sizes that points and lines may have, in pixels.
    pub const MARK_SIZES: RangeInclusive<f32> = 0.5..=100.0;

    /// What a pixel takes until its picture is written, as measured: the film has 36 of these.
    pub(crate) const BYTES_OF_PIXEL: usize = 96;

    /// About how many bytes a picture takes until it is written, beside what the scene takes.
    #[must_use]
    pub fn picture_bytes(&self) -> u64 {
        // What four samples see that are traced together takes 32 bytes in place of 8.
        let of_four = if self.samples < 4 { 0 } else { 24 };
        (Self::BYTES_OF_PIXEL as u64 + of_four + self.layer_bytes()) * u64::from(self.width) * u64::from(self.height)
    }

    /// What a pixel's layers take, and as much again for writing them. Of the scene's lights it is known later how many they are.
    fn layer_bytes(&self) -> u64 {
        let lights = self.lights.as_ref().map_or(1, Vec::len) as u64;
        let of = |layer: Layer, bytes: u64| if self.layers.has(layer) { 2 * bytes } else { 0 };
        of(Layer::Shadow, 4 * lights)
            + of(Layer::Motion, 8)
            + of(Layer::Barycentric, 8)
            + of(Layer::Ids, 4)
            + of(Layer::Cryptomatte, size_of::<[Covered; Coverage::RANKS]>() as u64)
    }

    /// What the camera sees of a frame.
    ///
    /// # Errors
    /// [`Error::NoSuchCamera`], where the frame has no camera of the number that is asked for.
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

    /// The camera, unless one is made that sees the whole scene from outside; `None` as well where there is no such camera.
    pub(crate) fn chosen_camera<'a>(&'a self, frame: &'a Frame) -> Option<&'a Camera> {
        let number = match &self.camera {
            CameraChoice::Own(camera) => return Some(camera),
            CameraChoice::Scene(camera) => *camera,
            CameraChoice::Default => 0,
        };
        frame.cameras.get(number).map(|named| &named.camera)
    }

    /// The lights of a frame, or those in place of them.
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
        Ok(Staged { frame, lights: self.lights(frame), sky_lights: 0, view, settings: self, surroundings })
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

/// From where a scene is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum CameraChoice {
    /// The scene's own first camera, or else one that sees the whole scene.
    #[default]
    Default,
    /// One of the scene's own cameras, counted from 0, wherever it is at the frame's moment.
    Scene(usize),
    /// A camera of your own.
    Own(Camera),
}

impl From<Camera> for CameraChoice {
    fn from(camera: Camera) -> Self {
        Self::Own(camera)
    }
}

/// From linear radiance to what a screen can show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// Khronos PBR Neutral: colours up to 0.8 keep their hue and contrast, brighter ones are compressed towards white.
    #[default]
    PbrNeutral,
    /// Everything above one is cut off.
    Clip,
}
