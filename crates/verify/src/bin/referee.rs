//! Asks every structure about random scenes, and the referee whether the answers are true.
#![forbid(unsafe_code)]

use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Result;
use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use umbrage::gpu::{DeviceLimits, Gpu};
use umbrage::scene::{Frame, Light, Material, Materials, Mesh};
use umbrage::{CameraChoice, Renderer, Settings, Sides};
use umbrage_rays::SeenPixels;
use umbrage_verify::referee::{self, Trial, compare, random_case};
use umbrage_verify::{Case, Truth};

/// Compares all structures, with every SIMD level and several numbers of threads, with the definitions in exact arithmetic.
#[derive(Debug, Parser)]
#[command(name = "referee", after_help = EXAMPLES)]
struct Flags {
    /// How long
    #[arg(long, value_name = "N", default_value = "1", value_parser = minutes)]
    minutes: f64,
    /// The first scene; those that follow have the next numbers
    #[arg(long, value_name = "N", default_value = "1")]
    seed: u64,
    /// At most so many scenes
    #[arg(long, value_name = "N")]
    scenes: Option<u64>,
    /// Ask a GPU too, or a program that stands in for one
    #[arg(long)]
    gpu: bool,
}

const EXAMPLES: &str = "Examples:
  cargo run --release -p umbrage-verify --bin referee -- --minutes 5
      Five minutes of random scenes
  cargo run --release -p umbrage-verify --bin referee -- --seed 1234 --scenes 1
      One scene again, by its number
  cargo run --release -p umbrage-verify --bin referee -- --gpu --scenes 200
      The GPU as well";

fn minutes(text: &str) -> Result<f64, String> {
    let is_possible = |minutes: &f64| *minutes > 0.0 && *minutes < 1e6;
    text.parse().ok().filter(is_possible).ok_or_else(|| "a number above zero is needed, such as 5 or 0.5".to_owned())
}

/// Scenes with disagreements that are printed.
const MOST_PRINTED: usize = 20;

fn main() -> Result<ExitCode> {
    let flags = Flags::parse();
    let mut gpu = if flags.gpu { Some(Renderer::with_gpu(Gpu::open("", DeviceLimits::Portable)?)?) } else { None };
    let (started, time) = (Instant::now(), Duration::from_secs_f64(60.0 * flags.minutes));
    let progress = ProgressBar::new(time.as_secs()).with_style(ProgressStyle::with_template("{bar:40} {eta} {msg}")?);
    let (mut trial, mut wrong, mut wrong_scenes, mut scenes) = (Trial::new(), 0, 0, 0);
    let (mut pixels, mut hits, mut points, mut lit) = (0, 0, 0, 0);
    while started.elapsed() < time && flags.scenes.is_none_or(|most| scenes < most) {
        let seed = flags.seed.wrapping_add(scenes);
        let case = random_case(seed);
        let truth = referee::truth(&case);
        let mut found = trial.disagreements(&case, &truth);
        if let Some(renderer) = &mut gpu {
            found.extend(of_gpu(renderer, &case, &truth).err().map(|how| format!("gpu: {how}")));
        }
        wrong += found.len();
        if let [first, others @ ..] = &found[..] {
            wrong_scenes += 1;
            if wrong_scenes <= MOST_PRINTED {
                let others = if others.is_empty() { String::new() } else { format!(", and {} more", others.len()) };
                progress.suspend(|| println!("--seed {seed}: {}: {first}{others}", case.name));
            }
        }
        scenes += 1;
        let hits_here = truth.triangle.iter().filter(|&&id| id != SeenPixels::NONE).count();
        (pixels, hits) = (pixels + truth.triangle.len(), hits + hits_here);
        (points, lit) =
            (points + hits_here * truth.lit.len(), lit + truth.lit.iter().flatten().filter(|&&lit| lit).count());
        progress.set_position(started.elapsed().as_secs());
        progress.set_message(format!("{scenes} scenes, {wrong} disagreements"));
    }
    progress.finish_and_clear();
    println!(
        "{scenes} scenes from --seed {}: {hits} of {pixels} rays hit, {lit} of {points} points are lit; {} answers, {wrong} \
         disagreements",
        flags.seed, trial.answers
    );
    Ok(if wrong == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Compares a GPU's frame with the truth.
fn of_gpu(renderer: &mut Renderer, case: &Case, truth: &Truth) -> Result<(), String> {
    let mut frame = Frame::from_triangles(case.mesh.positions.clone(), case.mesh.indices.clone());
    let of_one_side = Material { double_sided: false, ..Material::clay() };
    frame.materials = Arc::new(Materials { materials: vec![of_one_side, Material::clay()], ..Materials::default() });
    let material_of_triangle = (0..case.mesh.indices.len() as u32).map(|id| case.sides.has_back(id).into()).collect();
    frame.mesh = Arc::new(Mesh { material_of_triangle, ..(*frame.mesh).clone() });
    frame.lights = case.lights.iter().map(|&source| Light::new(source, 1.0)).collect();
    let settings = Settings {
        width: case.view.width,
        height: case.view.height,
        camera: CameraChoice::Own(case.view.camera),
        sides: Sides::File,
        ..Settings::default()
    };
    renderer.render_frame(&frame, &settings).map_err(|error| error.to_string())?;
    compare(case, truth, renderer.seen(), renderer.light_masks())
}
