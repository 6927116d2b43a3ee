//! Work of the grids for a frame: counts by name.

use umbrage::Renderer;
use umbrage::rays::Counts;

use crate::table::Row;

/// Work of the camera's grid, and of the light grid for all lights together.
#[derive(Clone, Debug)]
pub(crate) struct Work {
    /// Whether any grid has counts.
    is_known: bool,
    counts: Vec<(String, u64)>,
    /// Milliseconds of the light grid's own stages; stages for all lights count once.
    light_milliseconds: Vec<(String, f64)>,
}

impl Work {
    /// Work of a renderer's last frame, at its last sample.
    pub(crate) fn of(renderer: &Renderer) -> Self {
        let (camera, lights) = (renderer.camera_work(), renderer.light_work());
        let mut sum = umbrage::Work::default();
        lights.iter().for_each(|light| sum += *light);
        // Shared by all lights, so counted once.
        sum.seconds.survey = lights.first().map_or(0.0, |first| first.seconds.survey);
        let named = |of: &'static str| move |(name, count)| (format!("{of}_{name}"), count);
        let counts = camera.counts.named().map(named("see")).chain(sum.counts.named().map(named("shadow")));
        let seconds = sum.seconds.named();
        let light_milliseconds = seconds.map(|(name, seconds)| (format!("shadow_{name}_ms"), 1e3 * seconds));
        Self {
            is_known: camera.counts != Counts::default() || !lights.is_empty(),
            counts: counts.collect(),
            light_milliseconds: light_milliseconds.collect(),
        }
    }

    /// All of it, as a table's columns.
    pub(crate) fn columns(&self) -> Row {
        let counts = self.counts.iter().map(|(name, count)| (name.clone(), self.is_known.then_some(*count).into()));
        let times = self.light_milliseconds.iter();
        counts.chain(times.map(|(name, time)| (name.clone(), self.is_known.then_some(*time).into()))).collect()
    }

    /// Non-zero counts, for people.
    pub(crate) fn lines(&self) -> [String; 2] {
        let counts = self.counts.iter().filter(|(_, count)| *count > 0).map(|(name, count)| format!("{name} {count}"));
        let times = self.light_milliseconds.iter().filter(|(_, time)| *time > 0.0);
        let times = times.map(|(name, time)| format!("{name} {time:.2}"));
        [counts.collect::<Vec<_>>().join(", "), times.collect::<Vec<_>>().join(", ")]
    }
}
