//! Detection of changes to a scene's file.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// The last modification time of a file, polled at intervals.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    last: Option<(PathBuf, Option<SystemTime>)>,
    asked: Option<Instant>,
}

impl Watch {
    /// Polling interval.
    pub(crate) const INTERVAL: Duration = Duration::from_millis(500);

    /// Whether `path` was written since the previous call for it. A file that is missing for a moment, as while it is being
    /// replaced, counts as changed only once it is back.
    pub(crate) fn has_changed(&mut self, path: &Path) -> bool {
        if self.asked.is_some_and(|asked| asked.elapsed() < Self::INTERVAL) {
            return false;
        }
        self.asked = Some(Instant::now());
        let written = std::fs::metadata(path).and_then(|about| about.modified()).ok();
        let is_same_file = self.last.as_ref().is_some_and(|(last, _)| last == path);
        let before = self.last.take().and_then(|(_, before)| before);
        self.last = Some((path.to_owned(), written.or(before)));
        is_same_file && written.is_some() && written != before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_new_time_of_the_same_file_is_a_change() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.obj");
        let mut watch = Watch::default();
        let mut ask = |path: &Path| {
            watch.asked = None;
            watch.has_changed(path)
        };
        let write = |seconds: u64| {
            let file = std::fs::File::create(&path).expect("a file");
            file.set_modified(SystemTime::UNIX_EPOCH + Duration::from_secs(seconds)).expect("a time");
        };
        write(1000);
        assert!(!ask(&path) && !ask(&path));
        write(2000);
        assert!(ask(&path) && !ask(&path));
        std::fs::remove_file(&path).expect("removed");
        assert!(!ask(&path) && !ask(&path));
        write(3000);
        assert!(ask(&path) && !ask(&path));
        assert!(!ask(Path::new("demo:cloth")));
    }
}
