//! The worker's orders and pictures.

use std::path::PathBuf;
use std::sync::Arc;

use umbrage::rays::{Bounds, View};
use umbrage::scene::{Light, NamedCamera};
use umbrage::spec::BackgroundSpec;
use umbrage::{Scene, Settings, Stats};

use crate::canvas::Pixels;
use crate::choices::EngineChoice;
use crate::focus::Focus;
use crate::heat::HeatMap;
use crate::light_grid::LightGridPicture;
use crate::recording::Recording;
use crate::show::Show;

/// A picture to render.
pub(crate) struct Order {
    /// Later orders have higher numbers.
    pub(crate) number: u64,
    pub(crate) scene: Arc<Scene>,
    pub(crate) look: Look,
    /// Whether the scene's focus isn't known yet.
    pub(crate) needs_focus: bool,
    /// The file to write, if any.
    pub(crate) file: Option<FileOrder>,
}

/// All choices that affect a picture of a scene.
#[derive(Clone, PartialEq)]
pub(crate) struct Look {
    pub(crate) seconds: f64,
    /// All settings but the background, which may have to be read.
    pub(crate) settings: Settings,
    pub(crate) background: BackgroundSpec,
    pub(crate) engine: EngineChoice,
    pub(crate) show: Show,
    /// Whether the light's grid is shown.
    pub(crate) shows_light_grid: bool,
    /// Index of the light whose grid or cells are shown, if any.
    pub(crate) light: Option<usize>,
}

impl Look {
    /// Whether two looks are equal but for the number of samples.
    pub(crate) fn differs_in_samples(&self, other: &Self) -> bool {
        let settings = Settings { samples: self.settings.samples, ..other.settings.clone() };
        *self == Self { settings, ..other.clone() }
    }
}

/// The kind of file that a picture goes to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum FileOrder {
    /// A single image.
    Still(PathBuf),
    /// The next frame of a recording.
    Frame(Recording),
}

/// A finished picture.
pub(crate) struct Picture {
    /// The order's number.
    pub(crate) number: u64,
    pub(crate) seconds: f64,
    /// The camera and size.
    pub(crate) view: View,
    pub(crate) pixels: Pixels,
    pub(crate) heat: Option<HeatMap>,
    pub(crate) light_grid: Option<LightGridPicture>,
    pub(crate) stats: Stats,
    /// The device that rendered it.
    pub(crate) device: String,
    /// The lights and cameras at its time, and the whole animation's bounds.
    pub(crate) lights: Vec<Light>,
    pub(crate) cameras: Vec<NamedCamera>,
    pub(crate) bounds: Bounds,
    /// Set where the film was fetched.
    pub(crate) focus: Option<Focus>,
    /// Time from the order to the pixels, in milliseconds.
    pub(crate) milliseconds: f64,
}

impl Picture {
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.view.width as usize, self.view.height as usize]
    }
}
