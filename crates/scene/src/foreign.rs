//! Files of other kinds than their names say: images, archives, pages, pointers.

use std::path::Path;

use serde_json::Value;

use crate::memory::Budget;
use crate::{Error, folder};

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
const PAGE: &str = "a page of a web site";
const DOWNLOAD: &str = "the download has failed, or needs a login";
const USD: &str = "Universal Scene Description";
const FROM_USD: &str = "Blender imports it (File > Import > Universal Scene Description) and exports .glb";

/// Length of the part of a file that is read again: all of a glTF 1.0 file, whose buffers are files of their own.
const MOST_BYTES: u64 = 1 << 22;

/// The error of a file of another kind than its name says; the reader's own error for other files.
pub(crate) fn or_what_it_is(error: Error, path: &Path, budget: &Budget) -> Error {
    let Error::Malformed { path: wrong, .. } = &error else { return error };
    let mut bytes = Vec::new();
    if wrong != path || folder::append(path, MOST_BYTES, &mut bytes, budget).is_err() {
        return error;
    }
    let found = BEGINNINGS.iter().find(|(first, ..)| bytes.starts_with(first) && !is_named_so(path, first));
    let told = |what: &str, hint: &str| Error::malformed(path, "its first bytes", format!("this is {what}; {hint}"));
    match found {
        Some((_, what, hint)) => told(what, hint),
        // Version 1.0 has maps by name in place of lists.
        None if serde_json::from_slice::<Value>(&bytes).is_ok_and(|json| json["meshes"].is_object()) => {
            Error::unsupported(
                path,
                "glTF 1.0",
                "gltf-pipeline makes 2.0 of it: `npx gltf-pipeline -i FILE -o OUT.glb`",
            )
        }
        None => error,
    }
}

/// Whether the name says the kind of file that begins with `first`.
fn is_named_so(path: &Path, first: &[u8]) -> bool {
    let ends = |ending: &str| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(ending));
    match first {
        b"glTF" => ends("glb") || ends("gltf"),
        b"ply" => ends("ply"),
        _ => false,
    }
}
