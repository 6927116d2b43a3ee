//! Frames side by side with those of other ray tracers.

mod compare;
mod contest;
mod contestants;
mod print;

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::{Args, ValueEnum};
use umbrage::rays::{DirectGrids, PacketSide, UniformGrid, UniformOptions};
use umbrage_peers::Embree;

use crate::flags::{SceneFlags, size};
use crate::grids::Ours;
use crate::shot::Lights;
use crate::table::Form;

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
    /// The lights that cast shadows
    #[arg(long, value_enum, default_value = "first")]
    lights: Lights,
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
    let addresses = flags.scenes.addresses();
    let mut out = io::stdout();
    match flags.form {
        Form::Table => print::head(&mut out, flags, &addresses, embree.version())?,
        Form::Csv => print::csv_head(&mut out)?,
        Form::Json => {}
    }
    let mut rows = Vec::new();
    for address in addresses {
        let scene = umbrage::open(&address).with_context(|| format!("scene {address}"))?;
        let row = contest::hold(&address, &scene, flags, &embree).with_context(|| format!("scene {address}"))?;
        match flags.form {
            Form::Table => print::columns(&mut out, &row)?,
            Form::Csv => print::values(&mut out, &row)?,
            Form::Json => {}
        }
        rows.push(row);
    }
    match flags.form {
        Form::Table => print::means(&mut out, &rows)?,
        Form::Csv => {}
        Form::Json => writeln!(out, "{}", serde_json::to_string_pretty(&rows)?)?,
    }
    Ok(())
}
