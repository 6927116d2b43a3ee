//! The files that a scene's file names: those in its folder and below, unless others are allowed.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use crate::memory::Budget;

/// The storage of files: disk or memory.
#[derive(Clone, Debug, Default)]
pub(crate) enum Files {
    #[default]
    OnDisk,
    /// In memory, by their paths as [`plain`] writes them.
    Given(Arc<BTreeMap<PathBuf, Vec<u8>>>),
}

impl Files {
    /// Makes files in memory from paths and bytes.
    pub(crate) fn given(files: impl IntoIterator<Item = (PathBuf, Vec<u8>)>) -> Self {
        Self::Given(Arc::new(files.into_iter().map(|(path, bytes)| (plain(&path), bytes)).collect()))
    }

    /// Whether there is such a file.
    pub(crate) fn has(&self, path: &Path) -> bool {
        match self {
            Self::OnDisk => path.is_file(),
            Self::Given(files) => find(files, path).is_some(),
        }
    }

    /// The names of all files and folders in a folder.
    fn names_in(&self, folder: &Path) -> Vec<String> {
        match self {
            Self::OnDisk => {
                let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
                let entries = fs::read_dir(folder).into_iter().flatten().flatten();
                entries.filter_map(|entry| entry.file_name().into_string().ok()).collect()
            }
            Self::Given(files) => {
                let folder = plain(folder);
                let below = files.keys().filter_map(|file| file.strip_prefix(&folder).ok()?.components().next());
                below.filter_map(|name| Some(name.as_os_str().to_str()?.to_owned())).collect()
            }
        }
    }
}

/// Normalizes a path: drops `.`, and each `..` together with the part before it.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if plain.file_name().is_some() => _ = plain.pop(),
            part => plain.push(part),
        }
    }
    plain
}

/// Finds the file at a path, or else the only file of that name in any folder: files dropped on a page have names, but
/// no folders.
fn find<'a>(files: &'a BTreeMap<PathBuf, Vec<u8>>, path: &Path) -> Option<&'a [u8]> {
    if let Some(bytes) = files.get(&plain(path)) {
        return Some(bytes);
    }
    let mut called_so = files.iter().filter(|(file, _)| file.file_name() == path.file_name());
    let (_, bytes) = called_so.next()?;
    called_so.next().is_none().then_some(bytes)
}

/// Opens a regular file. Pipes are refused, since they wait for a writer, and so are devices, which may never end.
fn open(path: &Path) -> io::Result<File> {
    // Checked before opening, since opening a pipe already waits.
    if fs::metadata(path)?.is_file() { File::open(path) } else { Err(io::Error::other("not a regular file")) }
}

/// Reads a regular file, up to the length that it has when it is opened.
pub(crate) fn read(path: &Path, budget: &Budget) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    append(path, u64::MAX, &mut bytes, budget)?;
    Ok(bytes)
}

/// As [`read`], but appends at most `limit` bytes to `bytes`.
pub(crate) fn append(path: &Path, limit: u64, bytes: &mut Vec<u8>, budget: &Budget) -> io::Result<()> {
    if let Files::Given(files) = budget.may_read() {
        let file = find(files, path).ok_or(io::ErrorKind::NotFound)?;
        budget.note(path);
        let length = usize::try_from(limit).unwrap_or(usize::MAX).min(file.len());
        budget.reserve(bytes, length, format_args!("reading {}", path.display())).map_err(io::Error::other)?;
        bytes.extend_from_slice(&file[..length]);
        return Ok(());
    }
    let file = open(path)?;
    budget.note(path);
    let length = file.metadata()?.len().min(limit);
    let room = usize::try_from(length).unwrap_or(usize::MAX);
    budget.reserve(bytes, room, format_args!("reading {}", path.display())).map_err(io::Error::other)?;
    // The file may grow in the meantime.
    io::Read::read_to_end(&mut io::Read::take(file, length), bytes).map(drop)
}

/// Warning that a file is missing and that one whose name differs only in case was read instead.
pub(crate) fn read_instead(other: &str) -> String {
    format!("is not there; `{other}` was read, whose name has other small and capital letters")
}

/// The folder to which the names in a file are relative.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Folder {
    path: PathBuf,
    /// Number of levels below the scene's folder.
    depth: usize,
    /// The scene's folder without symbolic links; `None` where the file system doesn't say.
    scene: Option<PathBuf>,
    allow_outside: bool,
}

impl Folder {
    /// The folder of a scene's file.
    pub(crate) fn of(scene: &Path, allow_outside: bool) -> Self {
        let path = scene.parent().unwrap_or(Path::new("")).to_owned();
        let scene = fs::canonicalize(if path.as_os_str().is_empty() { Path::new(".") } else { &path }).ok();
        Self { path, depth: 0, scene, allow_outside }
    }

    /// Resolves `name`, whose parts are separated by `/` or `\`, to a file and its folder. Returns `None` where the file is
    /// outside of the scene's folder, directly or by a symbolic link, and that isn't allowed.
    pub(crate) fn file(&self, name: &str) -> Option<(PathBuf, Self)> {
        // On Windows, names may have drives, with a root or without.
        let has_drive = || Path::new(name).components().any(|part| matches!(part, Component::Prefix(_)));
        let is_absolute = name.starts_with(['/', '\\']) || Path::new(name).has_root() || has_drive();
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
        let path = self.path.join(name);
        let is_inside = !is_absolute && depth.is_some() && self.leads_inside(&path);
        let folder = path.parent().unwrap_or(&self.path).to_owned();
        let folder = Self { path: folder, depth: depth.unwrap_or(0), ..self.clone() };
        (is_inside || self.allow_outside).then_some((path, folder))
    }

    /// As [`Folder::file`], ignoring case, and returns the file's own name too. Among several matches, the first by name.
    pub(crate) fn in_other_case(&self, name: &str, files: &Files) -> Option<((PathBuf, Self), String)> {
        let is_same = |a: &str, b: &str| a.to_lowercase() == b.to_lowercase();
        let mut there: Vec<String> = Vec::new();
        for part in name.split(['/', '\\']) {
            let before = if there.is_empty() { String::new() } else { there.join("/") + "/" };
            if part.is_empty() || part == "." || part == ".." {
                there.push(part.to_owned());
                continue;
            }
            let (folder, _) = self.file(&format!("{before}."))?;
            let mut names = files.names_in(&folder);
            names.sort_unstable();
            let found =
                names.iter().find(|name| *name == part).or_else(|| names.iter().find(|name| is_same(name, part)));
            there.push(found?.clone());
        }
        let name = there.join("/");
        let found = self.file(&name).filter(|(path, _)| files.has(path))?;
        Some((found, name))
    }

    /// Whether a file is in the scene's folder or below once all symbolic links are followed; true for missing files.
    fn leads_inside(&self, path: &Path) -> bool {
        let Some(scene) = &self.scene else { return true };
        fs::canonicalize(path).map_or(true, |path| path.starts_with(scene))
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

    #[cfg(unix)]
    #[test]
    fn links_lead_no_further_than_names() {
        use std::os::unix::fs::symlink;

        let outer = tempfile::tempdir().expect("a folder");
        let at = |path: &str| outer.path().join(path);
        fs::create_dir_all(at("scene/sub")).expect("a folder");
        for path in ["secret.bin", "scene/inside.bin"] {
            fs::write(at(path), "").expect("a file");
        }
        symlink("../../secret.bin", at("scene/sub/out.bin")).expect("a link");
        symlink("../inside.bin", at("scene/sub/in.bin")).expect("a link");
        symlink(outer.path(), at("scene/up")).expect("a link");
        // The scene's folder may be reached by a link itself.
        symlink(at("scene"), at("link")).expect("a link");
        for scene in ["scene/a.obj", "link/a.obj"] {
            let folder = Folder::of(&at(scene), false);
            for (name, is_inside) in
                [("sub/in.bin", true), ("sub/none.bin", true), ("sub/out.bin", false), ("up/secret.bin", false)]
            {
                assert_eq!(folder.file(name).is_some(), is_inside, "{name}");
                assert!(Folder { allow_outside: true, ..folder.clone() }.file(name).is_some());
            }
        }
    }

    #[test]
    fn names_are_found_whatever_their_case() {
        let outer = tempfile::tempdir().expect("a folder");
        let paths = ["scene/Tex/Wood.PNG", "scene/Tex/b.png", "scene/Tex/B.png", "secret.bin"];
        fs::create_dir_all(outer.path().join("scene/Tex")).expect("a folder");
        for path in paths {
            fs::write(outer.path().join(path), "").expect("a file");
        }
        let given = Files::given(paths.map(|path| (path.into(), Vec::new())));
        for (files, root) in [(Files::OnDisk, outer.path()), (given, Path::new(""))] {
            let folder = Folder::of(&root.join("scene/a.obj"), false);
            let found = |name: &str| folder.in_other_case(name, &files).map(|(_, name)| name);
            for (name, is) in [
                ("tex/wood.png", Some("Tex/Wood.PNG")),
                ("TEX\\./WOOD.png", Some("Tex/./Wood.PNG")),
                ("tex/b.png", Some("Tex/b.png")),
                ("tex/b.PNG", Some("Tex/B.png")),
                ("tex/oak.png", None),
                ("tex", None),
                ("../SECRET.bin", None),
            ] {
                assert_eq!(found(name).as_deref(), is, "{name}");
            }
        }
    }

    #[test]
    fn given_files_are_found_by_path_or_by_a_name_that_is_the_only_one() {
        let files = ["car.obj", "a/b.png", "c/d.png", "e/d.png"].map(|path| (path.into(), path.as_bytes().to_vec()));
        let Files::Given(files) = Files::given(files) else { panic!("they are given") };
        let found = |path: &str| find(&files, Path::new(path)).map(|bytes| String::from_utf8(bytes.to_vec()).unwrap());
        for (path, file) in [
            ("car.obj", Some("car.obj")),
            ("./x/../car.obj", Some("car.obj")),
            ("a/./b.png", Some("a/b.png")),
            ("textures/b.png", Some("a/b.png")),
            ("e/d.png", Some("e/d.png")),
            ("d.png", None),
            ("f.png", None),
            ("", None),
            ("..", None),
        ] {
            assert_eq!(found(path).as_deref(), file, "{path}");
        }
    }
}
