use std::collections::BTreeSet;
use std::io::{self, BufRead, BufReader};
use std::process::{Child, Command, ExitStatus, Stdio};

use crate::command::shown;

/// Output of a step's commands, and facts from it: compiled packages and tests.
#[derive(Clone, Debug, Default)]
pub(crate) struct Log {
    pub(crate) compiled: Compiled,
    /// Seconds and name of each test.
    pub(crate) tests: Vec<(f64, String)>,
}

/// Packages that cargo compiled, checked or documented.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Compiled {
    pub(crate) count: usize,
    /// Names of the workspace's packages.
    pub(crate) own: BTreeSet<String>,
}

impl Log {
    /// Runs a command, with its output in the log.
    pub(crate) fn run(&mut self, command: &mut Command) -> Outcome {
        self.watch(command, |_| {})
    }

    /// Runs commands beside each other, with the lines of all of them in the log.
    pub(crate) fn run_together(&mut self, commands: &mut [Command]) -> Outcome {
        self.watch_together(&mut commands.iter_mut().collect::<Vec<_>>(), |_| {})
    }

    /// Runs a command, and shows each line of both its streams to `see`.
    pub(crate) fn watch(&mut self, command: &mut Command, see: impl FnMut(&str)) -> Outcome {
        self.watch_together(&mut [command], see)
    }

    fn watch_together(&mut self, commands: &mut [&mut Command], see: impl FnMut(&str)) -> Outcome {
        let shown: Vec<_> = commands.iter().map(|command| shown(command)).collect();
        shown.iter().for_each(|command| println!("$ {command}"));
        let statuses = self.read(commands, see).map_err(|error| format!("{}: {error}", shown.join(", ")))?;
        let failed = shown.iter().zip(&statuses).filter(|(_, status)| !status.success());
        of_complaints(&failed.map(|(command, status)| format!("{command}: {status}")).collect::<Vec<_>>())
    }

    fn read(&mut self, commands: &mut [&mut Command], mut see: impl FnMut(&str)) -> io::Result<Vec<ExitStatus>> {
        let (output, input) = io::pipe()?;
        let mut children = Vec::new();
        for command in commands {
            let child = command.stdout(input.try_clone()?).stderr(input.try_clone()?).spawn();
            // The output ends when the last writer has ended, so this process mustn't be one.
            command.stdout(Stdio::inherit()).stderr(Stdio::inherit());
            children.push(child?);
        }
        drop(input);
        for line in BufReader::new(output).split(b'\n') {
            let line = line?;
            let line = String::from_utf8_lossy(&line);
            println!("{line}");
            self.compiled.add(&line);
            see(&line);
        }
        children.iter_mut().map(Child::wait).collect()
    }
}

impl Compiled {
    /// Reads cargo's line about a package: `Compiling NAME vVERSION`, and a folder if it is of the workspace.
    fn add(&mut self, line: &str) {
        let verbs = ["Compiling ", "Checking ", "Documenting "];
        let package = verbs.iter().find_map(|verb| line.trim_start().strip_prefix(verb));
        let Some((name, version)) = package.and_then(|package| package.split_once(" v")) else { return };
        self.count += 1;
        if version.contains(" (") {
            self.own.insert(name.to_owned());
        }
    }
}

/// How a step ended.
pub(crate) type Outcome = Result<(), NotPassed>;

/// Why a step didn't pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum NotPassed {
    /// The reason, in one or more lines.
    Failed(String),
    /// The reason: a requirement of the step isn't installed.
    Skipped(String),
}

/// A failure.
impl From<String> for NotPassed {
    fn from(why: String) -> Self {
        Self::Failed(why)
    }
}

/// The outcome of a step with a requirement that isn't installed.
pub(crate) fn skipped(why: &str) -> Outcome {
    Err(NotPassed::Skipped(why.to_owned()))
}

/// Passes if there is no complaint; otherwise fails with all of them.
pub(crate) fn of_complaints(complaints: &[String]) -> Outcome {
    if complaints.is_empty() { Ok(()) } else { Err(complaints.join("\n").into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_both_streams_are_seen() {
        let shell = |script: &str| {
            let mut seen = Vec::new();
            let ended =
                Log::default().watch(Command::new("sh").args(["-c", script]), |line| seen.push(line.to_owned()));
            seen.sort();
            (ended.is_ok(), seen)
        };
        let both = vec!["error".to_owned(), "output".to_owned()];
        assert_eq!(shell("echo output; echo error >&2"), (true, both.clone()));
        assert_eq!(shell("echo error >&2; echo output; exit 1"), (false, both));
        assert!(Log::default().run(&mut Command::new("no-such-program")).is_err());
    }

    #[test]
    fn commands_run_beside_each_other() {
        // The first one ends after the second, whose failure is reported.
        let folder = tempfile::tempdir().unwrap();
        let shell = |script: &str| {
            let mut shell = Command::new("sh");
            shell.current_dir(folder.path()).args(["-c", script]);
            shell
        };
        let first = || shell("while ! [ -e done ]; do sleep 0.01; done");
        let second = |code: u8| shell(&format!("touch done; exit {code}"));
        assert_eq!(Log::default().run_together(&mut [first(), second(0)]), Ok(()));
        let failed = Log::default().run_together(&mut [first(), second(3)]);
        assert_eq!(failed, Err("sh -c touch done; exit 3: exit status: 3".to_owned().into()));
    }

    #[test]
    fn compiled_packages_are_counted() {
        let lines = "   Compiling serde v1.0.2\n    Checking a-b v0.1.0 (packages/a-b)\n Documenting a-b v0.1.0 (packages/a-b)\n\
            Compiling the rest\n    Finished `dev` profile\n";
        let mut log = Log::default();
        assert_eq!(log.run(Command::new("printf").args(["%s", lines])), Ok(()));
        assert_eq!(log.compiled, Compiled { count: 3, own: BTreeSet::from(["a-b".to_owned()]) });
    }
}
