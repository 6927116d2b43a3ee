//! Every check of the repository, as one program: `cargo run -p ci`.
//!
//! All checks run, whatever fails; the summary names each with its time, and the exit code is 1 where any failed. With
//! `--all` what takes longest runs as well: the window, the page in a browser, the release build, and ten million rays and a minute of fuzzing with it.
#![forbid(unsafe_code)]

mod command;
mod cpu_tests;
mod cpu_time;
mod debian;
mod dependencies;
mod equipped_tests;
mod examples;
mod file_length;
mod licences;
mod links;
mod outcome;
mod page;
mod python;
mod repository;
mod smoke;
mod test_times;
mod watch;

use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::Instant;

use command::{Scope, cargo, cargo_workspace, run};
use equipped_tests::{GPU, VIEWER, WINDOW};
use outcome::{Outcome, Ran};
use repository::Build;

/// A check's name and what does it, in the repository and for tests of so much of it.
type Check = (&'static str, fn(&Path, Scope) -> Outcome);

/// In the order in which they run: what fails fast comes first, and what builds the most comes last.
const CHECKS: &[Check] = &[
    ("packages", |_, _| debian::install()),
    ("format", |root, _| run(cargo(root).args(["fmt", "--all", "--check"]))),
    ("file length", |root, _| file_length::check(root)),
    ("links", |root, _| links::check(root)),
    ("licences", |root, _| licences::check(root)),
    ("dependencies", |root, _| dependencies::check(root)),
    ("clippy", |root, _| {
        run(cargo_workspace(root, Scope::Whole, &["clippy", "--all-targets"]).args(["--", "-D", "warnings"]))
    }),
    ("docs", |root, _| {
        run(cargo_workspace(root, Scope::Whole, &["doc", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"))
    }),
    ("tests", cpu_tests::check),
    ("examples", examples::check),
    ("GPU tests", |root, scope| GPU.check(root, scope)),
    ("doc tests", |root, scope| run(&mut cargo_workspace(root, scope, &["test", "--doc"]))),
    ("benchmarks", cpu_tests::check_benchmarks),
    // Tests have made these already, with the features that examples give their dependencies.
    ("programs", |root, scope| {
        run(cargo_workspace(root, scope, &["build", "--examples"]).args([
            "--bin",
            "umbrage",
            "--bin",
            "watertight",
            "--bin",
            "fuzz",
        ]))
    }),
    ("python", python::check),
    ("smoke render", |root, _| smoke::check(root, Build::Dev)),
    ("watertight", |root, _| watertight(root, Build::Dev, "1e6")),
    ("fuzz", |root, _| fuzz(root, Build::Dev, ["--mutants", "300"])),
];

/// What `--all` adds: the window, the other programs, and everything compiled once more, as users compile it.
const LONG_CHECKS: &[Check] = &[
    ("viewer", |root, scope| VIEWER.check(root, scope)),
    ("window", |root, scope| WINDOW.check(root, scope)),
    ("all programs", |root, scope| run(&mut cargo_workspace(root, scope, &["build", "--bins", "--examples"]))),
    ("page", |root, _| page::check(root)),
    ("release build", |root, _| {
        run(cargo(root).args(["build", "--release", "--bins", "-p", "umbrage-cli", "-p", "umbrage-verify", "--locked"]))
    }),
    ("smoke, release", |root, _| smoke::check(root, Build::Release)),
    ("10⁷ rays", |root, _| watertight(root, Build::Release, "1e7")),
    ("fuzz, release", |root, _| fuzz(root, Build::Release, ["--minutes", "1"])),
];

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let is_all = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => false,
        ["--all"] => true,
        _ => {
            eprintln!("usage: cargo run -p ci [-- --all]");
            return ExitCode::FAILURE;
        }
    };
    let root = match repository::root() {
        Ok(root) => root,
        Err(why) => {
            eprintln!("error: {why}");
            return ExitCode::FAILURE;
        }
    };
    let scope = if is_all { Scope::Whole } else { Scope::WithoutWindow };
    let mut results = Vec::new();
    for (name, check) in CHECKS.iter().chain(LONG_CHECKS.iter().filter(|_| is_all)) {
        println!("\n=== {name}");
        let (started, cpu_started) = (Instant::now(), cpu_time::of_children());
        let outcome = check(&root, scope);
        let cpu_seconds = cpu_time::of_children().zip(cpu_started).map(|(end, start)| end - start);
        results.push(Ran { name, seconds: started.elapsed().as_secs_f64(), cpu_seconds, outcome });
    }
    print!("{}", outcome::summary(&results));
    if results.iter().any(Ran::has_failed) { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// So many rays at shared edges and corners: none slips through.
fn watertight(root: &Path, build: Build, rays: &str) -> Outcome {
    run(Command::new(build.program(root, "watertight")).args(["--rays", rays]))
}

/// So many mutants of all input, or for so long: none is a finding.
fn fuzz(root: &Path, build: Build, how_long: [&str; 2]) -> Outcome {
    run(Command::new(build.program(root, "fuzz")).args(how_long))
}
