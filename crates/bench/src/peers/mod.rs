//! Frames side by side with those of other ray tracers.

mod compare;
mod contest;
mod contestants;
mod print;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use umbrage::Scene;
use umbrage_peers::Embree;

use crate::frame::{Form, size};

#[derive(Debug, Args)]
pub(crate) struct PeersFlags {
    /// Files, sequences or demo:NAME [default: the gallery's dynamic scenes, and the real ones of --files]
    scenes: Vec<String>,
    /// Folder of the real scenes
    #[arg(long, value_name = "DIR")]
    files: Option<PathBuf>,
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

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Lights {
    /// The frame's first one
    First,
    /// All of them, one after the other
    All,
}

/// Scenes of the gallery whose triangles all move or change.
const GALLERY: [&str; 6] = ["demo:cloth", "demo:forest", "demo:hall", "demo:shatter", "demo:statue", "demo:marbles"];
/// Files that are looked for in the folder of real scenes; those that aren't there are left away.
const FILES: [&str; 9] = [
    "cesium_man.glb",
    "robot_expressive.glb",
    "robot_arm.glb",
    "elephant_gallop.glb",
    "vintage_fan.glb",
    "horse_gallop_obj_sequence",
    "sibenik.obj",
    "country_kitchen.glb",
    "dream_apartment.glb",
];

pub(crate) fn run(flags: &PeersFlags) -> Result<()> {
    let embree = Embree::load(flags.embree.as_deref(), rayon::current_num_threads())?;
    if matches!(flags.form, Form::Table) {
        print::head(flags, embree.version());
    } else if matches!(flags.form, Form::Csv) {
        print::csv_head();
    }
    let mut rows = Vec::new();
    for address in scenes(flags) {
        let scene = Scene::open(&address).with_context(|| format!("scene {address}"))?;
        let row = contest::hold(&address, &scene, flags, &embree).with_context(|| format!("scene {address}"))?;
        match flags.form {
            Form::Table => print::columns(&row),
            Form::Csv => print::values(&row),
            Form::Json => {}
        }
        rows.push(row);
    }
    match flags.form {
        Form::Table => print::means(&rows),
        Form::Csv => {}
        Form::Json => println!("{}", serde_json::to_string_pretty(&rows)?),
    }
    Ok(())
}

/// Addresses of the scenes that take part.
fn scenes(flags: &PeersFlags) -> Vec<String> {
    if !flags.scenes.is_empty() {
        return flags.scenes.clone();
    }
    let path = |folder: &Path, name: &str| folder.join(name).to_string_lossy().into_owned();
    let files = flags.files.iter().flat_map(|folder| FILES.map(|name| path(folder, name)));
    GALLERY.map(str::to_owned).into_iter().chain(files.filter(|path| Path::new(path).exists())).collect()
}
