//! Frames on a GPU, stage by stage, by its own clock.

use std::time::Instant;

use anyhow::{Context, Result, bail};
use umbrage::gpu::{Adapter, DeviceLimits, Gpu};
use umbrage::{Renderer, Settings, Stage};

use crate::frame::FrameFlags;
use crate::median::median;
use crate::shot::moments;
use crate::table::{Cell, Form, Row, Table, row};

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
    let FrameFlags { size: [width, height], samples, frames, .. } = flags;
    let conditions = format!(
        "{name}, {backend}, {driver}\n{width}x{height}, samples {samples}, medians of {frames} frames in milliseconds"
    );
    let mut table = Table::start(flags.form, &conditions)?;
    for address in scenes {
        let rows = measure(address, flags).with_context(|| format!("scene {address}"))?;
        rows.into_iter().try_for_each(|row| table.push(row))?;
    }
    Ok(table.finish(&[
        "traced: all that finds what pixels see and what lights reach; wall: the whole frame by the CPU's clock.",
    ])?)
}

fn open(flags: &FrameFlags) -> Result<Gpu> {
    Ok(Gpu::open(flags.device.as_deref().unwrap_or_default(), DeviceLimits::Adapter)?)
}

/// For people a row of groups of stages, else a row for each stage: medians over the frames by the GPU's clock.
fn measure(address: &str, flags: &FrameFlags) -> Result<Vec<Row>> {
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
    let head = row![("scene", address), ("triangles", stats.triangles), ("lights", stats.lights)];
    let pixels = f64::from(width) * f64::from(height);
    let bytes = |bytes: usize, each: f64| Cell::Number(bytes as f64 / each, 1);
    let tail = row![
        ("traced", Cell::Number(median(frames.iter().map(traced)), 3)),
        ("wall", median(walls.iter().copied())),
        ("bytes_triangle", bytes(stats.structure_bytes, stats.triangles.max(1) as f64)),
        ("light_bytes_pixel", bytes(stats.point_bytes, pixels)),
        ("bytes_pixel", bytes(stats.pixel_bytes, pixels)),
    ];
    let stages =
        stats.stages.iter().map(|stage| (stage.name, median(frames.iter().map(|stages| of(stages, stage.name)))));
    let stages: Vec<(&str, f64)> = stages.collect();
    let row = |middle: Row| head.iter().cloned().chain(middle).chain(tail.iter().cloned()).collect();
    if flags.form != Form::Table {
        let of_stage =
            |(name, time): &(&str, f64)| row(row![("stage", *name), ("milliseconds", Cell::Number(*time, 4))]);
        return Ok(stages.iter().map(of_stage).collect());
    }
    let groups = GROUPS.iter().map(|(group, names)| {
        let time = stages.iter().filter(|(name, _)| names.contains(name)).map(|(_, time)| time).sum();
        ((*group).to_owned(), Cell::Number(time, 3))
    });
    Ok(vec![row(groups.collect())])
}
