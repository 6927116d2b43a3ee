use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tempfile::TempPath;

use super::{Error, NumberedPath, mp4};

/// The hidden files that this process writes.
static WRITTEN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn written() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    // A panic elsewhere leaves the set whole.
    WRITTEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the hidden files of all [writers](super::Writer) of this process, which must end then: later calls that
/// begin or finish a file wait for ever.
pub fn remove_partial_files() {
    mp4::end_encoders();
    let written = written();
    for path in &*written {
        // A missing file needs no removing.
        let _ = fs::remove_file(path);
    }
    mem::forget(written);
}

/// A file that takes its name only when it is whole, see the [module](super).
#[derive(Debug)]
pub(crate) struct PartialFile {
    /// The requested name.
    path: PathBuf,
    file: Arc<File>,
    /// Paths of the hidden file and of the finished one, unless it is written directly. Dropping the first removes the
    /// file.
    renaming: Option<(TempPath, PathBuf)>,
}

impl PartialFile {
    /// Starts a file that will be `path`. A file of that name stays until [`PartialFile::keep`].
    ///
    /// A device or a pipe is written directly; a symbolic link stays, and its target is replaced.
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
        let prefix = format!(".{}{PARTIAL}", shortened(&to.file_name().unwrap_or_default().to_string_lossy()));
        hidden.prefix(&prefix);
        // Permissions of any new file, not of the owner alone. The umask applies.
        #[cfg(unix)]
        hidden.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut written = written();
        loop {
            // In the same folder, since renaming works only within a file system.
            let (file, from) = hidden.tempfile_in(folder_of(&to)).map_err(refused)?.into_parts();
            // The lock tells other processes that the file is being written. One of them may have swept it before that.
            let is_taken = matches!(file.try_lock(), Err(TryLockError::WouldBlock)) || !from.exists();
            if !is_taken {
                written.insert(from.to_path_buf());
                return Ok(Self { path: path.to_owned(), file: Arc::new(file), renaming: Some((from, to)) });
            }
        }
    }

    /// The file to write to; drop it before [`PartialFile::keep`].
    pub(crate) fn file(&self) -> Arc<File> {
        Arc::clone(&self.file)
    }

    /// The path under which it is written.
    pub(crate) fn hidden_path(&self) -> &Path {
        self.renaming.as_ref().map_or(&self.path, |(from, _)| from)
    }

    /// Gives the file its name, in place of any file that had it.
    pub(crate) fn keep(mut self) -> Result<(), Error> {
        let Some((from, to)) = self.renaming.take() else { return Ok(()) };
        let mut written = written();
        written.remove(&*from);
        from.persist(to).map_err(|refused| Error::write(&self.path, refused.error))
    }
}

impl Drop for PartialFile {
    fn drop(&mut self) {
        if let Some((from, _)) = &self.renaming {
            written().remove(&**from);
        }
    }
}

/// Text behind the finished file's name in the names of hidden files.
const PARTIAL: &str = ".partial-";

/// The start of a file's name, for the name of a hidden file: names have 255 bytes at most.
fn shortened(name: &str) -> String {
    const MOST_LETTERS: usize = 50;
    name.chars().take(MOST_LETTERS).collect()
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Removes the hidden files of killed processes: those of `path`, or of all frames of a [numbered one](NumberedPath),
/// that no process writes any more. A [writer](super::Writer) does this first.
pub fn sweep(path: &Path) {
    let to = destination(path);
    let numbered = NumberedPath::parse(path).ok().flatten();
    let is_ours = |name: &str| match &numbered {
        Some(numbered) => shortened(&numbered.alike(name)) == name,
        None => shortened(&to.file_name().unwrap_or_default().to_string_lossy()) == name,
    };
    // Where the folder can't be read, nothing is to be swept.
    for entry in fs::read_dir(folder_of(&to)).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_str().and_then(|name| name.strip_prefix('.')?.rsplit_once(PARTIAL));
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_file && name.is_some_and(|(name, _)| is_ours(name)) && is_left_behind(&entry.path()) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Whether no process writes a hidden file. Its writer holds a lock; without locks, the file is unchanged for an hour.
fn is_left_behind(path: &Path) -> bool {
    const LONG: Duration = Duration::from_secs(3600);
    let Ok(file) = OpenOptions::new().write(true).open(path) else { return false };
    match file.try_lock() {
        Ok(()) => true,
        Err(TryLockError::WouldBlock) => false,
        Err(TryLockError::Error(_)) => {
            let changed = file.metadata().and_then(|there| there.modified());
            changed.is_ok_and(|changed| changed.elapsed().is_ok_and(|age| age > LONG))
        }
    }
}

/// The final target of a symbolic link, whether it exists or not; any other path itself.
fn destination(path: &Path) -> PathBuf {
    const MOST_LINKS: usize = 40;
    let mut to = path.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(next) = fs::read_link(&to) else { break };
        to = to.parent().unwrap_or(Path::new("")).join(next);
    }
    to
}

/// Check of a whole file before it takes its name; a file that fails never does.
pub(crate) type Look<'a> = &'a mut dyn FnMut(&File) -> io::Result<()>;

/// Writes a whole file.
pub(crate) fn write(
    path: &Path,
    look: Look<'_>,
    encode: impl FnOnce(Arc<File>) -> io::Result<()>,
) -> Result<(), Error> {
    let partial = PartialFile::create(path)?;
    encode(partial.file()).and_then(|()| look(&partial.file)).map_err(|source| Error::write(path, source))?;
    partial.keep()
}

/// Writes a file, which appears under its name only when it is whole.
///
/// # Errors
/// Where the system refuses to write, or the path is a folder.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    write(path, &mut |_| Ok(()), |file| (&*file).write_all(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_and_missing_folders_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let message = |path: &Path| PartialFile::create(path).unwrap_err().to_string();
        assert!(message(folder.path()).contains("is a folder"));
        let missing = folder.path().join("missing/a.png");
        assert!(message(&missing).contains("missing/a.png: can't be written"));
    }

    #[test]
    fn what_nobody_writes_any_more_is_swept() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let long = format!("{}_0001.png", "a".repeat(60));
        for name in [".a.png", ".b_0007.png", ".b_12.png", &format!(".{}", shortened(&long))] {
            fs::write(path(&format!("{name}.partial-x")), b"half").unwrap();
        }
        let living = PartialFile::create(&path("a.png")).unwrap();
        let names = || {
            let entries = fs::read_dir(folder.path()).unwrap();
            let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
            names.sort();
            names.iter().map(|name| name.split(PARTIAL).next().unwrap().to_owned()).collect::<Vec<_>>()
        };
        assert_eq!(names().len(), 5);
        sweep(&path("other.png"));
        assert_eq!(names().len(), 5);
        sweep(&path("a.png"));
        sweep(&path("b_%04d.png"));
        sweep(&path(&long.replace("0001", "%04d")));
        assert_eq!(names(), [".a.png", ".b_12.png"]);
        living.keep().unwrap();
        assert_eq!(names(), [".b_12.png", "a.png"]);
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
