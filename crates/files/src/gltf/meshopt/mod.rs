//! `EXT_meshopt_compression` and its successor `KHR_meshopt_compression`: buffer views whose bytes are compressed by
//! meshoptimizer.
//!
//! `vertices` and `indices` read the two kinds of streams, `filters` decodes numbers after that.

mod filters;
mod indices;
mod vertices;

use gltf::json::buffer;
use rayon::prelude::*;
use serde::Deserialize;
use serde_json::Value;
use umbrage_scene::Error;

use self::filters::Filter;
use super::document::Document;

const NAMES: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// The extension's object in a buffer view.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Compressed {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: usize,
    count: usize,
    mode: String,
    filter: Option<Filter>,
}

/// Replaces all compressed buffer views by plain ones.
///
/// # Errors
/// Where a view is broken, or exceeds the memory budget.
pub(super) fn decompress(document: &mut Document) -> Result<(), Error> {
    let views = document.json.buffer_views.par_iter().enumerate();
    let decoded: Vec<Result<_, Error>> =
        views.filter_map(|(number, view)| Some(read(document, number, view)?.map(|bytes| (number, bytes)))).collect();
    for result in decoded {
        let (number, bytes) = result?;
        document.replace_view(number, bytes);
    }
    Ok(())
}

/// The decompressed bytes of a view; `None` where it isn't compressed.
fn read(document: &Document, number: usize, view: &buffer::View) -> Option<Result<Vec<u8>, Error>> {
    let extensions = &view.extensions.as_ref()?.others;
    let (name, json) = NAMES.iter().find_map(|name| Some((name, extensions.get(*name)?)))?;
    let location = format!("bufferViews[{number}].extensions.{name}");
    Some(decode(document, json, &location))
}

fn decode(document: &Document, json: &Value, location: &str) -> Result<Vec<u8>, Error> {
    let malformed = |cause: String| document.malformed(location, cause);
    let compressed = Compressed::deserialize(json).map_err(|error| malformed(error.to_string()))?;
    let Compressed { count, byte_stride: stride, .. } = compressed;
    let filter = compressed.filter.unwrap_or_default();
    let buffer = document.buffer(compressed.buffer, format_args!("{location}.buffer"))?;
    let (first, length) = (compressed.byte_offset, compressed.byte_length);
    let range = first.checked_add(length).and_then(|end| buffer.get(first..end));
    let bytes = range.ok_or_else(|| {
        malformed(format!("{length} bytes from byte {first} on reach beyond the {} bytes of its buffer", buffer.len()))
    })?;
    if !is_stride(&compressed.mode, stride) || !filter.takes(stride) {
        let cause = format!("byteStride is {stride}, which elements of mode {} can't have", compressed.mode);
        return Err(malformed(cause));
    }
    let length = count.checked_mul(stride).ok_or_else(|| malformed(format!("{count} elements are too many")))?;
    document.take_for::<u8>(length, location)?;
    let elements = match compressed.mode.as_str() {
        "ATTRIBUTES" => vertices::vertices(bytes, count, stride).map(|mut elements| {
            filter.undo(&mut elements, stride);
            elements
        }),
        "TRIANGLES" => indices::triangles(bytes, count).map(|indices| as_bytes(&indices, stride)),
        _ => indices::sequence(bytes, count).map(|indices| as_bytes(&indices, stride)),
    };
    elements.map_err(malformed)
}

/// Whether a mode accepts elements of `stride` bytes; false for unknown modes.
fn is_stride(mode: &str, stride: usize) -> bool {
    match mode {
        "ATTRIBUTES" => stride.is_multiple_of(4) && (4..=256).contains(&stride),
        "TRIANGLES" | "INDICES" => stride == 2 || stride == 4,
        _ => false,
    }
}

fn as_bytes(indices: &[u32], stride: usize) -> Vec<u8> {
    match stride {
        2 => indices.iter().flat_map(|&index| (index as u16).to_le_bytes()).collect(),
        _ => indices.iter().flat_map(|index| index.to_le_bytes()).collect(),
    }
}

/// The unread bytes of a stream.
#[derive(Debug)]
pub(super) struct Bytes<'a> {
    rest: &'a [u8],
}

impl<'a> Bytes<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// The next `count` bytes.
    ///
    /// # Errors
    /// A message, where there are fewer.
    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or("its bytes end too early")?;
        self.rest = rest;
        Ok(taken)
    }

    /// The next byte.
    ///
    /// # Errors
    /// As [`Bytes::take`].
    pub(super) fn byte(&mut self) -> Result<u8, String> {
        Ok(self.take(1)?[0])
    }

    /// A number in groups of seven bits, the lowest first; the last group's byte is below 128.
    ///
    /// # Errors
    /// As [`Bytes::take`], and where it doesn't fit into 32 bits.
    pub(super) fn number(&mut self) -> Result<u32, String> {
        let mut number = 0;
        for shift in (0..32).step_by(7) {
            let byte = self.byte()?;
            number |= u32::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(number);
            }
        }
        Err("a number takes more than five bytes".to_owned())
    }

    /// Checks that all bytes were read.
    ///
    /// # Errors
    /// A message with the number of bytes left.
    pub(super) fn expect_end(&self) -> Result<(), String> {
        if self.rest.is_empty() {
            return Ok(());
        }
        Err(format!("{} bytes are left over behind the last element", self.rest.len()))
    }
}

/// A signed number from its zigzag code: 0, −1, 1, −2 …
pub(super) fn signed(code: u32) -> u32 {
    (code >> 1) ^ (code & 1).wrapping_neg()
}
