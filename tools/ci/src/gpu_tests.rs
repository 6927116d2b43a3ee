use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::command::cargo;
use crate::debian;
use crate::outcome::Outcome;

/// What a test prints at the start of a line on standard error when it finds no adapter.
const SKIPPED: &str = "skipped-gpu:";

/// Selects the tests that need an adapter, for nextest. They run apart: those of a file share a device, so that its
/// kernels are compiled once, which a process for each test would not.
pub(crate) const FILTER: &str = "package(umbrage-gpu) or binary(/^gpu/)";

/// The tests that need an adapter. On a machine that could have Mesa's software adapter, it is a failure if they find
/// none.
pub(crate) fn check(root: &Path) -> Outcome {
    let mut skipped = 0;
    for arguments in [
        ["--package", "umbrage-gpu", "--lib", "--tests"].as_slice(),
        ["--package", "umbrage-verify", "--test", "gpu*"].as_slice(),
    ] {
        let mut test = cargo(root);
        test.args(["test", "--locked", "--no-fail-fast"]).args(arguments).args(["--", "--nocapture"]);
        match count_skipped(&mut test) {
            Ok(count) => skipped += count,
            Err(why) => return Outcome::Failed(why),
        }
    }
    judge(skipped, debian::can_have(debian::SOFTWARE_ADAPTER))
}

fn judge(skipped: usize, can_have_adapter: bool) -> Outcome {
    let found_none = format!("{skipped} tests found no GPU adapter");
    match (skipped, can_have_adapter) {
        (0, _) => Outcome::Passed,
        (_, true) => Outcome::Failed(format!("{found_none}, although {} is there", debian::SOFTWARE_ADAPTER)),
        (_, false) => Outcome::Skipped(found_none),
    }
}

/// Runs tests whose output is for the log, and counts those that found no adapter.
///
/// # Errors
/// Where a test fails, or they can't be run.
fn count_skipped(command: &mut Command) -> Result<usize, String> {
    let failed = |why: &dyn std::fmt::Display| format!("GPU tests: {why}");
    let mut child = command.stderr(Stdio::piped()).spawn().map_err(|error| failed(&error))?;
    let mut skipped = 0;
    if let Some(lines) = child.stderr.take() {
        for line in BufReader::new(lines).split(b'\n') {
            let line = line.map_err(|error| failed(&error))?;
            let line = String::from_utf8_lossy(&line);
            eprintln!("{line}");
            skipped += usize::from(line.starts_with(SKIPPED));
        }
    }
    let status = child.wait().map_err(|error| failed(&error))?;
    if status.success() { Ok(skipped) } else { Err(failed(&status)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tests_without_an_adapter_count() {
        let shell = |script: &str| count_skipped(Command::new("sh").args(["-c", script]));
        assert_eq!(shell("echo skipped-gpu: none >&2; echo other >&2; echo skipped-gpu: none >&2"), Ok(2));
        assert_eq!(shell("true"), Ok(0));
        assert!(shell("exit 1").is_err());
    }

    #[test]
    fn missing_adapters_fail_where_there_could_be_one() {
        assert_eq!(judge(0, true), Outcome::Passed);
        assert!(judge(3, true).is_failure());
        assert_eq!(judge(3, false), Outcome::Skipped("3 tests found no GPU adapter".to_owned()));
    }
}
