use anyhow::{Context, Result};
use umbrage::rays::{Counts, SeenPixels, Structure as _, UniformGrid, UniformOptions, ray_by_ray};
use umbrage::scene::Frame;

use crate::flags::AnimationFlags;
use crate::grids::time;
use crate::median::median;
use crate::shot::{Lights, Shot, moments};

/// How the camera's rays are traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Way {
    /// In packets, as the options say.
    Packets,
    /// One at a time, from cell to cell.
    Single,
}

/// What building a grid and seeing through it cost: medians, in milliseconds.
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
    /// Of the last frame.
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
    counts: Counts,
    /// Milliseconds to build, and to see.
    times: Vec<[f64; 2]>,
}

impl Trial {
    fn new((options, way): (UniformOptions, Way), flags: &AnimationFlags) -> Result<Self> {
        let mut grid = UniformGrid::with_level(flags.simd.unwrap_or_default());
        grid.set_options(options)?;
        Ok(Self { grid, way, seen: SeenPixels::default(), counts: Counts::default(), times: Vec::new() })
    }

    fn run(&mut self, shot: &Shot<'_>, is_counted: bool) {
        let Self { grid, way, seen, counts, times } = self;
        let (triangles, mut spent) = (shot.frame.triangles(), [0.0; 2]);
        time(&mut spent[0], || grid.build(triangles));
        time(&mut spent[1], || match way {
            Way::Packets => {
                let opacities = shot.opacities();
                *counts = grid.see(&shot.question(&opacities, &shot.samples[0]), seen);
            }
            Way::Single => {
                let opacities = shot.opacities();
                ray_by_ray::see(&*grid, &shot.question(&opacities, &shot.samples[0]), seen);
            }
        });
        if is_counted {
            times.push(spent);
        }
    }

    fn costs(&self, triangles: usize) -> Costs {
        let of = |stage: usize| median(self.times.iter().map(|times| times[stage]));
        let references = self.grid.references() + self.grid.nested_references();
        let (nested_grids, bytes) = (self.grid.nested_grids(), self.grid.bytes().triangles);
        Costs { triangles, references, nested_grids, bytes, build: of(0), see: of(1), counts: self.counts }
    }
}
