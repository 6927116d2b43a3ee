use std::path::Path;
use std::process::Command;

use crate::command::run;
use crate::outcome::Outcome;
use crate::repository::Build;

/// Rays at shared edges and corners: none slips through.
pub(crate) fn check(root: &Path, build: Build) -> Outcome {
    let rays = match build {
        // With debug assertions, and barely optimised.
        Build::Dev => "1e6",
        Build::Release => "1e7",
    };
    run(Command::new(build.program(root, "watertight")).args(["--rays", rays]))
}
