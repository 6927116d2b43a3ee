use std::cmp::Ordering;

use wildmatch::WildMatch;

/// A file-name pattern.
#[derive(Debug)]
pub(super) enum Pattern {
    /// A number between two texts, padded with zeros to `width` digits, as by `printf`.
    Number { prefix: String, width: usize, suffix: String },
    /// `*` for any characters and `?` for any one.
    Wildcard(WildMatch),
}

impl Pattern {
    /// Maximum width of a number in digits.
    const MAX_WIDTH: usize = 20;

    /// Parses `name` as a pattern; `None` for a plain name.
    ///
    /// # Errors
    /// A message why the pattern is invalid.
    pub(super) fn parse(name: &str) -> Result<Option<Self>, String> {
        let Some((before, after)) = name.split_once('%') else {
            let is_wildcard = name.contains(['*', '?']);
            return Ok(is_wildcard.then(|| Self::Wildcard(WildMatch::new(name))));
        };
        let digits = after.len() - after.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let (width, conversion) = after.split_at(digits);
        let Some(suffix) = conversion.strip_prefix('d') else {
            return Err("after `%`, write `d` or, for four digits with zeros, `04d`".to_owned());
        };
        if suffix.contains(['%', '*', '?']) || before.contains(['*', '?']) {
            return Err("a pattern has one `%d`, or else `*` and `?`".to_owned());
        }
        let padded = width.is_empty() || width.starts_with('0');
        let width = width.parse().unwrap_or(if width.is_empty() { 1 } else { usize::MAX });
        if !padded || width > Self::MAX_WIDTH {
            return Err(format!("`%` takes a width of up to {} digits, with a zero before it", Self::MAX_WIDTH));
        }
        Ok(Some(Self::Number { prefix: before.to_owned(), width, suffix: suffix.to_owned() }))
    }

    pub(super) fn matches(&self, name: &str) -> bool {
        match self {
            Self::Number { prefix, width, suffix } => {
                let digits = name.strip_prefix(prefix.as_str()).and_then(|rest| rest.strip_suffix(suffix.as_str()));
                digits.is_some_and(|digits| {
                    let written = digits.parse().map(|number: u64| format!("{number:0width$}"));
                    written.is_ok_and(|written| written == digits)
                })
            }
            Self::Wildcard(pattern) => pattern.matches(name),
        }
    }
}

/// Each number in a name's stem, with the text before and after it.
pub(super) fn numbers(name: &str) -> Vec<(&str, u64, &str)> {
    let stem_end = name.rfind('.').unwrap_or(name.len());
    let bytes = name.as_bytes();
    let mut found = Vec::new();
    let mut start = 0;
    while start < stem_end {
        let end = (start..stem_end).find(|&at| !bytes[at].is_ascii_digit()).unwrap_or(stem_end);
        // A number that doesn't fit counts as text.
        if let Ok(number) = name[start..end].parse() {
            found.push((&name[..start], number, &name[end..]));
        }
        start = (end..stem_end).find(|&at| bytes[at].is_ascii_digit()).unwrap_or(stem_end);
    }
    found
}

/// Natural order: compares numbers in names by value, ignoring leading zeros, and texts by character.
pub(super) fn natural_order(a: &str, b: &str) -> Ordering {
    let (mut left, mut right) = (a, b);
    loop {
        let ((text_left, digits_left, rest_left), (text_right, digits_right, rest_right)) = (split(left), split(right));
        let (value_left, value_right) = (digits_left.trim_start_matches('0'), digits_right.trim_start_matches('0'));
        let order = (text_left.cmp(text_right))
            .then_with(|| digits_left.is_empty().cmp(&digits_right.is_empty()).reverse())
            .then_with(|| value_left.len().cmp(&value_right.len()))
            .then_with(|| value_left.cmp(value_right));
        if order != Ordering::Equal {
            return order;
        }
        if rest_left.is_empty() && rest_right.is_empty() {
            return a.cmp(b);
        }
        (left, right) = (rest_left, rest_right);
    }
}

/// The text before the first digit, the digits, and the rest.
fn split(name: &str) -> (&str, &str, &str) {
    let start = name.find(|c: char| c.is_ascii_digit()).unwrap_or(name.len());
    let (text, rest) = name.split_at(start);
    let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    (text, &rest[..end], &rest[end..])
}
