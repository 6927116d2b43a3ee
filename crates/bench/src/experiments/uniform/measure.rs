use anyhow::{Context, Result};
use umbrage::rays::{Counts, LightMask, SeenPixels, Structure as _, UniformGrid, UniformOptions, ray_by_ray};
use umbrage::scene::Frame;

use crate::flags::AnimationFlags;
use crate::grids::time;
use crate::measure::median;
use crate::shot::{Lights, Shot, moments};

/// How the camera's rays are traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Way {
    /// In packets, by the options.
    Packets,
    /// In packets, and so are the first light's.
    PacketsAndShadows,
    /// One at a time, from cell to cell.
    Single,
}

/// Costs of building a grid and seeing through it: medians, in milliseconds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Costs {
    pub(super) triangles: usize,
    /// Pairs of a cell and a triangle in it.
    pub(super) references: usize,
    /// Grids inside of cells.
    pub(super) nested_grids: usize,
    pub(super) bytes: usize,
    pub(super) build: f64,
    pub(super) see: f64,
    pub(super) shadow: f64,
    /// Counts of the last frame.
    pub(super) counts: Counts,
}

/// Builds grids of each of `forms` over frames of the scene at `address` and sees through them, in turn.
pub(super) fn measure(
    address: &str,
    size: [u32; 2],
    forms: &[(UniformOptions, Way)],
    flags: &AnimationFlags,
) -> Result<Vec<Costs>> {
    let scene = umbrage::open(address).with_context(|| format!("scene {address}"))?;
    let mut trials = forms.iter().map(|&form| Trial::new(form, flags)).collect::<Result<Vec<_>>>()?;
    let mut frame = Frame::default();
    for (seconds, is_counted) in moments(&scene, flags.frames) {
        scene.pose(seconds, &mut frame)?;
        let shot = Shot { masks: flags.masks, ..Shot::new(&frame, address, size, 1, Lights::First) };
        for trial in &mut trials {
            trial.run(&shot, is_counted);
        }
    }
    Ok(trials.iter().map(|trial| trial.costs(frame.triangles().len())).collect())
}

struct Trial {
    grid: UniformGrid,
    way: Way,
    seen: SeenPixels,
    mask: LightMask,
    counts: Counts,
    /// Milliseconds to build, to see and to shadow.
    times: Vec<[f64; 3]>,
}

impl Trial {
    fn new((options, way): (UniformOptions, Way), flags: &AnimationFlags) -> Result<Self> {
        let mut grid = UniformGrid::with_level(flags.simd.unwrap_or_default());
        grid.set_options(options)?;
        let (seen, mask) = (SeenPixels::default(), LightMask::default());
        Ok(Self { grid, way, seen, mask, counts: Counts::default(), times: Vec::new() })
    }

    fn run(&mut self, shot: &Shot<'_>, is_counted: bool) {
        let Self { grid, way, seen, mask, counts, times } = self;
        let (triangles, mut spent) = (shot.frame.triangles(), [0.0; 3]);
        time(&mut spent[0], || grid.build(triangles));
        let opacities = shot.opacities();
        let question = shot.question(&opacities, &shot.samples[0]);
        time(&mut spent[1], || match way {
            Way::Packets | Way::PacketsAndShadows => *counts = grid.see(&question, seen),
            Way::Single => {
                ray_by_ray::see(&*grid, &question, seen);
                *counts = grid.take_visits();
            }
        });
        if let (Way::PacketsAndShadows, Some(light)) = (way, shot.lights.first()) {
            time(&mut spent[2], || grid.shadow(&question, seen, light, mask));
        }
        if is_counted {
            times.push(spent);
        }
    }

    fn costs(&self, triangles: usize) -> Costs {
        let of = |stage: usize| median(self.times.iter().map(|times| times[stage]));
        let references = self.grid.references() + self.grid.nested_references();
        let (nested_grids, bytes) = (self.grid.nested_grids(), self.grid.bytes().triangles);
        let [build, see, shadow] = [0, 1, 2].map(of);
        Costs { triangles, references, nested_grids, bytes, build, see, shadow, counts: self.counts }
    }
}
