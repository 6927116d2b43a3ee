use std::fs;
use std::path::Path;
use std::process::Command;

use crate::command::run;
use crate::outcome::Outcome;
use crate::repository::Build;

/// The command renders a picture.
pub(crate) fn check(root: &Path, build: Build) -> Outcome {
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let picture = folder.path().join("smoke.png");
    let mut umbrage = Command::new(build.program(root, "umbrage"));
    run(umbrage.args(["render", "demo:cloth", "--size", "320x180", "--output"]).arg(&picture))?;
    let bytes = fs::read(&picture).map_err(|error| format!("{}: {error}", picture.display()))?;
    judge(&bytes)
}

/// Whether a PNG file holds something to see: one colour everywhere compresses to next to nothing.
fn judge(picture: &[u8]) -> Outcome {
    const LEAST_BYTES: usize = 2_000;
    if !picture.starts_with(b"\x89PNG\r\n\x1a\n") {
        return Err("the picture is no PNG".to_owned().into());
    }
    if picture.len() < LEAST_BYTES {
        return Err(format!("{} bytes are too few for a picture with something in it", picture.len()).into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_pictures_fail() {
        let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
        assert!(judge(&bytes).is_err());
        bytes.resize(5_000, 7);
        assert_eq!(judge(&bytes), Ok(()));
        bytes[0] = 0;
        assert!(judge(&bytes).is_err());
    }
}
