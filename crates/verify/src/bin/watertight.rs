//! Sends rays at shared edges and corners of triangles: none may slip through, and nothing may shadow itself.
#![forbid(unsafe_code)]

use std::time::Instant;

use anyhow::Result;
use clap::Parser;
use indicatif::ProgressBar;
use umbrage_verify::{Random, SeamTrial};

/// Aims rays at shared edges and vertices, through all grids, and counts leaks and self-shadowing.
#[derive(Debug, Parser)]
#[command(name = "watertight", after_help = EXAMPLES)]
struct Flags {
    /// How many camera rays exactly through shared vertices and edges; each sends shadow rays too, and so do others
    /// that are between them
    #[arg(long, value_name = "N", default_value = "1e7", value_parser = count)]
    rays: u64,
    /// Which random sheets
    #[arg(long, value_name = "N", default_value = "1")]
    seed: u64,
    /// One sheet of rays in so many is lit from the side too, and given to other structures
    #[arg(long, value_name = "N", default_value = "3", value_parser = clap::value_parser!(u32).range(1..))]
    others_every: u32,
}

const EXAMPLES: &str = "Examples:
  cargo run --release -p umbrage-verify --bin watertight
      Ten million rays at seams, as every check of the repository does
  cargo run --release -p umbrage-verify --bin watertight -- --rays 1e9 --seed 7 --others-every 30
      A thousand million others";

fn count(text: &str) -> Result<u64, String> {
    let number: f64 = text.parse().map_err(|_| "a number is needed, such as 1e7")?;
    if (1.0..=1e15).contains(&number) { Ok(number as u64) } else { Err("from 1 to 1e15".to_owned()) }
}

fn main() -> Result<()> {
    let flags = Flags::parse();
    let (mut random, started) = (Random::new(flags.seed), Instant::now());
    let progress = ProgressBar::new(flags.rays);
    let mut trial = SeamTrial::new(flags.others_every as usize)?;
    while trial.at_seams() < flags.rays {
        trial.next(&mut random)?;
        progress.set_position(trial.at_seams().min(flags.rays));
    }
    progress.finish_and_clear();
    println!("{trial}.\nNo leak, no self-shadowing; {:.1} s", started.elapsed().as_secs_f64());
    Ok(())
}
