//! Compares the imports of modules with the names that they use.

use std::collections::HashSet;

use super::{Module, STAGE};

/// Faults of the imports of linked modules, the root last: each fault names a module and an item.
pub(super) fn faults(linked: &[Module<'_>]) -> Vec<String> {
    let names: Vec<_> = linked.iter().map(|module| Names::of(&module.body)).collect();
    let Some(of_root) = names.last() else { return Vec::new() };
    let declared_by = |path: &str| {
        let is_declared = |(module, _): &(&Module<'_>, _)| module.path == path;
        linked.iter().zip(&names).find(is_declared).map_or(of_root, |(_, names)| names)
    };
    let mut faults = Vec::new();
    for (module, own) in linked.iter().zip(&names) {
        let path = module.path;
        let mut imported = HashSet::new();
        for import in &module.imports {
            let from = if import.path == STAGE { of_root } else { declared_by(import.path) };
            for name in import.names() {
                if !from.declared.contains(name) {
                    faults.push(format!("{path} imports {name} from {}, which doesn't declare it", import.path));
                }
                if !own.used.contains(name) {
                    faults.push(format!("{path} imports {name} and doesn't use it"));
                }
                if !imported.insert(name) {
                    faults.push(format!("{path} imports {name} twice"));
                }
            }
        }
        for (other, of_other) in linked.iter().zip(&names) {
            let mut missing: Vec<_> = of_other.declared.intersection(&own.used).collect();
            missing.retain(|name| !own.declared.contains(*name) && !imported.contains(*name));
            missing.sort_unstable();
            faults.extend(
                missing.into_iter().map(|name| format!("{path} uses {name} of {} and doesn't import it", other.path)),
            );
        }
    }
    faults
}

/// Names at module scope in a module's text.
#[derive(Debug, Default)]
struct Names<'a> {
    declared: HashSet<&'a str>,
    /// Names that are neither members nor parameters or variables of the function around them.
    used: HashSet<&'a str>,
}

impl<'a> Names<'a> {
    fn of(text: &'a str) -> Self {
        let mut names = Self::default();
        let (mut depth, mut item) = (0, Vec::new());
        for token in tokens(text) {
            item.push(token);
            match token {
                "{" | "(" => depth += 1,
                "}" | ")" => depth -= 1,
                _ => {}
            }
            if depth == 0 && matches!(token, "}" | ";") {
                names.take(&item);
                item.clear();
            }
        }
        names
    }

    /// Adds the names of a declaration at module scope.
    fn take(&mut self, item: &[&'a str]) {
        const KEYWORDS: [&str; 6] = ["alias", "const", "fn", "override", "struct", "var"];
        let Some(keyword) = item.iter().position(|token| KEYWORDS.contains(token)) else { return };
        // The name comes after an address space and an access mode.
        let before_type = item[keyword..].iter().take_while(|token| !matches!(**token, ":" | "=" | "(" | "{"));
        let Some(&name) = before_type.filter(|token| is_name(token)).last() else { return };
        self.declared.insert(name);
        let (mut locals, mut used) = (HashSet::from([name]), Vec::new());
        for (index, token) in item.iter().enumerate().filter(|(_, token)| is_name(token)) {
            let before = index.checked_sub(1).map_or("", |index| item[index]);
            let after = item.get(index + 1).copied().unwrap_or_default();
            if matches!(before, "let" | "var" | "const") || after == ":" {
                locals.insert(token);
            } else if !matches!(before, "." | "@") {
                used.push(*token);
            }
        }
        self.used.extend(used.into_iter().filter(|name| !locals.contains(name)));
    }
}

fn is_name(token: &str) -> bool {
    token.starts_with(|first: char| first.is_alphabetic() || first == '_')
}

/// Words, numbers and single other characters of a text, without comments, spaces and names of built-in values.
fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    for line in text.lines() {
        let mut rest = line.split_once("//").map_or(line, |(code, _)| code).trim_start();
        while let Some(first) = rest.chars().next() {
            let is_word = |c: char| c.is_alphanumeric() || c == '_';
            let end = if is_word(first) { rest.find(|c| !is_word(c)).unwrap_or(rest.len()) } else { first.len_utf8() };
            let (token, after) = rest.split_at(end);
            rest = after.trim_start();
            if token == "builtin" {
                rest = rest.split_once(')').map_or("", |(_, after)| after).trim_start();
            }
            tokens.push(token);
        }
    }
    tokens
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::read;

    /// The faults of two modules, of which `root` is the stage.
    fn faults_of(module: &str, root: &str) -> Vec<String> {
        faults(&[read("a", module), read("root", root)])
    }

    const MODULE: &str = "import stage::{input};\n\
         struct Pair { first: u32, @size(8) second: u32 }\n\
         const LIMIT: u32 = 4u; // other\n\
         fn limited(x: u32) -> u32 { return min(x, LIMIT) + input[0]; }";

    #[test]
    fn right_imports_have_no_faults() {
        let root = "import package::a::{\n    LIMIT, Pair,\n    limited,\n};\n\
             @group(0) @binding(0) var<storage, read> input: array<u32>;\n\
             @compute @workgroup_size(LIMIT) fn run(@builtin(workgroup_id) other: vec3<u32>) {\n\
                 let first = Pair(limited(1u), 2u).first;\n\
             }";
        assert_eq!(faults_of(MODULE, root), [""; 0]);
    }

    #[test]
    fn what_is_used_and_not_imported_is_named() {
        let root = "import package::a::{limited};\nvar<private> input: Pair;\nfn run() { limited(LIMIT); }";
        let missing = ["LIMIT", "Pair"].map(|name| format!("root uses {name} of a and doesn't import it"));
        assert_eq!(faults_of(MODULE, root), missing);
    }

    #[test]
    fn what_is_imported_and_not_used_or_not_there_is_named() {
        let root = "import package::a::{LIMIT, limit};\nvar<private> input: u32;\n\
             fn run(LIMIT: u32) -> u32 { return LIMIT + limit; }";
        let wrong = ["root imports LIMIT and doesn't use it", "root imports limit from a, which doesn't declare it"];
        assert_eq!(faults_of(MODULE, root), wrong);
    }

    #[test]
    fn what_the_stage_does_not_declare_is_named() {
        assert_eq!(faults_of(MODULE, "fn run() {}"), ["a imports input from stage, which doesn't declare it"]);
    }
}
