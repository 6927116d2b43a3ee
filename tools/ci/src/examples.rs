use std::path::Path;
use std::process::Command;

use crate::command::{Scope, cargo_workspace, run};
use crate::outcome::Outcome;
use crate::repository::{self, Build};

/// The folder of the library's examples.
const FOLDER: &str = "crates/umbrage/examples";

/// Every example runs to its end. They are built as the tests are, and share what these have compiled.
pub(crate) fn check(root: &Path, scope: Scope) -> Outcome {
    run(&mut cargo_workspace(root, scope, &["build", "--examples"]))?;
    let sources = repository::files(&root.join(FOLDER), "rs")?;
    if sources.is_empty() {
        return Err(format!("{FOLDER}: there are no examples").into());
    }
    let names = sources.iter().filter_map(|source| source.file_stem()?.to_str());
    let outcomes = names.map(|name| run(&mut Command::new(Build::Example.program(root, name))));
    outcomes.fold(Ok(()), Outcome::and)
}
