//! The user's choices about pictures of any scene.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use umbrage::spec::BackgroundSpec;
use umbrage::{Settings, Sides, Structure, ToneMap, UnknownStructure};

/// Choices that outlive the window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Choices {
    pub(crate) engine: EngineChoice,
    /// The structure that finds triangles on the CPU.
    #[serde(with = "as_text")]
    pub(crate) structures: Structures,
    #[serde(with = "as_text")]
    pub(crate) sides: Sides,
    /// On the CPU.
    pub(crate) smooth_terminator: bool,
    pub(crate) bounces: u32,
    /// Sizes of points and lines, in pixels.
    pub(crate) point_size: f32,
    pub(crate) line_width: f32,
    /// Samples of pictures that stay, and of recordings.
    pub(crate) samples: u32,
    /// Samples of pictures in motion.
    pub(crate) samples_in_motion: u32,
    pub(crate) aperture: f32,
    /// Depth in world units; `None` for the depth of the picture's middle.
    pub(crate) focus: Option<f32>,
    pub(crate) shutter_seconds: f64,
    pub(crate) light_radius: f32,
    pub(crate) sky_shadows: bool,
    /// On the CPU.
    pub(crate) ambient_occlusion: f32,
    pub(crate) gloss: bool,
    pub(crate) resolution: Resolution,
    pub(crate) exposure_stops: f32,
    #[serde(with = "as_text")]
    pub(crate) tone_map: ToneMap,
    #[serde(with = "as_text")]
    pub(crate) surroundings: BackgroundSpec,
}

/// The engine that renders.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum EngineChoice {
    /// The processor.
    #[default]
    Cpu,
    /// The first adapter with this in its name.
    Gpu(String),
}

/// One of the structures; the others keep their options until they are chosen again.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Structures {
    all: Vec<Structure>,
    chosen: usize,
}

/// The size of pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Resolution {
    /// As many pixels as the screen shows.
    #[default]
    Window,
    /// One pixel for each square of screen pixels with this side.
    Fraction(u32),
    /// A fixed width and height in pixels.
    Fixed([u32; 2]),
}

/// Stores values by their names. Unknown names become the defaults.
mod as_text {
    use std::fmt::Display;
    use std::str::FromStr;

    use serde::{Deserialize, Deserializer, Serializer};

    pub(super) fn serialize<T: Display, S: Serializer>(value: &T, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(value)
    }

    pub(super) fn deserialize<'de, T: FromStr + Default, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
        Ok(String::deserialize(deserializer)?.parse().unwrap_or_default())
    }
}

impl Default for Choices {
    fn default() -> Self {
        let Settings { sides, smooth_terminator, bounces, aperture, focus, .. } = Settings::default();
        let Settings { shutter_seconds, light_radius, sky_shadows, ambient_occlusion, .. } = Settings::default();
        let Settings { gloss, exposure_stops, tone_map, point_size, line_width, .. } = Settings::default();
        Self {
            engine: EngineChoice::default(),
            structures: Structures::default(),
            sides,
            smooth_terminator,
            bounces,
            point_size,
            line_width,
            samples: 64,
            samples_in_motion: 1,
            aperture,
            focus,
            shutter_seconds,
            light_radius,
            sky_shadows,
            ambient_occlusion,
            gloss,
            resolution: Resolution::default(),
            exposure_stops,
            tone_map,
            surroundings: BackgroundSpec::default(),
        }
    }
}

impl Default for Structures {
    fn default() -> Self {
        Self { all: umbrage_papers::structures().iter().cloned().collect(), chosen: 0 }
    }
}

impl Structures {
    pub(crate) fn chosen(&self) -> &Structure {
        &self.all[self.chosen]
    }

    /// The chosen one, whose options may be changed.
    pub(crate) fn change(&mut self) -> &mut Structure {
        &mut self.all[self.chosen]
    }

    /// Chooses the structure of this name, with its last options.
    pub(crate) fn choose(&mut self, name: &str) {
        self.chosen = self.all.iter().position(|known| known.name() == name).unwrap_or(self.chosen);
    }
}

/// All structures, the chosen one first.
impl fmt::Display for Structures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.chosen())?;
        self.all.iter().try_for_each(|structure| write!(f, " {structure}"))
    }
}

impl FromStr for Structures {
    type Err = UnknownStructure;

    fn from_str(text: &str) -> Result<Self, UnknownStructure> {
        let known = umbrage_papers::structures();
        let named: Vec<Structure> = text.split(' ').map(|text| known.parse(text)).collect::<Result<_, _>>()?;
        let mut structures = Self::default();
        for structure in named.into_iter().rev() {
            structures.choose(structure.name());
            *structures.change() = structure;
        }
        Ok(structures)
    }
}

impl Choices {
    /// The settings of a picture for a screen of this size in pixels, without camera, lights and background.
    pub(crate) fn settings(&self, screen: [u32; 2]) -> Settings {
        let [width, height] = self.resolution.size(screen);
        // A GPU has one structure.
        let structure = match self.engine {
            EngineChoice::Cpu => self.structures.chosen().clone(),
            EngineChoice::Gpu(_) => Structure::default(),
        };
        let bounces = self.bounces.min(Settings::MAX_BOUNCES);
        Settings {
            width,
            height,
            samples: self.samples.clamp(1, Settings::MAX_SAMPLES),
            aperture: self.aperture,
            focus: self.focus,
            shutter_seconds: self.shutter_seconds,
            light_radius: self.light_radius,
            sky_shadows: self.sky_shadows,
            ambient_occlusion: if self.sky_shadows { 0.0 } else { self.ambient_occlusion },
            gloss: self.gloss && bounces > 0,
            structure,
            sides: self.sides,
            smooth_terminator: self.smooth_terminator && self.engine == EngineChoice::Cpu,
            bounces,
            point_size: in_pixels(self.point_size),
            line_width: in_pixels(self.line_width),
            exposure_stops: self.exposure_stops,
            tone_map: self.tone_map,
            ..Settings::default()
        }
    }
}

/// Clamps a size of points or lines to its range.
fn in_pixels(size: f32) -> f32 {
    let (least, most) = Settings::MARK_SIZES.into_inner();
    size.clamp(least, most)
}

impl Choices {
    /// The samples of the next picture: of the first one for `None`, else of the one that follows a picture with `shown`
    /// samples.
    pub(crate) fn samples_after(&self, shown: Option<u32>) -> u32 {
        const GROWTH: u32 = 4;
        let most = self.samples.clamp(1, Settings::MAX_SAMPLES);
        match shown {
            None => self.samples_in_motion.clamp(1, most),
            Some(shown) => shown.saturating_mul(GROWTH).min(most),
        }
    }
}

impl Resolution {
    /// The size of a picture on a screen of this size in pixels; at least one pixel a side.
    pub(crate) fn size(self, screen: [u32; 2]) -> [u32; 2] {
        let size = match self {
            Self::Window => screen,
            Self::Fraction(side) => screen.map(|pixels| pixels.div_ceil(side.max(1))),
            Self::Fixed(size) => size,
        };
        size.map(|side| side.clamp(1, Settings::MAX_SIDE))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_as_large_as_chosen() {
        assert_eq!(Resolution::Window.size([800, 600]), [800, 600]);
        assert_eq!(Resolution::Fraction(2).size([801, 600]), [401, 300]);
        assert_eq!(Resolution::Fixed([64, 32]).size([801, 600]), [64, 32]);
        // A picture has pixels even in a window without height.
        assert_eq!(Resolution::Window.size([800, 0]), [800, 1]);
    }

    #[test]
    fn pictures_become_sharper_until_they_have_all_their_samples() {
        let choices = Choices { samples: 40, samples_in_motion: 2, ..Choices::default() };
        let all = std::iter::successors(Some(choices.samples_after(None)), |&shown| {
            Some(choices.samples_after(Some(shown))).filter(|&samples| samples != shown)
        });
        assert!(all.eq([2, 8, 32, 40]));
        assert_eq!(Choices { samples: 1, ..choices }.samples_after(None), 1);
    }

    #[test]
    fn structures_keep_their_options() {
        let mut structures = Structures::default();
        structures.choose("kdtree");
        structures.change().set_option("builder", "presorted").expect("a builder");
        let tuned = structures.chosen().clone();
        structures.choose("bvh");
        assert_eq!(structures.to_string().parse(), Ok(structures.clone()));
        structures.choose("kdtree");
        assert!(*structures.chosen() == tuned && tuned != tuned.with_defaults());
        assert_eq!(structures.to_string().parse(), Ok(structures));
    }

    #[test]
    fn a_gpu_has_no_choice_of_structure() {
        let mut choices = Choices { bounces: 3, ..Choices::default() };
        choices.structures.choose("bvh");
        let on_cpu = choices.settings([8, 8]);
        assert_eq!((on_cpu.structure, on_cpu.bounces), (Structure::bvh(), 3));
        let on_gpu = Choices { engine: EngineChoice::Gpu(String::new()), ..choices }.settings([8, 8]);
        assert_eq!((on_gpu.structure, on_gpu.bounces), (Structure::default(), 3));
    }
}
