//! What the grids had to do for a frame, number by number under its name.

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};
use umbrage::Renderer;
use umbrage::rays::{GridCounts, LightGridCounts, LightGridSeconds};

/// What the camera's grid did, and the light grid for all lights together.
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
        let camera = renderer.camera_work();
        let lights = renderer.light_work();
        (camera != GridCounts::default() || !lights.is_empty())
            .then(|| Self::sum(&camera, lights.iter().map(|work| (work.counts, work.seconds))))
    }

    /// That of a camera and its lights.
    pub(crate) fn sum(
        camera: &GridCounts,
        lights: impl IntoIterator<Item = (LightGridCounts, LightGridSeconds)>,
    ) -> Self {
        let mut counts = LightGridCounts::default().named();
        let mut seconds = LightGridSeconds::default().named();
        for (place, (light, stages)) in lights.into_iter().enumerate() {
            let once = LightGridSeconds { survey: 0.0, ..stages };
            let stages = if place == 0 { stages } else { once };
            counts.iter_mut().zip(light.named()).for_each(|(sum, (_, count))| sum.1 += count);
            seconds.iter_mut().zip(stages.named()).for_each(|(sum, (_, time))| sum.1 += time);
        }
        let camera = camera.named().map(|(name, count)| (format!("see_{name}"), count));
        let light = counts.map(|(name, count)| (format!("shadow_{name}"), count));
        let light_milliseconds = seconds.map(|(name, seconds)| (format!("shadow_{name}_ms"), 1e3 * seconds)).into();
        Self { counts: camera.into_iter().chain(light).collect(), light_milliseconds }
    }

    /// Names of all counts and stages, in their order.
    pub(crate) fn names() -> impl Iterator<Item = String> {
        let Self { counts, light_milliseconds } = Self::sum(&GridCounts::default(), None);
        let counts = counts.into_iter().map(|(name, _)| name);
        counts.chain(light_milliseconds.into_iter().map(|(name, _)| name))
    }
}

fn as_map<S: Serializer, T: Copy + Serialize>(pairs: &[(String, T)], serializer: S) -> Result<S::Ok, S::Error> {
    pairs.iter().map(|(name, value)| (name, *value)).collect::<BTreeMap<_, _>>().serialize(serializer)
}
