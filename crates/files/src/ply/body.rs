use super::header::{Element, Encoding, PropertyKind};
use crate::scalar::Scalar;
use crate::text::{Lines, number, quoted};

/// Reads a PLY file's values one after the other.
#[derive(Clone, Debug)]
pub(super) enum Body<'a> {
    /// One row a line.
    Ascii {
        lines: Lines<'a>,
        /// The rest of the row's line.
        row: &'a [u8],
    },
    Binary {
        rest: &'a [u8],
        big_endian: bool,
    },
}

impl<'a> Body<'a> {
    pub(super) fn new(encoding: Encoding, bytes: &'a [u8]) -> Self {
        match encoding {
            Encoding::Ascii => Self::Ascii { lines: Lines::new(bytes), row: &[] },
            Encoding::LittleEndian => Self::Binary { rest: bytes, big_endian: false },
            Encoding::BigEndian => Self::Binary { rest: bytes, big_endian: true },
        }
    }

    /// Number of bytes after the current row's line, or after the last value read.
    pub(super) fn bytes_left(&self) -> usize {
        match self {
            Self::Ascii { lines, .. } => lines.rest().len(),
            Self::Binary { rest, .. } => rest.len(),
        }
    }

    /// Whether the rest of a text is white space.
    pub(super) fn is_blank(&self) -> bool {
        match self {
            Self::Ascii { lines, .. } => lines.rest().trim_ascii().is_empty(),
            Self::Binary { rest, .. } => rest.is_empty(),
        }
    }

    /// Calls `read` for each row of an element.
    ///
    /// # Errors
    /// The row's index, and the reason in words.
    pub(super) fn each_row(
        &mut self,
        element: &Element,
        mut read: impl FnMut(&mut Self) -> Result<(), String>,
    ) -> Result<(), (u64, String)> {
        let mut read_row = || self.begin_row().and_then(|()| read(self));
        (0..element.count).try_for_each(|row| read_row().map_err(|cause| (row, cause)))
    }

    /// Goes to the next row: in ASCII, to the next line that isn't blank.
    ///
    /// # Errors
    /// Where the file ends.
    fn begin_row(&mut self) -> Result<(), String> {
        if let Self::Ascii { lines, row } = self {
            *row =
                lines.map(|(_, line)| line.trim_ascii()).find(|line| !line.is_empty()).ok_or("the file ends here")?;
        }
        Ok(())
    }

    /// The next value, exact for every type.
    ///
    /// # Errors
    /// Where the row or the file ends, or a word isn't a number of the type.
    pub(super) fn value(&mut self, scalar: Scalar) -> Result<f64, String> {
        match self {
            Self::Ascii { row, .. } => {
                let end = row.iter().position(u8::is_ascii_whitespace).unwrap_or(row.len());
                let word = &row[..end];
                if word.is_empty() {
                    return Err("the line has too few values".to_owned());
                }
                *row = row[end..].trim_ascii_start();
                parse(word, scalar)
            }
            Self::Binary { rest, big_endian } => {
                let (value, after) = rest.split_at_checked(scalar.bytes()).ok_or("the file ends here")?;
                *rest = after;
                Ok(scalar.decode(value, *big_endian))
            }
        }
    }

    /// The next list's length.
    ///
    /// # Errors
    /// As [`Body::value`], and where it isn't a whole number from 0, or is longer than the rest of the file.
    pub(super) fn list_length(&mut self, count: Scalar, item: Scalar) -> Result<usize, String> {
        let length = self.value(count)?;
        if length < 0.0 || length.fract() != 0.0 {
            return Err(format!("{length} is not the length of a list"));
        }
        let room = match self {
            Self::Ascii { row, .. } => row.len().div_ceil(2),
            Self::Binary { rest, .. } => rest.len() / item.bytes(),
        };
        if length > room as f64 {
            return Err(format!("a list of {length} values where at most {room} are left"));
        }
        Ok(length as usize)
    }

    /// Skips a property.
    ///
    /// # Errors
    /// As [`Body::value`] and [`Body::list_length`].
    pub(super) fn skip(&mut self, kind: PropertyKind) -> Result<(), String> {
        match kind {
            PropertyKind::Scalar(scalar) => self.value(scalar).map(drop),
            PropertyKind::List { count, item } => {
                let length = self.list_length(count, item)?;
                match self {
                    Self::Ascii { .. } => (0..length).try_for_each(|_| self.value(item).map(drop)),
                    Self::Binary { rest, .. } => {
                        // In range: the length was compared with the rest of the file.
                        *rest = &rest[length * item.bytes()..];
                        Ok(())
                    }
                }
            }
        }
    }
}

/// The number that `word` spells, rounded to its type as a binary file would hold it.
fn parse(word: &[u8], scalar: Scalar) -> Result<f64, String> {
    let Some((lowest, highest)) = scalar.whole_range() else {
        return if scalar == Scalar::F32 { number::<f32>(word).map(f64::from) } else { number(word) };
    };
    // Some writers spell whole numbers as `3.0`.
    let value: f64 = number(word)?;
    if value.fract() == 0.0 && (lowest..=highest).contains(&value) {
        Ok(value)
    } else {
        Err(format!("{} is not a whole number from {lowest} to {highest}", quoted(word)))
    }
}
