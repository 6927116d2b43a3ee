use std::str::FromStr;

/// The lines of a text without their ends (LF or CRLF), each with its number, counted from 1.
#[derive(Clone, Debug)]
pub(crate) struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    pub(crate) fn new(text: &'a [u8]) -> Self {
        Self { rest: text, number: 0 }
    }

    /// What comes after the lines given so far.
    pub(crate) fn rest(&self) -> &'a [u8] {
        self.rest
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let (line, rest) = match self.rest.iter().position(|&byte| byte == b'\n') {
            Some(end) => (&self.rest[..end], &self.rest[end + 1..]),
            None => (self.rest, &[][..]),
        };
        self.rest = rest;
        self.number += 1;
        Some((self.number, line.strip_suffix(b"\r").unwrap_or(line)))
    }
}

/// The words of a line, however much white space separates them.
pub(crate) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> + Clone {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// The line's first word, and the rest without white space around it. Both are empty for an empty line.
pub(crate) fn keyword(line: &[u8]) -> (&[u8], &[u8]) {
    let line = line.trim_ascii();
    let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    (&line[..end], line[end..].trim_ascii_start())
}

/// The number that `word` spells; NaN and infinity count as numbers for floating-point types.
///
/// # Errors
/// Says in words that it spells none.
pub(crate) fn number<T: FromStr>(word: &[u8]) -> Result<T, String> {
    std::str::from_utf8(word)
        .ok()
        .and_then(|word| word.parse().ok())
        .ok_or_else(|| format!("{} is not a number that fits here", quoted(word)))
}

/// `text` as an error message shows it: in back quotes, on one line and not longer than a person wants to read.
pub(crate) fn quoted(text: &[u8]) -> String {
    const MAX_CHARS: usize = 40;
    // No character takes more than four bytes, so that a huge text isn't decoded for its first words.
    let text_start = String::from_utf8_lossy(&text[..text.len().min(4 * MAX_CHARS + 4)]);
    let shown: String = text_start
        .chars()
        .take(MAX_CHARS)
        .map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c })
        .collect();
    let more = if text_start.chars().count() > MAX_CHARS { "…" } else { "" };
    format!("`{shown}{more}`")
}
