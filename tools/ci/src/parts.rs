use std::path::Path;

use crate::command::{FEATURES, WINDOW_FEATURES};
use crate::equipped_tests::{GPU, VIEWER, WINDOW};
use crate::inputs::Inputs;
use crate::log::{Log, Outcome};
use crate::passed::{Pass, Passed};
use crate::report::Report;
use crate::test_times::Length;
use crate::{cpu_tests, lints, page, python, smoke, trust};

/// A step's name, and its check in the repository.
pub(crate) type Step = (&'static str, fn(&Path, &mut Log) -> Outcome);

/// Steps of the second tier, which needn't run again while its inputs stay the same.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    pub(crate) name: &'static str,
    pub(crate) steps: &'static [Step],
    inputs: Inputs,
}

/// The second tier. The other inputs of a part include its source file here.
pub(crate) const PARTS: &[Part] = &[
    Part {
        name: "long tests",
        steps: &[("long tests", |root, log| cpu_tests::check(root, log, Length::Long))],
        inputs: Inputs {
            packages: &["umbrage-rays", "umbrage-verify", "umbrage-bench", "umbrage-cli"],
            tests: true,
            features: &[FEATURES],
            others: &["tools/ci/src/cpu_tests.rs"],
        },
    },
    Part {
        name: "long GPU tests",
        steps: &[("long GPU tests", |root, log| GPU.check(root, log, Length::Long))],
        inputs: Inputs {
            packages: &["umbrage-verify"],
            tests: true,
            features: &[FEATURES],
            others: &["tools/ci/src/equipped_tests.rs"],
        },
    },
    Part {
        name: "python",
        steps: &[("python", python::check)],
        inputs: Inputs {
            packages: &["umbrage-python", "umbrage-cli"],
            tests: false,
            features: &[FEATURES],
            others: &[
                "clippy.toml",
                "pyproject.toml",
                "docs/python.md",
                "tools/compatibility",
                "tools/ci/src/lints.rs",
                "tools/ci/src/python.rs",
            ],
        },
    },
    Part {
        name: "trust",
        steps: &[trust::AT_LENGTH],
        inputs: Inputs {
            packages: &["umbrage-verify", "umbrage-cli"],
            tests: false,
            features: &[FEATURES],
            others: &["tools/ci/src/trust.rs"],
        },
    },
    Part {
        name: "window",
        steps: &[
            ("viewer tests", |root, log| VIEWER.check(root, log, Length::Short)),
            ("window tests", |root, log| WINDOW.check(root, log, Length::Short)),
            ("window clippy", |root, log| log.run(&mut lints::denied(lints::window_clippy(root)))),
        ],
        inputs: Inputs {
            packages: lints::WINDOW_PACKAGES,
            tests: true,
            features: &[FEATURES, WINDOW_FEATURES],
            others: &["clippy.toml", "tools/ci/src/equipped_tests.rs", "tools/ci/src/lints.rs"],
        },
    },
    Part {
        name: "page",
        steps: &[("page", page::check)],
        inputs: Inputs {
            // The page depends on the GPU engine only in browsers.
            packages: &["web", "umbrage-page", "umbrage-gpu"],
            tests: false,
            features: &[],
            others: &["tools/web-tests", "tools/ci/src/page.rs"],
        },
    },
    Part {
        name: "all docs",
        steps: &[("all docs", |root, log| log.run(&mut lints::all_docs(root)))],
        inputs: Inputs {
            packages: &[],
            tests: false,
            features: &[FEATURES, WINDOW_FEATURES],
            others: &["tools/ci/src/lints.rs"],
        },
    },
    Part {
        name: "first picture",
        steps: &[("first picture", smoke::check_first_picture)],
        inputs: Inputs { packages: &["umbrage-cli"], tests: false, features: &[], others: &["tools/ci/src/smoke.rs"] },
    },
];

impl Part {
    /// Runs the steps, unless only changed parts are to run and this one has passed with the same inputs. Records a
    /// pass if all of them pass; a skipped step doesn't.
    ///
    /// # Errors
    /// If a pass can't be recorded.
    pub(crate) fn run(
        &self,
        root: &Path,
        report: &mut Report,
        passed: &mut Passed,
        only_changed: bool,
    ) -> Result<(), String> {
        let inputs = self.inputs.hash(root);
        let inputs = inputs.inspect_err(|why| println!("{} counts as changed: {why}", self.name)).ok();
        let pass = inputs.as_ref().and_then(|inputs| passed.with_inputs(self.name, inputs));
        if let (true, Some(pass)) = (only_changed, pass) {
            report.leave_out(self.name, pass);
            return Ok(());
        }
        let ran = report.run_all(root, self.steps);
        match inputs {
            Some(inputs) if ran.iter().all(|step| step.outcome.is_ok()) => {
                let seconds = ran.iter().map(|step| step.seconds).sum();
                let cpu_seconds = ran.iter().filter_map(|step| step.cpu_seconds).sum();
                passed.record(self.name, Pass { inputs, seconds, cpu_seconds })
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::inputs::tests::Repository;
    use crate::log::skipped;
    use crate::repository;

    const PASSING: Part = Part {
        name: "a",
        steps: &[("first", |_, _| Ok(())), ("second", |_, _| Ok(()))],
        inputs: Inputs { packages: &["a"], tests: true, features: &[], others: &[] },
    };

    /// The number of steps that run for changes.
    fn steps_due(part: &Part, repository: &Repository) -> usize {
        let root = repository.root();
        let mut report = Report::default();
        part.run(root, &mut report, &mut Passed::read(root).unwrap(), true).unwrap();
        report.steps.len()
    }

    #[test]
    fn parts_are_due_when_their_inputs_change() {
        let repository = Repository::new();
        assert_eq!(steps_due(&PASSING, &repository), 2, "it has never passed");
        assert_eq!(steps_due(&PASSING, &repository), 0);
        repository.write("d/src/lib.rs", "//! Of another part\n");
        assert_eq!(steps_due(&PASSING, &repository), 0);
        repository.write("b/src/lib.rs", "//! Of a dependency\n");
        assert_eq!(steps_due(&PASSING, &repository), 2);
        assert_eq!(steps_due(&PASSING, &repository), 0);
        let mut report = Report::default();
        PASSING.run(repository.root(), &mut report, &mut Passed::read(repository.root()).unwrap(), false).unwrap();
        assert_eq!(report.steps.len(), 2, "all parts are to run");
        fs::remove_dir_all(repository.root().join(".git")).unwrap();
        assert_eq!(steps_due(&PASSING, &repository), 2, "without git");
    }

    #[test]
    fn parts_that_fail_or_are_skipped_are_due_again() {
        let repository = Repository::new();
        let failing =
            Part { steps: &[("first", |_, _| Ok(())), ("second", |_, _| Err("no".to_owned().into()))], ..PASSING };
        let skipping = Part { steps: &[("first", |_, _| skipped("no browser")), ("second", |_, _| Ok(()))], ..PASSING };
        for part in [failing, skipping] {
            assert_eq!(steps_due(&part, &repository), 2);
            assert_eq!(steps_due(&part, &repository), 2);
        }
        assert_eq!(steps_due(&PASSING, &repository), 2);
        assert_eq!(steps_due(&failing, &repository), 0);
    }

    #[test]
    fn long_tests_are_inputs_of_their_part() {
        let root = repository::root().unwrap();
        let folders = |name: &str| PARTS.iter().find(|part| part.name == name).unwrap().inputs.folders(&root).unwrap();
        let (on_cpu, on_gpu) = (folders("long tests"), folders("long GPU tests"));
        let is_long = |line: &str| line.trim_start().starts_with("mod long");
        for path in repository::files(&root, "rs").unwrap() {
            if repository::read(&path).unwrap().lines().any(is_long) {
                let path = path.strip_prefix(&root).unwrap();
                let is_gpu = path.components().any(|folder| folder.as_os_str() == GPU.program);
                let folders = if is_gpu { &on_gpu } else { &on_cpu };
                assert!(folders.iter().any(|folder| path.starts_with(folder)), "{}", path.display());
            }
        }
    }

    #[test]
    fn other_inputs_are_there() {
        let root = repository::root().unwrap();
        let missing = |path: &&&str| !root.join(path).exists();
        for part in PARTS {
            assert_eq!(part.inputs.others.iter().find(missing), None, "{}", part.name);
        }
    }
}
