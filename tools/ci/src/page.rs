use std::path::Path;
use std::process::{Command, Stdio};

use crate::command::build;
use crate::debian;
use crate::log::{Log, Outcome, skipped};
use crate::repository::built;

/// Rust's library for browsers.
const TARGET: &str = "wasm32-unknown-unknown";

/// The program in JavaScript that opens the page.
const TESTS: &str = "tools/web-tests";

/// Compiles the page for browsers, and checks that a browser shows it, with the same pictures as this machine's.
pub(crate) fn check(root: &Path, log: &mut Log) -> Outcome {
    if !is_there(Command::new("rustup"), &["target", "add", TARGET]) {
        return skipped("Rust's library for browsers can't be installed (rustup target add wasm32-unknown-unknown)");
    }
    log.run(&mut build(root, &["web"]))?;
    let web = built(root, "web");
    log.run(Command::new(&web).current_dir(root).arg("build"))?;
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
    log.run(in_tests("npm").args(["run", "--silent", "test"]))
}

/// Whether a command can be run and succeeds.
fn is_there(mut command: Command, arguments: &[&str]) -> bool {
    command.args(arguments).stdout(Stdio::null()).status().is_ok_and(|status| status.success())
}
