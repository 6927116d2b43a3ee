use std::path::Path;
use std::process::Command;

use crate::command::build;
use crate::log::{Log, Outcome};
use crate::parts::Step;
use crate::repository::built;

/// Programs that steps run, and programs that the fuzzer runs.
pub(crate) const PROGRAMS: &[&str] = &["umbrage", "watertight", "fuzz", "referee"];

/// A million rays at shared edges and corners: none slips through.
pub(crate) const WATERTIGHT: Step = ("watertight", |root, log| run(root, log, "watertight", ["--rays", "1e6"]));

/// The same 300 mutants of each kind of input every time: none is a finding.
pub(crate) const FUZZ: Step = ("fuzz", |root, log| run(root, log, "fuzz", ["--mutants", "300"]));

/// Random scenes, rays and mutants for over ten CPU minutes. Each program takes one processor, so they run together.
pub(crate) const AT_LENGTH: Step = ("trust at length", |root, log| {
    log.run(&mut build(root, PROGRAMS))?;
    let programs: [(&str, &[&str]); 5] = [
        ("referee", &["--minutes", "3"]),
        ("referee", &["--frames", "--minutes", "3"]),
        ("referee", &["--distances", "--minutes", "1"]),
        ("fuzz", &["--minutes", "5"]),
        ("watertight", &["--rays", "1e7"]),
    ];
    log.run_together(&mut programs.map(|(program, arguments)| command(root, program, arguments)))
});

fn run(root: &Path, log: &mut Log, program: &str, arguments: [&str; 2]) -> Outcome {
    log.run(&mut build(root, PROGRAMS))?;
    log.run(&mut command(root, program, &arguments))
}

fn command(root: &Path, program: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(built(root, program));
    command.current_dir(root).args(arguments);
    command
}
