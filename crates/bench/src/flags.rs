//! Flags shared by several commands.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::Args;
use umbrage::rays::SimdLevel;

use crate::plot::Chart;
use crate::shot;
use crate::table::{Form, Table};

/// Flags of commands that trace the gallery, or real scenes.
#[derive(Args, Debug)]
pub(crate) struct SceneFlags {
    /// Files, sequences or demo:NAME [default: the gallery's dynamic scenes, and the real ones of --files]
    scenes: Vec<String>,
    /// Folder of the real scenes
    #[arg(long, value_name = "DIR")]
    files: Option<PathBuf>,
}

impl SceneFlags {
    /// Addresses of the scenes that take part.
    pub(crate) fn addresses(&self) -> Vec<String> {
        shot::addresses(&self.scenes, self.files.as_ref())
    }
}

/// Flags of commands that make a table, and most of them a chart.
#[derive(Args, Debug)]
pub(crate) struct OutputFlags {
    /// How the results are written
    #[arg(long, value_enum, default_value = "table")]
    form: Form,
    /// Draw them as well
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
}

impl OutputFlags {
    /// Begins the table of a command that draws as well.
    pub(crate) fn start(&self, conditions: &str) -> Result<Table> {
        Ok(Table::start(self.form, conditions)?)
    }

    /// Begins the table of a command that draws nothing.
    pub(crate) fn start_without_chart(&self, conditions: &str) -> Result<Table> {
        ensure!(self.plot.is_none(), "these results come without a chart: leave --plot away");
        self.start(conditions)
    }

    /// Writes notes below the table, the rest of the table, and the chart, if requested.
    pub(crate) fn finish(&self, table: Table, notes: &[&str], chart: &dyn Chart) -> Result<()> {
        table.finish(notes)?;
        self.plot.iter().try_for_each(|path| write_chart(path, chart))
    }
}

/// Writes a chart as a file.
pub(crate) fn write_chart(path: &Path, chart: &dyn Chart) -> Result<()> {
    std::fs::write(path, chart.svg()?).with_context(|| format!("could not write {}", path.display()))
}

/// Flags of experiments that trace frames of animations.
#[derive(Args, Debug)]
pub(crate) struct AnimationFlags {
    /// Frames over each scene's animation; one more comes first and doesn't count
    #[arg(long, value_name = "N", default_value = "9", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) frames: u32,
    /// Ask alpha masks and opacity about hits, which all triangles go without by default
    #[arg(long)]
    pub(crate) masks: bool,
    /// Threads to work with [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// SIMD instructions for the grids: sse2, avx2 or avx512 [default: the widest]
    #[arg(long, value_name = "LEVEL")]
    pub(crate) simd: Option<SimdLevel>,
    #[command(flatten)]
    pub(crate) output: OutputFlags,
}

impl AnimationFlags {
    /// Starts the requested number of threads, and returns a line with the conditions of measurement.
    pub(crate) fn prepare(&self, size: Option<[u32; 2]>) -> Result<String> {
        use_threads(self.threads)?;
        let size = size.map_or_else(String::new, |[width, height]| format!("{width}x{height}, "));
        let (threads, simd) = (rayon::current_num_threads(), self.simd.unwrap_or_default());
        let masks = if self.masks { "asked" } else { "not asked" };
        let frames = self.frames;
        Ok(format!("{size}threads {threads}, {simd}, alpha masks {masks}, medians of {frames} frames in milliseconds"))
    }
}

/// The same, with images of one size.
#[derive(Args, Debug)]
pub(crate) struct ImageFlags {
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x1024", value_parser = size)]
    pub(crate) size: [u32; 2],
    #[command(flatten)]
    pub(crate) animation: AnimationFlags,
}

impl ImageFlags {
    /// Starts the requested number of threads, and begins the table.
    pub(crate) fn start(&self) -> Result<Table> {
        self.animation.output.start(&self.animation.prepare(Some(self.size))?)
    }

    /// The same for a command that draws nothing.
    pub(crate) fn start_without_chart(&self) -> Result<Table> {
        self.animation.output.start_without_chart(&self.animation.prepare(Some(self.size))?)
    }

    /// Writes notes below the table, the rest of the table, and the chart, if requested.
    pub(crate) fn finish(&self, table: Table, notes: &[&str], chart: &dyn Chart) -> Result<()> {
        self.animation.output.finish(table, notes, chart)
    }
}

/// Makes everything work on `threads` threads; `None` stands for one for each core.
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
