use std::path::Path;

use crate::command::cargo_workspace;
use crate::debian;
use crate::outcome::Outcome;
use crate::test_times::{self, TestTimes};

/// What a test prints at the start of a line on standard error when it finds no adapter.
const SKIPPED: &str = "skipped-gpu:";

/// The test programs that need an adapter are called so. Those of one share a device, so that its kernels are compiled
/// once, which a process for each test would not.
pub(crate) const TEST: &str = "gpu";

/// The tests that need an adapter. On a machine that could have Mesa's software adapter, it is a failure if they find
/// none.
pub(crate) fn check(root: &Path) -> Outcome {
    let mut test = cargo_workspace(root, &["test", "--no-fail-fast"]);
    test.args(["--test", TEST]);
    test_times::ask_for_times(&mut test);
    test.arg("--nocapture");
    match TestTimes::of(&mut test, Some(SKIPPED)) {
        Ok(times) => judge(times.marked, debian::can_have(debian::SOFTWARE_ADAPTER)),
        Err(why) => Outcome::Failed(why),
    }
}

fn judge(skipped: usize, can_have_adapter: bool) -> Outcome {
    let found_none = format!("{skipped} tests found no GPU adapter");
    match (skipped, can_have_adapter) {
        (0, _) => Outcome::Passed,
        (_, true) => Outcome::Failed(format!("{found_none}, although {} is there", debian::SOFTWARE_ADAPTER)),
        (_, false) => Outcome::Skipped(found_none),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_adapters_fail_where_there_could_be_one() {
        assert_eq!(judge(0, true), Outcome::Passed);
        assert!(judge(3, true).is_failure());
        assert_eq!(judge(3, false), Outcome::Skipped("3 tests found no GPU adapter".to_owned()));
    }
}
