//! The paper's indirect mapping (§3): sorting to small tiles, tracing by larger ones.

use anyhow::Result;
use clap::Args;
use umbrage::rays::{Cells, ListedOptions};

use crate::flags::{ExperimentFlags, size, use_threads};
use crate::measure::measure;
use crate::plot::{LineChart, Scale, Series};
use crate::shot::{name, short_name};
use crate::table::{Cell, Table};

#[derive(Args, Debug)]
pub(crate) struct MappingFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:hall", "demo:statue"])]
    scenes: Vec<String>,
    /// Depth slices
    #[arg(long, value_name = "N", default_value_t = Cells::DEFAULT.slices())]
    slices: u32,
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
    ("k", 4),
    ("tracing_tile", 12),
    ("pairs", 10),
    ("cells", 9),
    ("block_tests", 12),
    ("build", 8),
    ("see", 8),
    ("both", 8),
];

impl MappingFlags {
    /// Measures, prints and draws.
    pub(crate) fn run(&self) -> Result<()> {
        use_threads(self.common.threads)?;
        let sizes = [8_u32, 16, 32, 64].into_iter().flat_map(|tile| [1, 2, 4, 8].map(|k| (tile, k)));
        let possible: Vec<Cells> = sizes.filter_map(|(tile, k)| Cells::new(tile, k, self.slices).ok()).collect();
        let options = |cells| ListedOptions { cells, skips_blocks: !self.all_blocks, ..ListedOptions::DEFAULT };
        let forms: Vec<_> = possible.iter().map(|&cells| options(cells).into()).collect();
        let conditions = self.common.conditions(Some(self.size));
        let mut table = Table::start(self.common.form, &conditions, COLUMNS)?;
        let mut series: Vec<Series> = Vec::new();
        for address in &self.scenes {
            let all = measure(address, self.size, &forms, &self.common, |shot| shot.lights.clear())?;
            for (cells, costs) in possible.iter().zip(all) {
                let (tile, k) = (cells.sorting_tile(), cells.tracing_tiles());
                let counts = costs.listed.unwrap_or_default();
                let mut row: Vec<Cell> = vec![name(address).into()];
                row.extend([tile, k, tile * k].map(|number| Cell::Count(u64::from(number))));
                row.extend([counts.pairs, counts.cells, counts.tests].map(Cell::Count));
                row.extend([costs.build, costs.see, costs.frame].map(|time| Cell::Number(time, 2)));
                table.push(&row)?;
                let title = format!("{}, {tile}x{tile}", short_name(address));
                let point = [f64::from(k), costs.frame];
                Series::add(&mut series, &title, point);
            }
        }
        table.note("k x k sorting tiles make a tracing tile; k = 1 is without indirect mapping. Primary rays only.")?;
        table.finish()?;
        self.common.draw(|| {
            let (x_title, y_title) = ("k, sorting tiles a side of a tracing tile", "milliseconds to build and see");
            LineChart { title: "Indirect mapping", x_title, y_title, scales: [Scale::Doubling, Scale::Linear], series }
                .svg()
        })
    }
}
