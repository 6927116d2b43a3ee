use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::io::IsTerminal;
use std::path::Path;
use std::time::Instant;

use crate::command::seconds_of_children;
use crate::log::{Compiled, Log, NotPassed, Outcome};
use crate::parts::Step;
use crate::passed::{Pass, read_tables};
use crate::repository::{read, target};
use crate::test_times::slowest;

/// The file with each step's budget in CPU seconds.
pub(crate) const BUDGETS: &str = "tools/ci/budgets.toml";

/// Factor of its budget above which a step is named.
const TOLERANCE: f64 = 1.5;

/// The reports of the last run of all checks, and of the one before, in the build output.
const FILES: [&str; 2] = ["ci-report.txt", "ci-report.before.txt"];

/// Columns of a step's name; two spaces or more end it.
const NAME_WIDTH: usize = 19;

const INDENTATION: &str = "\n                     ";

/// The steps of a run, with outcomes and times.
#[derive(Debug, Default)]
pub(crate) struct Report {
    pub(crate) steps: Vec<Ran>,
    /// Parts whose inputs are the same as for their last pass.
    left_out: Vec<String>,
    /// Seconds and name of each test.
    tests: Vec<(f64, String)>,
    /// CPU seconds of steps by name.
    budgets: BTreeMap<String, f64>,
    /// Seconds of steps by name, in the last run of all checks.
    before: BTreeMap<String, f64>,
}

/// A step that has run.
#[derive(Clone, Debug)]
pub(crate) struct Ran {
    pub(crate) name: &'static str,
    /// On the clock.
    pub(crate) seconds: f64,
    /// On all processors together; `None` if the system doesn't tell.
    pub(crate) cpu_seconds: Option<f64>,
    pub(crate) compiled: Compiled,
    pub(crate) outcome: Outcome,
}

impl Report {
    /// An empty report, with the budgets and the previous report.
    ///
    /// # Errors
    /// If the budgets can't be read.
    pub(crate) fn new(root: &Path) -> Result<Self, String> {
        let before = fs::read_to_string(target(root).join(FILES[0])).unwrap_or_default();
        Ok(Self { budgets: budgets(root)?, before: seconds_of_steps(&before), ..Self::default() })
    }

    /// Runs steps one after the other, even after failures.
    pub(crate) fn run_all<'a>(&mut self, root: &Path, steps: impl IntoIterator<Item = &'a Step>) -> &[Ran] {
        let first = self.steps.len();
        for (name, check) in steps {
            println!("\n=== {name}");
            let (started, cpu_started) = (Instant::now(), seconds_of_children());
            let mut log = Log::default();
            let outcome = check(root, &mut log);
            let cpu_seconds = seconds_of_children().zip(cpu_started).map(|(end, start)| end - start);
            let seconds = started.elapsed().as_secs_f64();
            self.tests.append(&mut log.tests);
            self.steps.push(Ran { name, seconds, cpu_seconds, compiled: log.compiled, outcome });
        }
        &self.steps[first..]
    }

    /// Records a part that needn't run.
    pub(crate) fn leave_out(&mut self, part: &str, Pass { seconds, cpu_seconds, .. }: &Pass) {
        let took = format!("it took {seconds:.1} s, {cpu_seconds:.1} CPU s");
        self.left_out.push(format!("{part:<NAME_WIDTH$} has passed with the same inputs; {took}"));
    }

    pub(crate) fn has_failed(&self) -> bool {
        self.steps.iter().any(Ran::has_failed)
    }

    /// Prints the summary; keeps that of all checks in a folder, beside the previous one.
    ///
    /// # Errors
    /// If it can't be kept.
    pub(crate) fn finish(&self, folder: &Path, is_complete: bool) -> Result<(), String> {
        let is_red = std::io::stdout().is_terminal() || std::env::var_os("CI").is_some();
        print!("{}", self.summary(is_red));
        if !is_complete {
            return Ok(());
        }
        let [report, before] = FILES.map(|name| folder.join(name));
        // The first run has no previous one.
        let _ = fs::rename(&report, before);
        fs::write(&report, self.summary(false)).map_err(|error| format!("{}: {error}", report.display()))?;
        println!("{}", report.display());
        Ok(())
    }

    /// A line for each step: name, seconds, outcome and reason; below it its compiled packages; and the slowest tests.
    fn summary(&self, is_red: bool) -> String {
        let mut text = format!("\n=== summary\n{:<NAME_WIDTH$} {:>9} {:>9} {:>9}\n", "", "seconds", "CPU", "change");
        for step in &self.steps {
            let budget = self.budgets.get(step.name).filter(|budget| step.is_above(**budget));
            let mut name = format!("{:<NAME_WIDTH$}", step.name);
            if is_red && budget.is_some() {
                name = format!("\x1b[31m{name}\x1b[0m");
            }
            let times = times(step.seconds, step.cpu_seconds, self.change(step));
            // Writing to a string can't fail.
            let _ = write!(text, "{name} {times}  {}", ended(&step.outcome));
            if let Some(budget) = budget {
                let _ = write!(text, "; over budget: {budget} CPU s");
            }
            let Compiled { count, own } = &step.compiled;
            if *count > 0 {
                let _ = write!(text, "{INDENTATION}packages compiled: {count}, of the workspace: {}", listed(own));
            }
            text.push('\n');
        }
        for part in &self.left_out {
            let _ = writeln!(text, "{part}");
        }
        let seconds = self.steps.iter().map(|step| step.seconds).sum();
        let cpu_seconds = self.steps.iter().map(|step| step.cpu_seconds).sum();
        let change = self.steps.iter().filter_map(|step| self.change(step)).reduce(|one, other| one + other);
        let failed = self.steps.iter().filter(|step| step.has_failed()).count();
        let verdict = if failed == 0 { "all is well".to_owned() } else { format!("{failed} failed") };
        let _ = writeln!(text, "{:<NAME_WIDTH$} {}  {verdict}", "in all", times(seconds, cpu_seconds, change));
        if !self.tests.is_empty() {
            text += &slowest(&self.tests);
        }
        text
    }

    /// Seconds on the clock that the step takes more than in the last run of all checks.
    fn change(&self, step: &Ran) -> Option<f64> {
        Some(step.seconds - self.before.get(step.name)?)
    }
}

impl Ran {
    fn has_failed(&self) -> bool {
        matches!(self.outcome, Err(NotPassed::Failed(_)))
    }

    fn is_above(&self, budget: f64) -> bool {
        self.cpu_seconds.is_some_and(|seconds| seconds > TOLERANCE * budget)
    }
}

fn times(seconds: f64, cpu_seconds: Option<f64>, change: Option<f64>) -> String {
    let cpu_seconds = cpu_seconds.map_or_else(|| "?".to_owned(), |seconds| format!("{seconds:.1}"));
    let change = change.map_or_else(String::new, |seconds| format!("{seconds:+.1}"));
    format!("{seconds:>9.1} {cpu_seconds:>9} {change:>9}")
}

fn ended(outcome: &Outcome) -> String {
    let ended = match outcome {
        Ok(()) => "passed".to_owned(),
        Err(NotPassed::Failed(why)) => format!("FAILED: {why}"),
        Err(NotPassed::Skipped(why)) => format!("skipped: {why}"),
    };
    // Further lines of a reason are below its first one.
    ended.replace('\n', INDENTATION)
}

fn listed(names: &BTreeSet<String>) -> String {
    let names: Vec<_> = names.iter().map(String::as_str).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

/// Seconds by name of step, from a summary.
fn seconds_of_steps(summary: &str) -> BTreeMap<String, f64> {
    let step = |line: &str| {
        let (name, numbers) = line.split_once("  ")?;
        Some((name.to_owned(), numbers.split_whitespace().next()?.parse().ok()?))
    };
    summary.lines().filter(|line| !line.starts_with(' ')).filter_map(step).collect()
}

/// CPU seconds of each step by name.
///
/// # Errors
/// If the file can't be read, or a budget is no number.
fn budgets(root: &Path) -> Result<BTreeMap<String, f64>, String> {
    let tables = read_tables(&read(&root.join(BUDGETS))?).map_err(|why| format!("{BUDGETS}: {why}"))?;
    let budget = |(step, seconds): (String, String)| {
        let seconds = seconds.parse().map_err(|error| format!("{BUDGETS}: {step}: {error}"))?;
        Ok((step, seconds))
    };
    tables.into_iter().flat_map(|(_, steps)| steps).map(budget).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::skipped;

    fn ran(name: &'static str, seconds: f64, outcome: Outcome) -> Ran {
        Ran { name, seconds, cpu_seconds: Some(2.0 * seconds), compiled: Compiled::default(), outcome }
    }

    #[test]
    fn summaries_say_how_steps_ended_and_why() {
        let mut failed = ran("b", 2.0, Err("first\nsecond".to_owned().into()));
        failed.compiled = Compiled { count: 3, own: BTreeSet::from(["rays".to_owned(), "scene".to_owned()]) };
        let mut report = Report { steps: vec![ran("a", 1.0, Ok(())), failed], ..Report::default() };
        report.steps.push(ran("c", 0.0, skipped("not here")));
        report.leave_out("page", &Pass { inputs: String::new(), seconds: 5.0, cpu_seconds: 9.0 });
        report.tests.push((1.5, "x::y".to_owned()));
        let text = report.summary(false);
        let parts =
            ["a ", "passed\n", "FAILED: first\n", "  second", "skipped: not here", "1 failed\n", "1.50 s  x::y"];
        let more =
            ["packages compiled: 3, of the workspace: rays, scene\n", "it took 5.0 s, 9.0 CPU s\n", " 3.0       6.0 "];
        for part in parts.iter().chain(&more) {
            assert!(text.contains(part), "{part} in {text}");
        }
        report.steps[1].cpu_seconds = None;
        assert!(report.summary(false).contains("3.0         ? "));
    }

    #[test]
    fn steps_above_their_budget_by_half_are_named() {
        let budgets = BTreeMap::from([("a".to_owned(), 1.0), ("b".to_owned(), 1.0)]);
        let report =
            Report { steps: vec![ran("a", 0.75, Ok(())), ran("b", 0.8, Ok(()))], budgets, ..Report::default() };
        let over = |text: &str| {
            text.lines().filter(|line| line.contains("over budget")).map(str::to_owned).collect::<Vec<_>>()
        };
        let plain = over(&report.summary(false));
        assert!(
            plain.len() == 1 && plain[0].starts_with("b  ") && plain[0].ends_with("over budget: 1 CPU s"),
            "{plain:?}"
        );
        assert!(over(&report.summary(true))[0].starts_with("\x1b[31mb  "));
        assert!(!report.has_failed());
    }

    #[test]
    fn reports_are_compared_with_the_one_before() {
        let former = Report { steps: vec![ran("10⁷ rays", 2.0, Ok(())), ran("b", 1.0, Ok(()))], ..Report::default() };
        let before = seconds_of_steps(&former.summary(false));
        assert_eq!(
            before.iter().map(|(name, seconds)| (name.as_str(), *seconds)).collect::<Vec<_>>(),
            [("10⁷ rays", 2.0), ("b", 1.0), ("in all", 3.0)]
        );
        let report =
            Report { steps: vec![ran("10⁷ rays", 2.5, Ok(())), ran("c", 1.0, Ok(()))], before, ..Report::default() };
        let text = report.summary(false);
        assert!(text.contains(" +0.5  passed") && text.contains(" +0.5  all is well"), "{text}");
    }

    #[test]
    fn reports_of_all_checks_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let run = |name, is_complete| {
            let report = Report { steps: vec![ran(name, 1.0, Ok(()))], ..Report::default() };
            report.finish(folder.path(), is_complete).unwrap();
        };
        run("first", true);
        run("second", true);
        run("named", false);
        let has = |file: &str, name: &str| read(&folder.path().join(file)).unwrap().contains(name);
        assert!(has(FILES[0], "second") && has(FILES[1], "first"));
    }
}
