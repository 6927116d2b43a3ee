//! A full report about a GPU, by one command.

mod frames;
mod launches;
mod roofline;

use std::fmt::Display;
use std::fs::File;
use std::io::Write;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use clap::Args;
use serde_json::{Map, Value};
use umbrage::gpu::{Adapter, Gpu};
use umbrage::{Renderer, Settings};
use umbrage_verify::Differences;

pub(crate) use frames::{Course, NOTE};
pub(crate) use roofline::{RooflineFlags, run as run_roofline};

use crate::shot;
use crate::table::{Form, Row, Table, json_of, row};

#[derive(Debug, Args)]
pub(crate) struct GpuFlags {
    /// Files, sequences or demo:NAME [default: the gallery]
    scenes: Vec<String>,
    /// The GPU, by a part of its name [default: the first]
    #[arg(long, value_name = "NAME", default_value = "", hide_default_value = true)]
    device: String,
    /// How long it may take: scenes that would be done later are left out
    #[arg(long, value_name = "N", default_value = "9", value_parser = minutes)]
    minutes: Duration,
    /// Write all of it to a file as well, with each stage of a frame by itself
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
}

/// Size of the image in which both engines are compared.
const COMPARED: [u32; 2] = [640, 360];

fn minutes(text: &str) -> Result<Duration, String> {
    let time = text.parse().ok().and_then(|minutes: f64| Duration::try_from_secs_f64(60.0 * minutes).ok());
    time.ok_or_else(|| "a number of minutes is needed, such as 9".to_owned())
}

pub(crate) fn run(flags: &GpuFlags) -> Result<()> {
    // Opened first, so that a file that can't be written fails now.
    let json = flags
        .json
        .as_ref()
        .map(|path| File::create(path).with_context(|| format!("could not write {}", path.display())));
    let json = json.transpose()?;
    let course =
        |size, samples, frames, has_one_light| Course { device: &flags.device, size, samples, frames, has_one_light };
    let still = course([1024, 1024], 1, 5, true);
    let smooth = course([1920, 1080], 32, 2, false);
    let scenes = shot::or_gallery(&flags.scenes);
    let mut report = Report::new(flags.minutes);

    let gpu = still.open()?;
    report.section("adapters", "GPUs, and programs that stand in for one", adapters(gpu.adapter()))?;
    report.section("limits", &format!("What {} has", gpu.adapter().name), limits(&gpu))?;
    report.section("launches", "Work that is nothing, medians", launches::measure(&gpu)?)?;
    drop(gpu);

    let [width, height] = COMPARED;
    let title = format!("Pixels that differ from the CPU engine's, {width}x{height}");
    let mut differing = 0;
    report.scenes("agreement", &title, &[], &scenes, |address| {
        let differences = differences(&still, address)?;
        differing += differences.triangles + differences.shadows;
        let Differences { triangles, shadows, colors, .. } = differences;
        let row = row![("scene", address), ("triangles", triangles), ("shadows", shadows), ("colors", colors)];
        Ok((row.clone(), vec![row]))
    })?;
    for (key, course, lights) in [("frames", still, "the first light"), ("samples", smooth, "all lights")] {
        let Course { size: [width, height], samples, frames, .. } = course;
        let title =
            format!("{width}x{height}, samples {samples}, {lights}, medians of {frames} frames in milliseconds");
        report.scenes(key, &title, &[NOTE], &scenes, |address| {
            let measured = course.measure(address)?;
            Ok((measured.grouped(), measured.each_stage()))
        })?;
    }
    if let Some(mut file) = json {
        writeln!(file, "{:#}", Value::Object(report.json))?;
    }
    ensure!(differing == 0, "{differing} answers differ from the CPU engine's");
    Ok(())
}

/// Tables as they come, and all of them as JSON at the end.
struct Report {
    started: Instant,
    most: Duration,
    json: Map<String, Value>,
}

impl Report {
    fn new(most: Duration) -> Self {
        Self { started: Instant::now(), most, json: Map::new() }
    }

    /// Writes a table of finished rows.
    fn section(&mut self, key: &str, title: &str, rows: Vec<Row>) -> Result<()> {
        let mut table = Table::start(Form::Table, title)?;
        rows.iter().try_for_each(|row| table.push(row.clone()))?;
        self.json.insert(key.to_owned(), rows.into_iter().map(json_of).collect());
        Ok(table.finish(&[""])?)
    }

    /// Writes a table with a row for each scene, while time is left: one for people, and one for programs.
    fn scenes(
        &mut self,
        key: &str,
        title: &str,
        notes: &[&str],
        scenes: &[String],
        mut measure: impl FnMut(&str) -> Result<(Row, Vec<Row>)>,
    ) -> Result<()> {
        let mut table = Table::start(Form::Table, title)?;
        let mut all = Vec::new();
        let mut longest = Duration::ZERO;
        let mut left_out = Vec::new();
        for address in scenes {
            if self.started.elapsed() + longest > self.most {
                left_out.push(address.as_str());
                continue;
            }
            let start = Instant::now();
            let (row, rows) = measure(address).with_context(|| format!("scene {address}"))?;
            longest = longest.max(start.elapsed());
            table.push(row)?;
            all.extend(rows.into_iter().map(json_of));
        }
        if !left_out.is_empty() {
            table.note(&format!("Left out, since --minutes are over: {}", left_out.join(", ")))?;
        }
        self.json.insert(key.to_owned(), Value::Array(all));
        Ok(table.finish(&[notes, &[""]].concat())?)
    }
}

/// All adapters, the chosen one marked.
fn adapters(chosen: &Adapter) -> Vec<Row> {
    let row = |adapter: Adapter| {
        row![
            ("adapter", adapter.name.as_str()),
            ("backend", adapter.backend.as_str()),
            ("kind", if adapter.is_software { "software" } else { "GPU" }),
            ("measured", if adapter == *chosen { "yes" } else { "" }),
            ("driver", adapter.driver.as_str()),
        ]
    };
    Adapter::all().into_iter().map(row).collect()
}

/// Limits of the device that matter to frames.
fn limits(gpu: &Gpu) -> Vec<Row> {
    let limits = gpu.device.limits();
    let of = |name: &str, value: &dyn Display| row![("limit", name), ("value", value.to_string())];
    vec![
        of("timestamps", &if gpu.has_timestamps() { "yes" } else { "no: stages can't be timed" }),
        of("bytes of a buffer", &limits.max_buffer_size),
        of("bytes of a binding", &limits.max_storage_buffer_binding_size),
        of("bytes of workgroup memory", &limits.max_compute_workgroup_storage_size),
        of("invocations of a workgroup", &limits.max_compute_invocations_per_workgroup),
        of("storage buffers of a stage", &limits.max_storage_buffers_per_shader_stage),
    ]
}

/// Differences of a frame in the middle of a scene's animation from the CPU engine's.
fn differences(course: &Course<'_>, address: &str) -> Result<Differences> {
    let scene = umbrage::open(address)?;
    let seconds = 0.4 * scene.duration_seconds();
    let [width, height] = COMPARED;
    let settings = Settings { width, height, ..Settings::default() };
    let (mut cpu, mut gpu) = (Renderer::default(), Renderer::with_gpu(course.open()?)?);
    cpu.render(&scene, seconds, &settings)?;
    gpu.render(&scene, seconds, &settings)?;
    Ok(Differences::between(&cpu, &gpu, &settings))
}
