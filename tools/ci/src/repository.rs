use std::fs;
use std::path::{Path, PathBuf};

/// The repository's root: the folder above `tools/ci`.
///
/// # Errors
/// Where the program was moved away from its sources.
pub(crate) fn root() -> Result<PathBuf, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    root.canonicalize().map_err(|error| format!("{}: {error}", root.display()))
}

/// The text of a file.
///
/// # Errors
/// Where it can't be read.
pub(crate) fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

/// A path as it is named from the root on.
pub(crate) fn within<'a>(root: &Path, path: &'a Path) -> std::path::Display<'a> {
    path.strip_prefix(root).unwrap_or(path).display()
}

/// How programs are compiled.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Build {
    /// As tests are.
    Dev,
    /// Examples, as tests are.
    Example,
    /// As users compile them.
    Release,
}

impl Build {
    /// The program of that name.
    pub(crate) fn program(self, root: &Path, name: &str) -> PathBuf {
        self.folder(root).join(format!("{name}{}", std::env::consts::EXE_SUFFIX))
    }

    /// Where programs and libraries are put.
    pub(crate) fn folder(self, root: &Path) -> PathBuf {
        let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
        let folder = match self {
            Self::Dev => "debug",
            Self::Example => "debug/examples",
            Self::Release => "release",
        };
        root.join(target).join(folder)
    }
}

/// All files under `root` with this extension, sorted; hidden folders, build output and packages of
/// other languages are left out.
///
/// # Errors
/// Where a folder can't be read.
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
