//! Heat maps: each pixel's cost as a colour over the picture.

use eframe::egui::Color32;
use umbrage::{HeatKind, HeatScale, Renderer, Settings, Structure, WorkCounts};
use umbrage_papers::Listed;

use crate::choices::EngineChoice;
use crate::light_grid::LightGridPicture;
use crate::order::Order;

/// Counts for each pixel, and their colours.
pub(crate) struct HeatMap {
    pub(crate) heat: HeatKind,
    /// The light, for counts of a light's cells.
    pub(crate) light: Option<usize>,
    /// In rows from the upper left corner.
    pub(crate) counts: Vec<u32>,
    pub(crate) scale: HeatScale,
    /// The engine that counted, where another one rendered.
    pub(crate) note: Option<&'static str>,
}

impl HeatMap {
    pub(crate) fn pixels(&self) -> Vec<Color32> {
        let colors = self.counts.iter().map(|&count| self.scale.color(count));
        colors.map(|[red, green, blue]| Color32::from_rgb(red, green, blue)).collect()
    }

    /// The title: the counted quantity, its light and the engine.
    pub(crate) fn title(&self) -> String {
        let light = self.light.map(|light| format!(" of light {}", light + 1)).unwrap_or_default();
        let note = self.note.map(|note| format!(", {note}")).unwrap_or_default();
        format!("{}{light}{note}", title(self.heat))
    }
}

/// The counted quantity, as a title.
pub(crate) fn title(heat: HeatKind) -> String {
    capitalised(heat.title())
}

/// Capitalises words that begin with an ASCII letter.
pub(crate) fn capitalised(words: &str) -> String {
    words[..1].to_uppercase() + &words[1..]
}

/// Makes heat maps, in reused memory.
#[derive(Default)]
pub(crate) struct HeatMaker {
    counter: Renderer,
    counts: WorkCounts,
    /// The order counted last, and its light, if that exists.
    counted: Option<(u64, Option<usize>)>,
}

impl HeatMaker {
    /// Counts the work of an order's picture; `settings` hold its camera.
    ///
    /// # Errors
    /// Where the scene's work can't be counted.
    pub(crate) fn make(
        &mut self,
        heat: HeatKind,
        order: &Order,
        renderer: &Renderer,
        settings: &Settings,
    ) -> Result<HeatMap, String> {
        let (settings, mut note) = countable(order, settings);
        let light = self.count(order, renderer, &settings)?.filter(|_| heat == HeatKind::Points);
        let WorkCounts { pixels: work, cells } = &self.counts;
        let pixels = (0..settings.height).flat_map(|y| (0..settings.width).map(move |x| (x, y)));
        if heat == HeatKind::Points && light.is_none() {
            note = Some("but there is no light");
        }
        let count = |(x, y)| match (heat, light) {
            (HeatKind::Points, Some(_)) => cells.points_at(x, y),
            (HeatKind::Points, None) => 0,
            _ => heat.of(work.at(x, y)).unwrap_or_default(),
        };
        let counts: Vec<u32> = pixels.map(count).collect();
        Ok(HeatMap { heat, light, scale: HeatScale::of(&counts), counts, note })
    }

    /// Makes a picture of the grid of the order's light, to draw over the order's picture; `None` without a light.
    ///
    /// # Errors
    /// As with [`HeatMaker::make`].
    pub(crate) fn light_grid(
        &mut self,
        order: &Order,
        renderer: &Renderer,
        settings: &Settings,
    ) -> Result<Option<LightGridPicture>, String> {
        let (settings, note) = countable(order, settings);
        let Some(number) = self.count(order, renderer, &settings)? else { return Ok(None) };
        let (source, size) = (&renderer.scenery().lights[number].source, [settings.width, settings.height]);
        Ok(Some(LightGridPicture::new(&self.counts.cells, size, number, source, note)))
    }

    /// Counts the work of the frame just rendered for an order, unless that is done. Returns the order's light, if
    /// it exists.
    fn count(&mut self, order: &Order, renderer: &Renderer, settings: &Settings) -> Result<Option<usize>, String> {
        if let Some((number, light)) = self.counted
            && number == order.number
        {
            return Ok(light);
        }
        self.counted = None;
        let light = order.look.light.filter(|&light| light < renderer.scenery().lights.len());
        let counted = self.counter.count_work(renderer.frame(), settings, light, &mut self.counts);
        counted.map_err(|error| error.to_string())?;
        self.counted = Some((order.number, light));
        Ok(light)
    }
}

/// Settings that the CPU can count, and a note where these differ from the rendering ones.
fn countable(order: &Order, settings: &Settings) -> (Settings, Option<&'static str>) {
    let (structure, note) = match (&order.look.engine, &settings.structure) {
        (EngineChoice::Gpu(_), _) => {
            (Structure::of::<Listed>(), Some("counted on the CPU, in triangles listed by cell"))
        }
        (_, structure) if structure.is_specialised() => (structure.clone(), None),
        _ => (Structure::default(), Some("counted in the perspective grid")),
    };
    (Settings { structure, ..settings.clone() }, note)
}
