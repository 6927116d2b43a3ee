use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command::{Scope, cargo_workspace};
use crate::equipped_tests::{GPU, VIEWER, WINDOW};
use crate::log::{Log, Outcome};
use crate::repository::files;
use crate::test_times::{Length, run_tests};

/// Test programs that have a step of their own.
const APART: [&str; 3] = [GPU.program, VIEWER.program, WINDOW.program];

/// Runs all tests but those in documentation and those that have a step of their own.
pub(crate) fn check(root: &Path, log: &mut Log, length: Length) -> Outcome {
    run_tests(log, &mut command(root)?, length, None).map(drop)
}

/// `cargo test` of all programs that have no step of their own. A program's tests run in one process, since those of the
/// conformance suite share the oracle's answers.
pub(crate) fn command(root: &Path) -> Result<Command, String> {
    let arguments = ["test", "--no-fail-fast", "--lib", "--bins", "--examples"];
    let mut test = cargo_workspace(root, Scope::Windowless, &arguments);
    for program in test_programs(root)?.iter().filter(|program| !APART.contains(&program.as_str())) {
        test.args(["--test", program]);
    }
    Ok(test)
}

/// Runs each benchmark once, as a test.
pub(crate) fn benchmarks(root: &Path) -> Command {
    cargo_workspace(root, Scope::Windowless, &["test", "--bench", "*", "--examples"])
}

/// The names of all test programs: files in the folders `tests` of packages, and folders there with a `main.rs`. A
/// folder `tests` within a package's source has modules of unit tests.
fn test_programs(root: &Path) -> Result<BTreeSet<String>, String> {
    let program = |path: PathBuf| {
        let program = if path.ends_with("main.rs") { path.parent()? } else { &path };
        let folder = program.parent()?;
        let is_test = folder.ends_with("tests") && folder.with_file_name("Cargo.toml").is_file();
        is_test.then(|| program.file_stem().unwrap_or_default().to_string_lossy().into_owned())
    };
    Ok(files(root, "rs")?.into_iter().filter_map(program).collect())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn test_programs_are_files_and_folders() {
        let root = tempfile::tempdir().unwrap();
        let tests = ["a/tests/one.rs", "a/tests/two/main.rs", "a/tests/two/b.rs", "b/tests/data/c.txt"];
        let others = ["a/Cargo.toml", "b/Cargo.toml", "a/src/main.rs", "a/src/module/tests/unit.rs"];
        for path in tests.into_iter().chain(others) {
            let path = root.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        assert_eq!(test_programs(root.path()).unwrap().into_iter().collect::<Vec<_>>(), ["one", "two"]);
    }

    #[test]
    fn programs_with_a_step_of_their_own_are_there() {
        let programs = test_programs(&crate::repository::root().unwrap()).unwrap();
        assert!(APART.iter().all(|name| programs.contains(*name)), "{programs:?}");
    }
}
