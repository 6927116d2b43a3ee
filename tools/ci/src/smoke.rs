//! Whether programs run: the command, as tests build it and as the README does, and examples.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use crate::command::{build, cargo, seconds_of_children};
use crate::log::{Log, Outcome};
use crate::repository::{built, empty_folder, files};

/// Checks that the command renders a picture.
pub(crate) fn check(root: &Path, log: &mut Log) -> Outcome {
    log.run(&mut build(root, &["umbrage"]))?;
    render(root, log, Command::new(built(root, "umbrage")))
}

/// Renders a picture with the command, as tests build it or as `cargo run` does.
fn render(root: &Path, log: &mut Log, mut umbrage: Command) -> Outcome {
    let picture = empty_folder(root, "smoke")?.join("smoke.png");
    log.run(umbrage.args(["render", "demo:cloth", "--size", "320x180", "--output"]).arg(&picture))?;
    let bytes = fs::read(&picture).map_err(|error| format!("{}: {error}", picture.display()))?;
    judge(&bytes)
}

/// Passes if a PNG file has a visible picture: one colour everywhere compresses to almost nothing.
fn judge(picture: &[u8]) -> Outcome {
    const LEAST_BYTES: usize = 2_000;
    if !picture.starts_with(b"\x89PNG\r\n\x1a\n") {
        return Err("the picture is no PNG".to_owned().into());
    }
    if picture.len() < LEAST_BYTES {
        return Err(format!("{} bytes are too few for a picture with something in it", picture.len()).into());
    }
    Ok(())
}

/// Goal for a fresh clone's first picture on two idle processors: seconds on the clock, and CPU seconds.
const GOAL: (f64, f64) = (180.0, 360.0);

/// Checks the README's way to a first picture: the command is compiled for release, with its default features, and
/// renders. A machine may be busy, so a time above the goal is printed and is no failure.
pub(crate) fn check_first_picture(root: &Path, log: &mut Log) -> Outcome {
    let (started, cpu_started) = (Instant::now(), seconds_of_children());
    let mut umbrage = cargo(root);
    umbrage.args(["run", "--release", "--locked", "--"]);
    render(root, log, umbrage)?;
    let cpu_seconds = seconds_of_children().zip(cpu_started).map_or(f64::NAN, |(end, start)| end - start);
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

/// The folder of the library's examples.
const FOLDER: &str = "crates/umbrage/examples";

/// Checks that every example runs to its end.
pub(crate) fn check_examples(root: &Path, log: &mut Log) -> Outcome {
    log.run(&mut build(root, &[]))?;
    let sources = files(&root.join(FOLDER), "rs")?;
    if sources.is_empty() {
        return Err(format!("{FOLDER}: there are no examples").into());
    }
    let names = sources.iter().filter_map(|source| source.file_stem()?.to_str());
    let outcomes = names.map(|name| log.run(&mut Command::new(built(root, &format!("examples/{name}")))));
    outcomes.fold(Ok(()), Outcome::and)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_pictures_fail() {
        let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
        assert!(judge(&bytes).is_err());
        bytes.resize(5_000, 7);
        assert_eq!(judge(&bytes), Ok(()));
        bytes[0] = 0;
        assert!(judge(&bytes).is_err());
    }
}
