use std::path::Path;

use umbrage_scene::Error;

use crate::scalar::Scalar;
use crate::text::{Lines, number, quoted, words};

/// The header of a PLY file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    /// In the order of their values.
    pub(super) elements: Vec<Element>,
    /// Length of the header in bytes.
    pub(super) bytes: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// A kind of record that the file lists, for instance vertices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) name: String,
    /// Number claimed by the header; untrusted, so nothing is allocated by it.
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: PropertyKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PropertyKind {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

impl Element {
    /// Minimum bytes of one record: empty lists and words of one digit.
    pub(super) fn least_bytes(&self, encoding: Encoding) -> usize {
        let least = |property: &Property| match (encoding, property.kind) {
            (Encoding::Ascii, _) => 2,
            (_, PropertyKind::Scalar(scalar) | PropertyKind::List { count: scalar, .. }) => scalar.bytes(),
        };
        self.properties.iter().map(least).sum()
    }
}

impl Header {
    /// Maximum length of a header in bytes.
    const MAX_BYTES: usize = 1 << 20;

    /// Reads the header at the start of `text`.
    ///
    /// # Errors
    /// Names the line that breaks the format.
    pub(super) fn parse(path: &Path, text: &[u8]) -> Result<Self, Error> {
        let mut lines = Lines::new(text);
        if lines.next().is_none_or(|(_, line)| line.trim_ascii_end() != b"ply") {
            return Err(Error::malformed(path, "line 1", "not a PLY file: the first line is not `ply`"));
        }
        let first = &text[..text.len() - lines.rest().len()];
        let ends_in_cr = first.ends_with(b"\r");
        let mut encoding = None;
        let mut elements = Vec::new();
        let mut last = 1;
        while let Some((line_number, line)) = lines.next() {
            last = line_number;
            let malformed = |cause| Error::malformed(path, format!("line {line_number}"), cause);
            let bytes = text.len() - lines.rest().len();
            if bytes > Self::MAX_BYTES {
                return Err(malformed(format!("no `end_header` in the first {} bytes", Self::MAX_BYTES)));
            }
            if line.trim_ascii() == b"end_header" {
                let encoding = encoding
                    .ok_or_else(|| Error::malformed(path, "header", "no `format` line says how values are encoded"))?;
                // With lines that end in CR, a newline byte here belongs to the first value.
                let is_value = encoding != Encoding::Ascii && ends_in_cr && text[..bytes].ends_with(b"\r\n");
                return Ok(Self { encoding, elements, bytes: bytes - usize::from(is_value) });
            }
            statement(line, &mut encoding, &mut elements).map_err(malformed)?;
        }
        Err(Error::malformed(path, format!("line {last}"), "the file ends before `end_header`"))
    }
}

fn statement(line: &[u8], encoding: &mut Option<Encoding>, elements: &mut Vec<Element>) -> Result<(), String> {
    let mut words = words(line);
    let keyword = words.next().unwrap_or_default();
    match keyword {
        b"" | b"comment" | b"obj_info" => {}
        b"format" => {
            *encoding = Some(match words.next().unwrap_or_default() {
                b"ascii" => Encoding::Ascii,
                b"binary_little_endian" => Encoding::LittleEndian,
                b"binary_big_endian" => Encoding::BigEndian,
                other => return Err(format!("unknown format {}", quoted(other))),
            });
        }
        b"element" => {
            let name = words.next().ok_or("an element without a name")?;
            let count = number(words.next().ok_or("an element without a count")?)?;
            elements.push(Element { name: lossy(name), count, properties: Vec::new() });
        }
        b"property" => {
            let element = elements.last_mut().ok_or("a property before the first element")?;
            let mut word = || words.next().unwrap_or_default();
            let kind = match word() {
                b"list" => PropertyKind::List { count: scalar(word())?, item: scalar(word())? },
                name => PropertyKind::Scalar(scalar(name)?),
            };
            let name = words.next().ok_or("a property without a name")?;
            element.properties.push(Property { name: lossy(name), kind });
        }
        other => return Err(format!("{} is no header line", quoted(other))),
    }
    Ok(())
}

fn lossy(name: &[u8]) -> String {
    String::from_utf8_lossy(name).into_owned()
}

fn scalar(name: &[u8]) -> Result<Scalar, String> {
    Ok(match name {
        b"char" | b"int8" => Scalar::I8,
        b"uchar" | b"uint8" => Scalar::U8,
        b"short" | b"int16" => Scalar::I16,
        b"ushort" | b"uint16" => Scalar::U16,
        b"int" | b"int32" => Scalar::I32,
        b"uint" | b"uint32" => Scalar::U32,
        b"float" | b"float32" => Scalar::F32,
        b"double" | b"float64" => Scalar::F64,
        _ => return Err(format!("unknown type {}", quoted(name))),
    })
}
