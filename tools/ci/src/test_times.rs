use std::process::Command;

use crate::command::Scope;
use crate::watch::watch;

/// So many tests are named as the slowest.
const NAMED: usize = 10;

/// Tests in modules of this name take long, and run only with `--all`.
const LONG: &str = "long::";

/// Ends a `cargo test`'s own arguments, and has its programs run the tests of a scope and say how long each took. They say so
/// only to whoever may use what isn't stable; how they are compiled stays as it was.
pub(crate) fn end_arguments(test: &mut Command, scope: Scope) {
    if cfg!(unix) {
        test.args(["--config", "target.'cfg(unix)'.runner=['env', 'RUSTC_BOOTSTRAP=1']"]);
        test.args(["--", "-Zunstable-options", "--report-time"]);
    } else {
        test.arg("--");
    }
    if scope == Scope::Short {
        test.args(["--skip", LONG]);
    }
}

/// What tests said.
#[derive(Debug, Default)]
pub(crate) struct TestTimes {
    /// Seconds and names.
    tests: Vec<(f64, String)>,
    /// How often a line began with the marker.
    pub(crate) marked: usize,
}

impl TestTimes {
    /// Runs tests, names the slowest, and counts those that say, by `marker` at the start of a line, that they lack
    /// something.
    ///
    /// # Errors
    /// Where a test fails, or they can't be run.
    pub(crate) fn of(test: &mut Command, marker: Option<&str>) -> Result<Self, String> {
        let mut times = Self::default();
        let ended = watch(test, |line| {
            times.marked += usize::from(marker.is_some_and(|marker| line.starts_with(marker)));
            times.tests.extend(time_of(line));
        });
        times.name_slowest();
        ended.map(|()| times).map_err(|error| error.to_string())
    }

    fn name_slowest(&mut self) {
        self.tests.sort_by(|(one, _), (other, _)| other.total_cmp(one));
        let total: f64 = self.tests.iter().map(|(seconds, _)| seconds).sum();
        println!("\n{} tests took {total:.1} s, the slowest of them:", self.tests.len());
        for (seconds, name) in self.tests.iter().take(NAMED) {
            println!("{seconds:>8.2} s  {name}");
        }
    }
}

/// What a line says of a test that has passed: `test NAME ... ok <1.234s>`.
fn time_of(line: &str) -> Option<(f64, String)> {
    // What a test prints without waiting may stand in between.
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
    }

    #[test]
    fn tests_that_lack_something_count() {
        let shell = |script: &str| TestTimes::of(Command::new("sh").args(["-c", script]), Some("skipped:"));
        let told = shell("echo skipped: none >&2; echo other >&2; echo skipped: none >&2; echo 'test a ... ok <0.5s>'");
        let told = told.expect("it ends well");
        assert_eq!((told.marked, told.tests), (2, vec![(0.5, "a".to_owned())]));
        assert_eq!(shell("true").expect("it ends well").marked, 0);
        assert!(shell("exit 1").is_err());
    }
}
