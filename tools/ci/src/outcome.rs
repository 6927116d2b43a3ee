use std::fmt::Write as _;

/// How a check ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    Passed,
    /// With the reason, of one line or more.
    Failed(String),
    /// With the reason.
    Skipped(String),
}

impl Outcome {
    pub(crate) fn is_failure(&self) -> bool {
        matches!(self, Self::Failed(_))
    }

    /// Passed where there is no complaint, else failed with all of them.
    pub(crate) fn of_complaints(complaints: &[String]) -> Self {
        if complaints.is_empty() { Self::Passed } else { Self::Failed(complaints.join("\n")) }
    }
}

/// Each check in a line: name, seconds, how it ended and why.
pub(crate) fn summary(results: &[(&str, f64, Outcome)]) -> String {
    let mut text = "\n=== summary\n".to_owned();
    for (name, seconds, outcome) in results {
        let (word, why) = match outcome {
            Outcome::Passed => ("passed", ""),
            Outcome::Failed(why) => ("FAILED", why.as_str()),
            Outcome::Skipped(why) => ("skipped", why.as_str()),
        };
        let colon = if why.is_empty() { "" } else { ": " };
        // Further lines of a reason stand below its first one. Writing to a string can't fail.
        let _ = writeln!(
            text,
            "{name:<14} {seconds:>7.1} s  {word}{colon}{}",
            why.replace('\n', "\n                            ")
        );
    }
    let total: f64 = results.iter().map(|(_, seconds, _)| seconds).sum();
    let failed = results.iter().filter(|(_, _, outcome)| outcome.is_failure()).count();
    let verdict = if failed == 0 { "all is well".to_owned() } else { format!("{failed} failed") };
    let _ = writeln!(text, "{:<14} {total:>7.1} s  {verdict}", "in all");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summaries_say_what_failed_and_why() {
        let results = [
            ("a", 1.0, Outcome::Passed),
            ("b", 2.0, Outcome::Failed("first\nsecond".to_owned())),
            ("c", 0.0, Outcome::Skipped("not here".to_owned())),
        ];
        let text = summary(&results);
        for part in ["a ", "passed\n", "FAILED: first\n", "  second", "skipped: not here", "3.0 s  1 failed"] {
            assert!(text.contains(part), "{part} in {text}");
        }
    }
}
