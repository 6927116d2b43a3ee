//! The files that a scene's file names: those in its folder and below, unless others are allowed.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use crate::memory::Budget;

/// Opens a file that has an end: pipes wait for whoever writes to them, and devices may never stop.
fn open(path: &Path) -> io::Result<File> {
    // Asked before it is opened, since a pipe waits there already.
    if fs::metadata(path)?.is_file() { File::open(path) } else { Err(io::Error::other("not a regular file")) }
}

/// All bytes of a file that has an end, as many as it has when it is opened.
pub(crate) fn read(path: &Path, budget: &Budget) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    append(path, u64::MAX, &mut bytes, budget)?;
    Ok(bytes)
}

/// As [`read`], at most `limit` bytes, behind those that are there.
pub(crate) fn append(path: &Path, limit: u64, bytes: &mut Vec<u8>, budget: &Budget) -> io::Result<()> {
    let file = open(path)?;
    budget.note(path);
    let length = file.metadata()?.len().min(limit);
    let room = usize::try_from(length).unwrap_or(usize::MAX);
    budget.reserve(bytes, room, format_args!("reading {}", path.display())).map_err(io::Error::other)?;
    // It may grow in the meantime.
    io::Read::read_to_end(&mut io::Read::take(file, length), bytes).map(drop)
}

/// Where names in a file lead from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Folder {
    path: PathBuf,
    /// How far below the scene's folder this is.
    depth: usize,
    allow_outside: bool,
}

impl Folder {
    /// The folder of a scene's file.
    pub(crate) fn of(scene: &Path, allow_outside: bool) -> Self {
        Self { path: scene.parent().unwrap_or(Path::new("")).to_owned(), depth: 0, allow_outside }
    }

    /// The file that `name` means, with `/` or `\` between its parts, and that file's own folder; `None` where it is outside
    /// of the scene's folder and may not be.
    pub(crate) fn file(&self, name: &str) -> Option<(PathBuf, Self)> {
        let is_absolute = name.starts_with(['/', '\\']) || Path::new(name).has_root();
        let mut depth = Some(self.depth);
        let mut parts = name.split(['/', '\\']).peekable();
        while let Some(part) = parts.next() {
            depth = match part {
                _ if parts.peek().is_none() && part != ".." => depth,
                "" | "." => depth,
                ".." => depth.and_then(|depth| depth.checked_sub(1)),
                _ => depth.map(|depth| depth + 1),
            };
        }
        let is_inside = !is_absolute && depth.is_some();
        let path = self.path.join(name);
        let folder = path.parent().unwrap_or(&self.path).to_owned();
        let folder = Self { path: folder, depth: depth.unwrap_or(0), allow_outside: self.allow_outside };
        (is_inside || self.allow_outside).then_some((path, folder))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_no_higher_than_the_scene() {
        let folder = Folder::of(Path::new("scenes/car/car.obj"), false);
        let leads_to = |folder: &Folder, name: &str| folder.file(name).map(|(path, _)| path);
        assert_eq!(leads_to(&folder, "a/../b.png"), Some("scenes/car/a/../b.png".into()));
        for name in ["../b.png", "a/../../b.png", "..\\b.png", "a/..\\../b.png", "/b.png", "\\b.png", ".."] {
            assert_eq!(leads_to(&folder, name), None, "{name}");
            assert!(leads_to(&Folder { allow_outside: true, ..folder.clone() }, name).is_some());
        }
        let (_, below) = folder.file("materials/car.mtl").expect("a file below");
        assert_eq!(leads_to(&below, "../textures/b.png"), Some("scenes/car/materials/../textures/b.png".into()));
        assert_eq!(leads_to(&below, "../../b.png"), None);
    }
}
