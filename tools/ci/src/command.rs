use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::outcome::Outcome;

/// Whether cargo has a subcommand of this name, which may come from a program that was installed beside it.
pub(crate) fn has_subcommand(name: &str) -> bool {
    let mut asked = Command::new(cargo_path());
    asked.args([name, "--version"]).stdout(Stdio::null()).stderr(Stdio::null());
    asked.status().is_ok_and(|status| status.success())
}

/// The cargo that runs this program, in the repository's root.
pub(crate) fn cargo(root: &Path) -> Command {
    let mut command = Command::new(cargo_path());
    command.current_dir(root);
    command
}

/// How much of the workspace a command is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scope {
    /// All of it, with all that its features add, and all tests.
    Whole,
    /// All but the window, whose toolkit is more than a third of all packages, and but tests that take long.
    Short,
}

/// A cargo command about the workspace. Those that select the same crates and features share what they compile: tests and
/// builds count what some tests ask about, so that `umbrage-rays` isn't compiled once more for these; clippy and docs are
/// about the features that users have.
pub(crate) fn cargo_workspace(root: &Path, scope: Scope, subcommand: &[&str]) -> Command {
    let mut command = cargo(root);
    command.args(subcommand).args(["--workspace", "--locked"]);
    command.args(match scope {
        Scope::Whole => ["--features", "umbrage-cli/view,umbrage-bench/view"],
        Scope::Short => ["--exclude", "umbrage-viewer"],
    });
    if matches!(subcommand.first(), Some(&("test" | "build"))) {
        command.args(["--features", "umbrage-bench/statistics"]);
    }
    command
}

fn cargo_path() -> OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

/// Runs a command whose output is for the person who reads the log.
pub(crate) fn run(command: &mut Command) -> Outcome {
    println!("$ {}", shown(command));
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{}: {status}", shown(command)).into()),
        Err(error) => Err(format!("{}: {error}", shown(command)).into()),
    }
}

/// A command's standard output; what it says on standard error is for the log.
///
/// # Errors
/// Says why it could not be run, or that it failed.
pub(crate) fn output(command: &mut Command) -> Result<String, String> {
    let output = command.stderr(Stdio::inherit()).output().map_err(|error| format!("{}: {error}", shown(command)))?;
    if !output.status.success() {
        return Err(format!("{}: {}", shown(command), output.status));
    }
    String::from_utf8(output.stdout).map_err(|error| format!("{}: {error}", shown(command)))
}

fn shown(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_stem().unwrap_or_default().to_string_lossy();
    let arguments = command.get_args().map(|argument| argument.to_string_lossy());
    std::iter::once(program).chain(arguments).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_pass_and_fail() {
        let root = Path::new(".");
        assert_eq!(run(cargo(root).arg("--version")), Ok(()));
        assert!(run(cargo(root).arg("no-such-command")).is_err());
        assert!(run(&mut Command::new("no-such-program")).is_err());
        assert!(output(cargo(root).arg("--version")).unwrap().starts_with("cargo "));
        assert!(output(cargo(root).arg("no-such-command")).is_err());
        assert!(has_subcommand("clippy") && !has_subcommand("no-such-command"));
    }
}
