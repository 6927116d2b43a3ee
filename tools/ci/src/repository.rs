use std::fs;
use std::path::{Path, PathBuf};

/// The repository's root: the folder above `tools/ci`.
///
/// # Errors
/// If the program was moved away from its sources.
pub(crate) fn root() -> Result<PathBuf, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    root.canonicalize().map_err(|error| format!("{}: {error}", root.display()))
}

/// The text of a file.
///
/// # Errors
/// If it can't be read.
pub(crate) fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

/// A path relative to the root.
pub(crate) fn within<'a>(root: &Path, path: &'a Path) -> std::path::Display<'a> {
    path.strip_prefix(root).unwrap_or(path).display()
}

/// The folder of build output.
pub(crate) fn target(root: &Path) -> PathBuf {
    root.join(std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into()))
}

/// The folder of programs and libraries that are built as the tests are.
pub(crate) fn built_folder(root: &Path) -> PathBuf {
    target(root).join("debug")
}

/// A program that is built as the tests are.
pub(crate) fn built(root: &Path, name: &str) -> PathBuf {
    built_folder(root).join(format!("{name}{}", std::env::consts::EXE_SUFFIX))
}

/// An empty folder of that name in the build output, for the files of a step.
///
/// # Errors
/// If it can't be made.
pub(crate) fn empty_folder(root: &Path, name: &str) -> Result<PathBuf, String> {
    let folder = target(root).join("ci").join(name);
    let failure = |error| format!("{}: {error}", folder.display());
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(failure)?;
    }
    fs::create_dir_all(&folder).map_err(failure)?;
    Ok(folder)
}

/// All files under `root` with this extension, sorted; hidden folders, build output and packages of
/// other languages are left out.
///
/// # Errors
/// If a folder can't be read.
pub(crate) fn files(root: &Path, extension: &str) -> Result<Vec<PathBuf>, String> {
    let mut found = Vec::new();
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        let failure = |error| format!("{}: {error}", folder.display());
        for entry in fs::read_dir(&folder).map_err(failure)? {
            let entry = entry.map_err(failure)?;
            let name = entry.file_name();
            let name = name.to_string_lossy();
            let kind = entry.file_type().map_err(failure)?;
            // Links are not followed: they may lead out of the repository or round in a circle.
            let is_made = name.starts_with("target") || name == "node_modules";
            if kind.is_dir() && !name.starts_with('.') && !is_made {
                folders.push(entry.path());
            } else if kind.is_file() && entry.path().extension().is_some_and(|found| found == extension) {
                found.push(entry.path());
            }
        }
    }
    found.sort();
    Ok(found)
}
