//! A glTF file's JSON, buffers and URIs.

use std::collections::BTreeSet;
use std::fmt::Display;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use data_url::DataUrl;
use gltf::json::accessor::Accessor;
use gltf::json::{Index, Root, buffer};
use percent_encoding::percent_decode_str;
use serde::Deserialize;
use serde_json::Value;
use umbrage_scene::Error;

use super::far::FarNode;
use super::pointers::PointerChannel;
use super::{draco, extensions, meshopt, pointers};
use crate::folder::{self, Files, Folder};
use crate::memory::Budget;
use crate::text::MARK;

/// A glTF file as it was read: its JSON, of which nothing is checked yet, and the bytes that it refers to.
#[derive(Debug)]
pub(super) struct Document {
    pub(super) json: Root,
    /// The channels that animate properties other than nodes'.
    pub(super) pointers: Vec<PointerChannel>,
    path: PathBuf,
    folder: Folder,
    pub(super) budget: Budget,
    /// The whole file, followed by its buffers from other files.
    bytes: Vec<u8>,
    /// Range of the JSON in `bytes`.
    text: Range<usize>,
    /// Range of each buffer in `bytes`.
    buffers: Vec<Range<usize>>,
    /// The decompressed buffers, which come after these.
    decompressed: Vec<Vec<u8>>,
    /// Names of files, and of the files that were read instead.
    renamed: Mutex<BTreeSet<[String; 2]>>,
}

impl Document {
    /// Reads a `.gltf` or `.glb` file, told apart by their content, and all of its buffers.
    ///
    /// # Errors
    /// Where a file can't be read or is cut off, the JSON is broken, or a required extension is unsupported.
    pub(super) fn read(
        path: &Path,
        allow_outside: bool,
        budget: &Budget,
        warnings: &mut Vec<String>,
    ) -> Result<Self, Error> {
        let file = folder::read(path, budget).map_err(|source| Error::read(path, source))?;
        let (json, binary) =
            if file.starts_with(b"glTF") { glb_chunks(path, &file, warnings)? } else { (0..file.len(), None) };
        let range = json.clone();
        let text = &file[json];
        take_for_json(text, budget).map_err(|cause| Error::malformed(path, "JSON", cause))?;
        let (json, pointers) = parse(path, text, warnings)?;
        extensions::check(path, &json, warnings)?;
        let folder = Folder::of(path, allow_outside);
        let (path, budget) = (path.to_owned(), budget.clone());
        let mut document = Self {
            json,
            pointers,
            path,
            folder,
            budget,
            bytes: file,
            text: range,
            buffers: Vec::new(),
            decompressed: Vec::new(),
            renamed: Mutex::default(),
        };
        document.read_buffers(binary.as_ref())?;
        meshopt::decompress(&mut document)?;
        draco::decompress(&mut document, warnings)?;
        Ok(document)
    }

    /// The numbers of all nodes as the JSON spells them. Empty if only the [lenient parser](parse_leniently) accepts the
    /// JSON.
    pub(super) fn far_nodes(&self) -> Vec<FarNode> {
        #[derive(Deserialize)]
        struct Root {
            nodes: Vec<FarNode>,
        }
        serde_json::from_slice(trimmed(&self.bytes[self.text.clone()])).map_or(Vec::new(), |Root { nodes }| nodes)
    }

    /// The error `cause` at `location`, a path in the JSON.
    pub(super) fn malformed(&self, location: impl Display, cause: impl Into<String>) -> Error {
        Error::malformed(&self.path, location.to_string(), cause)
    }

    /// Takes memory for `count` values of some type, for `location` in the JSON.
    ///
    /// # Errors
    /// Where too little is left.
    pub(super) fn take_for<T>(&self, count: usize, location: impl Display) -> Result<(), Error> {
        self.budget.take_for::<T>(count, &location).map_err(|cause| self.malformed(location, cause))
    }

    /// Element `index` of `list`, the JSON's array `name`, as `location` in the JSON asks for it.
    ///
    /// # Errors
    /// Where the list is shorter.
    pub(super) fn element<'a, T>(
        &self,
        list: &'a [T],
        name: &str,
        index: usize,
        location: impl Display,
    ) -> Result<&'a T, Error> {
        list.get(index).ok_or_else(|| {
            self.malformed(location, format!("index {index} is out of range: `{name}` has {} elements", list.len()))
        })
    }

    /// The bytes of buffer view `index` and the view itself, as `location` in the JSON asks for it.
    ///
    /// # Errors
    /// Where the view doesn't exist or reaches beyond its buffer.
    pub(super) fn view(&self, index: usize, location: impl Display) -> Result<(&[u8], &buffer::View), Error> {
        let view = self.element(&self.json.buffer_views, "bufferViews", index, location)?;
        let own_location = format_args!("bufferViews[{index}]");
        let bytes = self.buffer(view.buffer.value(), format_args!("{own_location}.buffer"))?;
        let first = view.byte_offset.map_or(0, |offset| offset.0);
        let range = first
            .checked_add(view.byte_length.0)
            .and_then(|end| Some(usize::try_from(first).ok()?..usize::try_from(end).ok()?));
        let Some(bytes) = range.and_then(|range| bytes.get(range)) else {
            let cause = format!(
                "{} bytes from byte {first} on reach beyond the {} bytes of its buffer",
                view.byte_length.0,
                bytes.len()
            );
            return Err(self.malformed(own_location, cause));
        };
        Ok((bytes, view))
    }

    /// The bytes of buffer `index`, as `location` in the JSON asks for it.
    ///
    /// # Errors
    /// Where it doesn't exist.
    pub(super) fn buffer(&self, index: usize, location: impl Display) -> Result<&[u8], Error> {
        if let Some(bytes) = index.checked_sub(self.buffers.len()).and_then(|index| self.decompressed.get(index)) {
            return Ok(bytes);
        }
        let range = self.element(&self.buffers, "buffers", index, location)?;
        Ok(&self.bytes[range.clone()])
    }

    /// Replaces buffer view `index` by these bytes.
    pub(super) fn replace_view(&mut self, index: usize, bytes: Vec<u8>) {
        let view = &mut self.json.buffer_views[index];
        view.buffer = Index::new((self.buffers.len() + self.decompressed.len()) as u32);
        view.byte_offset = None;
        view.byte_length = bytes.len().into();
        self.decompressed.push(bytes);
    }

    /// Adds an accessor to all of these bytes.
    pub(super) fn add_accessor(&mut self, accessor: Accessor, bytes: Vec<u8>) -> Index<Accessor> {
        let view = Index::push(
            &mut self.json.buffer_views,
            buffer::View {
                buffer: Index::new(0),
                byte_length: 0_usize.into(),
                byte_offset: None,
                byte_stride: None,
                name: None,
                target: None,
                extensions: None,
                extras: Default::default(),
            },
        );
        self.replace_view(view.value(), bytes);
        let accessor = Accessor { buffer_view: Some(view), byte_offset: None, sparse: None, ..accessor };
        Index::push(&mut self.json.accessors, accessor)
    }

    /// Appends the bytes of a buffer's or an image's URI, at most `limit` of them.
    ///
    /// # Errors
    /// The reason why they can't be read, in words.
    pub(super) fn fetch(&self, uri: &str, limit: u64, bytes: &mut Vec<u8>, budget: &Budget) -> Result<(), String> {
        // Bytes in base64 are shorter than that.
        budget.take(uri.len() as u64, "a URI's bytes")?;
        if let Some(scheme) = scheme(uri) {
            if !scheme.eq_ignore_ascii_case("data") {
                return Err(format!("`{scheme}:` URIs are not read; put the file beside the scene or embed it"));
            }
            let url = DataUrl::process(uri).map_err(|_| "a data URI without a comma before its bytes")?;
            let (mut embedded, _) = url.decode_to_vec().map_err(|error| format!("broken base64: {error}"))?;
            budget.reserve(bytes, embedded.len(), "a URI's bytes")?;
            bytes.append(&mut embedded);
            return Ok(());
        }
        let path = self.find(uri, budget.may_read())?;
        let read = folder::append(&path, limit, bytes, budget);
        read.map_err(|error| format!("{}: {error}", path.display()))
    }

    /// The file that a relative URI names.
    ///
    /// # Errors
    /// A message why it is refused, such as a path out of the scene's folder.
    fn find(&self, uri: &str, files: &Files) -> Result<PathBuf, String> {
        let relative = percent_decode_str(uri).decode_utf8().map_err(|_| "a path that is not UTF-8")?;
        if relative.is_empty() {
            return Err("an empty URI".to_owned());
        }
        // Checked after decoding, so that `%2F` and `%2E` hide nothing.
        let (path, _) = self.folder.file(&relative).ok_or_else(|| {
            format!(
                "`{relative}` is outside of the scene's folder; if you trust the file, allow that (--allow-outside)"
            )
        })?;
        let other = if files.has(&path) { None } else { self.folder.in_other_case(&relative, files) };
        let Some(((other, _), name)) = other else { return Ok(path) };
        let mut renamed = self.renamed.lock().unwrap_or_else(PoisonError::into_inner);
        renamed.insert([relative.into_owned(), name]);
        Ok(other)
    }

    /// Warnings about files that were read under another name.
    pub(super) fn warnings(&self) -> Vec<String> {
        let renamed = self.renamed.lock().unwrap_or_else(PoisonError::into_inner);
        renamed.iter().map(|[name, other]| format!("`{name}` {}", folder::read_instead(other))).collect()
    }

    fn read_buffers(&mut self, binary: Option<&Range<usize>>) -> Result<(), Error> {
        let mut bytes = std::mem::take(&mut self.bytes);
        for (index, buffer) in self.json.buffers.iter().enumerate() {
            let location = format_args!("buffers[{index}]");
            let range = if let Some(uri) = &buffer.uri {
                let first = bytes.len();
                self.fetch(uri, buffer.byte_length.0, &mut bytes, &self.budget)
                    .map_err(|cause| self.malformed(format_args!("{location}.uri"), cause))?;
                first..bytes.len()
            } else {
                // Buffers without bytes are legal where nothing uses them; using one fails with its length of zero.
                binary.filter(|_| index == 0).cloned().unwrap_or_default()
            };
            let length = range.len();
            if buffer.byte_length.0 > length as u64 && (buffer.uri.is_some() || length > 0) {
                let cause = format!("byteLength is {}, but there are only {length} bytes", buffer.byte_length.0);
                return Err(self.malformed(location, cause));
            }
            self.buffers.push(range);
        }
        self.bytes = bytes;
        for buffer in &mut self.json.buffers {
            buffer.uri = None;
        }
        Ok(())
    }
}

/// Where the JSON chunk and the binary chunk of a GLB lie in the file.
fn glb_chunks(
    path: &Path,
    file: &[u8],
    warnings: &mut Vec<String>,
) -> Result<(Range<usize>, Option<Range<usize>>), Error> {
    let word = |at: usize| {
        let bytes = file.get(at..)?.first_chunk::<4>()?;
        Some(u32::from_le_bytes(*bytes))
    };
    let cut_off = |at: usize| Error::malformed(path, format!("byte {at}"), "the file is cut off");
    let version = word(4).ok_or_else(|| cut_off(file.len()))?;
    if version != 2 {
        return Err(Error::unsupported(path, format!("version {version} of GLB"), "export the scene as glTF 2.0"));
    }
    let length = word(8).ok_or_else(|| cut_off(file.len()))? as usize;
    if length > file.len() {
        let cause = format!("the file is cut off: its header says {length} bytes, but there are {}", file.len());
        return Err(Error::malformed(path, "byte 8", cause));
    }
    const JSON: u32 = u32::from_le_bytes(*b"JSON");
    const BINARY: u32 = u32::from_le_bytes(*b"BIN\0");
    let (mut json, mut binary) = (None, None);
    let mut at = 12;
    while at + 8 <= length {
        let (Some(chunk_length), Some(kind)) = (word(at), word(at + 4)) else { return Err(cut_off(at)) };
        let first = at + 8;
        let end = first.checked_add(chunk_length as usize).filter(|&end| end <= length).ok_or_else(|| {
            let cause = format!("a chunk of {chunk_length} bytes reaches beyond the file's {length} bytes");
            Error::malformed(path, format!("byte {at}"), cause)
        })?;
        match kind {
            JSON if json.is_none() => json = Some(first..end),
            BINARY if binary.is_none() => binary = Some(first..end),
            // The format asks readers to skip chunks that they don't know.
            _ => {}
        }
        let padded = end.next_multiple_of(4);
        let is_chunk = |at: usize| {
            let fits = word(at).is_some_and(|chunk| at as u64 + 8 + u64::from(chunk) <= length as u64);
            fits && matches!(word(at + 4), Some(JSON | BINARY))
        };
        at = if is_chunk(end) && !is_chunk(padded) { end } else { padded };
        if at != padded {
            warnings.push(format!(
                "the chunk of {chunk_length} bytes is not padded to four; the next was read right behind it"
            ));
        }
    }
    let json = json.ok_or_else(|| Error::malformed(path, "byte 12", "there is no JSON chunk"))?;
    Ok((json, binary))
}

/// Takes the memory of a parsed JSON text: its bytes, and an allowance for each object and each value. The largest of
/// glTF's objects, nodes and materials, may be written `{}`.
fn take_for_json(text: &[u8], budget: &Budget) -> Result<(), String> {
    const OF_OBJECT: u64 = 1024;
    const OF_VALUE: u64 = 32;
    let bytes = text.iter().fold(text.len() as u64, |bytes, letter| match letter {
        b'{' => bytes + OF_OBJECT,
        b',' | b'[' => bytes + OF_VALUE,
        _ => bytes,
    });
    budget.take(bytes, "the JSON")
}

/// JSON without its byte order mark, and without the zeros with which some writers fill up the JSON chunk.
fn trimmed(text: &[u8]) -> &[u8] {
    let text = text.strip_prefix(MARK).unwrap_or(text);
    &text[..text.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1)]
}

fn parse(path: &Path, text: &[u8], warnings: &mut Vec<String>) -> Result<(Root, Vec<PointerChannel>), Error> {
    let text = trimmed(text);
    let (json, pointers) = match Root::from_slice(text) {
        Ok(json) => (json, Vec::new()),
        Err(error) => parse_leniently(path, text, &error, warnings)?,
    };
    let version = &json.asset.version;
    if !version.starts_with("2.") || json.asset.min_version.as_deref().is_some_and(|version| version != "2.0") {
        return Err(unsupported_version(path, json.asset.min_version.as_ref().unwrap_or(version)));
    }
    Ok((json, pointers))
}

fn unsupported_version(path: &Path, version: &str) -> Error {
    Error::unsupported(path, format!("glTF {version}"), "export the scene as glTF 2.0")
}

/// Parses JSON that is legal glTF but that the parsing library, whose `error` this is, refuses: scenes without nodes, animation
/// channels without a target node, of which those with pointers are kept, `extras` that are no objects and whole numbers that are
/// written as `1.0`.
///
/// # Errors
/// Where it is broken in other ways.
fn parse_leniently(
    path: &Path,
    text: &[u8],
    error: &serde_json::Error,
    warnings: &mut Vec<String>,
) -> Result<(Root, Vec<PointerChannel>), Error> {
    let malformed = |error: &serde_json::Error| Error::malformed(path, "JSON", error.to_string());
    let mut json: Value = serde_json::from_slice(text).map_err(|_| malformed(error))?;
    if let Some(version) = json.pointer("/asset/version").and_then(Value::as_str)
        && !version.starts_with("2.")
    {
        return Err(unsupported_version(path, version));
    }
    fn elements<'a>(parent: &'a mut Value, name: &str) -> impl Iterator<Item = &'a mut Value> {
        parent.get_mut(name).and_then(Value::as_array_mut).into_iter().flatten()
    }
    let is_loose = tighten(&mut json);
    for scene in elements(&mut json, "scenes").filter_map(Value::as_object_mut) {
        scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
    }
    let (mut left_out, mut pointers) = (0, Vec::new());
    for (number, animation) in elements(&mut json, "animations").enumerate() {
        pointers.extend(pointers::resolve(number, animation));
        if let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) {
            channels.retain(|channel| pointers::pointer(channel).is_none());
            let all = channels.len();
            channels.retain(|channel| channel.pointer("/target/node").is_some());
            left_out += all - channels.len();
        }
    }
    // The first error has a position, but may be about a part that was mended.
    let root = serde_json::from_value(json).map_err(|second| malformed(if is_loose { &second } else { error }))?;
    if left_out > 0 {
        warnings.push(format!("{left_out} animation channels were left out, as they move something else than a node"));
    }
    Ok((root, pointers))
}

/// Removes `extras`, which may be anything, and writes whole numbers without a fraction or an exponent; returns whether
/// it changed any. Goes no deeper than JSON is parsed.
fn tighten(json: &mut Value) -> bool {
    /// Integers up to this one are exact in f64.
    const MOST: f64 = (1_u64 << 53) as f64;
    match json {
        Value::Object(members) => {
            let had_extras = members.remove("extras").is_some();
            members.values_mut().fold(had_extras, |changed, value| tighten(value) | changed)
        }
        Value::Array(values) => values.iter_mut().fold(false, |changed, value| tighten(value) | changed),
        Value::Number(number) if number.is_f64() => {
            let whole = number.as_f64().filter(|value| value.fract() == 0.0 && value.abs() <= MOST);
            let whole = whole.filter(|value| !(*value == 0.0 && value.is_sign_negative()));
            if let Some(whole) = whole {
                *json = Value::from(whole as i64);
            }
            whole.is_some()
        }
        _ => false,
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
