//! Where a glTF file's buffers and images are.

use std::path::PathBuf;

use data_url::DataUrl;
use percent_encoding::percent_decode_str;

use crate::folder::{Files, Folder};

/// What a URI of a glTF file points to.
#[derive(Debug)]
pub(super) enum Resource {
    /// The bytes inside a `data:` URI.
    Embedded(Vec<u8>),
    /// A file beside the scene's.
    File(PathBuf),
    /// One whose name, which comes second, has other small and capital letters than the first.
    InOtherCase(PathBuf, [String; 2]),
}

/// Resolves `uri` against the scene's folder.
///
/// # Errors
/// Says in words why the URI is refused: a path out of the folder, another scheme than `data:`, or broken base64.
pub(super) fn resolve(folder: &Folder, files: &Files, uri: &str) -> Result<Resource, String> {
    if let Some(scheme) = scheme(uri) {
        if !scheme.eq_ignore_ascii_case("data") {
            return Err(format!("`{scheme}:` URIs are not read; put the file beside the scene or embed it"));
        }
        let url = DataUrl::process(uri).map_err(|_| "a data URI without a comma before its bytes")?;
        let (bytes, _) = url.decode_to_vec().map_err(|error| format!("broken base64: {error}"))?;
        return Ok(Resource::Embedded(bytes));
    }
    let relative = percent_decode_str(uri).decode_utf8().map_err(|_| "a path that is not UTF-8")?;
    if relative.is_empty() {
        return Err("an empty URI".to_owned());
    }
    // Checked after decoding, so that `%2F` and `%2E` hide nothing.
    match folder.file(&relative) {
        Some((path, _)) if files.has(&path) => Ok(Resource::File(path)),
        Some((path, _)) => Ok(match folder.in_other_case(&relative, files) {
            Some(((path, _), name)) => Resource::InOtherCase(path, [relative.into_owned(), name]),
            None => Resource::File(path),
        }),
        None => Err(format!(
            "`{relative}` is outside of the scene's folder; if you trust the file, allow that (--allow-outside)"
        )),
    }
}

/// What stands before the colon of an absolute URI (RFC 3986 §3.1).
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let mut letters = scheme.bytes();
    let valid = letters.next()?.is_ascii_alphabetic()
        && letters.all(|letter| letter.is_ascii_alphanumeric() || b"+-.".contains(&letter));
    valid.then_some(scheme)
}
