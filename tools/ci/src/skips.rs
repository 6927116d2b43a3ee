//! Tests that pass where what they need isn't there, and say so.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

/// Runs tests whose output is for the log, and counts those that say, by `marker` at the start of a line on standard
/// error, that they lack something.
///
/// # Errors
/// Where a test fails, or they can't be run.
pub(crate) fn count_skipped(command: &mut Command, marker: &str) -> Result<usize, String> {
    let failed = |why: &dyn std::fmt::Display| why.to_string();
    let mut child = command.stderr(Stdio::piped()).spawn().map_err(|error| failed(&error))?;
    let mut skipped = 0;
    if let Some(lines) = child.stderr.take() {
        for line in BufReader::new(lines).split(b'\n') {
            let line = line.map_err(|error| failed(&error))?;
            let line = String::from_utf8_lossy(&line);
            eprintln!("{line}");
            skipped += usize::from(line.starts_with(marker));
        }
    }
    let status = child.wait().map_err(|error| failed(&error))?;
    if status.success() { Ok(skipped) } else { Err(failed(&status)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tests_that_lack_something_count() {
        let shell = |script: &str| count_skipped(Command::new("sh").args(["-c", script]), "skipped:");
        assert_eq!(shell("echo skipped: none >&2; echo other >&2; echo skipped: none >&2"), Ok(2));
        assert_eq!(shell("true"), Ok(0));
        assert!(shell("exit 1").is_err());
    }
}
