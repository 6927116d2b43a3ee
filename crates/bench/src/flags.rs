//! What several commands are told alike.

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use umbrage::rays::SimdLevel;

use crate::table::{Columns, Form, Table};

/// Flags of every experiment.
#[derive(Args, Debug)]
pub(crate) struct ExperimentFlags {
    /// Frames over each scene's animation; one more comes first and doesn't count
    #[arg(long, value_name = "N", default_value = "9", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) frames: u32,
    /// Ask alpha masks and opacity about hits, which all triangles go without by default
    #[arg(long)]
    pub(crate) masks: bool,
    /// Threads to work with [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// SIMD instructions for the grids: sse2, sse4.2, avx2 or avx512 [default: the widest]
    #[arg(long, value_name = "LEVEL")]
    pub(crate) simd: Option<SimdLevel>,
    /// How the results are written
    #[arg(long, value_enum, default_value = "table")]
    pub(crate) form: Form,
    /// Draw them as well
    #[arg(long, value_name = "FILE.svg")]
    pub(crate) plot: Option<PathBuf>,
}

impl ExperimentFlags {
    /// Has everything use as many threads as are asked for, and begins the table.
    pub(crate) fn start(&self, size: Option<[u32; 2]>, columns: Columns) -> Result<Table> {
        use_threads(self.threads)?;
        Ok(Table::start(self.form, &self.conditions(size), columns)?)
    }

    /// How everything is measured, in one line.
    fn conditions(&self, size: Option<[u32; 2]>) -> String {
        let size = size.map_or_else(String::new, |[width, height]| format!("{width}x{height}, "));
        let (threads, simd) = (rayon::current_num_threads(), self.simd.unwrap_or_default());
        let masks = if self.masks { "asked" } else { "not asked" };
        let frames = self.frames;
        format!("{size}threads {threads}, {simd}, alpha masks {masks}, medians of {frames} frames in milliseconds")
    }

    /// Writes the chart, if one is wanted.
    pub(crate) fn draw(&self, svg: impl FnOnce() -> String) -> Result<()> {
        draw(self.plot.as_ref(), svg)
    }
}

/// Writes a chart to `path`, if there is one.
pub(crate) fn draw(path: Option<&PathBuf>, svg: impl FnOnce() -> String) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    std::fs::write(path, svg()).with_context(|| format!("could not write {}", path.display()))
}

/// Makes everything work on as many threads; `None` for one for each core.
pub(crate) fn use_threads(threads: Option<u16>) -> Result<()> {
    threads.map_or(Ok(()), |threads| {
        Ok(rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads)).build_global()?)
    })
}

/// Parses `WIDTHxHEIGHT` in pixels.
pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    sides.ok_or_else(|| "two numbers are needed, such as 1024x1024".to_owned())
}
