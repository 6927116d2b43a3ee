use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crate::command::{Program, cargo_workspace, run};
use crate::outcome::Outcome;
use crate::test_times::{self, TestTimes};
use crate::{gpu_tests, window};

/// Test programs that have a check of their own.
const APART: [&str; 2] = [gpu_tests::TEST, window::TEST];

/// All tests but those in documentation, which nextest can't run, and those that have a check of their own.
pub(crate) fn check(root: &Path) -> Outcome {
    let mut test = if Program::Nextest.is_here() {
        let others = format!("not ({})", APART.map(|name| format!("binary(={name})")).join(" or "));
        let mut nextest = cargo_workspace(root, &["nextest", "run"]);
        nextest.args(["--no-fail-fast", "-E", &others]);
        nextest
    } else {
        let programs = match test_programs(root) {
            Ok(programs) => programs,
            Err(why) => return Outcome::Failed(why),
        };
        let mut test = cargo_workspace(root, &["test", "--no-fail-fast", "--lib", "--bins", "--examples"]);
        for program in programs.iter().filter(|program| !APART.contains(&program.as_str())) {
            test.args(["--test", program]);
        }
        test_times::ask_for_times(&mut test);
        test
    };
    TestTimes::of(&mut test, None).map_or_else(Outcome::Failed, |_| Outcome::Passed)
}

/// Each benchmark once, as a test that it can be run.
pub(crate) fn check_benchmarks(root: &Path) -> Outcome {
    run(cargo_workspace(root, &["test"]).args(["--bench", "*"]))
}

/// The names of all test programs, as cargo finds them in folders of tests.
fn test_programs(root: &Path) -> Result<BTreeSet<String>, String> {
    let mut names = BTreeSet::new();
    for group in ["apps", "crates", "tools"] {
        for member in entries(&root.join(group))? {
            let tests = member.join("tests");
            if !tests.is_dir() {
                continue;
            }
            for entry in entries(&tests)? {
                let is_program = entry.join("main.rs").is_file() || entry.extension().is_some_and(|kind| kind == "rs");
                if let Some(name) = entry.file_stem().filter(|_| is_program) {
                    names.insert(name.to_string_lossy().into_owned());
                }
            }
        }
    }
    Ok(names)
}

fn entries(folder: &Path) -> Result<Vec<std::path::PathBuf>, String> {
    let failure = |error| format!("{}: {error}", folder.display());
    fs::read_dir(folder).map_err(failure)?.map(|entry| Ok(entry.map_err(failure)?.path())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn test_programs_are_files_and_folders() {
        let root = tempfile::tempdir().unwrap();
        for path in
            ["crates/a/tests/one.rs", "crates/a/tests/two/main.rs", "crates/a/tests/two/b.rs", "apps/b/src/lib.rs"]
        {
            let path = root.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        assert!(test_programs(root.path()).is_err(), "there are no tools");
        for path in ["tools/c/tests/data", "tools/c/tests/three"] {
            fs::create_dir_all(root.path().join(path)).unwrap();
        }
        fs::write(root.path().join("tools/c/tests/three/main.rs"), "").unwrap();
        assert_eq!(test_programs(root.path()).unwrap().into_iter().collect::<Vec<_>>(), ["one", "three", "two"]);
    }

    #[test]
    fn what_has_a_check_of_its_own_is_there() {
        let programs = test_programs(&crate::repository::root().unwrap()).unwrap();
        assert!(APART.iter().all(|name| programs.contains(*name)), "{programs:?}");
    }
}
