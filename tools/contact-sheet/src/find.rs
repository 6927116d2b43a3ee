use std::fs;
use std::path::{Path, PathBuf};

/// File types that hold a whole scene.
const EXTENSIONS: [&str; 5] = ["glb", "gltf", "obj", "ply", "stl"];

/// The scenes that the addresses mean: folders are searched, with the folders in them; what is none is left as it is.
///
/// A folder that holds nothing but several numbered files of one kind is one scene: a sequence.
///
/// # Errors
/// Where a folder can't be read or holds no scene.
pub(crate) fn scenes(addresses: &[PathBuf]) -> Result<Vec<PathBuf>, String> {
    let mut found = Vec::new();
    for address in addresses {
        if address.is_dir() {
            let before = found.len();
            search(address, &mut found)?;
            if found.len() == before {
                return Err(format!("{}: there is no scene in this folder", address.display()));
            }
        } else {
            found.push(address.clone());
        }
    }
    Ok(found)
}

fn search(folder: &Path, found: &mut Vec<PathBuf>) -> Result<(), String> {
    let failure = |error| format!("{}: {error}", folder.display());
    let mut folders = Vec::new();
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(failure)? {
        let path = entry.map_err(failure)?.path();
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        // Links to folders could lead round in a circle.
        if path.is_dir() && !path.is_symlink() {
            folders.push(path);
        } else if EXTENSIONS.contains(&extension.as_str()) {
            files.push(path);
        }
    }
    files.sort();
    folders.sort();
    if is_sequence(&files) {
        found.push(folder.to_owned());
    } else {
        found.extend(files);
    }
    folders.iter().try_for_each(|folder| search(folder, found))
}

/// Whether the files differ by a number alone.
fn is_sequence(files: &[PathBuf]) -> bool {
    let unnumbered = |file: &PathBuf| {
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let digits = name.contains(|letter: char| letter.is_ascii_digit());
        digits.then(|| name.replace(|letter: char| letter.is_ascii_digit(), ""))
    };
    match files {
        [] | [_] => false,
        [first, rest @ ..] => {
            let name = unnumbered(first);
            name.is_some() && rest.iter().all(|file| unnumbered(file) == name)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_searched_and_sequences_are_one_scene() {
        let folder = tempfile::tempdir().unwrap();
        let write = |path: &str| {
            let path = folder.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        };
        for path in ["b.obj", "a.GLB", "notes.txt", "gallop/h_01.obj", "gallop/h_02.obj", "more/c.ply", "more/d.stl"] {
            write(path);
        }
        let found = scenes(&[folder.path().to_owned(), "demo:cloth".into()]).unwrap();
        let expected = ["a.GLB", "b.obj", "gallop", "more/c.ply", "more/d.stl"];
        let mut expected: Vec<PathBuf> = expected.iter().map(|path| folder.path().join(path)).collect();
        expected.push("demo:cloth".into());
        assert_eq!(found, expected);
    }

    #[test]
    fn empty_folders_are_an_error() {
        let folder = tempfile::tempdir().unwrap();
        assert!(scenes(&[folder.path().to_owned()]).unwrap_err().contains("no scene"));
    }
}
