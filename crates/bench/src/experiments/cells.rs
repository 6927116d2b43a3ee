//! Sizes of the camera grid's cells: sorting tiles and depth slices.

use anyhow::Result;
use clap::Args;
use umbrage_papers::Cells;

use super::sweep::{Chart, SweepFlags};

#[derive(Args, Debug)]
pub(crate) struct CellsFlags {
    /// Pixels a side of sorting tiles; tracing tiles are as large as they can be
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [8, 16, 32, 64])]
    tiles: Vec<u32>,
    /// Numbers of depth slices
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [1, 2, 4, 8, 16, 32])]
    slices: Vec<u32>,
    #[command(flatten)]
    sweep: SweepFlags,
}

/// Pixels a side of the largest tracing tile.
const LARGEST_TILE: u32 = 64;

impl CellsFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let sizes = self.tiles.iter().flat_map(|&tile| self.slices.iter().map(move |&slices| (tile, slices)));
        let cells: Vec<Cells> = sizes
            .map(|(tile, slices)| Cells::new(tile, (LARGEST_TILE / tile.max(1)).max(1), slices))
            .collect::<Result<_, _>>()?;
        let chart = Chart { title: "Cell sizes", x_title: "depth slices", along: Cells::slices };
        self.sweep.run(&cells, "Tracing tiles of 64x64 pixels. Primary rays only.", &chart)
    }
}
