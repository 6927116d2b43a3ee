use std::path::Path;

use crate::command::{Scope, cargo_workspace};
use crate::debian;
use crate::outcome::{NotPassed, Outcome};
use crate::test_times::{self, TestTimes};

/// A test program with a check of its own, since a machine may lack what its tests need.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EquippedTests {
    /// The test program's name, in every crate that has one.
    pub(crate) program: &'static str,
    /// What a test prints at the start of a line on standard error where it lacks what it needs.
    marker: &'static str,
    /// The Debian package that has it.
    package: &'static str,
}

/// The tests that need a GPU adapter. Those of one program share a device, so that its kernels are compiled once, which a
/// process for each test would not.
pub(crate) const GPU: EquippedTests =
    EquippedTests { program: "gpu", marker: "skipped-gpu:", package: debian::SOFTWARE_ADAPTER };

/// The viewer's interface and its engines, drawn by an adapter without a window.
pub(crate) const VIEWER: EquippedTests = EquippedTests { program: "viewer", ..GPU };

/// The command with its window, on an X server without a screen.
pub(crate) const WINDOW: EquippedTests =
    EquippedTests { program: "view", marker: "skipped-window:", package: debian::X_SERVER };

impl EquippedTests {
    /// Runs them. On a machine that could have what they need, it is a failure if they lack it.
    pub(crate) fn check(self, root: &Path, scope: Scope) -> Outcome {
        let mut test = cargo_workspace(root, scope, &["test", "--no-fail-fast", "--test", self.program]);
        test_times::end_arguments(&mut test, scope);
        test.arg("--nocapture");
        let times = TestTimes::of(&mut test, Some(self.marker))?;
        self.judge(times.marked, debian::can_have(self.package))
    }

    fn judge(self, skipped: usize, can_have: bool) -> Outcome {
        let lacking = format!("{skipped} tests lack what {} has", self.package);
        match (skipped, can_have) {
            (0, _) => Ok(()),
            (_, true) => Err(NotPassed::Failed(format!("{lacking}, although it could be there"))),
            (_, false) => Err(NotPassed::Skipped(lacking)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tests_that_lack_something_fail_where_it_could_be() {
        assert_eq!(GPU.judge(0, true), Ok(()));
        assert!(matches!(GPU.judge(3, true), Err(NotPassed::Failed(_))));
        let why = format!("3 tests lack what {} has", debian::SOFTWARE_ADAPTER);
        assert_eq!(GPU.judge(3, false), Err(NotPassed::Skipped(why)));
    }
}
