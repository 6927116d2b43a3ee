//! Every check of the repository, as one program: `cargo run -p ci`.
//!
//! All checks run, whatever fails; the summary names each with its time, and the exit code is 1 where any failed.
#![forbid(unsafe_code)]

mod command;
mod debian;
mod examples;
mod file_length;
mod gpu_tests;
mod licences;
mod links;
mod outcome;
mod repository;
mod skips;
mod smoke;
mod spdx;
mod window;

use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::Instant;

use command::{Program, cargo, cargo_workspace, run};
use outcome::Outcome;

/// A check's name and what does it.
type Check = (&'static str, fn(&Path) -> Outcome);

/// In the order in which they run: what fails fast comes first, and what builds the most comes last.
const CHECKS: [Check; 16] = [
    ("packages", debian::install),
    ("format", |root| run(cargo(root).args(["fmt", "--all", "--check"]))),
    ("file length", file_length::check),
    ("links", links::check),
    ("licences", licences::check),
    ("advisories", advisories),
    ("clippy", |root| run(cargo_workspace(root, &["clippy", "--all-targets"]).args(["--", "-D", "warnings"]))),
    ("docs", |root| run(cargo_workspace(root, &["doc", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"))),
    ("tests", tests),
    ("examples", examples::check),
    ("GPU tests", gpu_tests::check),
    ("window", window::check),
    ("doc tests", |root| run(&mut cargo_workspace(root, &["test", "--doc"]))),
    ("release build", |root| {
        run(cargo(root).args(["build", "--release", "--bins", "-p", "umbrage-cli", "-p", "umbrage-verify", "--locked"]))
    }),
    ("smoke render", smoke::check),
    ("watertight", |root| run(&mut Command::new(repository::released(root, "watertight")))),
];

fn main() -> ExitCode {
    let root = match repository::root() {
        Ok(root) => root,
        Err(why) => {
            eprintln!("error: {why}");
            return ExitCode::FAILURE;
        }
    };
    let mut results = Vec::new();
    for (name, check) in CHECKS {
        println!("\n=== {name}");
        let started = Instant::now();
        let outcome = check(&root);
        results.push((name, started.elapsed().as_secs_f64(), outcome));
    }
    print!("{}", outcome::summary(&results));
    if results.iter().any(|(_, _, outcome)| outcome.is_failure()) { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// All tests but those in documentation, which nextest can't run, and, with nextest, those that have a check of their own.
fn tests(root: &Path) -> Outcome {
    if Program::Nextest.is_here() {
        let others = format!("not (binary(={}) or binary(={}))", gpu_tests::TEST, window::TEST);
        run(cargo_workspace(root, &["nextest", "run"]).args(["--no-fail-fast", "-E", &others]))
    } else {
        run(cargo_workspace(root, &["test", "--all-targets"]).arg("--no-fail-fast"))
    }
}

/// Known vulnerabilities of dependencies, where the tool and its database are here already.
fn advisories(root: &Path) -> Outcome {
    if !Program::Deny.is_here() {
        return Outcome::Skipped("cargo-deny is not installed (cargo install cargo-deny)".to_owned());
    }
    let Some(home) = std::env::home_dir() else {
        return Outcome::Skipped("there is no home folder to hold an advisory database".to_owned());
    };
    let databases = [home.join(".cargo/advisory-db"), home.join(".cargo/advisory-dbs")];
    if !databases.iter().any(|folder| folder.is_dir()) {
        return Outcome::Skipped("there is no advisory database (cargo deny fetch)".to_owned());
    }
    run(cargo(root).args(["deny", "--offline", "check", "advisories"]))
}
