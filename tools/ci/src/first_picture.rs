use std::path::Path;
use std::time::Instant;

use crate::command::cargo;
use crate::cpu_time;
use crate::log::Log;
use crate::outcome::Outcome;
use crate::smoke;

/// Goal for a fresh clone's first picture on two idle processors: seconds on the clock, and CPU seconds.
const GOAL: (f64, f64) = (180.0, 360.0);

/// Checks the README's way to a first picture: the command is compiled for release, with its default features, and
/// renders. A machine may be busy, so a time above the goal is printed and is no failure.
pub(crate) fn check(root: &Path, log: &mut Log) -> Outcome {
    let (started, cpu_started) = (Instant::now(), cpu_time::of_children());
    let mut umbrage = cargo(root);
    umbrage.args(["run", "--release", "--locked", "--"]);
    smoke::render(root, log, umbrage)?;
    let cpu_seconds = cpu_time::of_children().zip(cpu_started).map_or(f64::NAN, |(end, start)| end - start);
    println!(
        "first picture: {:.1} s (goal {:.0}), {cpu_seconds:.1} CPU s (goal {:.0}), with {} packages compiled",
        started.elapsed().as_secs_f64(),
        GOAL.0,
        GOAL.1,
        log.compiled.count
    );
    names_lacking_feature(root)
}

/// Checks that the command without features tells how to get a requested one: every other step has it with features.
fn names_lacking_feature(root: &Path) -> Outcome {
    let mut umbrage = cargo(root);
    umbrage.args(["run", "--release", "--locked", "--quiet", "--", "render", "--engine", "gpu"]);
    let ended = umbrage.output().map_err(|error| error.to_string())?;
    let error = String::from_utf8_lossy(&ended.stderr);
    if ended.status.success() || !error.contains("cargo run --release --features gpu") {
        return Err(format!("without its GPU engine the command says: {error}").into());
    }
    Ok(())
}
