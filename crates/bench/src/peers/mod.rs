//! Frames side by side with those of other ray tracers.

mod contest;
mod contestants;

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::{Args, ValueEnum};
use umbrage::rays::{DirectGrids, PacketSide, UniformGrid, UniformOptions};
use umbrage_peers::{Embree, TinyBvh};

use crate::flags::{SceneFlags, size};
use crate::grids::Ours;
use crate::measure::geometric_mean;
use crate::shot::{Lights, viewpoints};
use crate::table::{Form, Table};
use contest::{Libraries, Ratios};
pub(crate) use contestants::EmbreeSide;

#[derive(Debug, Args)]
pub(crate) struct PeersFlags {
    #[command(flatten)]
    scenes: SceneFlags,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x1024", value_parser = size)]
    size: [u32; 2],
    /// Camera rays for each pixel
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u32).range(1..))]
    samples: u32,
    /// Frames over each scene's animation
    #[arg(long, value_name = "N", default_value = "9", value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// How often each frame is traced by everyone, in turn
    #[arg(long, value_name = "N", default_value = "3", value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// The lights that cast shadows: first, all, or numbers of them, such as 1,2,4,8, each of which is measured. Where the
    /// scene has fewer, the others are its first one, turned around the scene
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "first")]
    lights: Vec<Lights>,
    /// Which of our structures takes part
    #[arg(long, value_enum, default_value = "perspective")]
    structure: OurStructure,
    /// Pixels a side of the uniform grid's packets: 2, 4, 8, 16 or 32
    #[arg(long, value_name = "N")]
    packet: Option<PacketSide>,
    /// Ask alpha masks and opacity about hits, which all triangles go without by default
    #[arg(long)]
    masks: bool,
    /// Trace through our own rays' hierarchy as well, one ray at a time
    #[arg(long)]
    bvh: bool,
    /// Embree's library [default: the system's]
    #[arg(long, value_name = "PATH", env = "UMBRAGE_EMBREE")]
    embree: Option<PathBuf>,
    /// tinybvh's library, which is compiled from crates/peers/src/tinybvh/glue.cpp [default: it doesn't take part]
    #[arg(long, value_name = "PATH", env = "UMBRAGE_TINYBVH", conflicts_with = "masks")]
    tinybvh: Option<PathBuf>,
    /// How the results are written
    #[arg(long, value_enum, default_value = "table")]
    form: Form,
}

/// Our structures that trace whole images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum OurStructure {
    /// A perspective grid for the camera and a light grid for each light
    Perspective,
    /// One uniform grid for all rays, traced in packets
    Grid,
}

impl PeersFlags {
    /// The conditions of measurement.
    fn conditions(&self, [major, minor, patch]: [u32; 3]) -> String {
        let Self { size: [width, height], samples, frames, rounds, .. } = self;
        let threads = rayon::current_num_threads();
        let lights = self.lights.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        let masks = if self.masks { "asked" } else { "not asked (all triangles opaque)" };
        format!(
            "Embree {major}.{minor}.{patch}, {width}x{height}, samples {samples}, threads {threads}, lights {lights}\n\
             alpha masks {masks}; medians of {frames} frames, {rounds} rounds each, in milliseconds"
        )
    }

    fn our_side(&self) -> Result<Ours> {
        ensure!(
            self.structure == OurStructure::Grid || self.packet.is_none(),
            "--packet is for `--structure grid`: only its rays are traced in packets"
        );
        Ok(match self.structure {
            OurStructure::Perspective => Ours::new(Box::<DirectGrids>::default()),
            OurStructure::Grid => {
                let packet = self.packet.unwrap_or_default();
                let mut grid = Box::<UniformGrid>::default();
                grid.set_options(UniformOptions { packet, ..UniformOptions::DEFAULT })?;
                Ours::new(grid)
            }
        })
    }
}

pub(crate) fn run(flags: &PeersFlags) -> Result<()> {
    let embree = Embree::load(flags.embree.as_deref(), rayon::current_num_threads())?;
    let tinybvh = flags.tinybvh.as_deref().map(TinyBvh::load).transpose()?;
    let libraries = Libraries { embree, tinybvh };
    let addresses = flags.scenes.addresses();
    let mut table = Table::start(flags.form, &flags.conditions(libraries.embree.version()))?;
    viewpoints(&addresses).iter().try_for_each(|viewpoint| table.note(viewpoint))?;
    let mut moving: Vec<(Lights, Ratios, Option<f64>)> = Vec::new();
    for address in addresses {
        let scene = umbrage::open(&address).with_context(|| format!("scene {address}"))?;
        let outcomes = contest::hold(&address, &scene, flags, &libraries);
        let outcomes = outcomes.with_context(|| format!("scene {address}"))?;
        for (index, (outcome, &lights)) in outcomes.iter().zip(&flags.lights).enumerate() {
            let before = index.checked_sub(1).map(|before| &outcomes[before]);
            outcome.rows(before).try_for_each(|row| table.push(row))?;
            moving.extend(outcome.is_moving.then(|| (lights, outcome.ratios(), outcome.tinybvh_ratio())));
        }
    }
    let means = flags.lights.iter().map(|&lights| means(&moving, lights)).collect::<Vec<_>>();
    let mut notes = vec![
        "ratio: a frame by the grids' frame; of_best: that of each frame's best round; no_rays: without making rays, which takes",
        "the others as long as `rays only`; light: our shadow pass by this one; per_light: what each light more than in the rows",
        "above adds to the frame. Pixels that differ: hit_or_miss, triangle, triangle at the same distance, shadows, of so many",
        "points, from Embree's or in its own rows tinybvh's. Embree's ways to build (low or medium quality) and tinybvh's layouts",
        "are sorted by frame.",
    ];
    notes.extend(means.iter().map(String::as_str));
    table.finish(&notes)?;
    Ok(())
}

/// The geometric means over moving scenes with this number of lights, as text.
fn means(moving: &[(Lights, Ratios, Option<f64>)], lights: Lights) -> String {
    let moving = moving.iter().filter(|(of, ..)| *of == lights);
    let mean = |of: fn(&Ratios) -> f64| geometric_mean(moving.clone().map(|(_, ratios, _)| of(ratios)));
    let tinybvh: Vec<f64> = moving.clone().filter_map(|(.., ratio)| *ratio).collect();
    let beside_tinybvh = if tinybvh.is_empty() {
        String::new()
    } else {
        format!("; beside tinybvh, ratio {:.2}", geometric_mean(tinybvh.into_iter()))
    };
    format!(
        "geometric mean of the {} moving scenes, lights {lights}: ratio {:.2}, of best {:.2}, without ray generation {:.2}, \
         a further light {:.2} of Embree's shadow pass{beside_tinybvh}",
        moving.clone().count(),
        mean(|ratios| ratios.frame),
        mean(|ratios| ratios.best),
        mean(|ratios| ratios.without_ray_generation),
        mean(|ratios| ratios.further_light)
    )
}
