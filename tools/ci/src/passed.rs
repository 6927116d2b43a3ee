use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// The file with the inputs with which each part has passed.
pub(crate) const FILE: &str = "tools/ci/passed.toml";

const HEADING: &str = "\
# Each part of the checks, with the hash of its inputs when it last passed, and the seconds that it took then on the clock and
# on all processors. `cargo run -p ci` writes it; with `-- --changed` it runs the parts whose inputs have another hash now.
";

/// Parts that have passed, by name.
#[derive(Debug)]
pub(crate) struct Passed {
    path: PathBuf,
    parts: BTreeMap<String, Pass>,
}

/// Inputs and times of a part's last pass.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pass {
    /// The hash of its inputs.
    pub(crate) inputs: String,
    pub(crate) seconds: f64,
    /// 0 if the system doesn't tell.
    pub(crate) cpu_seconds: f64,
}

impl Passed {
    /// Reads the file; without one no part has passed.
    ///
    /// # Errors
    /// If the file can't be read, or has another format than this program's.
    pub(crate) fn read(root: &Path) -> Result<Self, String> {
        let path = root.join(FILE);
        let text = if path.is_file() { crate::repository::read(&path)? } else { String::new() };
        let mut parts = BTreeMap::new();
        for (part, keys) in read_tables(&text).map_err(|why| format!("{FILE}: {why}"))?.into_iter().skip(1) {
            let value = |of: &str| keys.iter().find(|(key, _)| key == of).map(|(_, value)| value.as_str());
            let number = |of: &str| value(of).and_then(|text| text.parse().ok());
            let pass = value("inputs").zip(number("seconds")).zip(number("cpu_seconds"));
            let ((inputs, seconds), cpu_seconds) = pass.ok_or_else(|| format!("{FILE}: {part} lacks a value"))?;
            parts.insert(part, Pass { inputs: inputs.to_owned(), seconds, cpu_seconds });
        }
        Ok(Self { path, parts })
    }

    /// The part's pass with these inputs; `None` if it is due.
    pub(crate) fn with_inputs(&self, part: &str, inputs: &str) -> Option<&Pass> {
        self.parts.get(part).filter(|pass| pass.inputs == inputs)
    }

    /// Records a part that has passed, in the file as well.
    ///
    /// # Errors
    /// If the file can't be written.
    pub(crate) fn record(&mut self, part: &str, pass: Pass) -> Result<(), String> {
        self.parts.insert(part.to_owned(), pass);
        let mut text = HEADING.to_owned();
        for (part, Pass { inputs, seconds, cpu_seconds }) in &self.parts {
            // Writing to a string can't fail.
            let _ = write!(
                text,
                "\n[\"{part}\"]\ninputs = \"{inputs}\"\nseconds = {seconds:.1}\ncpu_seconds = {cpu_seconds:.1}\n"
            );
        }
        fs::write(&self.path, text).map_err(|error| format!("{}: {error}", self.path.display()))
    }
}

/// A table of TOML: its name, empty for the one at the start, and its keys and values without quotes.
pub(crate) type Table = (String, Vec<(String, String)>);

/// Reads the TOML that this program writes: comments, `["table"]`, and `"key" = value` with a string or a number.
///
/// # Errors
/// If a line is none of these; names the line.
pub(crate) fn read_tables(text: &str) -> Result<Vec<Table>, String> {
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
    fn records_are_read_again() {
        let root = tempfile::tempdir().unwrap();
        fs::create_dir_all(root.path().join(FILE).parent().unwrap()).unwrap();
        let mut passed = Passed::read(root.path()).unwrap();
        let pass = |inputs: &str| Pass { inputs: inputs.to_owned(), seconds: 1.5, cpu_seconds: 3.0 };
        passed.record("long tests", pass("0a")).unwrap();
        passed.record("page", pass("0b")).unwrap();
        passed.record("page", pass("0c")).unwrap();
        let passed = Passed::read(root.path()).unwrap();
        assert_eq!(passed.with_inputs("long tests", "0a"), Some(&pass("0a")));
        assert_eq!(passed.with_inputs("page", "0c"), Some(&pass("0c")));
        assert_eq!((passed.with_inputs("page", "0b"), passed.with_inputs("python", "0a")), (None, None));
        fs::write(root.path().join(FILE), "[\"page\"]\nseconds = 1\n").unwrap();
        assert!(Passed::read(root.path()).unwrap_err().contains("page lacks a value"));
    }

    #[test]
    fn tables_and_keys_are_read() {
        let tables = read_tables("# none\n\"a b\" = 1.5\n\n[\"c d\"]\ne = \"f\"\n").unwrap();
        let pair = |key: &str, value: &str| vec![(key.to_owned(), value.to_owned())];
        assert_eq!(tables, [(String::new(), pair("a b", "1.5")), ("c d".to_owned(), pair("e", "f"))]);
        assert!(read_tables("a = 1\nb\n").unwrap_err().starts_with("line 2"));
    }
}
