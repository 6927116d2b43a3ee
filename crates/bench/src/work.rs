//! What the grids had to do for a frame, number by number under its name.

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};
use umbrage::Renderer;
use umbrage::rays::Counts;

/// What the camera's grid did, and what the light grid did for all lights together.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Work {
    #[serde(serialize_with = "as_map")]
    pub(crate) counts: Vec<(String, u64)>,
    /// The light grid's own stages; what serves all lights is counted once.
    #[serde(serialize_with = "as_map")]
    pub(crate) light_milliseconds: Vec<(String, f64)>,
}

impl Work {
    /// That of a renderer's last frame, at its last sample; `None` if no grid has had any.
    pub(crate) fn of(renderer: &Renderer) -> Option<Self> {
        let (camera, lights) = (renderer.camera_work(), renderer.light_work());
        (camera.counts != Counts::default() || !lights.is_empty()).then(|| Self::new(camera.counts, lights))
    }

    fn new(camera: Counts, lights: &[umbrage::Work]) -> Self {
        let mut sum = umbrage::Work::default();
        lights.iter().for_each(|light| sum += *light);
        // What serves all lights is counted once.
        sum.seconds.survey = lights.first().map_or(0.0, |first| first.seconds.survey);
        let named = |of: &'static str| move |(name, count)| (format!("{of}_{name}"), count);
        let counts = camera.named().map(named("see")).chain(sum.counts.named().map(named("shadow")));
        let seconds = sum.seconds.named();
        let light_milliseconds = seconds.map(|(name, seconds)| (format!("shadow_{name}_ms"), 1e3 * seconds));
        Self { counts: counts.collect(), light_milliseconds: light_milliseconds.collect() }
    }

    /// Names of all counts and stages, in their order.
    pub(crate) fn names() -> impl Iterator<Item = String> {
        let Self { counts, light_milliseconds } = Self::new(Counts::default(), &[]);
        let counts = counts.into_iter().map(|(name, _)| name);
        counts.chain(light_milliseconds.into_iter().map(|(name, _)| name))
    }
}

fn as_map<S: Serializer, T: Copy + Serialize>(pairs: &[(String, T)], serializer: S) -> Result<S::Ok, S::Error> {
    pairs.iter().map(|(name, value)| (name, *value)).collect::<BTreeMap<_, _>>().serialize(serializer)
}
