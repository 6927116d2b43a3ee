//! Frames on a GPU, stage by stage, by its own clock.

use std::io::{self, Write};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use serde::Serialize;
use umbrage::gpu::{Adapter, DeviceLimits, Gpu};
use umbrage::{Renderer, Settings, Stage};

use crate::frame::FrameFlags;
use crate::median::median;
use crate::shot::moments;
use crate::table::Form;

/// A scene's frames on a GPU.
#[derive(Debug, Serialize)]
struct Row {
    scene: String,
    triangles: usize,
    lights: usize,
    /// Medians over the frames by the GPU's clock, in milliseconds.
    stages: Vec<Stage>,
    /// Median of all stages that find what pixels see and what lights reach.
    traced_milliseconds: f64,
    /// Median of the whole frame by the CPU's clock, with posing, uploading and fetching.
    wall_milliseconds: f64,
    structure_bytes_per_triangle: f64,
    point_bytes_per_pixel: f64,
    bytes_per_pixel: f64,
}

/// Columns of the table, and the stages that each sums up.
const GROUPS: [(&str, &[&str]); 9] = [
    ("project", &["project"]),
    ("list", &["count", "scan", "scatter", "balance"]),
    ("trace", &["trace"]),
    ("settle", &["settle"]),
    ("points", &["survey", "choose", "map", "spread", "sort"]),
    ("lights", &["light project", "light count", "light scan", "light scatter", "light balance"]),
    ("shadow", &["light trace"]),
    ("settle", &["light settle"]),
    ("shade", &["shade"]),
];

/// Stages that aren't part of finding triangles and shadows, or happen on the CPU.
const BESIDE: [&str; 6] = ["animate", "build", "pose", "omit", "shade", "fetch"];

pub(crate) fn run(flags: &FrameFlags, scenes: &[String]) -> Result<()> {
    let gpu = open(flags)?;
    if !gpu.has_timestamps() {
        bail!("{} has no timestamps, so its stages can't be timed", gpu.adapter().name);
    }
    let Adapter { name, driver, backend, .. } = gpu.adapter().clone();
    drop(gpu);
    let mut out = io::stdout();
    if matches!(flags.form, Form::Table) {
        let FrameFlags { size: [width, height], samples, frames, .. } = flags;
        writeln!(out, "{name}, {backend}, {driver}")?;
        writeln!(out, "{width}x{height}, samples {samples}, medians of {frames} frames in milliseconds")?;
        write!(out, "{:<28}{:>10}{:>7}", "scene", "triangles", "lights")?;
        GROUPS.iter().try_for_each(|(group, _)| write!(out, "{group:>10}"))?;
        writeln!(out, "{:>9}{:>9}{:>7}{:>8}{:>8}", "traced", "wall", "B/tri", "B/point", "B/pixel")?;
    }
    let mut rows = Vec::new();
    for address in scenes {
        let row = measure(address, flags).with_context(|| format!("scene {address}"))?;
        if matches!(flags.form, Form::Table) {
            write_columns(&mut out, &row)?;
        }
        rows.push(row);
    }
    match flags.form {
        Form::Table => {}
        Form::Csv => write_values(&mut out, &rows)?,
        Form::Json => writeln!(out, "{}", serde_json::to_string_pretty(&rows)?)?,
    }
    Ok(())
}

fn open(flags: &FrameFlags) -> Result<Gpu> {
    Ok(Gpu::open(flags.device.as_deref().unwrap_or_default(), DeviceLimits::Adapter)?)
}

fn measure(address: &str, flags: &FrameFlags) -> Result<Row> {
    // Each scene has a device of its own: buffers stay as large as the largest scene needed them.
    let mut renderer = Renderer::with_gpu(open(flags)?)?;
    let scene = umbrage::open(address)?;
    let [width, height] = flags.size;
    let settings = Settings { width, height, samples: flags.samples, ..Settings::default() };
    let mut frames = Vec::new();
    let mut walls = Vec::new();
    // The first frame compiles kernels as well.
    for (seconds, is_counted) in moments(&scene, flags.frames) {
        let start = Instant::now();
        renderer.render(&scene, seconds, &settings)?;
        if is_counted {
            walls.push(1e3 * start.elapsed().as_secs_f64());
            frames.push(renderer.stats().stages.clone());
        }
    }
    let stats = renderer.stats();
    let of = |stages: &[Stage], name| -> f64 {
        stages.iter().filter(|stage| stage.name == name).map(|stage| stage.milliseconds).sum()
    };
    let traced = |stages: &Vec<Stage>| -> f64 {
        stages.iter().filter(|stage| !BESIDE.contains(&stage.name)).map(|stage| stage.milliseconds).sum()
    };
    let stages = stats
        .stages
        .iter()
        .map(|&Stage { name, .. }| Stage { name, milliseconds: median(frames.iter().map(|stages| of(stages, name))) });
    let pixels = f64::from(width) * f64::from(height);
    Ok(Row {
        scene: address.to_owned(),
        triangles: stats.triangles,
        lights: stats.lights,
        stages: stages.collect(),
        traced_milliseconds: median(frames.iter().map(traced)),
        wall_milliseconds: median(walls.iter().copied()),
        structure_bytes_per_triangle: stats.structure_bytes as f64 / stats.triangles.max(1) as f64,
        point_bytes_per_pixel: stats.point_bytes as f64 / pixels,
        bytes_per_pixel: stats.pixel_bytes as f64 / pixels,
    })
}

fn write_columns(out: &mut impl Write, row: &Row) -> io::Result<()> {
    write!(out, "{:<28}{:>10}{:>7}", row.scene, row.triangles, row.lights)?;
    for (_, names) in GROUPS {
        let in_group = row.stages.iter().filter(|stage| names.contains(&stage.name));
        write!(out, "{:>10.3}", in_group.map(|stage| stage.milliseconds).sum::<f64>())?;
    }
    writeln!(
        out,
        "{:>9.3}{:>9.2}{:>7.0}{:>8.0}{:>8.0}",
        row.traced_milliseconds,
        row.wall_milliseconds,
        row.structure_bytes_per_triangle,
        row.point_bytes_per_pixel,
        row.bytes_per_pixel
    )
}

/// One line for each stage of each scene.
fn write_values(out: &mut impl Write, rows: &[Row]) -> io::Result<()> {
    writeln!(out, "scene,triangles,lights,stage,milliseconds")?;
    for row in rows {
        for stage in &row.stages {
            let (scene, triangles, lights) = (&row.scene, row.triangles, row.lights);
            writeln!(out, "{scene},{triangles},{lights},{},{:.4}", stage.name, stage.milliseconds)?;
        }
    }
    Ok(())
}
