//! Unsafe code in the libraries that the command is compiled of.

use std::collections::{BTreeMap, BTreeSet};
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, ensure};

use super::rays::number;
use super::{Effort, Finding};

/// Roles of libraries, whether they are given bytes of a file, and their names. Unsorted libraries come last.
const ROLES: [(&str, &str, &str); 7] = [
    ("JPEG", "yes", "zune-jpeg zune-core"),
    (
        "PNG, GIF, WebP, EXR and Zstandard",
        "yes",
        "png gif image-webp exr zune-inflate fdeflate flate2 miniz_oxide simd-adler32 adler2 crc32fast weezl lebe \
         bit_field half smallvec ruzstd byteorder byteorder-lite quick-error",
    ),
    (
        "Texts, glTF, Draco, KTX2 and hashes",
        "yes",
        "serde serde_core serde_json itoa zmij memchr gltf gltf-json data-url percent-encoding draco-core basisu sha2 \
         digest block-buffer hybrid-array crypto-common typenum",
    ),
    (
        "Numbers as bytes, SIMD and mathematics",
        "once they are numbers",
        "bytemuck zerocopy fearless_simd pulp raw-cpuid cpufeatures reborrow glam libm num-complex num-traits \
         bevy_mikktspace portable-atomic",
    ),
    ("Threads", "no", "rayon rayon-core crossbeam-deque crossbeam-epoch crossbeam-utils either once_cell lazy_static"),
    (
        "Files, signals and the system",
        "no",
        "libc bitflags rustix linux-raw-sys errno getrandom tempfile fastrand sysinfo signal-hook \
         signal-hook-registry terminal_size console web-time",
    ),
    (
        "Arguments and progress bars",
        "no",
        "clap clap_builder clap_lex clap_complete clap_mangen anstream anstyle anstyle-parse anstyle-query \
         colorchoice is_terminal_polyfill utf8parse strsim roff indicatif unicode-width unit-prefix bytesize \
         wildmatch",
    ),
];

/// How often code is marked as unsafe: blocks, functions, and implementations and traits.
type Counts = [u64; 3];

pub(super) fn below(_: &Effort) -> Result<Finding> {
    let packages = packages()?;
    let program = env::current_exe()?;
    let beside = program.parent().context("a folder")?;
    let built = if beside.ends_with("deps") { beside.to_owned() } else { beside.join("deps") };
    let sources = sources(&built)?;
    let (mut own, mut forbidding, mut counts) = (0, 0, BTreeMap::<&str, (&str, Counts)>::new());
    for (name, version, folder) in &packages {
        if let Some(folder) = folder {
            let root =
                ["src/lib.rs", "src/main.rs"].map(|root| fs::read_to_string(folder.join(root)).unwrap_or_default());
            own += 1;
            forbidding +=
                u64::from(root.iter().all(|root| root.is_empty() || root.contains("#![forbid(unsafe_code)]")));
            continue;
        }
        let files = sources.get(&format!("{name}-{version}"));
        let files = files.with_context(|| format!("{}: no sources of {name} {version}", built.display()))?;
        // Some are there in two versions.
        let (known, sum) = counts.entry(name.as_str()).or_insert(("", Counts::default()));
        *known = version;
        for file in files {
            let text = fs::read_to_string(file).with_context(|| file.display().to_string())?;
            sum.iter_mut().zip(marked(&text)).for_each(|(sum, more)| *sum += more);
        }
    }
    let of_all = counts.values().fold(Counts::default(), |sum, (_, more)| std::array::from_fn(|at| sum[at] + more[at]));
    let with = counts.values().filter(|(_, sum)| *sum != Counts::default()).count();
    let mut text = format!(
        "The command, with its default features, is compiled of {own} crates of this repository, {forbidding} of which forbid \
         unsafe code (`#![forbid(unsafe_code)]`), and of {} libraries. {with} of these have unsafe code: {} blocks, {} functions, \
         {} implementations and traits, in the source files that the compiler reads, for all processors, without tests. \
         Rust's own library isn't counted. No file is mapped into memory. Nobody here has audited this code.\n\n\
         | libraries for | given a file's bytes | blocks | functions | implementations, traits | of these |\n\
         |---|---|---|---|---|---|\n",
        counts.len(),
        number(of_all[0]),
        number(of_all[1]),
        number(of_all[2]),
    );
    let marks = |name: &str| counts.get(name).map_or(0, |(_, sum)| sum.iter().sum::<u64>());
    let mut row = |role: &str, bytes: &str, crates: &str| {
        let mut crates: Vec<_> = crates.split(' ').filter(|name| marks(name) > 0).collect();
        crates.sort_by_key(|name| std::cmp::Reverse(marks(name)));
        let [blocks, functions, others] =
            crates.iter().fold(Counts::default(), |sum, name| std::array::from_fn(|at| sum[at] + counts[*name].1[at]));
        let listed: Vec<_> =
            crates.iter().map(|name| format!("{name} {} ({})", counts[*name].0, marks(name))).collect();
        text += &format!("| {role} | {bytes} | {blocks} | {functions} | {others} | {} |\n", listed.join(", "));
    };
    ROLES.iter().for_each(|(role, bytes, crates)| row(role, bytes, crates));
    let is_sorted = |name: &&&str| ROLES.iter().any(|(.., crates)| crates.split(' ').any(|known| known == **name));
    let others: Vec<_> = counts.keys().filter(|name| marks(name) > 0 && !is_sorted(name)).copied().collect();
    if !others.is_empty() {
        row("others", "unknown", &others.join(" "));
    }
    let of_files = ROLES.iter().filter(|(_, bytes, _)| *bytes == "yes").flat_map(|(.., crates)| crates.split(' '));
    let without: Vec<_> = of_files.filter(|&name| counts.contains_key(name) && marks(name) == 0).collect();
    text += &format!("\nOf those that are given a file's bytes, these have none: {}.", without.join(", "));
    Ok(Finding::new(own == forbidding, text.trim_end()))
}

/// Name and version of every package that the command has at run time, and the folder of those of this repository.
fn packages() -> Result<Vec<(String, String, Option<PathBuf>)>> {
    let mut tree = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    tree.current_dir(env!("CARGO_MANIFEST_DIR")).args(["tree", "--package", "umbrage-cli", "--prefix", "none"]);
    let output = tree.args(["--edges", "normal,no-proc-macro", "--offline"]).output().context("cargo tree")?;
    ensure!(output.status.success(), "cargo tree: {}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8(output.stdout)?;
    // As `name v1.2.3 (/folder)`, and `(*)` where it was before.
    let lines: BTreeSet<_> = said.lines().map(|line| line.trim_end_matches(" (*)")).collect();
    let package = |line: &str| {
        let (name, rest) = line.split_once(" v")?;
        let (version, folder) = rest.split_once(" (").unwrap_or((rest, ""));
        let folder = folder.strip_suffix(')').map(PathBuf::from);
        Some((name.to_owned(), version.to_owned(), folder))
    };
    Ok(lines.into_iter().filter_map(package).collect())
}

/// The source files that the compiler read, by the name and version of their package, from the lists that it leaves.
fn sources(built: &Path) -> Result<BTreeMap<String, BTreeSet<PathBuf>>> {
    let mut sources: BTreeMap<String, BTreeSet<PathBuf>> = BTreeMap::new();
    for entry in fs::read_dir(built).with_context(|| built.display().to_string())? {
        let path = entry?.path();
        if path.extension().is_none_or(|kind| kind != "d") {
            continue;
        }
        let list = fs::read_to_string(&path)?;
        for file in list.split_whitespace().filter(|word| word.ends_with(".rs")) {
            // The package's folder stands below the registry's.
            let mut parts = Path::new(file).iter().map(|part| part.to_string_lossy());
            if parts.by_ref().any(|part| part == "registry")
                && let Some(package) = parts.nth(2)
            {
                sources.entry(package.into_owned()).or_default().insert(file.into());
            }
        }
    }
    Ok(sources)
}

/// How often code is marked as unsafe, outside of comments, strings and tests.
fn marked(text: &str) -> Counts {
    let code = code(text);
    let mut words = Vec::new();
    for (at, letter) in code.char_indices() {
        let is_word = |letter: char| letter.is_alphanumeric() || letter == '_';
        match words.last_mut() {
            Some((start, end)) if is_word(letter) && *end == at && code[*start..].starts_with(is_word) => {
                *end = at + letter.len_utf8();
            }
            _ if letter.is_whitespace() => {}
            _ => words.push((at, at + letter.len_utf8())),
        }
    }
    let words: Vec<&str> = words.into_iter().map(|(start, end)| &code[start..end]).collect();
    let (mut counts, mut at) = (Counts::default(), 0);
    while at < words.len() {
        let rest = &words[at..];
        if rest.starts_with(&["#", "[", "cfg", "(", "test", ")", "]"]) {
            at += item(rest);
            continue;
        }
        if let ["unsafe", rest @ ..] = rest {
            match rest {
                ["{", ..] | ["extern", "{", ..] => counts[0] += 1,
                // The types of functions aren't functions.
                ["fn" | "extern", "(", ..] | ["extern", "fn", "(", ..] => {}
                ["fn" | "extern", ..] => counts[1] += 1,
                ["impl" | "trait", ..] => counts[2] += 1,
                _ => {}
            }
        }
        at += 1;
    }
    counts
}

/// How many words an item has: up to its semicolon, or the end of its braces.
fn item(words: &[&str]) -> usize {
    let mut depth = 0_usize;
    for (at, word) in words.iter().enumerate() {
        match *word {
            ";" if depth == 0 => return at + 1,
            "{" => depth += 1,
            "}" if depth <= 1 => return at + 1,
            "}" => depth -= 1,
            _ => {}
        }
    }
    words.len()
}

/// The text without comments, strings and characters.
fn code(text: &str) -> String {
    let (mut code, mut rest) = (String::new(), text);
    while let Some(letter) = rest.chars().next() {
        let is_in_word = code.ends_with(|letter: char| letter.is_alphanumeric() || letter == '_');
        let raw = if is_in_word && !code.ends_with('b') { None } else { raw_string(rest) };
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            comment(rest)
        } else if let Some(length) = raw {
            length
        } else if letter == '"' {
            quoted(rest, '"')
        } else if letter == '\'' && (rest[1..].starts_with('\\') || rest.chars().nth(2) == Some('\'')) {
            quoted(rest, '\'')
        } else {
            code.push(letter);
            rest = &rest[letter.len_utf8()..];
            continue;
        };
        code.push(' ');
        rest = &rest[skipped..];
    }
    code
}

/// The length of a comment that may have others in it.
fn comment(text: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    loop {
        let rest = &text[at..];
        if rest.is_empty() {
            return at;
        } else if rest.starts_with("/*") {
            (depth, at) = (depth + 1, at + 2);
        } else if rest.starts_with("*/") {
            (depth, at) = (depth - 1, at + 2);
            if depth == 0 {
                return at;
            }
        } else {
            at += rest.chars().next().map_or(1, char::len_utf8);
        }
    }
}

/// The length of a raw string, if the text begins with one.
fn raw_string(text: &str) -> Option<usize> {
    let raw = text.strip_prefix('r')?.trim_start_matches('#');
    let end = format!("\"{}", "#".repeat(text.len() - 1 - raw.len()));
    let inside = raw.strip_prefix('"')?;
    let length = inside.find(&end).map_or(inside.len(), |at| at + end.len());
    Some(text.len() - inside.len() + length)
}

/// The length of a string or a character with its quotes.
fn quoted(text: &str, quote: char) -> usize {
    let mut letters = text.char_indices().skip(1);
    while let Some((at, letter)) = letters.next() {
        if letter == quote {
            return at + 1;
        }
        if letter == '\\' {
            letters.next();
        }
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unsafe_code_is_counted_where_it_is_code() {
        let text = r##"
            // unsafe {} in a comment /* and
            /* unsafe { /* unsafe {} */ } */
            const TEXT: &str = "unsafe { \" unsafe {";
            const RAW: &[u8] = br#"unsafe { " unsafe {"#;
            fn a<'a>(x: &'a u8) -> char { unsafe { b() } if *x == b'"' { '"' } else { '\'' } }
            unsafe fn b() { unsafe{} }
            pub unsafe extern "C" fn c(callback: unsafe extern "C" fn(u8), other: unsafe fn()) {}
            unsafe extern "C" { fn d(); }
            unsafe impl Send for E {} unsafe trait F {}
            #[unsafe(no_mangle)] fn not_unsafe { r#unsafe }
            #[cfg(test)] mod tests; #[cfg(test)]
            mod tests { fn g() { unsafe { if true {} } } unsafe fn h() {} }
            fn i() { unsafe { é() } }
        "##;
        assert_eq!(marked(text), [4, 2, 2]);
    }
}
