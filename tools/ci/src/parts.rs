use std::path::Path;

use crate::equipped_tests::{GPU, VIEWER, WINDOW};
use crate::log::Log;
use crate::outcome::Outcome;
use crate::test_times::Length;
use crate::{cpu_tests, first_picture, lints, page, python, trust};

/// A step's name, and the check that it runs in the repository.
pub(crate) type Step = (&'static str, fn(&Path, &mut Log) -> Outcome);

/// Steps of the second tier that prove one subject.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    pub(crate) name: &'static str,
    pub(crate) steps: &'static [Step],
}

/// The second tier.
pub(crate) const PARTS: &[Part] = &[
    Part { name: "long tests", steps: &[("long tests", |root, log| cpu_tests::check(root, log, Length::Long))] },
    Part { name: "long GPU tests", steps: &[("long GPU tests", |root, log| GPU.check(root, log, Length::Long))] },
    Part { name: "python", steps: &[("python", python::check)] },
    Part { name: "trust", steps: trust::AT_LENGTH },
    Part {
        name: "window",
        steps: &[
            ("viewer tests", |root, log| VIEWER.check(root, log, Length::Short)),
            ("window tests", |root, log| WINDOW.check(root, log, Length::Short)),
            ("window clippy", |root, log| log.run(&mut lints::denied(lints::window_clippy(root)))),
        ],
    },
    Part { name: "page", steps: &[("page", page::check)] },
    Part { name: "all docs", steps: &[("all docs", |root, log| log.run(&mut lints::all_docs(root)))] },
    Part { name: "first picture", steps: &[("first picture", first_picture::check)] },
];
