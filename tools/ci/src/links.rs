use std::path::Path;

use crate::log::{Outcome, of_complaints};
use crate::repository::{files, read, within};

/// Checks that every link of a Markdown file into the repository has a target.
pub(crate) fn check(root: &Path) -> Outcome {
    let mut complaints = Vec::new();
    for path in files(root, "md")? {
        let folder = path.parent().unwrap_or(root);
        for (line, target) in targets(&read(&path)?) {
            let Some(file) = local_file(&target) else { continue };
            // GitHub and other hosts resolve a leading slash to the root.
            let linked = file.strip_prefix('/').map_or_else(|| folder.join(file), |file| root.join(file));
            if !linked.exists() {
                complaints.push(format!("{}:{line}: there is no {target}", within(root, &path)));
            }
        }
    }
    of_complaints(&complaints)
}

/// The file that a link points to; `None` for a link elsewhere or into the same file.
fn local_file(target: &str) -> Option<&str> {
    let elsewhere = ["http://", "https://", "mailto:", "#"].iter().any(|start| target.starts_with(start));
    let file = target.split(['#', '?']).next().unwrap_or(target);
    (!elsewhere && !file.is_empty()).then_some(file)
}

/// Line number and target of each `[text](target)`, `[name]: target`, `src="target"` and `href="target"`, outside of code.
fn targets(markdown: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut in_code = false;
    for (line, text) in (1..).zip(markdown.lines()) {
        if text.trim_start().starts_with("```") || text.trim_start().starts_with("~~~") {
            in_code = !in_code;
        }
        if in_code {
            continue;
        }
        let text = without_code(text);
        for (start, end) in [("](", ')'), ("src=\"", '"'), ("href=\"", '"')] {
            let mut rest = text.as_str();
            while let Some((_, behind)) = rest.split_once(start) {
                rest = behind;
                let target = rest.split(end).next().unwrap_or(rest);
                // A title may follow the target.
                let target = target.split_whitespace().next().unwrap_or_default();
                found.push((line, target.trim_matches(['<', '>']).to_owned()));
            }
        }
        if let Some((_, target)) = text.strip_prefix('[').and_then(|rest| rest.split_once("]: ")) {
            found.push((line, target.split_whitespace().next().unwrap_or_default().to_owned()));
        }
    }
    found
}

/// The line without the parts between backticks.
fn without_code(line: &str) -> String {
    // An unpaired backtick is text.
    if !line.matches('`').count().is_multiple_of(2) {
        return line.to_owned();
    }
    line.split('`').step_by(2).collect::<Vec<_>>().join("`")
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "[a](a.md) and ![b](img/b.png \"title\") `[not](code.md)`\n\
        ```\n[not](code.md)\n```\n\
        <img src=\"c.png\"> [web](https://example.org/x) [here](#part)\n\
        [d]: d.md#part\n";

    #[test]
    fn targets_are_found_outside_of_code() {
        let found = targets(TEXT);
        let expected =
            [(1, "a.md"), (1, "img/b.png"), (5, "https://example.org/x"), (5, "#part"), (5, "c.png"), (6, "d.md#part")];
        assert_eq!(found, expected.map(|(line, target)| (line, target.to_owned())));
    }

    #[test]
    fn missing_files_are_complained_about() {
        let folder = tempfile::tempdir().unwrap();
        let write = |path: &str, text: &str| std::fs::write(folder.path().join(path), text).unwrap();
        write("READ.md", "[a](a.md) [root](/a.md#x) [web](https://example.org/none)");
        write("a.md", "");
        assert_eq!(check(folder.path()), Ok(()));
        write("READ.md", "\n[a](none.md)");
        assert_eq!(check(folder.path()), Err("READ.md:2: there is no none.md".to_owned().into()));
    }
}
