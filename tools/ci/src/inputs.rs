use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use sha2::{Digest, Sha256};

use crate::command::{cargo, output};
use crate::passed::FILE as PASSED;

/// Inputs of every part, besides its own.
const SHARED: &[&str] = &["Cargo.toml", "Cargo.lock"];

/// The files that decide whether a part passes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inputs {
    /// The packages that the part compiles, besides their dependencies; empty for the whole workspace.
    pub(crate) packages: &'static [&'static str],
    /// Whether their tests are compiled, so that dev-dependencies count.
    pub(crate) tests: bool,
    /// The selected features, of these packages and others.
    pub(crate) features: &'static [&'static [&'static str]],
    /// Other files and folders, from the root on.
    pub(crate) others: &'static [&'static str],
}

impl Inputs {
    /// The SHA-256 of all inputs' paths and contents, in hexadecimal digits. Files that git ignores are left out, and
    /// so is Markdown unless it is named.
    ///
    /// # Errors
    /// If git is missing, or doesn't know the repository.
    pub(crate) fn hash(&self, root: &Path) -> Result<String, String> {
        let mut list = Command::new("git");
        list.current_dir(root).args(["ls-files", "-z", "--cached", "--others", "--exclude-standard", "--"]);
        list.args(self.folders(root)?).args(SHARED).args(self.others);
        let listed = output(&mut list)?;
        let is_input = |path: &&str| self.others.contains(path) || !path.ends_with(".md") && *path != PASSED;
        // A deleted file may still be in git's index.
        let paths: BTreeSet<_> =
            listed.split_terminator('\0').filter(is_input).filter(|path| root.join(path).is_file()).collect();
        let mut hash = Sha256::new();
        for path in paths {
            let bytes = fs::read(root.join(path)).map_err(|error| format!("{path}: {error}"))?;
            // The length marks the end of each file.
            hash.update(format!("{path}\0{}\0", bytes.len()));
            hash.update(&bytes);
        }
        Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
    }

    /// Folders, relative to the root, of the packages and of the repository's packages that they depend on.
    pub(crate) fn folders(&self, root: &Path) -> Result<BTreeSet<String>, String> {
        let mut tree = cargo(root);
        tree.args(["tree", "--locked", "--prefix", "none", "--format", "{p}", "--edges"]);
        tree.arg(if self.tests { "normal,build,dev" } else { "normal,build" });
        if self.packages.is_empty() {
            tree.arg("--workspace");
        }
        tree.args(self.packages.iter().flat_map(|name| ["-p", name]));
        let is_selected = |feature: &&&str| {
            let package = feature.split('/').next().unwrap_or_default();
            self.packages.is_empty() || self.packages.contains(&package)
        };
        tree.args(
            self.features.iter().copied().flatten().filter(is_selected).flat_map(|feature| ["--features", feature]),
        );
        let root = root.canonicalize().map_err(|error| format!("{}: {error}", root.display()))?;
        // A package of the repository has its folder after name and version.
        let folder = |line: &str| {
            let folder = line.split_once(" (")?.1.split(')').next()?;
            Path::new(folder).strip_prefix(&root).ok()?.to_str().map(str::to_owned)
        };
        Ok(output(&mut tree)?.lines().filter_map(folder).collect())
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A git repository of packages `a`, which depends on `b` and, for its tests, on `c`, and of `d`.
    pub(crate) struct Repository(tempfile::TempDir);

    impl Repository {
        pub(crate) fn new() -> Self {
            let repository = Self(tempfile::tempdir().unwrap());
            repository.write("Cargo.toml", "[workspace]\nmembers = [\"a\", \"b\", \"c\", \"d\"]\nresolver = \"3\"\n");
            for (name, more) in [
                ("a", "[dependencies]\nb = { path = \"../b\" }\n[dev-dependencies]\nc = { path = \"../c\" }\n"),
                ("b", ""),
                ("c", ""),
                ("d", ""),
            ] {
                let package = format!("[package]\nname = \"{name}\"\nedition = \"2024\"\n{more}");
                repository.write(&format!("{name}/Cargo.toml"), &package);
                repository.write(&format!("{name}/src/lib.rs"), "//! A library\n");
                repository.write(&format!("{name}/src/more.rs"), "");
            }
            repository.write(".gitignore", "/a/made\n");
            repository.write("docs/guide.md", "A guide\n");
            repository.write(PASSED, "");
            for arguments in [["init", "-q"], ["add", "."]] {
                output(Command::new("git").current_dir(repository.root()).args(arguments)).unwrap();
            }
            output(cargo(repository.root()).args(["generate-lockfile", "--offline"])).unwrap();
            repository
        }

        pub(crate) fn root(&self) -> &Path {
            self.0.path()
        }

        pub(crate) fn write(&self, path: &str, text: &str) {
            let path = self.root().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
    }

    const TESTED: Inputs = Inputs { packages: &["a"], tests: true, features: &[], others: &["docs/guide.md", "tools"] };

    #[test]
    fn inputs_change_the_hash_and_nothing_else_does() {
        let repository = Repository::new();
        let root = repository.root();
        let mut last = TESTED.hash(root).unwrap();
        let mut changes = |what: &str| {
            let hash = TESTED.hash(root).unwrap();
            let changes = hash != last;
            assert_eq!(hash.len(), 64, "{what}");
            last = hash;
            changes
        };
        for path in
            ["a/src/lib.rs", "b/src/lib.rs", "c/src/lib.rs", "a/new.txt", "docs/guide.md", "tools/x", "Cargo.toml"]
        {
            let text = fs::read_to_string(root.join(path)).unwrap_or_default();
            repository.write(path, &(text + "# \n"));
            assert!(changes(path), "{path}");
        }
        for path in ["d/src/lib.rs", "a/made", "a/README.md", "docs/other.txt", "new.txt", PASSED] {
            repository.write(path, "# \n");
            assert!(!changes(path), "{path}");
        }
        fs::rename(root.join("a/new.txt"), root.join("a/other.txt")).unwrap();
        assert!(changes("a renamed file"));
        fs::rename(root.join("a/other.txt"), root.join("a/new.txt")).unwrap();
        assert!(changes("its first name"));
        repository.write("b/src/lib.rs", "//! A library\n# \r");
        assert!(changes("one byte"));
        fs::remove_file(root.join("b/src/more.rs")).unwrap();
        assert!(changes("a deleted file of git's index"));
    }

    #[test]
    fn dev_dependencies_count_if_tests_are_compiled() {
        let repository = Repository::new();
        let folders = |inputs: Inputs| inputs.folders(repository.root()).unwrap().into_iter().collect::<Vec<_>>();
        assert_eq!(folders(TESTED), ["a", "b", "c"]);
        assert_eq!(folders(Inputs { tests: false, ..TESTED }), ["a", "b"]);
        assert_eq!(folders(Inputs { packages: &[], ..TESTED }), ["a", "b", "c", "d"]);
    }

    #[test]
    fn without_git_there_is_no_hash() {
        let repository = Repository::new();
        fs::remove_dir_all(repository.root().join(".git")).unwrap();
        assert!(TESTED.hash(repository.root()).is_err());
    }
}
