//! Sizes of the camera grid's cells: sorting tiles and depth slices.

use anyhow::Result;
use clap::Args;
use umbrage::rays::{Cells, ListedOptions};

use crate::flags::{ExperimentFlags, size, use_threads};
use crate::measure::measure;
use crate::plot::{LineChart, Scale, Series};
use crate::shot::{name, short_name};
use crate::table::{Cell, Table};

#[derive(Args, Debug)]
pub(crate) struct CellsFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:hall", "demo:statue"])]
    scenes: Vec<String>,
    /// Pixels a side of sorting tiles; tracing tiles are as large as they can be
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [8, 16, 32, 64])]
    tiles: Vec<u32>,
    /// Numbers of depth slices
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [1, 2, 4, 8, 16, 32])]
    slices: Vec<u32>,
    /// Test every triangle of a cell in all pixels of its sorting tile, as the paper does
    #[arg(long)]
    all_blocks: bool,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x1024", value_parser = size)]
    size: [u32; 2],
    #[command(flatten)]
    common: ExperimentFlags,
}

const COLUMNS: &[(&str, usize)] = &[
    ("scene", 26),
    ("sorting_tile", 12),
    ("slices", 6),
    ("pairs", 10),
    ("cells", 9),
    ("block_tests", 12),
    ("build", 8),
    ("see", 8),
    ("both", 8),
    ("bytes_triangle", 14),
];

/// Pixels a side of the largest tracing tile.
const LARGEST_TILE: u32 = 64;

impl CellsFlags {
    /// Measures, prints and draws.
    pub(crate) fn run(&self) -> Result<()> {
        use_threads(self.common.threads)?;
        let sizes = self.tiles.iter().flat_map(|&tile| self.slices.iter().map(move |&slices| (tile, slices)));
        let possible: Vec<Cells> = sizes
            .map(|(tile, slices)| Cells::new(tile, (LARGEST_TILE / tile.max(1)).max(1), slices))
            .collect::<Result<_, _>>()?;
        let options = |cells| ListedOptions { cells, skips_blocks: !self.all_blocks, ..ListedOptions::DEFAULT };
        let forms: Vec<_> = possible.iter().map(|&cells| options(cells).into()).collect();
        let conditions = self.common.conditions(Some(self.size));
        let mut table = Table::start(self.common.form, &conditions, COLUMNS)?;
        let mut series: Vec<Series> = Vec::new();
        for address in &self.scenes {
            let all = measure(address, self.size, &forms, &self.common, |shot| shot.lights.clear())?;
            for (cells, costs) in possible.iter().zip(all) {
                let (tile, slices) = (cells.sorting_tile(), cells.slices());
                let counts = costs.listed.unwrap_or_default();
                let mut row: Vec<Cell> = vec![name(address).into()];
                row.extend([tile, slices].map(|number| Cell::Count(u64::from(number))));
                row.extend([counts.pairs, counts.cells, counts.tests].map(Cell::Count));
                row.extend([costs.build, costs.see, costs.frame].map(|time| Cell::Number(time, 2)));
                row.push(Cell::Number(costs.bytes[0] as f64 / costs.triangles.max(1) as f64, 1));
                table.push(&row)?;
                let title = format!("{}, {tile}x{tile}", short_name(address));
                let point = [f64::from(slices), costs.frame];
                Series::add(&mut series, &title, point);
            }
        }
        table.note("Tracing tiles of 64x64 pixels. Primary rays only.")?;
        table.finish()?;
        self.common.draw(|| {
            let (x_title, y_title) = ("depth slices", "milliseconds to build and see");
            LineChart { title: "Cell sizes", x_title, y_title, scales: [Scale::Doubling, Scale::Linear], series }.svg()
        })
    }
}
