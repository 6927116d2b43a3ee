/// A table of TOML: its name, empty for the one at the start, and its keys and values without quotes.
pub(crate) type Table = (String, Vec<(String, String)>);

/// Reads the TOML that this program writes: comments, `["table"]`, and `"key" = value` with a string or a number.
///
/// # Errors
/// If a line is none of these; names the line.
pub(crate) fn read(text: &str) -> Result<Vec<Table>, String> {
    let mut tables: Vec<Table> = vec![(String::new(), Vec::new())];
    let word = |text: &str| text.trim().trim_matches('"').to_owned();
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim();
        if let Some(name) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
            tables.push((word(name), Vec::new()));
        } else if let (Some((key, value)), Some((_, keys))) = (line.split_once('='), tables.last_mut()) {
            keys.push((word(key), word(value)));
        } else if !line.is_empty() && !line.starts_with('#') {
            return Err(format!("line {number}: neither a table nor a key and its value"));
        }
    }
    Ok(tables)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_and_keys_are_read() {
        let tables = read("# none\n\"a b\" = 1.5\n\n[\"c d\"]\ne = \"f\"\n").unwrap();
        let pair = |key: &str, value: &str| vec![(key.to_owned(), value.to_owned())];
        assert_eq!(tables, [(String::new(), pair("a b", "1.5")), ("c d".to_owned(), pair("e", "f"))]);
        assert!(read("a = 1\nb\n").unwrap_err().starts_with("line 2"));
    }
}
