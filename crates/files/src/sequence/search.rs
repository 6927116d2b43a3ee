use std::collections::HashMap;
use std::path::{Path, PathBuf};

use umbrage_scene::Error;

use super::names::{Pattern, natural_order, numbers};
use crate::formats::Format;

const LOOKED_FOR: &str = "numbered .obj, .ply or .stl files, such as name_0001.ply";

/// The files of a sequence, at least one, in order of display, and warnings.
type Found = (Vec<PathBuf>, Vec<String>);

/// Finds the files of the sequence at `address`; `None` for a plain file, which needn't exist.
///
/// # Errors
/// Where `address` is a pattern or a folder, but there is no sequence.
pub(super) fn find(address: &Path) -> Result<Option<Found>, Error> {
    let wrong = |cause: String| Error::address(address.display().to_string(), cause);
    if address.is_file() {
        return Ok(None);
    }
    let (folder, names, mut warnings) = if address.is_dir() {
        let (names, warnings) = largest_family(&scene_names(address, |_| true)?).map_err(wrong)?;
        (address, names, warnings)
    } else {
        let Some(name) = address.file_name().and_then(|name| name.to_str()) else { return Ok(None) };
        let folder = address.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let Some(pattern) = Pattern::parse(name).map_err(wrong)? else { return Ok(None) };
        if !folder.is_dir() {
            let cause = format!("there is no folder {} (wildcards may only be in the file's name)", folder.display());
            return Err(wrong(cause));
        }
        let names = scene_names(folder, |name| pattern.matches(name))?;
        if names.is_empty() {
            return Err(wrong("matches no .obj, .ply or .stl file".to_owned()));
        }
        (folder, names, Vec::new())
    };
    warnings.extend(gaps(&names));
    Ok(Some((names.into_iter().map(|name| folder.join(name)).collect(), warnings)))
}

/// Lists the files in `folder` that are readable scenes and accepted by `wanted`, in natural order.
///
/// # Errors
/// Where the folder can't be listed, or all such files are glTF.
fn scene_names(folder: &Path, wanted: impl Fn(&str) -> bool) -> Result<Vec<String>, Error> {
    let read = |source| Error::read(folder, source);
    let mut names = Vec::new();
    let mut gltf = None;
    for entry in std::fs::read_dir(folder).map_err(read)? {
        let path = entry.map_err(read)?.path();
        let Some(name) = path.file_name().and_then(|name| name.to_str()).filter(|name| wanted(name)) else { continue };
        match Format::of(&path) {
            Some(Format::Gltf) => gltf = Some(path),
            Some(Format::Obj | Format::Ply | Format::Stl) if path.is_file() => names.push(name.to_owned()),
            _ => {}
        }
    }
    match gltf {
        Some(path) if names.is_empty() => {
            Err(Error::unsupported(&path, "glTF in a sequence of files", "open the file alone, or use OBJ, PLY or STL"))
        }
        _ => {
            names.sort_by(|a, b| natural_order(a, b));
            Ok(names)
        }
    }
}

/// Finds the largest set of `names` that differ in one number only, and warns of the others. `names` are in natural order.
///
/// # Errors
/// A message with the expected names, where no name has a number.
fn largest_family(names: &[String]) -> Result<(Vec<String>, Vec<String>), String> {
    let mut families: HashMap<(&str, &str), Vec<usize>> = HashMap::new();
    for (index, name) in names.iter().enumerate() {
        for (prefix, _, suffix) in numbers(name) {
            families.entry((prefix, suffix)).or_default().push(index);
        }
    }
    // Of equally large families, the one whose first file comes first; of those with the same first file, the one that
    // counts by the last number. So the answer depends on the names alone.
    let largest = families
        .into_iter()
        .max_by(|((prefix_a, _), a), ((prefix_b, _), b)| {
            a.len().cmp(&b.len()).then_with(|| b[0].cmp(&a[0])).then_with(|| prefix_a.len().cmp(&prefix_b.len()))
        })
        .map(|(_, indices)| indices);
    let Some(indices) = largest else {
        return Err(match names.first() {
            None => format!("the folder has no file that can be shown; looked for {LOOKED_FOR}"),
            Some(name) => {
                format!("no file of the folder has a number; looked for {LOOKED_FOR} (to see one file, open `{name}`)")
            }
        });
    };
    let left_out = names.len() - indices.len();
    let mut warnings = Vec::new();
    if left_out > 0 {
        let example = (0..names.len())
            .find(|index| indices.binary_search(index).is_err())
            .map_or("", |index| names[index].as_str());
        let first = &names[indices[0]];
        warnings.push(format!("left out {left_out} files that don't belong to {first}, for instance {example}"));
    }
    Ok((indices.into_iter().map(|index| names[index].clone()).collect(), warnings))
}

/// Warnings about gaps and other irregularities in the numbers of `names`, which are in natural order.
fn gaps(names: &[String]) -> Vec<String> {
    if names.len() < 2 {
        return Vec::new();
    }
    let Some(sequence) = counted(names) else {
        return vec!["the files differ in more than one number: they show in the order of their names".to_owned()];
    };
    let mut missing = 0_u64;
    let mut first_missing = None;
    let mut repeated = None;
    for pair in sequence.windows(2) {
        match pair[1].saturating_sub(pair[0]) {
            0 => repeated = repeated.or(Some(pair[0])),
            1 => {}
            step => {
                missing = missing.saturating_add(step - 1);
                first_missing = first_missing.or(Some(pair[0] + 1));
            }
        }
    }
    let mut warnings = Vec::new();
    if let Some(first) = first_missing {
        warnings.push(format!(
            "{missing} numbers have no file, the first being {first}: the files around them follow each other"
        ));
    }
    if let Some(number) = repeated {
        warnings.push(format!("the number {number} has more than one file: each is a frame"));
    }
    warnings
}

/// The numbers in which `names` differ; `None` if they differ in more than one.
fn counted(names: &[String]) -> Option<Vec<u64>> {
    let first = names.first()?;
    numbers(first).into_iter().rev().find_map(|(prefix, _, suffix)| {
        let number = |name: &String| {
            let own = numbers(name).into_iter().find(|(own, _, rest)| *own == prefix && *rest == suffix);
            own.map(|(_, number, _)| number)
        };
        names.iter().map(number).collect()
    })
}
