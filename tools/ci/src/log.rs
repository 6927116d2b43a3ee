use std::collections::BTreeSet;
use std::io::{self, BufRead, BufReader};
use std::process::{Command, Stdio};

use crate::command::shown;
use crate::outcome::Outcome;

/// What the commands of a step print, and what it tells: packages that they compile and tests that they run.
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
    /// Names of those of the workspace.
    pub(crate) own: BTreeSet<String>,
}

impl Log {
    /// Runs a command, with its output in the log.
    pub(crate) fn run(&mut self, command: &mut Command) -> Outcome {
        self.watch(command, |_| {})
    }

    /// Runs a command, and shows each line of both its streams to `see`.
    pub(crate) fn watch(&mut self, command: &mut Command, see: impl FnMut(&str)) -> Outcome {
        println!("$ {}", shown(command));
        self.read(command, see).map_err(|error| format!("{}: {error}", shown(command)).into())
    }

    fn read(&mut self, command: &mut Command, mut see: impl FnMut(&str)) -> io::Result<()> {
        let (output, input) = io::pipe()?;
        let child = command.stdout(input.try_clone()?).stderr(input).spawn();
        // The output ends when the last writer has ended, so this process may not be one.
        command.stdout(Stdio::inherit()).stderr(Stdio::inherit());
        let mut child = child?;
        for line in BufReader::new(output).split(b'\n') {
            let line = line?;
            let line = String::from_utf8_lossy(&line);
            println!("{line}");
            self.compiled.add(&line);
            see(&line);
        }
        let status = child.wait()?;
        if status.success() { Ok(()) } else { Err(io::Error::other(status.to_string())) }
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
    fn compiled_packages_are_counted() {
        let lines = "   Compiling serde v1.0.2\n    Checking a-b v0.1.0 (/home/a-b)\n Documenting a-b v0.1.0 (/home/a-b)\n\
            Compiling the rest\n    Finished `dev` profile\n";
        let mut log = Log::default();
        assert_eq!(log.run(Command::new("printf").args(["%s", lines])), Ok(()));
        assert_eq!(log.compiled, Compiled { count: 3, own: BTreeSet::from(["a-b".to_owned()]) });
    }
}
