use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use umbrage::gpu::Adapter;
use umbrage::rays::{Counts, SimdLevel};
use umbrage::scene::Frame;
use umbrage::{CameraChoice, Renderer, Settings, Structure};

use crate::far::Far;
use crate::flags::{size, use_threads};
use crate::gpu::{Course, NOTE};
use crate::measure::median;
use crate::shot::{moments, or_gallery};
use crate::table::{Cell, Form, Row, Table, row};

#[derive(Debug, Args)]
pub(crate) struct FrameFlags {
    /// Files, sequences or demo:NAME [default: the gallery]
    scenes: Vec<String>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x1024", value_parser = size)]
    size: [u32; 2],
    /// Camera rays for each pixel
    #[arg(long, value_name = "N", default_value = "1")]
    samples: u32,
    /// Frames over each scene's animation; each is rendered once through each structure, in turn
    #[arg(long, value_name = "N", default_value = "9")]
    frames: u32,
    /// Threads to work with [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// What renders: `gpu` times each stage by the GPU's own clock, and compares nothing
    #[arg(long, value_enum, default_value = "cpu")]
    engine: EngineFlag,
    /// The GPU, by a part of its name [default: the first]
    #[arg(long, value_name = "NAME")]
    device: Option<String>,
    /// SIMD instructions for the grids: sse2, avx2 or avx512 [default: the widest]
    #[arg(long, value_name = "LEVEL")]
    simd: Option<SimdLevel>,
    /// Print what the grids had to do as well, and how long the light grid's own stages took
    #[arg(long)]
    work: bool,
    /// Each scene twice more, on the CPU: with one vertex ten million scenes away, and with a triangle there that covers the
    /// image
    #[arg(long)]
    far: bool,
    /// How the results are written
    #[arg(long, value_enum, default_value = "table")]
    form: Form,
}

/// What renders.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum EngineFlag {
    /// The CPU, through perspective grids, the uniform grid and the hierarchy in turn
    Cpu,
    /// A GPU, or a program that stands in for one
    Gpu,
}

/// Stages that find the pixels' triangles and the lights' masks: the frame of the papers.
const TRACING: [&str; 3] = ["build", "see", "shadow"];
const STAGES: [&str; 5] = ["animate", "build", "see", "shadow", "shade"];

/// All but the paper's form, which `table1` measures.
fn structures() -> Vec<Structure> {
    umbrage_papers::structures().only(|structure| structure.name() != "listed").iter().cloned().collect()
}

pub(crate) fn run(flags: &FrameFlags) -> Result<()> {
    use_threads(flags.threads)?;
    let simd = flags.simd.unwrap_or_default();
    let scenes = or_gallery(&flags.scenes);
    if matches!(flags.engine, EngineFlag::Gpu) {
        return run_on_gpu(flags, &scenes);
    }
    let FrameFlags { size: [width, height], samples, frames, .. } = flags;
    let threads = rayon::current_num_threads();
    let conditions = format!(
        "{width}x{height}, samples {samples}, threads {threads}, {simd}, medians of {frames} frames in milliseconds"
    );
    let mut table = Table::start(flags.form, &conditions)?;
    let kinds: &[_] = if flags.far { &[None, Some(Far::Vertex), Some(Far::Triangle)] } else { &[None] };
    for (address, &far) in scenes.iter().flat_map(|address| kinds.iter().map(move |far| (address, far))) {
        for (row, work) in measure(address, flags, far).with_context(|| format!("scene {address}"))? {
            let is_for_people = flags.form == Form::Table;
            // Most columns are for programs.
            let columns = if flags.work && !is_for_people { work.columns() } else { Row::new() };
            table.push(row.into_iter().chain(columns).collect())?;
            if flags.work {
                work.lines()
                    .iter()
                    .filter(|line| !line.is_empty())
                    .try_for_each(|line| table.note(&format!("    {line}")))?;
            }
        }
    }
    Ok(table.finish(&["traced: build + see + shadow; ratio: the slowest structure's by this one's; bytes for each triangle and pixel."])?)
}

fn run_on_gpu(flags: &FrameFlags, scenes: &[String]) -> Result<()> {
    let FrameFlags { size, samples, frames, .. } = *flags;
    let device = flags.device.as_deref().unwrap_or_default();
    let course = Course { device, size, samples, frames, has_one_light: false };
    let gpu = course.open()?;
    let Adapter { name, driver, backend, .. } = gpu.adapter();
    if !gpu.has_timestamps() {
        bail!("{name} has no timestamps, so its stages can't be timed");
    }
    let [width, height] = size;
    let conditions = format!(
        "{name}, {backend}, {driver}\n{width}x{height}, samples {samples}, medians of {frames} frames in milliseconds"
    );
    let mut table = Table::start(flags.form, &conditions)?;
    for address in scenes {
        let measured = course.measure(address).with_context(|| format!("scene {address}"))?;
        let rows = if flags.form == Form::Table { vec![measured.grouped()] } else { measured.each_stage() };
        rows.into_iter().try_for_each(|row| table.push(row))?;
    }
    Ok(table.finish(&[NOTE])?)
}

/// A scene's frames through each structure: medians in milliseconds, and the grids' counts in the last frame's last sample.
fn measure(address: &str, flags: &FrameFlags, far: Option<Far>) -> Result<Vec<(Row, Work)>> {
    let scene = umbrage::open(address)?;
    let name = far.map_or_else(|| address.to_owned(), |far| format!("{address}, {}", far.name()));
    let [width, height] = flags.size;
    let settings = |structure, camera| Settings {
        width,
        height,
        samples: flags.samples,
        structure,
        camera,
        ..Settings::default()
    };
    let structures = structures();
    let renderer = || Renderer::with_simd_level(flags.simd.unwrap_or_default());
    let mut renderers: Vec<Renderer> = structures.iter().map(|_| renderer()).collect();
    let mut times: Vec<Vec<_>> = structures.iter().map(|_| Vec::new()).collect();
    let mut mesh = None;
    for (seconds, is_counted) in moments(&scene, flags.frames) {
        let far_frame = far.map(|far| -> Result<(Frame, CameraChoice)> {
            let mut frame = scene.at(seconds)?;
            let camera = frame.camera(width as f32 / height as f32);
            far.place(&mut frame, &camera, &mut mesh);
            Ok((frame, camera.into()))
        });
        let far_frame = far_frame.transpose()?;
        for ((renderer, times), structure) in renderers.iter_mut().zip(&mut times).zip(&structures) {
            match &far_frame {
                Some((frame, camera)) => renderer.render_frame(frame, &settings(structure.clone(), *camera))?,
                None => renderer.render(&scene, seconds, &settings(structure.clone(), CameraChoice::Default))?,
            };
            if is_counted {
                times.push(STAGES.map(|name| stage_milliseconds(renderer, name)));
            }
        }
    }
    let traced = |times: &[f64; 5]| -> f64 {
        STAGES.iter().zip(times).filter(|(name, _)| TRACING.contains(name)).map(|(_, time)| time).sum()
    };
    let traced: Vec<f64> = times.iter().map(|times| median(times.iter().map(traced))).collect();
    let slowest = traced.iter().copied().fold(0.0, f64::max);
    let pixels = f64::from(width) * f64::from(height);
    let rows =
        renderers.iter().zip(&times).zip(&traced).zip(&structures).map(|(((renderer, times), traced), structure)| {
            let stats = renderer.stats();
            let bytes = |bytes: usize, each: f64| Cell::Number(bytes as f64 / each, 1);
            let mut row = row![
                ("scene", name.as_str()),
                ("structure", structure.name()),
                ("triangles", stats.triangles),
                ("lights", stats.lights),
            ];
            let stages = STAGES.iter().enumerate();
            row.extend(
                stages.map(|(at, name)| ((*name).to_owned(), median(times.iter().map(|times| times[at])).into())),
            );
            row.extend(row![
                ("traced", *traced),
                ("ratio", slowest / traced),
                ("bytes_triangle", bytes(stats.structure_bytes, stats.triangles.max(1) as f64)),
                ("light_bytes_pixel", bytes(stats.point_bytes, pixels)),
                ("bytes_pixel", bytes(stats.pixel_bytes, pixels)),
            ]);
            (row, Work::of(renderer))
        });
    Ok(rows.collect())
}

fn stage_milliseconds(renderer: &Renderer, name: &str) -> f64 {
    renderer.stats().stages.iter().find(|stage| stage.name == name).map_or(0.0, |stage| stage.milliseconds)
}

/// Work of the camera's grid, and of the light grid for all lights together.
#[derive(Clone, Debug)]
pub(crate) struct Work {
    /// Whether any grid has counts.
    is_known: bool,
    counts: Vec<(String, u64)>,
    /// Milliseconds of the light grid's own stages; stages for all lights count once.
    light_milliseconds: Vec<(String, f64)>,
}

impl Work {
    /// Work of a renderer's last frame, at its last sample.
    pub(crate) fn of(renderer: &Renderer) -> Self {
        let (camera, lights) = (renderer.camera_work(), renderer.light_work());
        let mut sum = umbrage::Work::default();
        lights.iter().for_each(|light| sum += *light);
        // Shared by all lights, so counted once.
        sum.seconds.survey = lights.first().map_or(0.0, |first| first.seconds.survey);
        let named = |of: &'static str| move |(name, count)| (format!("{of}_{name}"), count);
        let counts = camera.counts.named().map(named("see")).chain(sum.counts.named().map(named("shadow")));
        let seconds = sum.seconds.named();
        let light_milliseconds = seconds.map(|(name, seconds)| (format!("shadow_{name}_ms"), 1e3 * seconds));
        Self {
            is_known: camera.counts != Counts::default() || !lights.is_empty(),
            counts: counts.collect(),
            light_milliseconds: light_milliseconds.collect(),
        }
    }

    /// All of it, as a table's columns.
    pub(crate) fn columns(&self) -> Row {
        let counts = self.counts.iter().map(|(name, count)| (name.clone(), self.is_known.then_some(*count).into()));
        let times = self.light_milliseconds.iter();
        counts.chain(times.map(|(name, time)| (name.clone(), self.is_known.then_some(*time).into()))).collect()
    }

    /// Non-zero counts, for people.
    pub(crate) fn lines(&self) -> [String; 2] {
        let counts = self.counts.iter().filter(|(_, count)| *count > 0).map(|(name, count)| format!("{name} {count}"));
        let times = self.light_milliseconds.iter().filter(|(_, time)| *time > 0.0);
        let times = times.map(|(name, time)| format!("{name} {time:.2}"));
        [counts.collect::<Vec<_>>().join(", "), times.collect::<Vec<_>>().join(", ")]
    }
}
