use std::path::Path;

use crate::outcome::{Outcome, of_complaints};
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
}
