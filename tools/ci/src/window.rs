use std::path::Path;

use crate::command::cargo_workspace;
use crate::debian;
use crate::outcome::Outcome;
use crate::test_times::{self, TestTimes};

/// What a test prints at the start of a line on standard error when it finds no X server.
const SKIPPED: &str = "skipped-window:";

/// The test's file.
pub(crate) const TEST: &str = "view";

/// The command with its window, on an X server without a screen. On a machine that could have one, it is a failure if
/// there is none.
pub(crate) fn check(root: &Path) -> Outcome {
    let mut test = cargo_workspace(root, &["test", "--test", TEST]);
    test_times::ask_for_times(&mut test);
    test.arg("--nocapture");
    match TestTimes::of(&mut test, Some(SKIPPED)) {
        Err(why) => Outcome::Failed(why),
        Ok(TestTimes { marked: 0, .. }) => Outcome::Passed,
        Ok(_) if debian::can_have(debian::X_SERVER) => Outcome::Failed("Xvfb could be there, but isn't".to_owned()),
        Ok(_) => Outcome::Skipped("there is no Xvfb".to_owned()),
    }
}
