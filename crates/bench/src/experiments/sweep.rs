//! The camera's grid in the paper's form, with cells of several sizes.

use anyhow::Result;
use clap::Args;
use umbrage_papers::{Cells, ListedOptions};

use crate::flags::ImageFlags;
use crate::measure::{Costs, measure};
use crate::plot::{LineChart, Scale, Series};
use crate::shot::{name, short_name};
use crate::table::{Cell, Row, row};

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
    /// Position of cells on the chart's axis.
    pub(super) along: fn(&Cells) -> u32,
}

impl SweepFlags {
    pub(super) fn run(&self, cells: &[Cells], note: &str, chart: &Chart) -> Result<()> {
        let options = |cells| ListedOptions { cells, skips_blocks: !self.all_blocks, ..ListedOptions::DEFAULT };
        let forms: Vec<_> = cells.iter().map(|&cells| options(cells).into()).collect();
        let mut table = self.common.start()?;
        let mut series: Vec<Series> = Vec::new();
        for address in &self.scenes {
            let all = measure(address, self.common.size, &forms, &self.common.animation, |shot| shot.lights.clear())?;
            for (cells, costs) in cells.iter().zip(&all) {
                table.push(row(name(address), cells, costs))?;
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

fn row(name: &str, cells: &Cells, costs: &Costs) -> Row {
    let (tile, k) = (cells.sorting_tile(), cells.tracing_tiles());
    let counts = costs.counts;
    row![
        ("scene", name),
        ("sorting_tile", tile),
        ("k", k),
        ("tracing_tile", tile * k),
        ("slices", cells.slices()),
        ("pairs", counts.pairs),
        ("cells", counts.cells),
        ("block_tests", counts.tests),
        ("build", costs.build),
        ("see", costs.see),
        ("both", costs.frame),
        ("bytes_triangle", Cell::Number(costs.bytes.triangles as f64 / costs.triangles.max(1) as f64, 1)),
    ]
}
