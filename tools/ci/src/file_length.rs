use std::fs;
use std::path::Path;

use crate::outcome::Outcome;
use crate::repository::files;

const MAX_LINES: usize = 600;

/// No Rust file has more than [`MAX_LINES`] lines.
pub(crate) fn check(root: &Path) -> Outcome {
    match too_long(root) {
        Ok(complaints) => Outcome::of_complaints(&complaints),
        Err(why) => Outcome::Failed(why),
    }
}

fn too_long(root: &Path) -> Result<Vec<String>, String> {
    let mut complaints = Vec::new();
    for path in files(root, "rs")? {
        let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        let lines = text.lines().count();
        if lines > MAX_LINES {
            let path = path.strip_prefix(root).unwrap_or(&path);
            complaints.push(format!("{}: {lines} lines, more than {MAX_LINES}", path.display()));
        }
    }
    Ok(complaints)
}

#[cfg(test)]
mod tests {
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
        assert_eq!(check(folder.path()), Outcome::Passed);
        write("a/long.rs", MAX_LINES + 1);
        assert_eq!(check(folder.path()), Outcome::Failed("a/long.rs: 601 lines, more than 600".to_owned()));
    }
}
