use std::collections::BTreeMap;

use anyhow::{Context, Result};
use clap::Args;
use serde::Serialize;
use umbrage::rays::SimdLevel;
use umbrage::{Renderer, Scene, Settings, Structure};

use crate::flags::{size, use_threads};
use crate::median::median;
use crate::table::Form;
use crate::work::Work;

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
    /// SIMD instructions for the grids: sse2, sse4.2, avx2 or avx512 [default: the widest]
    #[arg(long, value_name = "LEVEL")]
    simd: Option<SimdLevel>,
    /// Print what the grids had to do as well, and how long the light grid's own stages took
    #[arg(long)]
    work: bool,
    /// How the results are written
    #[arg(long, value_enum, default_value = "table")]
    form: Form,
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
    bytes_per_pixel: f64,
    /// What the grids had to do in the last frame's last sample.
    work: Option<Work>,
}

/// The stages that find what pixels see and what lights reach: the frame of the papers.
const TRACING: [&str; 3] = ["build", "see", "shadow"];
const STAGES: [&str; 5] = ["animate", "build", "see", "shadow", "shade"];
const STRUCTURES: [(&str, Structure); 2] = [("perspective", Structure::Perspective), ("bvh", Structure::Bvh)];

pub(crate) fn run(flags: &FrameFlags) -> Result<()> {
    use_threads(flags.threads)?;
    let simd = flags.simd.unwrap_or_default();
    let gallery: Vec<String> = umbrage::scene::DEMOS.iter().map(|demo| format!("demo:{}", demo.name)).collect();
    let scenes = if flags.scenes.is_empty() { &gallery } else { &flags.scenes };
    if matches!(flags.form, Form::Table) {
        let [width, height] = flags.size;
        let (threads, frames, samples) = (rayon::current_num_threads(), flags.frames, flags.samples);
        println!(
            "{width}x{height}, samples {samples}, threads {threads}, {simd}, medians of {frames} frames in milliseconds"
        );
        print!("{:<28}{:>12}{:>10}{:>7}", "scene", "structure", "triangles", "lights");
        STAGES.iter().for_each(|stage| print!("{stage:>9}"));
        println!("{:>9}{:>7}{:>7}{:>8}", "traced", "ratio", "B/tri", "B/pixel");
    } else if matches!(flags.form, Form::Csv) {
        print!("scene,structure,triangles,lights,{},traced,bytes_per_triangle,bytes_per_pixel", STAGES.join(","));
        if flags.work {
            Work::names().for_each(|name| print!(",{name}"));
        }
        println!();
    }
    let mut rows = Vec::new();
    for address in scenes {
        let of_scene = measure(address, flags).with_context(|| format!("scene {address}"))?;
        match flags.form {
            Form::Table => of_scene.iter().for_each(|row| print_columns(row, &of_scene, flags.work)),
            Form::Csv => of_scene.iter().for_each(|row| print_values(row, flags.work)),
            Form::Json => {}
        }
        rows.extend(of_scene);
    }
    if matches!(flags.form, Form::Json) {
        println!("{}", serde_json::to_string_pretty(&rows)?);
    }
    Ok(())
}

fn measure(address: &str, flags: &FrameFlags) -> Result<Vec<Row>> {
    let scene = Scene::open(address)?;
    let [width, height] = flags.size;
    let settings = |structure| Settings { width, height, samples: flags.samples, structure, ..Settings::default() };
    let mut renderers = STRUCTURES.map(|_| Renderer::with_simd_level(flags.simd.unwrap_or_default()));
    let mut times = STRUCTURES.map(|_| Vec::new());
    // The first frame takes memory that later ones use again: it doesn't count.
    for frame in 0..=flags.frames {
        let seconds = scene.duration_seconds() * f64::from(frame) / f64::from(flags.frames + 1);
        for ((renderer, times), (_, structure)) in renderers.iter_mut().zip(&mut times).zip(STRUCTURES) {
            renderer.render(&scene, seconds, &settings(structure))?;
            if frame > 0 {
                times.push(STAGES.map(|name| stage_milliseconds(renderer, name)));
            }
        }
    }
    let rows = renderers.iter().zip(&times).zip(STRUCTURES).map(|((renderer, times), (structure, _))| {
        let stats = renderer.stats();
        let traced = |times: &[f64; 5]| -> f64 {
            STAGES.iter().zip(times).filter(|(name, _)| TRACING.contains(name)).map(|(_, time)| time).sum()
        };
        Row {
            scene: address.to_owned(),
            structure,
            triangles: stats.triangles,
            lights: stats.lights,
            stages: STAGES.iter().enumerate().map(|(at, &name)| (name, median(times.iter().map(|t| t[at])))).collect(),
            traced_milliseconds: median(times.iter().map(traced)),
            structure_bytes_per_triangle: stats.structure_bytes as f64 / stats.triangles.max(1) as f64,
            work: Work::of(renderer),
            bytes_per_pixel: stats.pixel_bytes as f64 / (f64::from(width) * f64::from(height)),
        }
    });
    Ok(rows.collect())
}

fn stage_milliseconds(renderer: &Renderer, name: &str) -> f64 {
    renderer.stats().stages.iter().find(|stage| stage.name == name).map_or(0.0, |stage| stage.milliseconds)
}

fn print_columns(row: &Row, of_scene: &[Row], with_work: bool) {
    let slowest = of_scene.iter().map(|row| row.traced_milliseconds).fold(0.0, f64::max);
    print!("{:<28}{:>12}{:>10}{:>7}", row.scene, row.structure, row.triangles, row.lights);
    STAGES.iter().for_each(|stage| print!("{:>9.2}", row.stages[stage]));
    let ratio = slowest / row.traced_milliseconds;
    let (traced, triangle, pixel) = (row.traced_milliseconds, row.structure_bytes_per_triangle, row.bytes_per_pixel);
    println!("{traced:>9.2}{ratio:>7.1}{triangle:>7.0}{pixel:>8.0}");
    if let Some(Work { counts, light_milliseconds }) = row.work.as_ref().filter(|_| with_work) {
        let counts: Vec<String> = counts.iter().map(|(name, count)| format!("{name} {count}")).collect();
        let stages: Vec<String> = light_milliseconds.iter().map(|(name, time)| format!("{name} {time:.2}")).collect();
        println!("    {}", counts.join(", "));
        println!("    {}", stages.join(", "));
    }
}

fn print_values(row: &Row, with_work: bool) {
    let stages: Vec<String> = STAGES.iter().map(|stage| format!("{:.3}", row.stages[stage])).collect();
    print!(
        "{},{},{},{},{},{:.3},{:.1},{:.1}",
        row.scene,
        row.structure,
        row.triangles,
        row.lights,
        stages.join(","),
        row.traced_milliseconds,
        row.structure_bytes_per_triangle,
        row.bytes_per_pixel
    );
    if with_work {
        match &row.work {
            Some(Work { counts, light_milliseconds }) => {
                counts.iter().for_each(|(_, count)| print!(",{count}"));
                light_milliseconds.iter().for_each(|(_, time)| print!(",{time:.3}"));
            }
            None => Work::names().for_each(|_| print!(",")),
        }
    }
    println!();
}
