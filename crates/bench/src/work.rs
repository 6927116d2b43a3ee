//! What the grids had to do for a frame, number by number under its name.

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};
use umbrage::Renderer;
use umbrage::rays::{GridCounts, LightGridCounts, LightGridSeconds};

/// What the camera's grid did, and the light grid for all lights together.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Work {
    #[serde(serialize_with = "as_map")]
    pub(crate) counts: Vec<(&'static str, u64)>,
    /// The light grid's own stages.
    #[serde(serialize_with = "as_map")]
    pub(crate) light_milliseconds: Vec<(&'static str, f64)>,
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
        let mut counts = light_counts(&LightGridCounts::default());
        let mut light_milliseconds = light_milliseconds(&LightGridSeconds::default());
        for (light, seconds) in lights {
            counts.iter_mut().zip(light_counts(&light)).for_each(|(sum, (_, count))| sum.1 += count);
            let stages = self::light_milliseconds(&seconds);
            light_milliseconds.iter_mut().zip(stages).for_each(|(sum, (_, time))| sum.1 += time);
        }
        let counts = camera_counts(camera).into_iter().chain(counts).collect();
        Self { counts, light_milliseconds: light_milliseconds.into() }
    }

    /// Names of all counts and stages, in their order.
    pub(crate) fn names() -> impl Iterator<Item = &'static str> {
        let Self { counts, light_milliseconds } = Self::sum(&GridCounts::default(), None);
        let counts = counts.into_iter().map(|(name, _)| name);
        counts.chain(light_milliseconds.into_iter().map(|(name, _)| name))
    }
}

fn camera_counts(counts: &GridCounts) -> [(&'static str, u64); 4] {
    let GridCounts { fragments, listed, undecided, referred } = *counts;
    [("fragments", fragments), ("listed", listed), ("camera_undecided", undecided), ("camera_referred", referred)]
}

fn light_counts(counts: &LightGridCounts) -> [(&'static str, u64); 8] {
    let LightGridCounts { points, outliers, layers, small_triangles, large_triangles, block_tests, undecided, masked } =
        *counts;
    [
        ("points", points),
        ("outliers", outliers),
        ("layers", layers),
        ("small_triangles", small_triangles),
        ("large_triangles", large_triangles),
        ("block_tests", block_tests),
        ("light_undecided", undecided),
        ("light_masked", masked),
    ]
}

fn light_milliseconds(seconds: &LightGridSeconds) -> [(&'static str, f64); 6] {
    let LightGridSeconds { locate, map, sort, project, trace, decide } = *seconds;
    [("locate", locate), ("map", map), ("sort", sort), ("project", project), ("trace", trace), ("decide", decide)]
        .map(|(name, seconds)| (name, 1e3 * seconds))
}

fn as_map<S: Serializer, T: Copy + Serialize>(pairs: &[(&'static str, T)], serializer: S) -> Result<S::Ok, S::Error> {
    pairs.iter().copied().collect::<BTreeMap<_, _>>().serialize(serializer)
}
