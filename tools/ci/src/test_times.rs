use std::process::Command;

use crate::log::{Log, NotPassed};

/// Number of tests that are named as the slowest.
const NAMED: usize = 10;

/// Modules of tests that take long.
const LONG: &str = "long::";

/// The tests of a program that a step runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Length {
    /// Those outside of modules called `long`.
    Short,
    /// Those in modules called `long`.
    Long,
}

/// Runs `cargo test`, names the slowest tests, and counts lines that begin with the marker, by which a test reports a
/// missing requirement.
///
/// # Errors
/// If a test fails, or none runs.
pub(crate) fn run_tests(
    log: &mut Log,
    test: &mut Command,
    length: Length,
    marker: Option<&str>,
) -> Result<usize, NotPassed> {
    let (mut count, mut marked, mut times) = (0, 0, Vec::new());
    let ended = log.watch(with_times(test, length, marker.is_some()), |line| {
        marked += usize::from(marker.is_some_and(|marker| line.starts_with(marker)));
        count += count_in(line);
        times.extend(time_of(line));
    });
    print!("{}", slowest(&times));
    log.tests.append(&mut times);
    ended?;
    if count == 0 { Err("no test has run".to_owned().into()) } else { Ok(marked) }
}

/// Ends a `cargo test`'s own arguments, and makes its programs report each test's time. They do so by an unstable
/// option, which they alone may use; their compilation stays the same.
fn with_times(test: &mut Command, length: Length, has_marker: bool) -> &mut Command {
    if cfg!(unix) {
        test.args(["--config", "target.'cfg(unix)'.runner=['env', 'RUSTC_BOOTSTRAP=1']"]);
        test.args(["--", "-Zunstable-options", "--report-time"]);
    } else {
        test.arg("--");
    }
    if has_marker {
        test.arg("--nocapture");
    }
    match length {
        Length::Short => test.args(["--skip", LONG]),
        Length::Long => test.arg(LONG),
    }
}

/// The slowest tests, one a line.
pub(crate) fn slowest(tests: &[(f64, String)]) -> String {
    let mut tests: Vec<_> = tests.iter().collect();
    tests.sort_by(|(one, _), (other, _)| other.total_cmp(one));
    let total: f64 = tests.iter().map(|(seconds, _)| seconds).sum();
    let named = tests.iter().take(NAMED).map(|(seconds, name)| format!("{seconds:>8.2} s  {name}\n"));
    let heading = format!("\n{} tests took {total:.1} s, the slowest of them:\n", tests.len());
    std::iter::once(heading).chain(named).collect()
}

/// The number of a program's tests, from its first line: `running 3 tests`.
fn count_in(line: &str) -> usize {
    let count = line.strip_prefix("running ").and_then(|line| line.split_once(" test")?.0.parse().ok());
    count.unwrap_or(0)
}

/// Seconds and name from the line about a test that has passed: `test NAME ... ok <1.234s>`.
fn time_of(line: &str) -> Option<(f64, String)> {
    // Unbuffered output of the test may be in between.
    let (name, rest) = line.trim().strip_prefix("test ")?.split_once(" ... ")?;
    let seconds = rest.rsplit_once('<')?.1.strip_suffix("s>")?;
    Some((seconds.parse().ok()?, name.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read() {
        assert_eq!(time_of("test a::b ... ok <1.250s>"), Some((1.25, "a::b".to_owned())));
        assert_eq!(time_of("test a - should panic ... ok <0.001s>"), Some((0.001, "a - should panic".to_owned())));
        for other in ["test a ... ok", "test a ... ignored", "test result: ok. 1 passed", "running 2 tests", ""] {
            assert_eq!(time_of(other), None, "{other}");
        }
        let tests: Vec<_> = (0..20_u8).map(|i| (f64::from(i), format!("t{i}"))).collect();
        let text = slowest(&tests);
        assert!(text.contains("20 tests took 190.0 s") && text.contains(" 19.00 s  t19\n") && !text.contains("t9\n"));
    }

    #[test]
    fn tests_that_lack_something_count() {
        // The script ignores the appended arguments, its positional parameters.
        let shell = |script: &str| {
            let mut log = Log::default();
            let marked = run_tests(&mut log, Command::new("sh").args(["-c", script]), Length::Short, Some("skipped:"));
            (marked, log.tests)
        };
        let told = shell(
            "echo 'running 1 test'; echo skipped: none >&2; echo other >&2; echo skipped: none >&2; echo 'test a ... ok <0.5s>'",
        );
        assert_eq!(told, (Ok(2), vec![(0.5, "a".to_owned())]));
        assert_eq!(shell("echo 'running 3 tests'").0, Ok(0));
        assert!(shell("echo 'running 0 tests'").0.is_err());
        assert!(shell("echo 'running 3 tests'; exit 1").0.is_err());
    }
}
