use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, bail, ensure};
use wasm_bindgen_cli_support::Bindgen;

const TARGET: &str = "wasm32-unknown-unknown";

/// The page's files beside the engine: markup, styles, scripts.
const SITE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/site");

/// Writes the page to a folder.
pub(crate) fn build(folder: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("{} can't be made", folder.display()))?;
    let module = compile()?;
    let mut bindgen = Bindgen::new();
    bindgen.input_path(&module).out_name("umbrage").typescript(false).web(true)?;
    bindgen.omit_default_module_path(false).remove_name_section(true);
    bindgen.generate(folder).context("the engine's JavaScript can't be made")?;
    // Servers that compress it don't send its length.
    let bytes = fs::metadata(folder.join("umbrage_bg.wasm")).context("the engine isn't there")?.len();
    fs::write(folder.join("engine-size.js"), format!("export default {bytes};\n"))?;
    for entry in fs::read_dir(SITE).with_context(|| SITE.to_owned())? {
        let from = entry?.path();
        let name = from.file_name().context("a file without a name")?;
        let to = folder.join(name);
        fs::copy(&from, &to).with_context(|| format!("{} can't be written", to.display()))?;
    }
    println!("the page is in {}", folder.display());
    Ok(())
}

/// Compiles the engine, and returns its path.
fn compile() -> anyhow::Result<PathBuf> {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| workspace.join("target"), PathBuf::from);
    let mut command = Command::new(cargo);
    command
        .current_dir(&workspace)
        .args(["build", "--locked", "--profile", "page", "--package", "umbrage-page", "--target", TARGET])
        .arg("--target-dir")
        .arg(&target)
        // Compiler flags for this machine's programs don't apply to browsers.
        .env("RUSTFLAGS", "-C target-feature=+simd128")
        .env_remove("CARGO_ENCODED_RUSTFLAGS");
    let status = command.status().context("cargo can't be run")?;
    if !status.success() {
        ensure!(has_target(), "Rust's library for browsers is missing: `rustup target add {TARGET}` installs it");
        bail!("the engine doesn't compile for browsers");
    }
    Ok(target.join(TARGET).join("page/umbrage_page.wasm"))
}

/// Whether Rust's standard library for browsers is installed.
fn has_target() -> bool {
    let mut asked = Command::new("rustc");
    asked.args(["--print", "target-libdir", "--target", TARGET]);
    asked.output().is_ok_and(|answer| Path::new(String::from_utf8_lossy(&answer.stdout).trim()).is_dir())
}
