use std::str::FromStr;

/// UTF-8's byte order mark, which some editors put before a text.
pub(crate) const MARK: &[u8] = b"\xEF\xBB\xBF";

/// The lines of a text without their ends (LF, CRLF or CR) and without its byte order mark, each with its number, counted from
/// 1.
#[derive(Clone, Debug)]
pub(crate) struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    pub(crate) fn new(text: &'a [u8]) -> Self {
        Self { rest: text.strip_prefix(MARK).unwrap_or(text), number: 0 }
    }

    /// The text after the lines returned so far.
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
        let end = self.rest.iter().position(|&byte| byte == b'\n' || byte == b'\r').unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(end);
        self.rest = rest.strip_prefix(b"\r\n").or_else(|| rest.get(1..)).unwrap_or_default();
        self.number += 1;
        Some((self.number, line))
    }
}

/// The words of a line, separated by any white space.
pub(crate) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> + Clone {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// The line's first word, and the rest without white space around it. Both are empty for an empty line.
pub(crate) fn keyword(line: &[u8]) -> (&[u8], &[u8]) {
    let line = line.trim_ascii();
    let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    (&line[..end], line[end..].trim_ascii_start())
}

/// Parses a number. Floating-point types accept NaN and infinity, also in the spelling of Microsoft's libraries (`-1.#IND`,
/// `1.#INF00`, `nan(ind)`).
///
/// # Errors
/// A message, where the word isn't a number of this type.
pub(crate) fn number<T: FromStr>(word: &[u8]) -> Result<T, String> {
    std::str::from_utf8(word)
        .ok()
        .and_then(|word| word.parse().or_else(|_| no_number(word).parse()).ok())
        .ok_or_else(|| format!("{} is not a number that fits here", quoted(word)))
}

/// Translates Microsoft's spellings of infinity and NaN to Rust's; empty for other words.
fn no_number(word: &str) -> &'static str {
    let (is_negative, word) = match word.strip_prefix('-') {
        Some(word) => (true, word),
        None => (false, word.strip_prefix('+').unwrap_or(word)),
    };
    match word.strip_prefix("1.#") {
        // `J` is `INF` rounded to one digit.
        Some(kind) if kind.starts_with("INF") || kind.starts_with('J') => {
            if is_negative {
                "-inf"
            } else {
                "inf"
            }
        }
        Some(_) => "nan",
        None if word.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("nan(")) => "nan",
        None => "",
    }
}

/// Formats `text` for an error message: in back quotes, on one line, cut to 40 characters.
pub(crate) fn quoted(text: &[u8]) -> String {
    const MAX_CHARS: usize = 40;
    // A character takes at most four bytes; the rest of a huge text needn't be decoded.
    let text_start = String::from_utf8_lossy(&text[..text.len().min(4 * MAX_CHARS + 4)]);
    let shown: String = text_start
        .chars()
        .take(MAX_CHARS)
        .map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c })
        .collect();
    let more = if text_start.chars().count() > MAX_CHARS { "…" } else { "" };
    format!("`{shown}{more}`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_as_on_any_system() {
        let lines = |text: &'static str| {
            let lines = Lines::new(text.as_bytes());
            lines.map(|(number, line)| format!("{number}{}", String::from_utf8_lossy(line))).collect::<Vec<_>>()
        };
        for text in ["a\nb\n\nc", "a\r\nb\r\n\r\nc\r\n", "a\rb\r\rc\r", "\u{feff}a\nb\r\rc\r\n"] {
            assert_eq!(lines(text), ["1a", "2b", "3", "4c"], "{text:?}");
        }
        assert_eq!(lines(""), [""; 0]);
        assert_eq!(lines("\u{feff}"), [""; 0]);
    }

    #[test]
    fn numbers_that_are_none_have_microsofts_spellings_too() {
        for word in ["nan", "-nan", "-nan(ind)", "nan(snan)", "NaN(ind)", "1.#QNAN", "-1.#IND", "1.#IND00", "1.#SNAN"] {
            assert!(number::<f32>(word.as_bytes()).unwrap().is_nan(), "{word}");
        }
        for (word, infinite) in [("1.#INF", f64::INFINITY), ("-1.#INF000", f64::NEG_INFINITY), ("+1.#J", f64::INFINITY)]
        {
            assert_eq!(number(word.as_bytes()), Ok(infinite), "{word}");
        }
        assert!(number::<f32>(b"1.5#IND").is_err() && number::<f32>(b"ind").is_err() && number::<f32>(b"").is_err());
        assert!(number::<u32>(b"1.#IND").is_err() && number::<i64>(b"nan(ind)").is_err());
    }
}
