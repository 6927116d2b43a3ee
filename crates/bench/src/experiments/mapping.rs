//! The paper's indirect mapping (§3): sorting to small tiles, tracing by larger ones.

use anyhow::Result;
use clap::Args;
use umbrage_papers::Cells;

use super::sweep::{Chart, SweepFlags};

#[derive(Args, Debug)]
pub(crate) struct MappingFlags {
    /// Depth slices
    #[arg(long, value_name = "N", default_value_t = Cells::DEFAULT.slices())]
    slices: u32,
    #[command(flatten)]
    sweep: SweepFlags,
}

impl MappingFlags {
    pub(crate) fn run(&self) -> Result<()> {
        // Some tiles can't be this large, but either all can have these slices or none.
        Cells::new(8, 1, self.slices)?;
        let sizes = [8_u32, 16, 32, 64].into_iter().flat_map(|tile| [1, 2, 4, 8].map(|k| (tile, k)));
        let cells: Vec<Cells> = sizes.filter_map(|(tile, k)| Cells::new(tile, k, self.slices).ok()).collect();
        let x_title = "k, sorting tiles a side of a tracing tile";
        let chart = Chart { title: "Indirect mapping", x_title, along: Cells::tracing_tiles };
        let note = "k x k sorting tiles make a tracing tile; k = 1 is without indirect mapping. Primary rays only.";
        self.sweep.run(&cells, note, &chart)
    }
}
