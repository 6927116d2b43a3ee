use std::path::Path;
use std::process::{Command, Stdio};

use crate::command::run;
use crate::debian;
use crate::outcome::{NotPassed, Outcome};
use crate::repository::Build;

/// Rust's library for browsers.
const TARGET: &str = "wasm32-unknown-unknown";

/// The program in JavaScript that opens the page.
const TESTS: &str = "tools/web-tests";

/// The page is compiled for browsers, and a browser shows it, with the same pictures as this machine's.
pub(crate) fn check(root: &Path) -> Outcome {
    if !is_there(Command::new("rustup"), &["target", "add", TARGET]) {
        return skipped("Rust's library for browsers can't be installed (rustup target add wasm32-unknown-unknown)");
    }
    let web = Build::Dev.program(root, "web");
    run(Command::new(&web).current_dir(root).arg("build"))?;
    if !Path::new(debian::CHROMIUM).is_file() {
        return skipped("the page is compiled, but no browser shows it: Debian's chromium is missing");
    }
    let tests = root.join(TESTS);
    let in_tests = |program: &str| {
        let mut command = Command::new(program);
        command.current_dir(&tests).env("WEB", &web).env("CHROMIUM", debian::CHROMIUM);
        command
    };
    if !is_there(in_tests("npm"), &["ci", "--no-audit", "--no-fund"]) {
        return skipped("the page is compiled, but nothing drives a browser: npm or its playwright-core is missing");
    }
    run(in_tests("npm").args(["run", "--silent", "test"]))
}

/// Whether a command can be run and succeeds.
fn is_there(mut command: Command, arguments: &[&str]) -> bool {
    command.args(arguments).stdout(Stdio::null()).status().is_ok_and(|status| status.success())
}

fn skipped(why: &str) -> Outcome {
    Err(NotPassed::Skipped(why.to_owned()))
}
