use std::path::{Path, PathBuf};

/// The path of a real scene, for optional tests: `None`, with a printed note, if the file doesn't exist.
///
/// Real scenes are not part of the repository. They are looked up in the folder that the environment variable
/// `UMBRAGE_SCENES` names, else in `../shared/scenes` beside the checkout.
#[must_use]
pub fn real_scene(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("UMBRAGE_SCENES")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes"), PathBuf::from);
    let path = folder.join(name);
    if path.exists() {
        Some(path)
    } else {
        println!("skipped: {} is not there (set UMBRAGE_SCENES to the folder that holds it)", path.display());
        None
    }
}
