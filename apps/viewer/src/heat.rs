//! Pictures of work: what each pixel cost, as colours over the picture.

use eframe::egui::Color32;
use serde::{Deserialize, Serialize};
use umbrage::rays::{PixelWork, Work};
use umbrage::{HeatScale, Renderer, Settings, Structure};

use crate::choices::EngineChoice;
use crate::order::Order;

/// What is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Heat {
    /// Triangles tested on a pixel's sample.
    Tested,
    /// Cells of the camera's grid that were searched for it.
    Cells,
    /// Triangles that the filter left to the predicate.
    Undecided,
}

impl Heat {
    pub(crate) const ALL: [Self; 3] = [Self::Tested, Self::Cells, Self::Undecided];

    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Tested => "Triangles tested",
            Self::Cells => "Cells visited",
            Self::Undecided => "Undecided tests",
        }
    }

    fn of(self, work: Work) -> u32 {
        match self {
            Self::Tested => work.tested,
            Self::Cells => work.cells,
            Self::Undecided => work.undecided,
        }
    }
}

/// Counts for each pixel, and their colours.
pub(crate) struct HeatMap {
    pub(crate) heat: Heat,
    /// In rows from the upper left corner.
    pub(crate) counts: Vec<u32>,
    pub(crate) scale: HeatScale,
    /// What counted, where that isn't what rendered.
    pub(crate) note: Option<&'static str>,
}

impl HeatMap {
    pub(crate) fn pixels(&self) -> Vec<Color32> {
        let colors = self.counts.iter().map(|&count| self.scale.color(count));
        colors.map(|[red, green, blue]| Color32::from_rgb(red, green, blue)).collect()
    }
}

/// Counts, in memory that is used again.
#[derive(Default)]
pub(crate) struct HeatMaker {
    counter: Renderer,
    work: PixelWork,
}

impl HeatMaker {
    /// Counts the work of an order's picture, whose camera is in `settings`.
    ///
    /// # Errors
    /// Where the structure counts nothing.
    pub(crate) fn make(
        &mut self,
        heat: Heat,
        order: &Order,
        _renderer: &Renderer,
        settings: &Settings,
    ) -> Result<HeatMap, String> {
        let (structure, note) = match (&order.engine, settings.structure) {
            (EngineChoice::Gpu(_), _) => (Structure::LISTED, Some("counted on the CPU, in triangles listed by cell")),
            (_, Structure::Bvh) => (Structure::Perspective, Some("counted in the perspective grid")),
            (_, structure) => (structure, None),
        };
        let settings = Settings { structure, ..settings.clone() };
        let counted = self.counter.count_work(&order.scene, order.seconds, &settings, &mut self.work);
        counted.map_err(|error| error.to_string())?;
        let pixels = (0..settings.height).flat_map(|y| (0..settings.width).map(move |x| (x, y)));
        let counts: Vec<u32> = pixels.map(|(x, y)| heat.of(self.work.at(x, y))).collect();
        Ok(HeatMap { heat, scale: HeatScale::of(&counts), counts, note })
    }
}
