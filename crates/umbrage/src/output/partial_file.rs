use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use tempfile::TempPath;

use super::Error;

/// A file that takes its name only when it is whole, see the [module](super).
#[derive(Debug)]
pub(crate) struct PartialFile {
    /// The name that was asked for.
    path: PathBuf,
    file: Arc<File>,
    /// Where the file is and what it becomes, if it isn't written directly. Dropping the first removes it.
    renaming: Option<(TempPath, PathBuf)>,
}

impl PartialFile {
    /// Starts a file that will be `path`. What is there now stays until [`PartialFile::keep`].
    ///
    /// A device or a pipe is written directly; a symbolic link stays, and what it points to is replaced.
    pub(crate) fn create(path: &Path) -> Result<Self, Error> {
        let refused = |source| Error::write(path, source);
        let to = match fs::metadata(path) {
            Ok(there) if there.is_dir() => return Err(Error::unsuitable(path, "is a folder; name a file in it")),
            Ok(there) if !there.is_file() => {
                let file = OpenOptions::new().write(true).open(path).map_err(refused)?;
                return Ok(Self { path: path.to_owned(), file: Arc::new(file), renaming: None });
            }
            Ok(_) | Err(_) => destination(path),
        };
        let mut hidden = tempfile::Builder::new();
        // Names have 255 bytes at most.
        const MOST_LETTERS: usize = 50;
        let name: String = to.file_name().unwrap_or_default().to_string_lossy().chars().take(MOST_LETTERS).collect();
        let prefix = format!(".{name}.partial-");
        hidden.prefix(&prefix);
        // As for any new file, not for its owner alone. The umask applies.
        #[cfg(unix)]
        hidden.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        // In the same folder, since renaming works only within a file system.
        let folder = to.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let (file, from) = hidden.tempfile_in(folder).map_err(refused)?.into_parts();
        Ok(Self { path: path.to_owned(), file: Arc::new(file), renaming: Some((from, to)) })
    }

    /// Where to write to; give it back (drop it) before [`PartialFile::keep`].
    pub(crate) fn file(&self) -> Arc<File> {
        Arc::clone(&self.file)
    }

    /// Gives the file its name, in place of what had it before.
    pub(crate) fn keep(self) -> Result<(), Error> {
        let Some((from, to)) = self.renaming else { return Ok(()) };
        from.persist(to).map_err(|refused| Error::write(&self.path, refused.error))
    }
}

/// Where a symbolic link leads in the end, whether anything is there or not; any other path itself.
fn destination(path: &Path) -> PathBuf {
    const MOST_LINKS: usize = 40;
    let mut to = path.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(next) = fs::read_link(&to) else { break };
        to = to.parent().unwrap_or(Path::new("")).join(next);
    }
    to
}

/// Writes a whole file.
pub(crate) fn write(path: &Path, encode: impl FnOnce(Arc<File>) -> io::Result<()>) -> Result<(), Error> {
    let partial = PartialFile::create(path)?;
    encode(partial.file()).map_err(|source| Error::write(path, source))?;
    partial.keep()
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn folders_and_missing_folders_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let message = |path: &Path| PartialFile::create(path).unwrap_err().to_string();
        assert!(message(folder.path()).contains("is a folder"));
        let missing = folder.path().join("missing/a.png");
        assert!(message(&missing).contains("missing/a.png: can't be written"));
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_and_devices_are_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        fs::write(&real, b"before").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        let partial = PartialFile::create(&link).unwrap();
        partial.file().write_all(b"after").unwrap();
        partial.keep().unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&real).unwrap(), b"after");

        // Whether or not that is there.
        let (nothing, dangling) = (folder.path().join("nothing.png"), folder.path().join("dangling.png"));
        std::os::unix::fs::symlink("nothing.png", &dangling).unwrap();
        PartialFile::create(&dangling).unwrap().keep().unwrap();
        assert!(fs::symlink_metadata(&dangling).unwrap().is_symlink() && nothing.is_file());

        let long = folder.path().join(format!("{}.png", "\u{e9}".repeat(120)));
        PartialFile::create(&long).unwrap().keep().unwrap();
        assert!(long.is_file());

        let device = PartialFile::create(Path::new("/dev/null")).unwrap();
        device.file().write_all(b"gone").unwrap();
        device.keep().unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }

    #[cfg(unix)]
    #[test]
    fn whoever_may_read_a_new_file_may_read_this() {
        use std::os::unix::fs::PermissionsExt;

        let folder = tempfile::tempdir().unwrap();
        let mode = |name: &str| fs::metadata(folder.path().join(name)).unwrap().permissions().mode();
        fs::write(folder.path().join("plain"), b"").unwrap();
        PartialFile::create(&folder.path().join("a.png")).unwrap().keep().unwrap();
        assert_eq!(mode("a.png"), mode("plain"));
    }
}
