use std::fmt::Write as _;

/// How a check ended.
pub(crate) type Outcome = Result<(), NotPassed>;

/// Why a check didn't pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum NotPassed {
    /// In one line or more.
    Failed(String),
    Skipped(String),
}

/// A failure.
impl From<String> for NotPassed {
    fn from(why: String) -> Self {
        Self::Failed(why)
    }
}

/// Passed where there is no complaint, else failed with all of them.
pub(crate) fn of_complaints(complaints: &[String]) -> Outcome {
    if complaints.is_empty() { Ok(()) } else { Err(complaints.join("\n").into()) }
}

/// A check that has run.
#[derive(Clone, Debug)]
pub(crate) struct Ran {
    pub(crate) name: &'static str,
    /// On the clock.
    pub(crate) seconds: f64,
    /// On all processors together, where the system says.
    pub(crate) cpu_seconds: Option<f64>,
    pub(crate) outcome: Outcome,
}

impl Ran {
    pub(crate) fn has_failed(&self) -> bool {
        matches!(self.outcome, Err(NotPassed::Failed(_)))
    }
}

/// Each check in a line: name, seconds, how it ended and why.
pub(crate) fn summary(results: &[Ran]) -> String {
    let mut text = format!("\n=== summary\n{:<14} {:>9} {:>9}\n", "", "seconds", "CPU");
    for Ran { name, seconds, cpu_seconds, outcome } in results {
        let ended = match outcome {
            Ok(()) => "passed".to_owned(),
            Err(NotPassed::Failed(why)) => format!("FAILED: {why}"),
            Err(NotPassed::Skipped(why)) => format!("skipped: {why}"),
        };
        // Further lines of a reason stand below its first one. Writing to a string can't fail.
        let ended = ended.replace('\n', "\n                                    ");
        let _ = writeln!(text, "{name:<14} {seconds:>9.1} {}  {ended}", cpu(*cpu_seconds));
    }
    let total: f64 = results.iter().map(|ran| ran.seconds).sum();
    let total_cpu: Option<f64> = results.iter().map(|ran| ran.cpu_seconds).sum();
    let failed = results.iter().filter(|ran| ran.has_failed()).count();
    let verdict = if failed == 0 { "all is well".to_owned() } else { format!("{failed} failed") };
    let _ = writeln!(text, "{:<14} {total:>9.1} {}  {verdict}", "in all", cpu(total_cpu));
    text
}

fn cpu(seconds: Option<f64>) -> String {
    seconds.map_or_else(|| format!("{:>9}", "?"), |seconds| format!("{seconds:>9.1}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summaries_say_what_failed_and_why() {
        let ran = |name, seconds, outcome| Ran { name, seconds, cpu_seconds: Some(2.0 * seconds), outcome };
        let mut results = [
            ran("a", 1.0, Ok(())),
            ran("b", 2.0, Err("first\nsecond".to_owned().into())),
            ran("c", 0.0, Err(NotPassed::Skipped("not here".to_owned()))),
        ];
        let text = summary(&results);
        for part in ["a ", "passed\n", "FAILED: first\n", "  second", "skipped: not here", "3.0       6.0  1 failed"] {
            assert!(text.contains(part), "{part} in {text}");
        }
        results[1].cpu_seconds = None;
        assert!(summary(&results).contains("3.0         ?  1 failed"));
    }
}
