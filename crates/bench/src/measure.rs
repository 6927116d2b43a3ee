//! Medians of a scene's frames through the grids.

use anyhow::{Context, Result};
use umbrage::rays::{Bytes, Counts};
use umbrage::scene::Frame;

use crate::flags::AnimationFlags;
use crate::grids::{Forms, Ours, Times};
use crate::shot::{Lights, Shot, moments};

/// Costs of frames: medians, in milliseconds.
#[derive(Clone, Debug)]
pub(crate) struct Costs {
    /// Triangles of the last frame.
    pub(crate) triangles: usize,
    pub(crate) build: f64,
    pub(crate) see: f64,
    pub(crate) survey: f64,
    pub(crate) shadow: f64,
    /// The median of the sums, not the sum of the medians.
    pub(crate) frame: f64,
    /// The light grid's own stages, which make up `survey` and `shadow`.
    pub(crate) light_stages: Vec<(&'static str, f64)>,
    /// Bytes of the grids at the end.
    pub(crate) bytes: Bytes,
    /// Counts of the last frame's camera, and of its lights.
    pub(crate) counts: Counts,
    pub(crate) light_counts: Counts,
}

/// Traces frames of the scene at `address`, with its first light, through grids of each of `forms` in turn. `arrange`
/// may change each frame's shot.
pub(crate) fn measure(
    address: &str,
    size: [u32; 2],
    forms: &[Forms],
    flags: &AnimationFlags,
    arrange: impl Fn(&mut Shot<'_>),
) -> Result<Vec<Costs>> {
    let scene = umbrage::open(address).with_context(|| format!("scene {address}"))?;
    let mut frame = Frame::default();
    let level = flags.simd.unwrap_or_default();
    let mut grids: Vec<Ours> = forms.iter().map(|forms| Ours::new(forms.make(level))).collect();
    let mut logs: Vec<Log> = forms.iter().map(|_| Log::default()).collect();
    for (seconds, is_counted) in moments(&scene, flags.frames) {
        scene.pose(seconds, &mut frame)?;
        let mut shot = Shot { masks: flags.masks, ..Shot::new(&frame, address, size, 1, Lights::First) };
        arrange(&mut shot);
        for (grids, log) in grids.iter_mut().zip(&mut logs) {
            let times = grids.trace(&shot)?;
            if is_counted {
                log.push((times, light_stages(grids)));
            }
        }
    }
    let triangles = frame.triangles().len();
    Ok(grids.iter().zip(&logs).map(|(grids, log)| Costs::new(triangles, grids, log)).collect())
}

/// Each frame's stages, and those of the light grid.
type Log = Vec<(Times, Vec<(&'static str, f64)>)>;

/// Milliseconds of the light grid's own stages; zero for those that its form doesn't have.
fn light_stages(grids: &Ours) -> Vec<(&'static str, f64)> {
    grids.work[1].seconds.named().map(|(name, seconds)| (name, 1e3 * seconds)).collect()
}

impl Costs {
    /// Milliseconds of one of the light grid's own stages; zero if its form doesn't have it.
    pub(crate) fn light_stage(&self, name: &str) -> f64 {
        self.light_stages.iter().find(|stage| stage.0 == name).map_or(0.0, |stage| stage.1)
    }

    fn new(triangles: usize, grids: &Ours, log: &Log) -> Self {
        let of = |stage: fn(&Times) -> f64| median(log.iter().map(|(times, _)| stage(times)));
        let mut light_stages = light_stages(grids);
        for (index, stage) in light_stages.iter_mut().enumerate() {
            stage.1 = median(log.iter().map(|(_, stages)| stages[index].1));
        }
        Self {
            triangles,
            build: of(|times| times.build),
            see: of(|times| times.see),
            survey: of(|times| times.survey),
            shadow: of(|times| times.shadow),
            frame: of(Times::frame),
            light_stages,
            bytes: grids.bytes(),
            counts: grids.work[0].counts,
            light_counts: grids.work[1].counts,
        }
    }
}

/// The middle one of `values`, the upper one of two; NaN if there are none.
pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The geometric mean of `values`, all above zero; NaN if there are none.
pub(crate) fn geometric_mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0.0), |(sum, count), value| (sum + value.ln(), count + 1.0));
    (sum / count).exp()
}
