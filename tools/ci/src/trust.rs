use std::path::Path;
use std::process::Command;

use crate::command::build;
use crate::log::Log;
use crate::outcome::Outcome;
use crate::parts::Step;
use crate::repository::built;

/// Programs that steps run, and that the fuzzer runs itself.
pub(crate) const PROGRAMS: &[&str] = &["umbrage", "watertight", "fuzz", "referee"];

/// A million rays at shared edges and corners: none slips through.
pub(crate) const WATERTIGHT: Step = ("watertight", |root, log| run(root, log, "watertight", ["--rays", "1e6"]));

/// The same 300 mutants of each kind of input every time: none is a finding.
pub(crate) const FUZZ: Step = ("fuzz", |root, log| run(root, log, "fuzz", ["--mutants", "300"]));

/// Random scenes, rays and mutants for ten minutes and more.
pub(crate) const AT_LENGTH: &[Step] = &[
    ("referee at length", |root, log| run(root, log, "referee", ["--minutes", "5"])),
    ("fuzz at length", |root, log| run(root, log, "fuzz", ["--minutes", "5"])),
    ("10⁷ rays", |root, log| run(root, log, "watertight", ["--rays", "1e7"])),
];

fn run(root: &Path, log: &mut Log, program: &str, arguments: [&str; 2]) -> Outcome {
    log.run(&mut build(root, PROGRAMS))?;
    log.run(Command::new(built(root, program)).current_dir(root).args(arguments))
}
