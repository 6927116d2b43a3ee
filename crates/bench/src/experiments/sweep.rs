//! The camera's grid in the paper's form, with cells of several sizes.

use anyhow::Result;
use clap::Args;
use umbrage::rays::{Cells, ListedOptions};

use crate::flags::ImageFlags;
use crate::measure::{Costs, measure};
use crate::plot::{LineChart, Scale, Series};
use crate::shot::{name, short_name};
use crate::table::Cell;

/// What all sweeps are told.
#[derive(Args, Debug)]
pub(super) struct SweepFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:hall", "demo:statue"])]
    scenes: Vec<String>,
    /// Test every triangle of a cell in all pixels of its sorting tile, as the paper does
    #[arg(long)]
    all_blocks: bool,
    #[command(flatten)]
    common: ImageFlags,
}

/// The chart of a sweep.
pub(super) struct Chart {
    pub(super) title: &'static str,
    pub(super) x_title: &'static str,
    /// Where cells are on the chart's axis.
    pub(super) along: fn(&Cells) -> u32,
}

const COLUMNS: &[(&str, usize)] = &[
    ("scene", 26),
    ("sorting_tile", 12),
    ("k", 4),
    ("tracing_tile", 12),
    ("slices", 6),
    ("pairs", 10),
    ("cells", 9),
    ("block_tests", 12),
    ("build", 8),
    ("see", 8),
    ("both", 8),
    ("bytes_triangle", 14),
];

impl SweepFlags {
    pub(super) fn run(&self, cells: &[Cells], note: &str, chart: &Chart) -> Result<()> {
        let options = |cells| ListedOptions { cells, skips_blocks: !self.all_blocks };
        let forms: Vec<_> = cells.iter().map(|&cells| options(cells).into()).collect();
        let mut table = self.common.start(COLUMNS)?;
        let mut series: Vec<Series> = Vec::new();
        for address in &self.scenes {
            let all = measure(address, self.common.size, &forms, &self.common.animation, |shot| shot.lights.clear())?;
            for (cells, costs) in cells.iter().zip(&all) {
                table.push(&row(name(address), cells, costs))?;
                let tile = cells.sorting_tile();
                let title = format!("{}, {tile}x{tile}", short_name(address));
                Series::add(&mut series, &title, [f64::from((chart.along)(cells)), costs.frame]);
            }
        }
        let &Chart { title, x_title, .. } = chart;
        let y_title = "milliseconds to build and see";
        let chart = LineChart { title, x_title, y_title, scales: [Scale::Doubling, Scale::Linear], series };
        self.common.finish(table, &[note], &chart)
    }
}

fn row(name: &str, cells: &Cells, costs: &Costs) -> Vec<Cell> {
    let (tile, k) = (cells.sorting_tile(), cells.tracing_tiles());
    let counts = costs.counts;
    let mut row: Vec<Cell> = vec![name.into()];
    row.extend([tile, k, tile * k, cells.slices()].map(|number| Cell::Count(u64::from(number))));
    row.extend([counts.pairs, counts.cells, counts.tests].map(Cell::Count));
    row.extend([costs.build, costs.see, costs.frame].map(|time| Cell::Number(time, 2)));
    row.push(Cell::Number(costs.bytes.triangles as f64 / costs.triangles.max(1) as f64, 1));
    row
}
