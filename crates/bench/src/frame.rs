use std::collections::BTreeMap;
use std::io::{self, Write};

use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use serde::Serialize;
use umbrage::rays::Choice as _;
use umbrage::rays::SimdLevel;
use umbrage::{Renderer, Settings, Structure};

use crate::flags::{size, use_threads};
use crate::gpu;
use crate::median::median;
use crate::shot::moments;
use crate::table::Form;
use crate::work::Work;

#[derive(Debug, Args)]
pub(crate) struct FrameFlags {
    /// Files, sequences or demo:NAME [default: the gallery]
    scenes: Vec<String>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x1024", value_parser = size)]
    pub(crate) size: [u32; 2],
    /// Camera rays for each pixel
    #[arg(long, value_name = "N", default_value = "1")]
    pub(crate) samples: u32,
    /// Frames over each scene's animation; each is rendered once through each structure, in turn
    #[arg(long, value_name = "N", default_value = "9")]
    pub(crate) frames: u32,
    /// Threads to work with [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// What renders: `gpu` times each stage by the GPU's own clock, and compares nothing
    #[arg(long, value_enum, default_value = "cpu")]
    engine: EngineFlag,
    /// The GPU, by a part of its name [default: the first]
    #[arg(long, value_name = "NAME")]
    pub(crate) device: Option<String>,
    /// SIMD instructions for the grids: sse2, sse4.2, avx2 or avx512 [default: the widest]
    #[arg(long, value_name = "LEVEL")]
    simd: Option<SimdLevel>,
    /// Print what the grids had to do as well, and how long the light grid's own stages took
    #[arg(long)]
    work: bool,
    /// How the results are written
    #[arg(long, value_enum, default_value = "table")]
    pub(crate) form: Form,
}

/// What renders.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum EngineFlag {
    /// The CPU, through perspective grids, the uniform grid and the hierarchy in turn
    Cpu,
    /// A GPU, or a program that stands in for one
    Gpu,
}

/// A scene's frames through one structure.
#[derive(Debug, Serialize)]
struct Row {
    scene: String,
    structure: &'static str,
    triangles: usize,
    lights: usize,
    /// Medians over the frames, in milliseconds, by stage.
    stages: BTreeMap<&'static str, f64>,
    /// Median of build + see + shadow.
    traced_milliseconds: f64,
    structure_bytes_per_triangle: f64,
    light_bytes_per_pixel: f64,
    bytes_per_pixel: f64,
    /// What the grids had to do in the last frame's last sample.
    work: Option<Work>,
}

/// The stages that find what pixels see and what lights reach: the frame of the papers.
const TRACING: [&str; 3] = ["build", "see", "shadow"];
const STAGES: [&str; 5] = ["animate", "build", "see", "shadow", "shade"];

/// All but the paper's form, which `table1` measures.
fn structures() -> Vec<Structure> {
    Structure::all().filter(|structure| *structure != Structure::LISTED).collect()
}

pub(crate) fn run(flags: &FrameFlags) -> Result<()> {
    use_threads(flags.threads)?;
    let simd = flags.simd.unwrap_or_default();
    let gallery: Vec<String> = umbrage::gallery::DEMOS.iter().map(|demo| format!("demo:{}", demo.name)).collect();
    let scenes = if flags.scenes.is_empty() { &gallery } else { &flags.scenes };
    if matches!(flags.engine, EngineFlag::Gpu) {
        return gpu::run(flags, scenes);
    }
    let mut out = io::stdout();
    match flags.form {
        Form::Table => write_head(&mut out, flags, simd)?,
        Form::Csv => write_names(&mut out, flags.work)?,
        Form::Json => {}
    }
    let mut rows = Vec::new();
    for address in scenes {
        let of_scene = measure(address, flags).with_context(|| format!("scene {address}"))?;
        match flags.form {
            Form::Table => of_scene.iter().try_for_each(|row| write_columns(&mut out, row, &of_scene, flags.work))?,
            Form::Csv => of_scene.iter().try_for_each(|row| write_values(&mut out, row, flags.work))?,
            Form::Json => {}
        }
        rows.extend(of_scene);
    }
    if matches!(flags.form, Form::Json) {
        writeln!(out, "{}", serde_json::to_string_pretty(&rows)?)?;
    }
    Ok(())
}

fn measure(address: &str, flags: &FrameFlags) -> Result<Vec<Row>> {
    let scene = umbrage::open(address)?;
    let [width, height] = flags.size;
    let settings = |structure| Settings { width, height, samples: flags.samples, structure, ..Settings::default() };
    let structures = structures();
    let renderer = || Renderer::with_simd_level(flags.simd.unwrap_or_default());
    let mut renderers: Vec<Renderer> = structures.iter().map(|_| renderer()).collect();
    let mut times: Vec<Vec<_>> = structures.iter().map(|_| Vec::new()).collect();
    for (seconds, is_counted) in moments(&scene, flags.frames) {
        for ((renderer, times), &structure) in renderers.iter_mut().zip(&mut times).zip(&structures) {
            renderer.render(&scene, seconds, &settings(structure))?;
            if is_counted {
                times.push(STAGES.map(|name| stage_milliseconds(renderer, name)));
            }
        }
    }
    let rows = renderers.iter().zip(&times).zip(&structures).map(|((renderer, times), structure)| {
        let stats = renderer.stats();
        let traced = |times: &[f64; 5]| -> f64 {
            STAGES.iter().zip(times).filter(|(name, _)| TRACING.contains(name)).map(|(_, time)| time).sum()
        };
        Row {
            scene: address.to_owned(),
            structure: structure.name(),
            triangles: stats.triangles,
            lights: stats.lights,
            stages: STAGES.iter().enumerate().map(|(at, &name)| (name, median(times.iter().map(|t| t[at])))).collect(),
            traced_milliseconds: median(times.iter().map(traced)),
            structure_bytes_per_triangle: stats.structure_bytes as f64 / stats.triangles.max(1) as f64,
            work: Work::of(renderer),
            light_bytes_per_pixel: stats.point_bytes as f64 / (f64::from(width) * f64::from(height)),
            bytes_per_pixel: stats.pixel_bytes as f64 / (f64::from(width) * f64::from(height)),
        }
    });
    Ok(rows.collect())
}

fn stage_milliseconds(renderer: &Renderer, name: &str) -> f64 {
    renderer.stats().stages.iter().find(|stage| stage.name == name).map_or(0.0, |stage| stage.milliseconds)
}

/// The head for people.
fn write_head(out: &mut impl Write, flags: &FrameFlags, simd: SimdLevel) -> io::Result<()> {
    let FrameFlags { size: [width, height], frames, samples, .. } = flags;
    let threads = rayon::current_num_threads();
    writeln!(
        out,
        "{width}x{height}, samples {samples}, threads {threads}, {simd}, medians of {frames} frames in milliseconds"
    )?;
    write!(out, "{:<28}{:>12}{:>10}{:>7}", "scene", "structure", "triangles", "lights")?;
    STAGES.iter().try_for_each(|stage| write!(out, "{stage:>9}"))?;
    writeln!(out, "{:>9}{:>7}{:>7}{:>8}{:>8}", "traced", "ratio", "B/tri", "B/point", "B/pixel")
}

/// The head of values with commas between them.
fn write_names(out: &mut impl Write, with_work: bool) -> io::Result<()> {
    write!(
        out,
        "scene,structure,triangles,lights,{},traced,bytes_per_triangle,light_bytes_per_pixel,bytes_per_pixel",
        STAGES.join(",")
    )?;
    if with_work {
        Work::names().try_for_each(|name| write!(out, ",{name}"))?;
    }
    writeln!(out)
}

fn write_columns(out: &mut impl Write, row: &Row, of_scene: &[Row], with_work: bool) -> io::Result<()> {
    let slowest = of_scene.iter().map(|row| row.traced_milliseconds).fold(0.0, f64::max);
    write!(out, "{:<28}{:>12}{:>10}{:>7}", row.scene, row.structure, row.triangles, row.lights)?;
    STAGES.iter().try_for_each(|stage| write!(out, "{:>9.2}", row.stages[stage]))?;
    let ratio = slowest / row.traced_milliseconds;
    let (traced, triangle) = (row.traced_milliseconds, row.structure_bytes_per_triangle);
    let (light, pixel) = (row.light_bytes_per_pixel, row.bytes_per_pixel);
    writeln!(out, "{traced:>9.2}{ratio:>7.1}{triangle:>7.0}{light:>8.0}{pixel:>8.0}")?;
    if let Some(Work { counts, light_milliseconds }) = row.work.as_ref().filter(|_| with_work) {
        let counts: Vec<String> =
            counts.iter().filter(|(_, count)| *count > 0).map(|(name, count)| format!("{name} {count}")).collect();
        let stages = light_milliseconds.iter().filter(|(_, time)| *time > 0.0);
        let stages: Vec<String> = stages.map(|(name, time)| format!("{name} {time:.2}")).collect();
        writeln!(out, "    {}", counts.join(", "))?;
        writeln!(out, "    {}", stages.join(", "))?;
    }
    Ok(())
}

fn write_values(out: &mut impl Write, row: &Row, with_work: bool) -> io::Result<()> {
    let stages: Vec<String> = STAGES.iter().map(|stage| format!("{:.3}", row.stages[stage])).collect();
    write!(
        out,
        "{},{},{},{},{},{:.3},{:.1},{:.1},{:.1}",
        row.scene,
        row.structure,
        row.triangles,
        row.lights,
        stages.join(","),
        row.traced_milliseconds,
        row.structure_bytes_per_triangle,
        row.light_bytes_per_pixel,
        row.bytes_per_pixel
    )?;
    if with_work {
        match &row.work {
            Some(Work { counts, light_milliseconds }) => {
                counts.iter().try_for_each(|(_, count)| write!(out, ",{count}"))?;
                light_milliseconds.iter().try_for_each(|(_, time)| write!(out, ",{time:.3}"))?;
            }
            None => Work::names().try_for_each(|_| write!(out, ","))?,
        }
    }
    writeln!(out)
}
