//! Frames side by side with those of other ray tracers.

mod contest;
mod contestants;

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::{Args, ValueEnum};
use umbrage::rays::DirectGrids;
use umbrage_papers::{PacketSide, UniformGrid, UniformOptions};
use umbrage_peers::{Embree, TinyBvh};

use crate::flags::{SceneFlags, size};
use crate::grids::Ours;
use crate::measure::geometric_mean;
use crate::shot::{Lights, viewpoints};
use crate::table::{Form, Table};
use contest::{Libraries, Outcome, Ratios};
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
    /// Embree's library [default: the newest of the system's and of the Python package embreex]
    #[arg(long, value_name = "PATH", env = "UMBRAGE_EMBREE")]
    embree: Option<PathBuf>,
    /// tinybvh's library, which is compiled from crates/peers/src/tinybvh/glue.cpp [default: it doesn't take part]
    #[arg(long, value_name = "PATH", env = "UMBRAGE_TINYBVH", conflicts_with = "masks")]
    tinybvh: Option<PathBuf>,
    /// One row for each scene: the grids, and Embree at its fastest
    #[arg(long)]
    brief: bool,
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
    fn conditions(&self, embree: &Embree) -> String {
        let [major, minor, patch] = embree.version();
        let Self { size: [width, height], samples, frames, rounds, .. } = self;
        let threads = rayon::current_num_threads();
        let lights = self.lights.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        let rays = embree.packet_width();
        let masks = if self.masks { "asked" } else { "not asked (all triangles opaque)" };
        format!(
            "Embree {major}.{minor}.{patch}, packets of {rays}, {width}x{height}, samples {samples}, threads {threads}, lights {lights}\n\
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
    let mut table = Table::start(flags.form, &flags.conditions(&libraries.embree))?;
    viewpoints(&addresses).iter().try_for_each(|viewpoint| table.note(viewpoint))?;
    let mut all: Vec<(Lights, Outcome)> = Vec::new();
    for address in addresses {
        let scene = umbrage::open(&address).with_context(|| format!("scene {address}"))?;
        let outcomes = contest::hold(&address, &scene, flags, &libraries);
        let outcomes = outcomes.with_context(|| format!("scene {address}"))?;
        for (index, outcome) in outcomes.iter().enumerate() {
            let before = index.checked_sub(1).map(|before| &outcomes[before]);
            if flags.brief {
                table.push(outcome.brief_row())?;
            } else {
                outcome.rows(before).try_for_each(|row| table.push(row))?;
            }
        }
        all.extend(flags.lights.iter().copied().zip(outcomes));
    }
    for &lights in &flags.lights {
        let of_lights: Vec<_> = all.iter().filter(|(of, _)| *of == lights).map(|(_, outcome)| outcome).collect();
        let moving: Vec<_> = of_lights.iter().copied().filter(|outcome| outcome.is_moving).collect();
        for (name, outcomes) in [("all", &of_lights), ("moving", &moving)] {
            let ratios: Vec<_> = outcomes.iter().map(|outcome| outcome.ratios()).collect();
            let (Some(mean), Some(worst)) = (Ratios::mean(&ratios), Ratios::worst(&ratios)) else { continue };
            let number = outcomes.len();
            for (what, ratios) in [("mean", mean), ("worst", worst)] {
                let name = format!("{what} of {number} {name}");
                table.push(if flags.brief { ratios.brief_row(name) } else { ratios.row(name, lights) })?;
            }
        }
    }
    let tinybvh = flags.lights.iter().filter_map(|&lights| beside_tinybvh(&all, lights)).collect::<Vec<_>>();
    let mut notes = vec![
        "ratio: a frame by the grids' frame; of_best: that of each frame's best round; no_rays: without making rays, which takes",
        "the others as long as `rays only`; light: our shadow pass by this one; per_light: what each light more than in the rows",
        "above adds to the frame. Pixels that differ: hit_or_miss, triangle, triangle at the same distance, shadows, of so many",
        "points, from Embree's or in its own rows tinybvh's. Embree's ways to build (low or medium quality) and tinybvh's layouts",
        "are sorted by frame. Means are geometric, of each scene's fastest Embree, and the worst is the lowest ratio and the",
        "highest light; scenes with animations are moving.",
    ];
    if flags.brief {
        notes =
            vec!["Embree's fastest way to build; a further light is our shadow pass by Embree's. Means are geometric."];
    }
    notes.extend(tinybvh.iter().map(String::as_str));
    table.finish(&notes)?;
    Ok(())
}

/// The geometric mean of tinybvh's ratios over moving scenes with this number of lights, as text.
fn beside_tinybvh(all: &[(Lights, Outcome)], lights: Lights) -> Option<String> {
    let moving = all.iter().filter(|(of, outcome)| *of == lights && outcome.is_moving);
    let ratios: Vec<f64> = moving.filter_map(|(_, outcome)| outcome.tinybvh_ratio()).collect();
    let mean = geometric_mean(ratios.iter().copied());
    (!ratios.is_empty())
        .then(|| format!("beside tinybvh, geometric mean of {} moving scenes: ratio {mean:.2}", ratios.len()))
}
