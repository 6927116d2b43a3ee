//! Dependencies: their licences, and all else that `deny.toml` asks of them.

use std::path::{Path, PathBuf};

use spdx::{Expression, ParseMode};

use crate::command::{cargo, has_subcommand, output};
use crate::log::{Log, Outcome, of_complaints, skipped};
use crate::repository::read;

/// Checks that every package of any build of the workspace has a licence that `deny.toml` allows.
pub(crate) fn check(root: &Path) -> Outcome {
    let allowed = allowed(&read(&root.join("deny.toml"))?);
    if allowed.is_empty() {
        return Err("deny.toml: no `allow` list under [licenses]".to_owned().into());
    }
    // Other systems' packages may be missing here; then only this system's are checked.
    let packages = packages(root, &["--target", "all"]).or_else(|why| {
        println!("only the packages for this system are checked: {why}");
        packages(root, &[])
    })?;
    println!("{} packages", packages.len());
    of_complaints(&complaints(&packages, &allowed))
}

/// Name with version, and licence expression.
type Package = (String, String);

fn packages(root: &Path, targets: &[&str]) -> Result<Vec<Package>, String> {
    let mut tree = cargo(root);
    tree.args(["tree", "--workspace", "--locked", "--prefix", "none", "--no-dedupe", "--format", "{p}|{l}"]);
    tree.args(targets);
    let mut packages: Vec<Package> = output(&mut tree)?.lines().filter_map(package).collect();
    packages.sort();
    packages.dedup();
    Ok(packages)
}

fn package(line: &str) -> Option<Package> {
    let (name, licence) = line.split_once('|')?;
    // The source of a package follows its version.
    let name = name.split(" (").next().unwrap_or(name);
    Some((name.to_owned(), licence.trim().to_owned()))
}

fn complaints(packages: &[Package], allowed: &[String]) -> Vec<String> {
    let complaint = |(name, licence): &Package| {
        if licence.is_empty() {
            return Some(format!("{name}: no licence is given"));
        }
        // Older manifests write `/` for `OR`.
        match Expression::parse_mode(licence, ParseMode::LAX) {
            Ok(expression) if expression.evaluate(|one| allowed.contains(&one.to_string())) => None,
            Ok(_) => Some(format!("{name}: {licence} is not allowed")),
            Err(why) => Some(format!("{name}: {licence}: {}", why.reason)),
        }
    };
    packages.iter().filter_map(complaint).collect()
}

/// The strings of the list `allow` in the table `[licenses]`.
fn allowed(deny: &str) -> Vec<String> {
    let licenses = deny.split("\n[").find(|table| table.trim_start_matches('[').starts_with("licenses]"));
    let list = licenses.and_then(|table| table.split_once("\nallow = [")).map_or("", |(_, behind)| behind);
    let list = list.split(']').next().unwrap_or(list);
    let lines = list.lines().map(|line| line.split('#').next().unwrap_or(line));
    lines.flat_map(|line| line.split('"').skip(1).step_by(2)).map(str::to_owned).collect()
}

/// Checks dependencies against `deny.toml`, if cargo-deny is installed: no versions side by side except the listed
/// ones, no other sources, and no known vulnerabilities if a database of advisories is here.
pub(crate) fn check_all(root: &Path, log: &mut Log) -> Outcome {
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
    fn the_allow_list_is_read() {
        let deny = "[graph]\nallow = [\"no\"]\n[licenses]\nconfidence = 1\nallow = [\n  \"MIT\", # not \"GPL\"\n  \"Zlib\",\n]\n[bans]\n";
        assert_eq!(allowed(deny), ["MIT", "Zlib"]);
        assert!(allowed("[licenses]\n").is_empty());
    }

    #[test]
    fn licences_are_complained_about() {
        let allowed = ["MIT", "Apache-2.0 WITH LLVM-exception"].map(str::to_owned);
        let complaints = |line: &str| complaints(&[package(line).unwrap()], &allowed);
        for licence in ["MIT OR ISC", "ISC/MIT", "MIT OR ISC AND Zlib", "Apache-2.0 WITH LLVM-exception"] {
            assert!(complaints(&format!("a v1.0.0|{licence}")).is_empty(), "{licence}");
        }
        for licence in ["ISC", "MIT AND ISC", "(MIT OR ISC) AND Zlib", "Apache-2.0", "MIT OR"] {
            assert_eq!(complaints(&format!("a v1.0.0|{licence}")).len(), 1, "{licence}");
        }
        assert_eq!(complaints("b v2.0.0 (proc-macro)|ISC"), ["b v2.0.0: ISC is not allowed"]);
        assert_eq!(complaints("c v0.1.0 (/path)|"), ["c v0.1.0: no licence is given"]);
    }

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
