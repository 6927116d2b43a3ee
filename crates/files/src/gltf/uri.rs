//! URIs of a glTF file's buffers and images.

use std::path::PathBuf;

use data_url::DataUrl;
use percent_encoding::percent_decode_str;

use crate::folder::{Files, Folder};

/// The resource that a URI of a glTF file refers to.
#[derive(Debug)]
pub(super) enum Resource {
    /// The bytes inside a `data:` URI.
    Embedded(Vec<u8>),
    /// A file beside the scene's.
    File(PathBuf),
    /// A file whose name differs in case, with the requested and the actual name.
    InOtherCase(PathBuf, [String; 2]),
}

/// Resolves `uri` against the scene's folder.
///
/// # Errors
/// A message why the URI is refused: a path out of the folder, a scheme other than `data:`, or broken base64.
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

/// The scheme of an absolute URI, before its colon (RFC 3986 §3.1).
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let mut letters = scheme.bytes();
    let valid = letters.next()?.is_ascii_alphabetic()
        && letters.all(|letter| letter.is_ascii_alphanumeric() || b"+-.".contains(&letter));
    valid.then_some(scheme)
}
