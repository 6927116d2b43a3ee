//! `umbrage structures`: the structures to choose from, and their options.

use std::fmt::Write as _;
use std::io::{self, Write as _};

use umbrage::{OptionValues, Structure};

use crate::choices::structures;
use crate::failure::Failure;
use crate::feature::Feature;

pub(crate) fn run(one: Option<&Structure>) -> Result<(), Failure> {
    let text = one.map_or_else(all, described);
    Ok(io::stdout().write_all(text.as_bytes())?)
}

/// A line or two for each structure.
fn all() -> String {
    let mut text = String::new();
    for structure in structures().iter() {
        // Writing to a string can't fail.
        let _ = writeln!(text, "{:<12} {}", structure.name(), structure.about());
        if let Some(paper) = structure.paper() {
            let _ = writeln!(text, "{:<12} {paper}", "");
        }
    }
    if let Err(Failure::Input { hint: Some(hint), .. }) = Feature::Papers.check() {
        let _ = writeln!(text, "listed, grid and kdtree are the papers' structures: {hint}");
    }
    text.push_str("\n`--structure NAME` chooses one; `umbrage structures NAME` lists its options\n");
    text
}

/// A structure with its options, as `option=value`, their descriptions and possible values.
fn described(structure: &Structure) -> String {
    let mut text = format!("{}: {}\n", structure.name(), structure.about());
    // Writing to a string can't fail.
    if let Some(paper) = structure.paper() {
        let _ = writeln!(text, "Paper: {paper}");
    }
    let on_gpu = if structure.with_defaults().check_on_gpu().is_ok() { "yes" } else { "no" };
    let _ = writeln!(text, "On a GPU: {on_gpu}");
    let mut example = None;
    for option in structure.options() {
        let value = structure.option(option.name).unwrap_or_default();
        let _ = write!(text, "\n{}={value}\n    {}", option.name, option.about);
        match &option.values {
            OptionValues::Names(names) if names().iter().any(|(_, about)| !about.is_empty()) => {
                let width = names().iter().map(|(name, _)| name.len()).max().unwrap_or_default();
                text.push('\n');
                for (name, about) in names() {
                    let _ = writeln!(text, "{}", format!("    {name:<width$}  {about}").trim_end());
                }
            }
            values => {
                let _ = writeln!(text, ": {}", values.in_words());
            }
        }
        if on_gpu == "yes" && !option.is_on_gpu {
            text.push_str("    On the CPU alone\n");
        }
        example.get_or_insert_with(|| format!("--structure {}:{}={value}", structure.name(), option.name));
    }
    match example {
        Some(example) => {
            let _ = writeln!(text, "\nOptions follow the name, with commas between them: {example}");
        }
        None => text.push_str("It has no options\n"),
    }
    text
}
