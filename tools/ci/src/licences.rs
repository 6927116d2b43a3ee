use std::fs;
use std::path::Path;

use crate::command::{cargo, output};
use crate::outcome::Outcome;
use crate::spdx;

/// Every package that the workspace can be built from has a licence that `deny.toml` allows.
pub(crate) fn check(root: &Path) -> Outcome {
    let allowed = match fs::read_to_string(root.join("deny.toml")).map(|text| allowed(&text)) {
        Ok(allowed) if !allowed.is_empty() => allowed,
        Ok(_) => return Outcome::Failed("deny.toml: no `allow` list under [licenses]".to_owned()),
        Err(error) => return Outcome::Failed(format!("deny.toml: {error}")),
    };
    // Other systems' packages may not be here; then this one's are checked.
    let listed = packages(root, &["--target", "all"]).or_else(|why| {
        println!("only the packages for this system are checked: {why}");
        packages(root, &[])
    });
    match listed {
        Ok(packages) => {
            println!("{} packages", packages.len());
            Outcome::of_complaints(&complaints(&packages, &allowed))
        }
        Err(why) => Outcome::Failed(why),
    }
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
    // Behind the version stands where a package comes from.
    let name = name.split(" (").next().unwrap_or(name);
    Some((name.to_owned(), licence.trim().to_owned()))
}

fn complaints(packages: &[Package], allowed: &[String]) -> Vec<String> {
    let complaint = |(name, licence): &Package| match spdx::is_allowed(licence, allowed) {
        Ok(true) => None,
        Ok(false) => Some(format!("{name}: {licence} is not allowed")),
        Err(_) if licence.is_empty() => Some(format!("{name}: no licence is given")),
        Err(why) => Some(format!("{name}: {why}")),
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
        let tree = ["a v1.0.0|MIT OR Apache-2.0", "b v2.0.0 (proc-macro)|GPL-3.0", "c v0.1.0 (/path)|", ""];
        let packages: Vec<Package> = tree.into_iter().filter_map(package).collect();
        assert_eq!(
            complaints(&packages, &["MIT".to_owned()]),
            ["b v2.0.0: GPL-3.0 is not allowed", "c v0.1.0: no licence is given"]
        );
    }
}
