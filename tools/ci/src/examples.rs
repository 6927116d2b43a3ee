use std::path::Path;
use std::process::Command;

use crate::command::build;
use crate::log::Log;
use crate::outcome::Outcome;
use crate::repository;

/// The folder of the library's examples.
const FOLDER: &str = "crates/umbrage/examples";

/// Checks that every example runs to its end.
pub(crate) fn check(root: &Path, log: &mut Log) -> Outcome {
    log.run(&mut build(root, &[]))?;
    let sources = repository::files(&root.join(FOLDER), "rs")?;
    if sources.is_empty() {
        return Err(format!("{FOLDER}: there are no examples").into());
    }
    let names = sources.iter().filter_map(|source| source.file_stem()?.to_str());
    let outcomes = names.map(|name| log.run(&mut Command::new(repository::built(root, &format!("examples/{name}")))));
    outcomes.fold(Ok(()), Outcome::and)
}
