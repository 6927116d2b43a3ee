//! Files whose content is of another kind than their name says: images, archives, pages, pointers.

use std::path::Path;

use serde_json::Value;
use umbrage_scene::Error;

use crate::folder;
use crate::memory::Budget;
use crate::text::MARK;

/// The first bytes of a file, the name of its kind, and a remedy.
const BEGINNINGS: &[(&[u8], &str, &str)] = &[
    (b"version https://git-lfs", "a pointer of Git LFS", "`git lfs pull` fetches the file itself"),
    (b"\x89PNG", "a PNG image", SCENES),
    (b"\xff\xd8\xff", "a JPEG image", SCENES),
    (b"GIF8", "a GIF image", SCENES),
    (b"#?RADIANCE", "a Radiance image", SCENES),
    (b"v/1\x01", "an OpenEXR image", SCENES),
    (b"%PDF", "a PDF document", SCENES),
    (b"PK\x03\x04", "a ZIP archive", "unpack it, and open the scene in it"),
    (b"\x1f\x8b", "compressed by gzip", "unpack it first (`gunzip`)"),
    (b"\xfd7zXZ", "compressed by xz", "unpack it first (`unxz`)"),
    (b"(\xb5/\xfd", "compressed by Zstandard", "unpack it first (`unzstd`)"),
    (b"\xff\xfe", UTF16, TO_UTF8),
    (b"\xfe\xff", UTF16, TO_UTF8),
    (b"<!DOCTYPE html", PAGE, DOWNLOAD),
    (b"<!doctype html", PAGE, DOWNLOAD),
    (b"<html", PAGE, DOWNLOAD),
    (b"glTF", "binary glTF", "call it .glb"),
    (b"ply", "PLY", "call it .ply"),
    (b"Kaydara FBX", "FBX", "Blender imports it (File > Import > FBX) and exports .glb"),
    (b"BLENDER", "Blender's own format", "Blender opens it and exports .glb (File > Export > glTF 2.0)"),
    (b"PXR-USDC", USD, FROM_USD),
    (b"#usda", USD, FROM_USD),
];

const SCENES: &str = "a scene is a .gltf, .glb, .obj, .ply or .stl file";
const UTF16: &str = "a text in UTF-16";
const TO_UTF8: &str = "save it as UTF-8 (`iconv -f UTF-16 -t UTF-8 FILE`)";
const PAGE: &str = "a page of a web site";
const DOWNLOAD: &str = "the download has failed, or needs a login";
const USD: &str = "Universal Scene Description";
const FROM_USD: &str = "Blender imports it (File > Import > Universal Scene Description) and exports .glb";

/// Number of bytes of a file that are read again: enough for all of a glTF 1.0 file, whose buffers are separate files.
const MOST_BYTES: u64 = 1 << 22;

/// Replaces a reader's error by one that names the file's true kind, where that differs from its name's.
pub(crate) fn or_what_it_is(error: Error, path: &Path, budget: &Budget) -> Error {
    let Error::Malformed { path: wrong, .. } = &error else { return error };
    let mut bytes = Vec::new();
    if wrong != path || folder::append(path, MOST_BYTES, &mut bytes, budget).is_err() {
        return error;
    }
    match kind(&bytes, path) {
        Some(kind) => kind,
        None if serde_json::from_slice::<Value>(bytes.strip_prefix(MARK).unwrap_or(&bytes))
            .is_ok_and(|json| is_version_1(&json)) =>
        {
            Error::unsupported(
                path,
                "glTF 1.0",
                "gltf-pipeline makes 2.0 of it: `npx gltf-pipeline -i FILE -o OUT.glb`",
            )
        }
        None => error,
    }
}

/// Checks the first bytes of a text format whose reader skips unknown words.
///
/// # Errors
/// Where the file is of another kind.
pub(crate) fn expect_text(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    kind(bytes, path).map_or(Ok(()), Err)
}

/// Returns an error where the first bytes show another kind of file than the name says.
fn kind(bytes: &[u8], path: &Path) -> Option<Error> {
    let is_ascii = |byte: u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    let (what, remedy) = match *bytes {
        // UTF-16 without a byte order mark.
        [a, 0, b, 0, ..] | [0, a, 0, b, ..] if is_ascii(a) && is_ascii(b) => (UTF16, TO_UTF8),
        _ => {
            let is_so = |first: &[u8]| bytes.starts_with(first) && !is_named_so(path, first);
            BEGINNINGS.iter().find(|(first, ..)| is_so(first)).map(|&(_, what, remedy)| (what, remedy))?
        }
    };
    Some(Error::malformed(path, "its first bytes", format!("this is {what}; {remedy}")))
}

/// Whether this is glTF 1.0, which has maps by name in place of lists.
fn is_version_1(json: &Value) -> bool {
    ["accessors", "buffers", "materials", "meshes", "nodes", "scenes"].iter().any(|list| json[list].is_object())
}

/// Whether the name's extension fits a file that begins with `first`.
fn is_named_so(path: &Path, first: &[u8]) -> bool {
    let ends = |ending: &str| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(ending));
    match first {
        b"glTF" => ends("glb") || ends("gltf"),
        b"ply" => ends("ply"),
        _ => false,
    }
}
