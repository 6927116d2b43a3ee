//! Whether the paths, commands, options and tests that crates/papers/docs/README.md names exist.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use umbrage_verify::structures::STRUCTURES;

/// The repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// All Rust files below a folder, by name without `.rs`.
fn sources(folder: &Path, found: &mut BTreeMap<String, String>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            sources(&path, found)?;
        } else if let Some(name) = path.file_name().and_then(|name| name.to_str()?.strip_suffix(".rs")) {
            found.entry(name.to_owned()).or_default().push_str(&fs::read_to_string(&path)?);
        }
    }
    Ok(())
}

/// Checks a document's words.
struct Checker {
    /// Texts of Rust files; those of the same name together.
    sources: BTreeMap<String, String>,
    commands: String,
}

impl Checker {
    fn new() -> io::Result<Self> {
        let mut found = BTreeMap::new();
        sources(&root().join("crates"), &mut found)?;
        sources(&root().join("apps"), &mut found)?;
        let mut commands = fs::read_to_string(root().join("crates/bench/src/main.rs"))?;
        commands += &fs::read_to_string(root().join("apps/cli/src/flags.rs"))?;
        Ok(Self { sources: found, commands })
    }

    /// Why a word in backquotes doesn't exist; `None` if it does.
    fn fault(&self, word: &str) -> Option<String> {
        let exists = if word.contains("::") {
            self.is_item(word)
        } else if word.starts_with("--") {
            self.is_flag(word)
        } else if let Some((program, arguments)) = word.split_once(' ').filter(|word| word.0.starts_with("umbrage")) {
            let mut arguments = arguments.split(' ');
            let command = arguments.next().unwrap_or_default();
            let is_known = |word: &str| match word.split_once(':') {
                Some((structure, option)) => is_option(structure, option),
                None => !word.starts_with("--") || self.is_flag(word),
            };
            matches!(program, "umbrage" | "umbrage-bench") && self.is_command(command) && arguments.all(is_known)
        } else if let Some((structure, option)) = word.split_once(':') {
            is_option(structure, option)
        } else {
            word.contains('/') && root().join("crates").join(word).exists()
        };
        (!exists).then(|| format!("`{word}` isn't there"))
    }

    /// A test of a file, a structure of the conformance suite, or a public item of a library.
    fn is_item(&self, path: &str) -> bool {
        let Some((module, item)) = path.rsplit_once("::") else { return false };
        match module {
            "conformance" => STRUCTURES.iter().any(|(name, _)| *name == item),
            _ if module.starts_with("umbrage") => {
                let declared =
                    |kind: &str| self.sources.values().any(|text| text.contains(&format!("pub {kind} {item}")));
                ["struct", "enum", "fn"].into_iter().any(declared)
            }
            _ => self.sources.get(module).is_some_and(|text| text.contains(&format!("fn {item}("))),
        }
    }

    fn is_flag(&self, flag: &str) -> bool {
        let name = flag.trim_start_matches("--");
        let (option, field) = (format!("\"{name}\""), format!("{}:", name.replace('-', "_")));
        self.commands.contains(&field) || self.commands.contains(&format!("long = {option}")) || {
            let benches = self.sources.values().filter(|text| text.contains("clap::Args"));
            benches.into_iter().any(|text| text.contains(&field))
        }
    }

    fn is_command(&self, name: &str) -> bool {
        let words = name.split('-').map(|word| word[..1].to_uppercase() + &word[1..]);
        self.commands.contains(&format!("    {}(", words.collect::<String>()))
    }
}

/// Whether a structure has an option.
fn is_option(structure: &str, option: &str) -> bool {
    umbrage_papers::structures().named(structure).is_ok_and(|structure| structure.option(option).is_some())
}

#[test]
fn what_the_table_of_the_papers_names_is_there() {
    let checker = Checker::new().unwrap();
    let document = fs::read_to_string(root().join("crates/papers/docs/README.md")).unwrap();
    let mut faults = Vec::new();
    let mut rows = 0;
    for (number, line) in (1..).zip(document.lines()) {
        let Some(row) = line.strip_prefix('|').and_then(|line| line.strip_suffix('|')) else { continue };
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let mut fault = |fault: String| faults.push(format!("line {number}: {fault}"));
        if let [_, technique, code, reached, test, _, verdict] = cells[..] {
            // A technique without code names no code, and says so.
            let is_built = !code.is_empty();
            if technique.is_empty() || verdict.is_empty() || (is_built && (reached.is_empty() || test.is_empty())) {
                fault("an empty cell".to_owned());
            }
            if !is_built && !verdict.starts_with("not ") && !verdict.starts_with("rayon") {
                fault(format!("no code, and yet `{verdict}`"));
            }
        } else {
            fault(format!("{} cells", cells.len()));
        }
        rows += 1;
        row.split('`').skip(1).step_by(2).filter_map(|word| checker.fault(word)).for_each(&mut fault);
        for target in row.split("](").skip(1).filter_map(|rest| rest.split_once(')')) {
            let file = target.0.split('#').next().unwrap_or_default();
            if !root().join("crates/papers/docs").join(file).exists() {
                fault(format!("{file} isn't there"));
            }
        }
    }
    assert!(rows > 40, "{rows} rows");
    assert!(faults.is_empty(), "crates/papers/docs/README.md:\n{}", faults.join("\n"));
}

#[test]
fn what_is_not_there_is_found() {
    let checker = Checker::new().unwrap();
    for there in [
        "rays/src/lib.rs",
        "listed:slices",
        "--orbit-light",
        "umbrage-bench table1 --lights",
        "umbrage render --engine",
    ]
    .into_iter()
    .chain(["conformance::listed", "papers::what_is_not_there_is_found", "umbrage_papers::KdLayout"])
    {
        assert_eq!(checker.fault(there), None);
    }
    for missing in [
        "rays/src/no.rs",
        "--no-such-flag",
        "umbrage-bench table7",
        "umbrage render --no-flag",
        "sometimes",
        "grid:lazy",
    ]
    .into_iter()
    .chain(["conformance::none", "papers::none", "umbrage::rays::Nothing"])
    {
        assert!(checker.fault(missing).is_some(), "{missing}");
    }
}
