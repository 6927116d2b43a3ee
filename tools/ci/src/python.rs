use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::command::build;
use crate::log::{Log, NotPassed, Outcome, skipped};
use crate::repository;

/// The folder of the package.
const FOLDER: &str = "crates/python";

/// Imports of tests and examples, besides the package itself; as in pyproject.toml's `test`.
const PACKAGES: &[&str] = &["OpenEXR", "numpy", "matplotlib", "pytest", "pyyaml", "rtree", "scipy", "trimesh"];

/// Imports of the farm, as in pyproject.toml's `farm`. Its tests are skipped, and say so, if these can't be installed.
const FARM_PACKAGES: &[&str] = &["pyarrow", "ray", "tqdm"];

/// The command, which the farm runs.
const COMMAND: &str = "umbrage";

/// Checks the Python package, with a library that is compiled with the whole workspace: its tests pass, and its
/// examples make pictures. `pip install .` would compile the dependencies once more, with other features.
pub(crate) fn check(root: &Path, log: &mut Log) -> Outcome {
    let python = python()?;
    let folder = repository::empty_folder(root, "python")?;
    let venv = folder.join("venv");
    log.run(Command::new(&python).args(["-m", "venv"]).arg(&venv))?;
    let python = venv.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let mut install = |packages: &[&str]| {
        let mut install = Command::new(&python);
        log.run(install.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]).args(packages))
    };
    if install(PACKAGES).is_err() {
        return skipped("the packages that the tests use can't be installed");
    }
    // The tests themselves report missing packages.
    let _ = install(FARM_PACKAGES);
    log.run(&mut library(root))?;
    let package = folder.join("site");
    stage(root, &package)?;
    let others = std::env::var_os("PATH").unwrap_or_default();
    let path = std::iter::once(repository::built_folder(root)).chain(std::env::split_paths(&others));
    let path = std::env::join_paths(path).map_err(|error| error.to_string())?;
    let in_package = |arguments: &[&str]| {
        let mut command = Command::new(&python);
        command.current_dir(root).env("PYTHONPATH", &package).env("PATH", &path).args(arguments);
        command
    };
    let tests = log.run(&mut in_package(&["-m", "pytest", "--quiet", "-p", "no:cacheprovider"]));
    let examples = repository::files(&root.join(FOLDER).join("examples"), "py")?;
    let picture = folder.join("picture.png");
    let examples = examples.iter().map(|example| {
        log.run(in_package(&[]).arg(example).arg(&picture))?;
        let bytes = fs::metadata(&picture).map(|file| file.len()).map_err(|error| error.to_string())?;
        fs::remove_file(&picture).map_err(|error| error.to_string())?;
        // A picture of one colour compresses to almost nothing.
        if bytes > 20_000 { Ok(()) } else { Err(format!("{}: an empty picture", example.display()).into()) }
    });
    examples.fold(tests, Outcome::and)
}

/// Finds a Python that is new enough.
fn python() -> Result<PathBuf, NotPassed> {
    let is_new = "import sys, venv; sys.exit(sys.version_info < (3, 9))";
    let names = ["python3", "python"].map(PathBuf::from);
    let found = names.into_iter().find(|name| {
        let mut asked = Command::new(name);
        asked.args(["-c", is_new]).stdout(Stdio::null()).stderr(Stdio::null());
        asked.status().is_ok_and(|status| status.success())
    });
    found.ok_or_else(|| NotPassed::Skipped("there is no Python 3.9 or newer with venv".to_owned()))
}

/// Builds the library and the command.
pub(crate) fn library(root: &Path) -> Command {
    let mut build = build(root, &[COMMAND]);
    build.arg("--lib");
    build
}

/// Copies the package's files to the places where an installation has them.
fn stage(root: &Path, site: &Path) -> Result<(), String> {
    let package = site.join("umbrage");
    fs::create_dir_all(&package).map_err(|error| format!("{}: {error}", package.display()))?;
    let copy = |from: &Path, to: &Path| {
        fs::copy(from, to).map(drop).map_err(|error| format!("{} to {}: {error}", from.display(), to.display()))
    };
    let sources = root.join(FOLDER).join("python/umbrage");
    for entry in fs::read_dir(&sources).map_err(|error| format!("{}: {error}", sources.display()))? {
        let path = entry.map_err(|error| error.to_string())?.path();
        let is_source = path.extension().is_some_and(|kind| ["py", "pyi", "typed"].iter().any(|of| kind == *of));
        if is_source && let Some(name) = path.file_name() {
            copy(&path, &package.join(name))?;
        }
    }
    let library = format!("{}umbrage_python{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let module = if cfg!(windows) { "_umbrage.pyd" } else { "_umbrage.abi3.so" };
    copy(&repository::built_folder(root).join(library), &package.join(module))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_packages_are_those_of_the_project() {
        let root = repository::root().unwrap();
        let project = repository::read(&root.join("pyproject.toml")).unwrap();
        let missing = |extra: &str, packages: &'static [&'static str]| {
            let line = project.lines().find(|line| line.starts_with(extra)).unwrap();
            packages.iter().filter(|package| !line.contains(&format!("\"{package}>="))).collect::<Vec<_>>()
        };
        assert_eq!(missing("test = ", PACKAGES), [&"numpy"], "numpy is asked for by the package itself");
        assert!(missing("farm = ", FARM_PACKAGES).is_empty());
    }
}
