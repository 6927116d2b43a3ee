use std::ffi::OsString;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// Features of all checks but the window's, each with the package that has it. Every command selects all of them, so
/// that no package is compiled twice; the check `features` ensures it.
pub(crate) const FEATURES: &[&str] =
    &["umbrage-bench/statistics", "umbrage-cli/avif", "umbrage-cli/gpu", "umbrage-cli/papers"];

/// The window's features. Its toolkit is more than a third of all packages.
pub(crate) const WINDOW_FEATURES: &[&str] = &["umbrage-bench/view", "umbrage-cli/view"];

/// Whether cargo has a subcommand of this name, which a separately installed program may provide.
pub(crate) fn has_subcommand(name: &str) -> bool {
    let mut asked = Command::new(cargo_path());
    asked.args([name, "--version"]).stdout(Stdio::null()).stderr(Stdio::null());
    asked.status().is_ok_and(|status| status.success())
}

/// Settings of all compilation here. Nothing is kept for the next one, and crates are compiled whole: tests take a
/// quarter less time than with crates in sixteen parts.
const COMPILED_WHOLE: [(&str, &str); 2] = [("CARGO_INCREMENTAL", "0"), ("CARGO_PROFILE_DEV_CODEGEN_UNITS", "1")];

/// The cargo that runs this program, in the repository's root.
pub(crate) fn cargo(root: &Path) -> Command {
    let mut command = Command::new(cargo_path());
    command.current_dir(root).envs(COMPILED_WHOLE);
    command
}

/// The packages that a command selects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scope {
    /// All packages, with the window and all features.
    Whole,
    /// All but the window.
    Windowless,
}

/// A cargo command about the workspace. Commands of one scope share compiled crates if all of them select examples or
/// tests: dev-dependencies, which come with these, turn on features of other dependencies. So do the Python package and
/// the page: left out here, their parts would compile everything once more.
pub(crate) fn cargo_workspace(root: &Path, scope: Scope, arguments: &[&str]) -> Command {
    let mut command = cargo(root);
    command.args(arguments).args(["--workspace", "--locked", "--features", &FEATURES.join(",")]);
    match scope {
        Scope::Whole => command.args(["--features", &WINDOW_FEATURES.join(",")]),
        Scope::Windowless => command.args(["--exclude", "umbrage-viewer"]),
    };
    command
}

/// Builds programs and all examples, as the tests are built.
pub(crate) fn build(root: &Path, programs: &[&str]) -> Command {
    let mut command = cargo_workspace(root, Scope::Windowless, &["build", "--examples"]);
    command.args(programs.iter().flat_map(|name| ["--bin", name]));
    command
}

fn cargo_path() -> OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

/// A command's standard output; standard error goes to the log.
///
/// # Errors
/// If it can't be run, or if it failed.
pub(crate) fn output(command: &mut Command) -> Result<String, String> {
    let output = command.stderr(Stdio::inherit()).output().map_err(|error| format!("{}: {error}", shown(command)))?;
    if !output.status.success() {
        return Err(format!("{}: {}", shown(command), output.status));
    }
    String::from_utf8(output.stdout).map_err(|error| format!("{}: {error}", shown(command)))
}

/// The command as typed, without the program's folder.
pub(crate) fn shown(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_stem().unwrap_or_default().to_string_lossy();
    let arguments = command.get_args().map(|argument| argument.to_string_lossy());
    std::iter::once(program).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// Unit of Linux's process times: hundredths of a second, on every machine.
const TICKS_PER_SECOND: f64 = 100.0;

/// CPU seconds of all programs that this one has run and that have ended; `None` if the system doesn't tell. Unlike a
/// check's time on the clock, it hardly depends on other load.
pub(crate) fn seconds_of_children() -> Option<f64> {
    seconds_in(&fs::read_to_string("/proc/self/stat").ok()?)
}

/// Reads `proc_pid_stat(5)`: numbers 16 and 17 are the children's ticks in user mode and in the kernel.
fn seconds_in(stat: &str) -> Option<f64> {
    // The program's name, number 2, may hold spaces.
    let mut rest = stat.rsplit_once(')')?.1.split_whitespace().skip(13);
    let mut ticks = || rest.next()?.parse::<f64>().ok();
    Some((ticks()? + ticks()?) / TICKS_PER_SECOND)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn output_is_read_from_commands_that_succeed() {
        let root = Path::new(".");
        assert!(output(cargo(root).arg("--version")).unwrap().starts_with("cargo "));
        assert!(output(cargo(root).arg("no-such-command")).is_err());
        assert!(has_subcommand("clippy") && !has_subcommand("no-such-command"));
    }

    #[test]
    fn children_are_counted() {
        let stat = "7 (a b) c) S 1 2 3 4 5 6 7 8 9 10 11 12 150 50 20 0 1";
        assert_eq!(seconds_in(stat), Some(2.0));
        assert_eq!(seconds_in("7 (a) S 1"), None);
        if cfg!(target_os = "linux") {
            assert!(seconds_of_children().is_some());
        }
    }
}
