//! What is asked of the worker, and what it makes.

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
    /// Whether it isn't known yet what the scene's pictures are about.
    pub(crate) needs_focus: bool,
    /// Where the picture goes as a file.
    pub(crate) file: Option<FileOrder>,
}

/// All that makes a picture of a scene another one.
#[derive(Clone, PartialEq)]
pub(crate) struct Look {
    pub(crate) seconds: f64,
    /// But for the background, which may have to be read.
    pub(crate) settings: Settings,
    pub(crate) background: BackgroundSpec,
    pub(crate) engine: EngineChoice,
    pub(crate) show: Show,
    /// Whether the light's grid is shown.
    pub(crate) shows_light_grid: bool,
    /// The light that these are about, by its index in the list, where any is.
    pub(crate) light: Option<usize>,
}

impl Look {
    /// Whether the other one is the same but for how many samples its pixels have.
    pub(crate) fn differs_in_samples(&self, other: &Self) -> bool {
        let settings = Settings { samples: self.settings.samples, ..other.settings.clone() };
        *self == Self { settings, ..other.clone() }
    }
}

/// A picture's way to a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum FileOrder {
    /// A file of its own.
    Still(PathBuf),
    /// The next frame of a recording.
    Frame(Recording),
}

/// A finished picture.
pub(crate) struct Picture {
    /// The number of its order.
    pub(crate) number: u64,
    pub(crate) seconds: f64,
    /// Where it was seen from.
    pub(crate) view: View,
    pub(crate) pixels: Pixels,
    pub(crate) heat: Option<HeatMap>,
    pub(crate) light_grid: Option<LightGridPicture>,
    pub(crate) stats: Stats,
    /// What rendered it.
    pub(crate) device: String,
    /// The lights and cameras of its moment, and the whole animation's bounds.
    pub(crate) lights: Vec<Light>,
    pub(crate) cameras: Vec<NamedCamera>,
    pub(crate) bounds: Bounds,
    /// Known where the film was fetched.
    pub(crate) focus: Option<Focus>,
    /// How long it took from the order to the pixels, in milliseconds.
    pub(crate) milliseconds: f64,
}

impl Picture {
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.view.width as usize, self.view.height as usize]
    }
}
