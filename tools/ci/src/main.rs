//! Every check of the repository, as one program.
//!
//! - `cargo run -p ci` runs the first tier: the checks that every change needs.
//! - `-- --changed` adds the parts of the second tier whose inputs have changed since their last pass.
//! - `-- --all` adds all parts.
//! - Names of steps and parts run only these: `cargo run -p ci -- clippy "GPU tests"`.
//!
//! `-- lines` prints the lines of code of each crate instead.
//!
//! All steps run, even after failures. The summary has each with its time, and the exit code is 1 if any failed.
#![forbid(unsafe_code)]

mod command;
mod cpu_tests;
mod debian;
mod equipped_tests;
mod features;
mod inputs;
mod licences;
mod lines;
mod links;
mod lints;
mod log;
mod page;
mod parts;
mod passed;
mod python;
mod report;
mod repository;
mod smoke;
mod test_times;
mod trust;

use std::process::ExitCode;

use command::{Scope, build, cargo, cargo_workspace};
use equipped_tests::GPU;
use parts::{PARTS, Part, Step};
use passed::Passed;
use report::Report;
use test_times::Length;

/// The steps that every change needs, fast ones first. All are compiled with the same settings, and share compiled crates.
const FIRST_TIER: &[Step] = &[
    ("packages", |_, log| debian::install(log)),
    ("format", |root, log| log.run(cargo(root).args(["fmt", "--all", "--check"]))),
    ("file length", |root, _| lines::check(root)),
    ("links", |root, _| links::check(root)),
    ("licences", |root, _| licences::check(root)),
    ("dependencies", licences::check_all),
    ("features", |root, _| features::check(root)),
    ("clippy", |root, log| log.run(&mut lints::denied(lints::clippy(root)))),
    ("docs", |root, log| log.run(&mut lints::docs(root))),
    ("tests", |root, log| cpu_tests::check(root, log, Length::Short)),
    ("GPU tests", |root, log| GPU.check(root, log, Length::Short)),
    ("doc tests", |root, log| log.run(&mut cargo_workspace(root, Scope::Windowless, &["test", "--doc"]))),
    ("examples", smoke::check_examples),
    ("benchmarks", |root, log| log.run(&mut cpu_tests::benchmarks(root))),
    ("programs", |root, log| log.run(&mut build(root, trust::PROGRAMS))),
    ("smoke render", smoke::check),
    trust::WATERTIGHT,
    trust::FUZZ,
];

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}

/// Runs the checks that arguments select.
fn run(arguments: &[String]) -> Result<(), String> {
    let root = repository::root()?;
    if arguments == ["lines"] {
        return lines::print(&root);
    }
    let Selection { steps, parts, only_changed, is_complete } = selection(arguments)?;
    let mut passed = Passed::read(&root)?;
    let mut report = Report::new(&root)?;
    report.run_all(&root, steps);
    for part in parts {
        part.run(&root, &mut report, &mut passed, only_changed)?;
    }
    report.finish(&repository::target(&root), is_complete)?;
    if report.has_failed() { Err("the checks have failed".to_owned()) } else { Ok(()) }
}

/// The checks of a run.
#[derive(Debug)]
struct Selection {
    steps: Vec<&'static Step>,
    parts: Vec<&'static Part>,
    /// Whether parts that have passed with the same inputs are left out.
    only_changed: bool,
    /// Whether no names were given.
    is_complete: bool,
}

/// Finds the checks that arguments select. A name is a step's of the first tier, a part's, or a step's of a part.
fn selection(arguments: &[String]) -> Result<Selection, String> {
    let (options, names): (Vec<_>, Vec<_>) = arguments.iter().partition(|argument| argument.starts_with("--"));
    let has = |option: &str| options.iter().any(|given| *given == option);
    let only_changed = has("--changed") && !has("--all");
    let is_named = |name: &str| names.iter().any(|given| *given == name);
    let steps_of_parts = || PARTS.iter().flat_map(|part| part.steps);
    let is_part = |name: &str| PARTS.iter().any(|part| part.name == name);
    let known: Vec<_> = FIRST_TIER.iter().map(|(name, _)| *name).chain(PARTS.iter().map(|part| part.name)).collect();
    let is_known = |name: &str| known.contains(&name) || steps_of_parts().any(|(step, _)| *step == name);
    let is_option = |argument: &str| ["--all", "--changed"].contains(&argument);
    if let Some(unknown) = arguments.iter().find(|argument| !is_option(argument) && !is_known(argument)) {
        return Err(format!(
            "usage: cargo run -p ci [-- [--all | --changed] [NAME ...] | lines]\nThere is no \"{unknown}\", but \"{}\"",
            known.join("\", \"")
        ));
    }
    if names.is_empty() {
        let parts = PARTS.iter().filter(|_| !options.is_empty()).collect();
        return Ok(Selection { steps: FIRST_TIER.iter().collect(), parts, only_changed, is_complete: true });
    }
    let steps = FIRST_TIER.iter().chain(steps_of_parts().filter(|(name, _)| !is_part(name)));
    Ok(Selection {
        steps: steps.filter(|(name, _)| is_named(name)).collect(),
        parts: PARTS.iter().filter(|part| is_named(part.name)).collect(),
        only_changed,
        is_complete: false,
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn checks_are_a_tier_or_those_that_are_named() {
        let names = |arguments: &[&str]| {
            let arguments: Vec<_> = arguments.iter().map(ToString::to_string).collect();
            let Selection { steps, parts, only_changed, .. } = selection(&arguments)?;
            let steps: Vec<_> = steps.into_iter().map(|(name, _)| *name).collect();
            Ok((steps, parts.into_iter().map(|part| part.name).collect::<Vec<_>>(), only_changed))
        };
        assert_eq!(names(&["page", "format"]), Ok((vec!["format"], vec!["page"], false)));
        assert_eq!(
            names(&["tests", "window tests", "clippy"]),
            Ok((vec!["clippy", "tests", "window tests"], vec![], false))
        );
        assert_eq!(names(&["--changed", "python"]), Ok((vec![], vec!["python"], true)));
        let counts =
            |arguments| names(arguments).map(|(steps, parts, only_changed)| (steps.len(), parts.len(), only_changed));
        assert_eq!(counts(&[]), Ok((FIRST_TIER.len(), 0, false)));
        assert_eq!(counts(&["--changed"]), Ok((FIRST_TIER.len(), PARTS.len(), true)));
        assert_eq!(counts(&["--all"]), Ok((FIRST_TIER.len(), PARTS.len(), false)));
        let refused: Result<_, String> = names(&["format", "--every"]);
        assert!(refused.unwrap_err().contains("no \"--every\", but \"packages\""));
    }

    #[test]
    fn every_step_has_a_budget() {
        let text = repository::read(&repository::root().unwrap().join(report::BUDGETS)).unwrap();
        let budgets: Vec<_> =
            passed::read_tables(&text).unwrap().into_iter().flat_map(|(_, budgets)| budgets).collect();
        let named: BTreeSet<_> = budgets.iter().map(|(step, _)| step.as_str()).collect();
        let steps: Vec<_> = FIRST_TIER.iter().chain(PARTS.iter().flat_map(|part| part.steps)).collect();
        assert_eq!(named, steps.iter().map(|(name, _)| *name).collect());
        assert_eq!(budgets.len(), steps.len(), "names are unique");
    }
}
