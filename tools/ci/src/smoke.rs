use std::fs;
use std::path::Path;
use std::process::Command;

use crate::command::build;
use crate::log::Log;
use crate::outcome::Outcome;
use crate::repository::{built, empty_folder};

/// Checks that the command renders a picture.
pub(crate) fn check(root: &Path, log: &mut Log) -> Outcome {
    log.run(&mut build(root, &["umbrage"]))?;
    render(root, log, Command::new(built(root, "umbrage")))
}

/// Renders a picture with the command, as tests build it or as `cargo run` does.
pub(crate) fn render(root: &Path, log: &mut Log, mut umbrage: Command) -> Outcome {
    let picture = empty_folder(root, "smoke")?.join("smoke.png");
    log.run(umbrage.args(["render", "demo:cloth", "--size", "320x180", "--output"]).arg(&picture))?;
    let bytes = fs::read(&picture).map_err(|error| format!("{}: {error}", picture.display()))?;
    judge(&bytes)
}

/// Passes if a PNG file has a visible picture: one colour everywhere compresses to almost nothing.
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
