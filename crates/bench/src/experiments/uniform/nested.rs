use anyhow::Result;
use clap::Args;
use umbrage_papers::UniformOptions;

use super::measure::{Costs, Way, measure};
use crate::flags::ImageFlags;
use crate::plot::{LineChart, Scale, Series};
use crate::shot::{name, short_name};
use crate::table::{Cell, Row, row};

#[derive(Args, Debug)]
pub(crate) struct NestedFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:stadium", "demo:forest", "demo:cloth", "demo:statue"])]
    scenes: Vec<String>,
    /// Triangles above which a cell may hold a grid of its own; none does first of all
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [16, 32, 64, 128, 256])]
    above: Vec<u32>,
    /// Trace the camera's rays one at a time as well: where no cell holds a grid, it takes minutes
    #[arg(long)]
    single: bool,
    #[command(flatten)]
    common: ImageFlags,
}

impl NestedFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let thresholds = || [None].into_iter().chain(self.above.iter().copied().map(Some));
        let options = |nested_above| UniformOptions { nested_above, ..UniformOptions::DEFAULT };
        let ways: &[Way] = if self.single { &[Way::Packets, Way::Single] } else { &[Way::Packets] };
        let forms: Vec<_> = thresholds().flat_map(|above| ways.iter().map(move |&way| (options(above), way))).collect();
        let mut table = self.common.start()?;
        let mut series = Vec::new();
        for address in &self.scenes {
            let costs = measure(address, self.common.size, &forms, &self.common.animation)?;
            for (above, costs) in thresholds().zip(costs.chunks_exact(ways.len())) {
                table.push(row(name(address), above, costs))?;
                // Without a limit no cell holds a grid.
                let x = f64::from(above.unwrap_or(1024));
                Series::add(&mut series, short_name(address), [x, costs[0].build + costs[0].see]);
            }
        }
        let notes = [
            "Cells that list more triangles than `above` may hold grids of their own, `grids` in number.",
            "see, single: the camera's rays in packets, and one at a time.",
        ];
        let (title, x_title) = ("Grids inside of cells", "triangles of a cell that may hold one (1024: none)");
        let y_title = "milliseconds to build and see";
        let chart = LineChart { title, x_title, y_title, scales: [Scale::Doubling, Scale::Logarithmic], series };
        self.common.finish(table, &notes, &chart)
    }
}

fn row(name: &str, above: Option<u32>, costs: &[Costs]) -> Row {
    let single = costs.get(1).map(|costs| costs.see);
    let costs = &costs[0];
    row![
        ("scene", name),
        ("above", above.map_or("none".into(), Cell::from)),
        ("grids", costs.nested_grids),
        ("references", costs.references),
        ("bytes_triangle", Cell::Number(costs.bytes as f64 / costs.triangles.max(1) as f64, 1)),
        ("build", costs.build),
        ("see", costs.see),
        ("single", single),
    ]
}
