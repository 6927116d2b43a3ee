use std::fs;
use std::path::Path;
use std::process::Command;

use crate::command::run;
use crate::outcome::Outcome;
use crate::repository::Build;

/// The command renders a picture.
pub(crate) fn check(root: &Path, build: Build) -> Outcome {
    let umbrage = build.program(root, "umbrage");
    let picture = std::env::temp_dir().join(format!("umbrage-smoke-{}.png", std::process::id()));
    let rendered =
        run(Command::new(umbrage).args(["render", "demo:cloth", "--size", "320x180", "--output"]).arg(&picture));
    let outcome = if rendered.is_failure() { rendered } else { judge(&picture) };
    // It may not exist.
    let _ = fs::remove_file(&picture);
    outcome
}

/// Whether a PNG file holds something to see: one colour everywhere compresses to next to nothing.
fn judge(picture: &Path) -> Outcome {
    const LEAST_BYTES: usize = 2_000;
    match fs::read(picture) {
        Ok(bytes) if !bytes.starts_with(b"\x89PNG\r\n\x1a\n") => Outcome::Failed("the picture is no PNG".to_owned()),
        Ok(bytes) if bytes.len() < LEAST_BYTES => {
            Outcome::Failed(format!("{} bytes are too few for a picture with something in it", bytes.len()))
        }
        Ok(_) => Outcome::Passed,
        Err(error) => Outcome::Failed(format!("{}: {error}", picture.display())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_pictures_fail() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        assert!(judge(&path).is_failure());
        let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
        fs::write(&path, &bytes).unwrap();
        assert!(judge(&path).is_failure());
        bytes.resize(5_000, 7);
        fs::write(&path, &bytes).unwrap();
        assert_eq!(judge(&path), Outcome::Passed);
        bytes[0] = 0;
        fs::write(&path, &bytes).unwrap();
        assert!(judge(&path).is_failure());
    }
}
