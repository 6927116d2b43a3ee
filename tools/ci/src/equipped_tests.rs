use std::path::Path;
use std::process::Command;

use crate::command::{Scope, cargo_workspace};
use crate::debian;
use crate::log::{Log, NotPassed, Outcome, skipped};
use crate::test_times::{Length, run_tests};

/// A test program with a step of its own, since its tests have requirements that a machine may lack.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EquippedTests {
    /// The test program's name.
    pub(crate) program: &'static str,
    scope: Scope,
    /// Start of the line on standard error by which a test reports a missing requirement.
    marker: &'static str,
    /// Debian package that meets the requirement.
    package: &'static str,
}

/// The tests that need a GPU adapter. Those of one program share a device, so that its kernels are compiled once, which a
/// process for each test would not.
pub(crate) const GPU: EquippedTests = EquippedTests {
    program: "gpu",
    scope: Scope::Windowless,
    marker: "skipped-gpu:",
    package: debian::SOFTWARE_ADAPTER,
};

/// The viewer's interface and its engines, drawn by an adapter without a window.
pub(crate) const VIEWER: EquippedTests = EquippedTests { program: "viewer", scope: Scope::Whole, ..GPU };

/// The command with its window, on an X server without a screen.
pub(crate) const WINDOW: EquippedTests =
    EquippedTests { program: "view", scope: Scope::Whole, marker: "skipped-window:", package: debian::X_SERVER };

impl EquippedTests {
    /// Runs them. Missing requirements are a failure if the machine could have them.
    pub(crate) fn check(self, root: &Path, log: &mut Log, length: Length) -> Outcome {
        let marked = run_tests(log, &mut self.command(root), length, Some(self.marker))?;
        self.judge(marked, debian::can_have(self.package))
    }

    /// `cargo test` of the program.
    pub(crate) fn command(self, root: &Path) -> Command {
        cargo_workspace(root, self.scope, &["test", "--no-fail-fast", "--test", self.program])
    }

    fn judge(self, count: usize, can_have: bool) -> Outcome {
        let lacking = format!("{count} tests lack what {} has", self.package);
        match (count, can_have) {
            (0, _) => Ok(()),
            (_, true) => Err(NotPassed::Failed(format!("{lacking}, although it could be there"))),
            (_, false) => skipped(&lacking),
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
        assert_eq!(GPU.judge(3, false), skipped(&format!("3 tests lack what {} has", debian::SOFTWARE_ADAPTER)));
    }
}
