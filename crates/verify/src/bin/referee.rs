//! Compares every structure's answers for random scenes with the referee.
#![forbid(unsafe_code)]

use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::Result;
use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use umbrage::gpu::{DeviceLimits, Gpu};
use umbrage::{Renderer, Structure};
use umbrage_rays::SeenPixels;
use umbrage_verify::referee::{
    self, DistanceTrial, KeptRenderers, Trial, check_frame, random_case, random_points, random_sequence,
};

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
    /// Ask renderers that are kept instead, about scenes that change from frame to frame, with all options of structures
    #[arg(long, conflicts_with = "gpu")]
    frames: bool,
    /// Ask about distances instead: nearest triangles, lists of near ones, and insides, of points all over each scene
    #[arg(long, conflicts_with_all = ["gpu", "frames"])]
    distances: bool,
}

const EXAMPLES: &str = "Examples:
  cargo run --release -p umbrage-verify --bin referee -- --minutes 5
      Five minutes of random scenes
  cargo run --release -p umbrage-verify --bin referee -- --seed 1234 --scenes 1
      One scene again, by its number
  cargo run --release -p umbrage-verify --bin referee -- --gpu --scenes 200
      The GPU as well
  cargo run --release -p umbrage-verify --bin referee -- --frames --minutes 10
      Ten minutes of scenes that change while their renderers are kept
  cargo run --release -p umbrage-verify --bin referee -- --distances --minutes 10
      Ten minutes of distances of points";

fn minutes(text: &str) -> Result<f64, String> {
    let is_possible = |minutes: &f64| *minutes > 0.0 && *minutes < 1e6;
    text.parse().ok().filter(is_possible).ok_or_else(|| "a number above zero is needed, such as 5 or 0.5".to_owned())
}

/// Maximum number of scenes whose disagreements are printed.
const MOST_PRINTED: usize = 20;

fn main() -> Result<ExitCode> {
    let flags = Flags::parse();
    let wrong = if flags.distances { judge_distances(&flags) } else { judge_pictures(&flags) }?;
    Ok(if wrong == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Compares pictures of scenes; returns the number of disagreements.
fn judge_pictures(flags: &Flags) -> Result<usize> {
    let mut gpu = if flags.gpu { Some(Renderer::with_gpu(Gpu::open("", DeviceLimits::Portable)?)?) } else { None };
    let (mut trial, mut kept) = (Trial::new(), KeptRenderers::new());
    let (mut pixels, mut hits, mut points, mut lit) = (0, 0, 0, 0);
    let (scenes, wrong) = each_scene(flags, |seed| {
        let frames = if flags.frames { random_sequence(seed) } else { vec![(Structure::default(), random_case(seed))] };
        let mut found = Vec::new();
        for (number, (structure, case)) in frames.iter().enumerate() {
            let truth = referee::truth(case);
            let mut wrong = if flags.frames {
                kept.disagreements(structure, case, &truth)
            } else {
                trial.disagreements(case, &truth)
            };
            if let Some(renderer) = &mut gpu {
                let checked = check_frame(renderer, structure, case, &truth);
                wrong.extend(checked.err().map(|how| format!("gpu: {how}")));
            }
            found.extend(wrong.into_iter().map(|how| format!("frame {number}: {}: {how}", case.name)));
            let hits_here = truth.triangle.iter().filter(|&&id| id != SeenPixels::NONE).count();
            (pixels, hits) = (pixels + truth.triangle.len(), hits + hits_here);
            let lit_here = truth.lit.iter().flatten().filter(|&&lit| lit).count();
            (points, lit) = (points + hits_here * truth.lit.len(), lit + lit_here);
        }
        found
    })?;
    println!(
        "{scenes} scenes from --seed {}: {hits} of {pixels} rays hit, {lit} of {points} points are lit; {} answers, {wrong} \
         disagreements",
        flags.seed,
        trial.answers + kept.answers
    );
    if flags.frames {
        println!(
            "{} frames were refused: options that exclude each other, or a camera or light that isn't finite",
            kept.refused
        );
    }
    Ok(wrong)
}

/// Compares distances of points from scenes; returns the number of disagreements.
fn judge_distances(flags: &Flags) -> Result<usize> {
    let (mut trial, mut points) = (DistanceTrial::new(), 0);
    let (scenes, wrong) = each_scene(flags, |seed| {
        let case = random_case(seed);
        let asked = random_points(seed, &case);
        points += asked.len();
        let wrong = trial.disagreements(&case, &asked, &referee::distances(case.mesh.triangles(), &asked));
        wrong.into_iter().map(|how| format!("{}: {how}", case.name)).collect()
    })?;
    println!(
        "{scenes} scenes from --seed {}: {points} points; {} answers, {wrong} disagreements",
        flags.seed, trial.answers
    );
    Ok(wrong)
}

/// Judges the scenes of consecutive seeds as long as time and flags allow, and prints the first disagreement of each;
/// returns the numbers of scenes and of disagreements.
fn each_scene(flags: &Flags, mut judge: impl FnMut(u64) -> Vec<String>) -> Result<(u64, usize)> {
    let (started, time) = (Instant::now(), Duration::from_secs_f64(60.0 * flags.minutes));
    let progress = ProgressBar::new(time.as_secs()).with_style(ProgressStyle::with_template("{bar:40} {eta} {msg}")?);
    let (mut scenes, mut wrong, mut wrong_scenes) = (0, 0, 0);
    while started.elapsed() < time && flags.scenes.is_none_or(|most| scenes < most) {
        let seed = flags.seed.wrapping_add(scenes);
        let found = judge(seed);
        wrong += found.len();
        if let [first, others @ ..] = &found[..] {
            wrong_scenes += 1;
            if wrong_scenes <= MOST_PRINTED {
                let others = if others.is_empty() { String::new() } else { format!(", and {} more", others.len()) };
                progress.suspend(|| println!("--seed {seed}: {first}{others}"));
            }
        }
        scenes += 1;
        progress.set_position(started.elapsed().as_secs());
        progress.set_message(format!("{scenes} scenes, {wrong} disagreements"));
    }
    progress.finish_and_clear();
    Ok((scenes, wrong))
}
