use std::process::{Command, Stdio};

use crate::command::output;
use crate::log::{Log, Outcome, skipped};

/// Mesa's Vulkan adapter in software, lavapipe, which stands in for a GPU.
pub(crate) const SOFTWARE_ADAPTER: &str = "mesa-vulkan-drivers";

/// An X server without a screen.
pub(crate) const X_SERVER: &str = "xvfb";

/// Path of the browser that shows the page, as its package installs it.
pub(crate) const CHROMIUM: &str = "/usr/bin/chromium";

/// Debian packages that the checks need, besides those to build Rust programs. The last but one is loaded by windows
/// for their keys.
const PACKAGES: &[&str] = &[SOFTWARE_ADAPTER, X_SERVER, "libxkbcommon-x11-0", "chromium"];

/// Installs missing packages, if possible.
pub(crate) fn install(log: &mut Log) -> Outcome {
    install_missing(PACKAGES, is_installed, may_install(), |packages| {
        log.run(Command::new("apt-get").arg("update"))?;
        let mut install = Command::new("apt-get");
        log.run(
            install
                .args(["install", "--yes", "--no-install-recommends"])
                .args(packages)
                .env("DEBIAN_FRONTEND", "noninteractive"),
        )
    })
}

fn install_missing(
    packages: &[&str],
    is_installed: impl Fn(&str) -> bool,
    may_install: Result<(), String>,
    install: impl FnOnce(&[&str]) -> Outcome,
) -> Outcome {
    let missing: Vec<&str> = packages.iter().copied().filter(|package| !is_installed(package)).collect();
    match may_install {
        _ if missing.is_empty() => Ok(()),
        Ok(()) => install(&missing),
        Err(why) => skipped(&format!("{} missing, and {why}", missing.join(", "))),
    }
}

/// Whether a package is installed, or can be.
pub(crate) fn can_have(package: &str) -> bool {
    is_installed(package) || may_install().is_ok()
}

fn is_installed(package: &str) -> bool {
    let mut query = Command::new("dpkg-query");
    query.args(["--show", "--showformat", "${Status}", package]).stderr(Stdio::null());
    query.output().is_ok_and(|answer| answer.stdout.ends_with(b"ok installed"))
}

fn may_install() -> Result<(), String> {
    match output(Command::new("id").arg("-u")) {
        Ok(user) if user.trim() == "0" => {}
        _ => return Err("only root may install packages".to_owned()),
    }
    let found = Command::new("apt-get").arg("--version").stdout(Stdio::null()).status();
    found.map(drop).map_err(|error| format!("apt-get can't be run: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_missing_packages_are_installed() {
        let is_installed = |package: &str| package == "here";
        let asked = |packages: &[&str]| Err(packages.join(", ").into());
        assert_eq!(install_missing(&[], is_installed, Ok(()), asked), Ok(()));
        assert_eq!(install_missing(&["here"], is_installed, Ok(()), asked), Ok(()));
        assert_eq!(install_missing(&["here", "gone"], is_installed, Ok(()), asked), asked(&["gone"]));
        let refused = install_missing(&["gone"], is_installed, Err("no".to_owned()), asked);
        assert_eq!(refused, skipped("gone missing, and no"));
    }

    #[test]
    fn nonsense_is_not_installed() {
        assert!(!is_installed("no-such-package-by-any-name"));
    }
}
