use std::path::Path;
use std::process::Command;

use crate::command::run;
use crate::outcome::Outcome;
use crate::repository::Build;

/// So many rays at shared edges and corners: none slips through.
pub(crate) fn check(root: &Path, build: Build, rays: &str) -> Outcome {
    run(Command::new(build.program(root, "watertight")).args(["--rays", rays]))
}
