//! Where a glTF file's buffers and images are.

use std::path::{Path, PathBuf};

/// What a URI of a glTF file points to.
#[derive(Debug, PartialEq)]
pub(super) enum Resource {
    /// The bytes inside a `data:` URI.
    Embedded(Vec<u8>),
    /// A file beside the scene's.
    File(PathBuf),
}

/// Resolves `uri` against the scene's folder.
///
/// # Errors
/// Says in words why the URI is refused: an absolute path, another scheme than `data:`, or broken base64.
pub(super) fn resolve(folder: &Path, uri: &str) -> Result<Resource, String> {
    if let Some(scheme) = scheme(uri) {
        if !scheme.eq_ignore_ascii_case("data") {
            return Err(format!("`{scheme}:` URIs are not read; put the file beside the scene or embed it"));
        }
        let (kind, content) =
            uri[scheme.len() + 1..].split_once(',').ok_or("a data URI without a comma before its bytes")?;
        let bytes = if kind.ends_with(";base64") { base64(content)? } else { percent_decoded(content) };
        return Ok(Resource::Embedded(bytes));
    }
    let relative = String::from_utf8(percent_decoded(uri)).map_err(|_| "a path that is not UTF-8".to_owned())?;
    // Checked after decoding, so that `%2F` hides nothing.
    if relative.starts_with(['/', '\\']) || Path::new(&relative).has_root() {
        return Err(format!("`{relative}` is an absolute path; only paths beside the scene are read"));
    }
    if relative.is_empty() {
        return Err("an empty URI".to_owned());
    }
    Ok(Resource::File(folder.join(relative)))
}

/// What stands before the colon of an absolute URI (RFC 3986 §3.1).
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let mut letters = scheme.bytes();
    let valid = letters.next()?.is_ascii_alphabetic()
        && letters.all(|letter| letter.is_ascii_alphanumeric() || b"+-.".contains(&letter));
    valid.then_some(scheme)
}

/// Replaces each `%XX` by its byte; a per cent sign without two hexadecimal digits stays, as files have such names.
fn percent_decoded(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let digit = |at: usize| bytes.get(at).and_then(|&byte| char::from(byte).to_digit(16));
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        match (bytes[at], digit(at + 1), digit(at + 2)) {
            (b'%', Some(high), Some(low)) => {
                decoded.push((high * 16 + low) as u8);
                at += 3;
            }
            (byte, ..) => {
                decoded.push(byte);
                at += 1;
            }
        }
    }
    decoded
}

/// The bytes of a base64 text (RFC 4648 §4), with or without padding.
fn base64(text: &str) -> Result<Vec<u8>, String> {
    let text = text.trim_end_matches('=').as_bytes();
    if text.len() % 4 == 1 {
        return Err("base64 that ends in the middle of a byte".to_owned());
    }
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for (group, letters) in text.chunks(4).enumerate() {
        let mut bits = 0_u32;
        for (index, &letter) in letters.iter().enumerate() {
            let value = sextet(letter).ok_or_else(|| {
                let at = group * 4 + index;
                format!("byte {at} of the base64 is `{}`", letter.escape_ascii())
            })?;
            bits |= u32::from(value) << (18 - 6 * index);
        }
        bytes.extend_from_slice(&bits.to_be_bytes()[1..letters.len()]);
    }
    Ok(bytes)
}

fn sextet(letter: u8) -> Option<u8> {
    match letter {
        b'A'..=b'Z' => Some(letter - b'A'),
        b'a'..=b'z' => Some(letter - b'a' + 26),
        b'0'..=b'9' => Some(letter - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resolved(uri: &str) -> Result<Resource, String> {
        resolve(Path::new("folder"), uri)
    }

    #[test]
    fn relative_paths_are_percent_decoded() {
        let file = |path: &str| Ok(Resource::File(Path::new("folder").join(path)));
        assert_eq!(resolved("a%20b/%C3%A9.bin"), file("a b/é.bin"));
        assert_eq!(resolved("100%.bin"), file("100%.bin"));
        assert_eq!(resolved("../a.bin"), file("../a.bin"));
    }

    #[test]
    fn base64_of_every_length_is_decoded() {
        // RFC 4648 §10.
        for (text, bytes) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg==", "foob"),
            ("Zm9vYmE=", "fooba"),
            ("Zm9vYmFy", "foobar"),
        ] {
            assert_eq!(resolved(&format!("data:;base64,{text}")), Ok(Resource::Embedded(bytes.into())));
            assert_eq!(base64(text.trim_end_matches('=')), Ok(bytes.into()), "without padding");
        }
        assert_eq!(resolved("data:text/plain,a%00b"), Ok(Resource::Embedded(b"a\0b".to_vec())));
    }

    #[test]
    fn other_resources_are_refused() {
        for (uri, part) in [
            ("http://host/a.bin", "`http:`"),
            ("C:\\a.bin", "`C:`"),
            ("/etc/a.bin", "absolute"),
            ("%2fetc/a.bin", "absolute"),
            ("\\\\host\\a.bin", "absolute"),
            ("data:nothing", "comma"),
            ("data:;base64,Zm9?", "`?`"),
            ("data:;base64,Z", "middle"),
            ("a%FF", "UTF-8"),
            ("", "empty"),
        ] {
            let cause = resolved(uri).expect_err(uri);
            assert!(cause.contains(part), "{uri}: {cause}");
        }
    }
}
