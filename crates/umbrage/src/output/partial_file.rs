use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use super::Error;

/// A file that takes its name only when it is whole, see the [module](super).
#[derive(Debug)]
pub(crate) struct PartialFile {
    /// The name that was asked for.
    path: PathBuf,
    file: Arc<File>,
    renaming: Option<Renaming>,
}

#[derive(Debug)]
struct Renaming {
    from: PathBuf,
    to: PathBuf,
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
            Ok(_) => fs::canonicalize(path).map_err(refused)?,
            Err(_) => path.to_owned(),
        };
        let (file, from) = create_hidden_beside(&to).map_err(refused)?;
        Ok(Self { path: path.to_owned(), file: Arc::new(file), renaming: Some(Renaming { from, to }) })
    }

    /// Where to write to; give it back (drop it) before [`PartialFile::keep`].
    pub(crate) fn file(&self) -> Arc<File> {
        Arc::clone(&self.file)
    }

    /// The name that was asked for.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the file its name, in place of what had it before.
    pub(crate) fn keep(mut self) -> Result<(), Error> {
        let Some(Renaming { from, to }) = &self.renaming else { return Ok(()) };
        fs::rename(from, to).map_err(|source| Error::write(&self.path, source))?;
        self.renaming = None;
        Ok(())
    }
}

impl Drop for PartialFile {
    fn drop(&mut self) {
        if let Some(Renaming { from, .. }) = &self.renaming {
            // Nobody is left to be told where this fails.
            let _ = fs::remove_file(from);
        }
    }
}

/// Creates a file that nothing else has opened, in the folder of `path`.
fn create_hidden_beside(path: &Path) -> io::Result<(File, PathBuf)> {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    const ATTEMPTS: u32 = 1000;
    let name = path.file_name().ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "no file name"))?;
    let mut taken = io::Error::from(io::ErrorKind::AlreadyExists);
    for _ in 0..ATTEMPTS {
        let mut hidden = OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".partial-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed)));
        let hidden = path.with_file_name(hidden);
        match OpenOptions::new().write(true).create_new(true).open(&hidden) {
            Ok(file) => return Ok((file, hidden)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => taken = error,
            Err(error) => return Err(error),
        }
    }
    Err(taken)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn names(folder: &Path) -> Vec<OsString> {
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect()
    }

    #[test]
    fn a_file_appears_when_it_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let partial = PartialFile::create(&path).unwrap();
        partial.file().write_all(b"whole").unwrap();
        assert!(!path.exists());
        partial.keep().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn dropping_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, b"before").unwrap();
        let partial = PartialFile::create(&path).unwrap();
        partial.file().write_all(b"half").unwrap();
        drop(partial);
        assert_eq!(fs::read(&path).unwrap(), b"before");
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn two_at_a_time_stay_apart() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let (first, second) = (PartialFile::create(&path).unwrap(), PartialFile::create(&path).unwrap());
        first.file().write_all(b"first").unwrap();
        second.file().write_all(b"second").unwrap();
        second.keep().unwrap();
        drop(first);
        assert_eq!(fs::read(&path).unwrap(), b"second");
    }

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

        let device = PartialFile::create(Path::new("/dev/null")).unwrap();
        device.file().write_all(b"gone").unwrap();
        device.keep().unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
