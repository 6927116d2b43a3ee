use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::command::{Scope, build, cargo_workspace, output};
use crate::equipped_tests::{GPU, VIEWER, WINDOW};
use crate::log::{Outcome, of_complaints};
use crate::{cpu_tests, lints, python, trust};

/// Units of compilation without their features; for each, its package and the commands by the features that they select.
type Units = BTreeMap<String, (String, BTreeMap<BTreeSet<String>, BTreeSet<&'static str>>)>;

/// The packages whose own features differ: they have the window or they don't.
const WITH_OR_WITHOUT_WINDOW: [&str; 2] = ["umbrage-bench@", "umbrage-cli@"];

/// Checks that the commands compile no package twice with different features. The page, which has features of its own,
/// is left out, and so are this program, which is compiled before, and all documentation: without tests it checks a few
/// packages with fewer features.
pub(crate) fn check(root: &Path) -> Outcome {
    let commands = [
        ("clippy", lints::clippy(root)),
        ("docs", lints::docs(root)),
        ("tests", cpu_tests::command(root)?),
        ("GPU tests", GPU.command(root)),
        ("doc tests", cargo_workspace(root, Scope::Windowless, &["test", "--doc"])),
        ("examples", build(root, &[])),
        ("benchmarks", cpu_tests::benchmarks(root)),
        ("programs", build(root, trust::PROGRAMS)),
        ("python", python::library(root)),
        ("window clippy", lints::window_clippy(root)),
        ("viewer tests", VIEWER.command(root)),
        ("window tests", WINDOW.command(root)),
    ];
    let mut units = Units::new();
    for (name, mut command) in commands {
        add(&mut units, name, &unit_graph(&mut command)?)?;
    }
    println!("{} units of compilation", units.len());
    of_complaints(&complaints(&units))
}

/// The units that a command compiles, as JSON, by an unstable option of cargo; the command isn't run.
fn unit_graph(command: &mut Command) -> Result<String, String> {
    output(command.args(["--unit-graph", "-Z", "unstable-options"]).env("RUSTC_BOOTSTRAP", "1"))
}

fn add(units: &mut Units, command: &'static str, graph: &str) -> Result<(), String> {
    let mut graph: Value = serde_json::from_str(graph).map_err(|error| format!("the unit graph: {error}"))?;
    let listed = graph["units"].as_array_mut().ok_or("the unit graph has no units")?;
    for unit in listed {
        let features = unit["features"].as_array().into_iter().flatten();
        let features = features.filter_map(|feature| feature.as_str().map(str::to_owned)).collect();
        let package = package(unit["pkg_id"].as_str().unwrap_or_default()).to_owned();
        if let Some(unit) = unit.as_object_mut() {
            unit.remove("features");
            unit.remove("dependencies");
        }
        if let Some(profile) = unit["profile"].as_object_mut() {
            // Units of the profiles `dev` and `test` are the same if their settings are.
            profile.remove("name");
        }
        let (_, selected) = units.entry(unit.to_string()).or_insert_with(|| (package, BTreeMap::new()));
        selected.entry(features).or_default().insert(command);
    }
    Ok(())
}

/// Name and version from `registry+https://…#NAME@VERSION` or `path+file://…/NAME#VERSION`.
fn package(id: &str) -> &str {
    let id = id.rsplit('/').next().unwrap_or(id);
    id.split_once('#').map_or(id, |(_, package)| if package.contains('@') { package } else { id })
}

/// Each package that has different features, with the features that some commands select and others don't.
fn complaints(units: &Units) -> Vec<String> {
    let complaint = |(package, selected): &(String, BTreeMap<BTreeSet<String>, BTreeSet<&str>>)| {
        let shared = selected.keys().cloned().reduce(|one, other| &one & &other)?;
        let variants = selected.iter().map(|(features, commands)| {
            let (features, commands) = (joined(&(features - &shared)), joined(commands));
            format!("with {} for {commands}", if features.is_empty() { "nothing more" } else { &features })
        });
        let variants = variants.collect::<Vec<_>>().join("; ");
        let may_differ = WITH_OR_WITHOUT_WINDOW.iter().any(|name| package.starts_with(name));
        (selected.len() > 1 && !may_differ).then(|| format!("{package} is built {variants}"))
    };
    // A package's build script and its library differ alike.
    units.values().filter_map(complaint).collect::<BTreeSet<_>>().into_iter().collect()
}

fn joined<T: AsRef<str>>(words: &BTreeSet<T>) -> String {
    words.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn graph(profile: &str, level: u8, features: &str) -> String {
        let unit = |mode: &str| {
            format!(
                r#"{{"pkg_id": "registry+https://host/index#num@1.2.3", "mode": "{mode}", "dependencies": [],
                "profile": {{"name": "{profile}", "opt_level": "{level}"}}, "features": [{features}]}}"#
            )
        };
        format!(r#"{{"version": 1, "units": [{}, {}]}}"#, unit("build"), unit("run-custom-build"))
    }

    fn complaints_of(graphs: &[(&'static str, String)]) -> Vec<String> {
        let mut units = Units::new();
        for (command, graph) in graphs {
            add(&mut units, command, graph).unwrap();
        }
        complaints(&units)
    }

    #[test]
    fn packages_with_different_features_are_named_once() {
        let tests = ("tests", graph("test", 1, r#""a", "b""#));
        let same = ("programs", graph("dev", 1, r#""b", "a""#));
        let apart = ("macros", graph("dev", 0, r#""a""#));
        assert!(complaints_of(&[tests.clone(), same.clone(), apart]).is_empty());
        let other = ("docs", graph("dev", 1, r#""a""#));
        let expected = "num@1.2.3 is built with nothing more for docs; with b for programs, tests";
        assert_eq!(complaints_of(&[tests, same, other]), [expected]);
        assert!(add(&mut Units::new(), "tests", "{}").is_err());
    }

    #[test]
    fn packages_are_named_with_their_versions() {
        assert_eq!(package("registry+https://github.com/rust-lang/crates.io-index#syn@3.0.9"), "syn@3.0.9");
        assert_eq!(package("path+file:///home/crates/gpu#umbrage-gpu@0.1.0"), "umbrage-gpu@0.1.0");
        assert_eq!(package("path+file:///home/tools/ci#0.1.0"), "ci#0.1.0");
    }
}
