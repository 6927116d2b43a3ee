//! Every check of the repository, as one program: `cargo run -p ci`.
//!
//! All checks run, whatever fails; the summary names each with its time, and the exit code is 1 where any failed. With
//! `--all` what takes longest runs as well: tests in modules called `long`, the window, the page in a browser, the release
//! build, and ten million rays and a minute of fuzzing with it. Names of checks have only these run: `cargo run -p ci -- clippy "GPU tests"`.
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

/// What `--all` adds to the long tests: the window, the other programs, and everything compiled once more, as users compile it.
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
    let (scope, checks) = match chosen(&arguments) {
        Ok(chosen) => chosen,
        Err(usage) => {
            eprintln!("{usage}");
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
    let mut results = Vec::new();
    for (name, check) in checks {
        println!("\n=== {name}");
        let (started, cpu_started) = (Instant::now(), cpu_time::of_children());
        let outcome = check(&root, scope);
        let cpu_seconds = cpu_time::of_children().zip(cpu_started).map(|(end, start)| end - start);
        results.push(Ran { name, seconds: started.elapsed().as_secs_f64(), cpu_seconds, outcome });
    }
    print!("{}", outcome::summary(&results));
    if results.iter().any(Ran::has_failed) { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// The checks that arguments ask for, those that are named or else all, and for how much of the workspace.
fn chosen(arguments: &[String]) -> Result<(Scope, Vec<&'static Check>), String> {
    let is_all = arguments.iter().any(|argument| argument == "--all");
    let names: Vec<_> = arguments.iter().filter(|argument| *argument != "--all").collect();
    let is_named = |(of, _): &&Check| names.iter().any(|name| of == *name);
    // Those of the window are about nothing in a workspace without it.
    let is_whole = is_all || LONG_CHECKS.iter().any(|check| is_named(&check));
    let scope = if is_whole { Scope::Whole } else { Scope::Short };
    if names.is_empty() {
        return Ok((scope, CHECKS.iter().chain(LONG_CHECKS.iter().filter(|_| is_all)).collect()));
    }
    let all = || CHECKS.iter().chain(LONG_CHECKS);
    match names.iter().find(|name| all().all(|(of, _)| of != **name)) {
        None => Ok((scope, all().filter(is_named).collect())),
        Some(unknown) => {
            let known = all().map(|(name, _)| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
            Err(format!("usage: cargo run -p ci [-- [--all] [NAME ...]]\nThere is no check \"{unknown}\", but {known}"))
        }
    }
}

/// So many rays at shared edges and corners: none slips through.
fn watertight(root: &Path, build: Build, rays: &str) -> Outcome {
    run(Command::new(build.program(root, "watertight")).args(["--rays", rays]))
}

/// So many mutants of all input, or for so long: none is a finding.
fn fuzz(root: &Path, build: Build, how_long: [&str; 2]) -> Outcome {
    run(Command::new(build.program(root, "fuzz")).args(how_long))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checks_are_all_or_those_that_are_named() {
        let names = |arguments: &[&str]| {
            let arguments: Vec<_> = arguments.iter().map(ToString::to_string).collect();
            chosen(&arguments).map(|(scope, checks)| (scope, checks.iter().map(|(name, _)| *name).collect::<Vec<_>>()))
        };
        assert_eq!(names(&["page", "format"]), Ok((Scope::Whole, vec!["format", "page"])));
        assert_eq!(names(&["--all", "tests"]), Ok((Scope::Whole, vec!["tests"])));
        assert_eq!(names(&["tests", "clippy"]), Ok((Scope::Short, vec!["clippy", "tests"])));
        let count = |arguments| names(arguments).map(|(_, names)| names.len());
        assert_eq!(count(&[]), Ok(CHECKS.len()));
        assert_eq!(count(&["--all"]), Ok(CHECKS.len() + LONG_CHECKS.len()));
        assert!(names(&["format", "--every"]).unwrap_err().contains("no check \"--every\", but \"packages\""));
    }
}
