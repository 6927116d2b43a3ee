use std::path::{Path, PathBuf};

use crate::command::{cargo, has_subcommand};
use crate::log::Log;
use crate::outcome::{Outcome, skipped};

/// Checks dependencies against `deny.toml`, if cargo-deny is installed: no versions side by side except the listed
/// ones, no other sources, and no known vulnerabilities if a database of advisories is here.
pub(crate) fn check(root: &Path, log: &mut Log) -> Outcome {
    if !has_subcommand("deny") {
        return skipped("cargo-deny is not installed (cargo install cargo-deny)");
    }
    let database = database(&std::env::home_dir().unwrap_or_default().join(".cargo"));
    let mut deny = cargo(root);
    deny.args(["deny", "--offline", "check", "bans", "licenses", "sources"]);
    let Some(database) = database else {
        log.run(&mut deny)?;
        return skipped("there is no database of advisories (cargo deny fetch db); all else is as deny.toml asks");
    };
    println!("advisories of the database that was fetched to {}", database.display());
    log.run(deny.arg("advisories"))
}

/// The advisories that cargo-deny fetched before, below cargo's folder.
fn database(cargo_folder: &Path) -> Option<PathBuf> {
    let mut databases = std::fs::read_dir(cargo_folder.join("advisory-dbs")).ok()?;
    databases.find_map(|entry| Some(entry.ok()?.path()).filter(|folder| folder.join("crates").is_dir()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_database_has_advisories_about_crates() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(database(folder.path()), None);
        let database_folder = folder.path().join("advisory-dbs/github.com-1");
        std::fs::create_dir_all(&database_folder).unwrap();
        assert_eq!(database(folder.path()), None);
        std::fs::create_dir(database_folder.join("crates")).unwrap();
        assert_eq!(database(folder.path()), Some(database_folder));
    }
}
