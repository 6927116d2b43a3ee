use std::path::Path;

use crate::Error;
use crate::text::{Lines, number, quoted, words};

/// What a PLY file says about itself before its values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    /// In the order in which their values come.
    pub(super) elements: Vec<Element>,
    /// How many bytes the header takes.
    pub(super) bytes: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// A kind of thing that the file lists, for instance its vertices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) name: String,
    /// How many the header claims; nothing may be allocated on its word.
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

/// A type of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &[u8]) -> Result<Self, String> {
        Ok(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return Err(format!("unknown type {}", quoted(name))),
        })
    }

    /// How many bytes a value takes in a binary file.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

impl Element {
    /// The fewest bytes that one of this element can take: its lists empty, its words one digit long.
    pub(super) fn least_bytes(&self, encoding: Encoding) -> usize {
        let least = |property: &Property| match (encoding, property.kind) {
            (Encoding::Ascii, _) => 2,
            (_, Kind::Scalar(scalar) | Kind::List { count: scalar, .. }) => scalar.bytes(),
        };
        self.properties.iter().map(least).sum()
    }
}

impl Header {
    /// The longest header that is read, in bytes.
    const MAX_BYTES: usize = 1 << 20;

    /// Reads the header at the start of `bytes`.
    ///
    /// # Errors
    /// Names the line that breaks the format.
    pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Self, Error> {
        let mut lines = Lines::new(bytes);
        if lines.next().is_none_or(|(_, line)| line.trim_ascii_end() != b"ply") {
            return Err(Error::malformed(path, "line 1", "not a PLY file: the first line is not `ply`"));
        }
        let mut encoding = None;
        let mut elements = Vec::new();
        let mut last = 1;
        while let Some((line_number, line)) = lines.next() {
            last = line_number;
            let malformed = |cause| Error::malformed(path, format!("line {line_number}"), cause);
            let bytes = bytes.len() - lines.rest().len();
            if bytes > Self::MAX_BYTES {
                return Err(malformed(format!("no `end_header` in the first {} bytes", Self::MAX_BYTES)));
            }
            if line.trim_ascii() == b"end_header" {
                let encoding = encoding
                    .ok_or_else(|| Error::malformed(path, "header", "no `format` line says how values are encoded"))?;
                return Ok(Self { encoding, elements, bytes });
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
                b"list" => Kind::List { count: Scalar::named(word())?, item: Scalar::named(word())? },
                name => Kind::Scalar(Scalar::named(name)?),
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

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Header, String> {
        Header::parse(Path::new("a.ply"), text.as_bytes()).map_err(|error| error.to_string())
    }

    #[test]
    fn a_header_lists_elements_and_their_properties_in_order() {
        let text = "ply\r\nformat binary_big_endian 1.0\r\ncomment by hand\r\nelement vertex 3\r\n\
                    property double x\r\nobj_info none\r\nelement face 1\r\nproperty list uint8 int32 vertex_index\r\n\
                    end_header\r\nrest";
        let header = parse(text).unwrap();
        assert_eq!(header.encoding, Encoding::BigEndian);
        assert_eq!(&text[header.bytes..], "rest");
        let property = |name: &str, kind| Property { name: name.to_owned(), kind };
        let [vertex, face] = header.elements.as_slice() else { panic!("{header:?}") };
        assert_eq!((vertex.name.as_str(), vertex.count), ("vertex", 3));
        assert_eq!(vertex.properties, [property("x", Kind::Scalar(Scalar::F64))]);
        let list = Kind::List { count: Scalar::U8, item: Scalar::I32 };
        assert_eq!(face.properties, [property("vertex_index", list)]);
        assert_eq!((vertex.least_bytes(header.encoding), face.least_bytes(header.encoding)), (8, 1));
    }

    #[test]
    fn broken_headers_name_their_line() {
        for (text, expected) in [
            ("", "line 1"),
            ("plyx\n", "line 1"),
            ("ply\nformat ascii 1.0\n", "line 2: the file ends before `end_header`"),
            ("ply\nformat utf7 1.0\n", "line 2: unknown format `utf7`"),
            ("ply\nelement vertex -3\n", "line 2: `-3` is not a number"),
            ("ply\nelement vertex\n", "line 2: an element without a count"),
            ("ply\nproperty float x\n", "line 2: a property before the first element"),
            ("ply\nelement vertex 1\nproperty half x\n", "line 3: unknown type `half`"),
            ("ply\nelement vertex 1\nproperty list uchar x\n", "line 3: unknown type `x`"),
            ("ply\nelement vertex 1\nproperty float\n", "line 3: a property without a name"),
            ("ply\nend_header\n", "header: no `format` line"),
            ("ply\nsurprise\n", "line 2: `surprise` is no header line"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(expected), "{text:?}: {error}");
        }
    }

    #[test]
    fn an_endless_header_is_given_up() {
        let comments = format!("ply\n{}", "comment\n".repeat(200_000));
        assert!(parse(&comments).unwrap_err().contains("no `end_header` in the first 1048576 bytes"));
        let one_line = format!("ply\ncomment {}", "x".repeat(2_000_000));
        let error = parse(&one_line).unwrap_err();
        assert!(error.contains("no `end_header`") && error.len() < 200, "{error}");
    }
}
