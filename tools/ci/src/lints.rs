use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command::{Scope, cargo_workspace, output};

/// Clippy's own arguments.
const ARGUMENTS: [&str; 2] = ["-D", "warnings"];

/// Packages with code for the window.
pub(crate) const WINDOW_PACKAGES: &[&str] = &["umbrage-bench", "umbrage-cli", "umbrage-viewer"];

/// Clippy on all but the window.
pub(crate) fn clippy(root: &Path) -> Command {
    cargo_workspace(root, Scope::Windowless, &["clippy", "--all-targets"])
}

/// Clippy on the window as well.
pub(crate) fn window_clippy(root: &Path) -> Command {
    cargo_workspace(root, Scope::Whole, &["clippy", "--all-targets"])
}

/// Makes clippy's warnings errors.
pub(crate) fn denied(mut clippy: Command) -> Command {
    clippy.arg("--").args(ARGUMENTS);
    clippy
}

/// The documentation of all libraries but the window's. With an example and with all packages, dependencies have the
/// features with which clippy has checked them; with fewer, many would be checked again.
pub(crate) fn docs(root: &Path) -> Command {
    of_docs(cargo_workspace(root, Scope::Windowless, &["doc", "--no-deps", "--lib", "--example", "rays"]))
}

/// The documentation of all packages, programs included.
pub(crate) fn all_docs(root: &Path) -> Command {
    of_docs(cargo_workspace(root, Scope::Whole, &["doc", "--no-deps"]))
}

/// Makes warnings errors, and reuses clippy's checks of the workspace's crates. Cargo finds them fresh if they are
/// checked by the same program with the same arguments, which cargo-clippy passes in these variables.
fn of_docs(mut docs: Command) -> Command {
    docs.env("RUSTDOCFLAGS", ARGUMENTS.join(" "));
    if let Some(driver) = clippy_driver() {
        let arguments: String = ARGUMENTS.iter().map(|argument| format!("{argument}__CLIPPY_HACKERY__")).collect();
        docs.env("RUSTC_WORKSPACE_WRAPPER", driver).env("CLIPPY_ARGS", arguments);
    }
    docs
}

/// Path of clippy's compiler.
fn clippy_driver() -> Option<PathBuf> {
    let sysroot = output(Command::new("rustc").args(["--print", "sysroot"])).ok()?;
    let driver = Path::new(sysroot.trim()).join("bin").join(format!("clippy-driver{}", std::env::consts::EXE_SUFFIX));
    driver.is_file().then_some(driver)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::command::cargo;

    #[test]
    fn docs_find_fresh_what_clippy_has_checked() {
        let root = tempfile::tempdir().unwrap();
        let write = |path: &str, text: &str| {
            let path = root.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        };
        let manifest = |name: &str| format!("[package]\nname = \"{name}\"\nversion = \"0.1.0\"\nedition = \"2024\"\n");
        write("Cargo.toml", "[workspace]\nmembers = [\"a\", \"b\"]\nresolver = \"3\"\n");
        write("a/Cargo.toml", &manifest("a"));
        write("a/src/lib.rs", "//! A\n");
        write("b/Cargo.toml", &(manifest("b") + "[dependencies]\na = { path = \"../a\" }\n"));
        write("b/src/lib.rs", "//! B\n");
        let target = root.path().join("target");
        let cargo = |arguments: &[&str]| {
            let mut command = cargo(root.path());
            command.args(arguments).args(["--workspace", "--offline"]).env("CARGO_TARGET_DIR", &target);
            command
        };
        let mut log = crate::log::Log::default();
        log.run(&mut denied(cargo(&["clippy", "--all-targets"]))).unwrap();
        let mut checked = Vec::new();
        log.watch(&mut of_docs(cargo(&["doc", "--no-deps"])), |line| {
            checked.extend(line.contains("Checking").then(|| line.to_owned()));
        })
        .unwrap();
        assert!(checked.is_empty(), "{checked:?}");
        assert_eq!(log.compiled.count, 4, "each crate is checked and documented");
    }
}
