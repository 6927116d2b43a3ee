//! Lines of files: the limit for each, and those of code in each crate.

use std::path::Path;
use std::str::Lines;

use crate::log::{Outcome, of_complaints};
use crate::repository::{files, read, within};

const MAX_LINES: usize = 600;

/// Checks that no Rust file has more than [`MAX_LINES`] lines.
pub(crate) fn check(root: &Path) -> Outcome {
    let mut complaints = Vec::new();
    for path in files(root, "rs")? {
        let lines = read(&path)?.lines().count();
        if lines > MAX_LINES {
            complaints.push(format!("{}: {lines} lines, more than {MAX_LINES}", within(root, &path)));
        }
    }
    of_complaints(&complaints)
}

/// Prints how many lines of Rust and WGSL the `src` of each crate has, without tests, comments and blank lines.
///
/// # Errors
/// If a file can't be read.
pub(crate) fn print(root: &Path) -> Result<(), String> {
    let mut totals = std::collections::BTreeMap::<String, [usize; 2]>::new();
    for (language, extension) in ["rs", "wgsl"].into_iter().enumerate() {
        for path in files(&root.join("crates"), extension)? {
            let mut parts = path.strip_prefix(root).unwrap_or(&path).iter().skip(1);
            let (name, folder) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
            let is_test = path.ends_with("tests.rs") || parts.any(|part| part == "tests");
            if folder == "src" && !is_test {
                totals.entry(name.to_string_lossy().into_owned()).or_default()[language] += of_code(&read(&path)?);
            }
        }
    }
    println!("{:<10}{:>8}{:>8}", "crate", "Rust", "WGSL");
    for (name, [rust, wgsl]) in totals {
        println!("{name:<10}{rust:>8}{wgsl:>8}");
    }
    Ok(())
}

fn of_code(text: &str) -> usize {
    let (mut lines, mut count) = (text.lines(), 0);
    while let Some(line) = lines.next().map(str::trim) {
        if line.starts_with("#[cfg(test)]") {
            skip_item(&mut lines);
        } else if line.starts_with("/*") && !line.contains("*/") {
            lines.find(|line| line.contains("*/"));
        } else if !line.is_empty() && !line.starts_with("//") && !line.starts_with("/*") {
            count += 1;
        }
    }
    count
}

/// Skips attributes and their item, up to the brace that closes it, which is as far to the right as the item begins.
fn skip_item(lines: &mut Lines<'_>) {
    let Some(first) = lines.find(|line| !line.trim_start().starts_with("#[")) else { return };
    let (indent, _) = first.split_at(first.len() - first.trim_start().len());
    let is_whole =
        first.ends_with(';') || first.ends_with('}') && first.matches('{').count() == first.matches('}').count();
    if !is_whole {
        lines.find(|line| line.strip_prefix(indent).is_some_and(|rest| rest.starts_with('}')));
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn long_files_are_found_outside_of_build_output() {
        let folder = tempfile::tempdir().unwrap();
        let write = |path: &str, lines: usize| {
            let path = folder.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "//\n".repeat(lines)).unwrap();
        };
        write("a/fits.rs", MAX_LINES);
        write("target/made.rs", MAX_LINES + 1);
        assert_eq!(check(folder.path()), Ok(()));
        write("a/long.rs", MAX_LINES + 1);
        assert_eq!(check(folder.path()), Err("a/long.rs: 601 lines, more than 600".to_owned().into()));
    }

    #[test]
    fn tests_comments_and_blank_lines_are_not_code() {
        let text = "//! a\n\nuse b;\n#[cfg(test)]\nmod c;\n/* d\ne */\nfn f() {\n    #[cfg(test)]\n    #[allow(g)]\n    {\n        h();\n    }\n    i(); // j\n}\n#[cfg(test)]\nmod tests {\n    k();\n}\n";
        assert_eq!(of_code(text), 4);
    }
}
