//! Gives bad input to every reader, to poses, the API and the command: nothing may panic, hang, take too much memory or
//! accept nonsense.
//!
//! Mutants are made and tried in a process of their own, so that a crash is found like any other fault. A mutant
//! follows from its number alone.
#![forbid(unsafe_code)]

mod mutate;
mod targets;
mod worker;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Result, ensure};
use clap::Parser;
use clap::builder::PossibleValuesParser;

use worker::Progress;

/// Tries mutants of small files, moments, command lines, frames and settings.
#[derive(Debug, Parser)]
#[command(name = "fuzz", after_help = EXAMPLES)]
struct Flags {
    /// How long, all targets together
    #[arg(long, value_name = "N", default_value = "1")]
    minutes: f64,
    /// What to try; may be given several times [default: all]
    #[arg(long = "target", value_name = "NAME", value_parser = PossibleValuesParser::new(targets::names()))]
    targets: Vec<String>,
    /// The first mutant of each target; those that follow have the next numbers
    #[arg(long, value_name = "N", default_value = "1")]
    seed: u64,
    /// So many mutants of each target, however long they take
    #[arg(long, value_name = "N", conflicts_with = "minutes")]
    mutants: Option<u64>,
    /// Where files are kept that something was found with
    #[arg(long, value_name = "FOLDER", default_value = "fuzz-findings")]
    keep: PathBuf,
    /// Try mutants of one target in this process and write its progress into this folder; for the program itself
    #[arg(long, value_name = "FOLDER", hide = true)]
    worker: Option<PathBuf>,
}

const EXAMPLES: &str = "Examples:
  cargo run --release -p umbrage-verify --bin fuzz -- --minutes 5
      Five minutes of everything; for the command itself, build it first (cargo build --release)
  cargo run --release -p umbrage-verify --bin fuzz -- --target ply --seed 1234 --mutants 1
      One mutant again, by its number";

/// Time limit of one mutant.
const PATIENCE: Duration = Duration::from_secs(20);

fn main() -> Result<ExitCode> {
    let mut flags = Flags::parse();
    if let Some(folder) = &flags.worker {
        worker::run(&flags.targets[0], flags.seed, flags.mutants.unwrap_or(u64::MAX), folder, &flags.keep)?;
        return Ok(ExitCode::SUCCESS);
    }
    if flags.targets.is_empty() {
        let sound = targets::names().into_iter().filter(|&name| name != targets::BROKEN);
        flags.targets = sound.map(str::to_owned).collect();
    }
    let all_time = Duration::try_from_secs_f64(60.0 * flags.minutes)?;
    let time = if flags.mutants.is_some() { Duration::MAX } else { all_time / flags.targets.len() as u32 };
    let mut findings = 0;
    for target in &flags.targets {
        findings += try_target(target, &flags, time)?;
    }
    println!("{findings} findings");
    Ok(if findings == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Tries mutants of one target, prints the counts of answers, and returns the number of findings.
fn try_target(target: &str, flags: &Flags, time: Duration) -> Result<u64> {
    let started = Instant::now();
    let (mut next, mut answers) = (flags.seed, [0; 3]);
    let last = flags.mutants.map_or(u64::MAX, |mutants| flags.seed.saturating_add(mutants));
    while next < last && started.elapsed() < time {
        let folder = tempfile::tempdir()?;
        let errors = folder.path().join("errors");
        let mut worker = Command::new(std::env::current_exe()?)
            .args(["--target", target, "--seed", &next.to_string(), "--mutants", &(last - next).to_string()])
            .args([Path::new("--keep"), &flags.keep, Path::new("--worker"), folder.path()])
            .stderr(fs::File::create(&errors)?)
            .env("RUST_BACKTRACE", "0")
            .stdin(Stdio::null())
            .spawn()?;
        let (mut at, mut since) = (next, Instant::now());
        let ended = loop {
            if let Some(status) = worker.try_wait()? {
                break (!status.success()).then(|| format!("ends the program, {status}"));
            }
            let is_stuck = since.elapsed() > PATIENCE;
            if is_stuck || started.elapsed() > time {
                worker.kill()?;
                worker.wait()?;
                break is_stuck.then(|| format!("takes over {} s", PATIENCE.as_secs()));
            }
            std::thread::sleep(Duration::from_millis(20));
            let next = Progress::read(folder.path()).next;
            if next != at {
                (at, since) = (next, Instant::now());
            }
        };
        let mut progress = Progress::read(folder.path());
        if let Some(why) = ended {
            let said = fs::read_to_string(errors).unwrap_or_default();
            ensure!(progress.next >= next, "{target}: {said}");
            progress.tell(target, &format!("{why}: {}", said.trim_end()), folder.path(), &flags.keep)?;
            progress.answers[2] += 1;
            progress.next += 1;
        }
        next = progress.next;
        answers = std::array::from_fn(|answer| answers[answer] + progress.answers[answer]);
    }
    let [accepted, refused, findings] = answers;
    println!("{target}: --seed {} to {next}: {accepted} accepted, {refused} refused, {findings} findings", flags.seed);
    Ok(findings)
}
