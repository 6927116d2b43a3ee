use anyhow::Result;
use clap::Args;
use umbrage_papers::UniformOptions;

use super::measure::{Costs, Way, measure};
use crate::flags::ImageFlags;
use crate::plot::{LineChart, Scale, Series};
use crate::shot::{name, short_name};
use crate::table::{Cell, Row, row};

#[derive(Args, Debug)]
pub(crate) struct DensityFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:marbles", "demo:forest", "demo:hall", "demo:shatter", "demo:statue"])]
    scenes: Vec<String>,
    /// Cells for each triangle: λ of the paper
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [0.5, 1.0, 2.0, 4.0, 6.0, 8.0, 12.0, 16.0, 32.0])]
    densities: Vec<f64>,
    #[command(flatten)]
    common: ImageFlags,
}

impl DensityFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let options = |cells_per_triangle| UniformOptions { cells_per_triangle, ..UniformOptions::DEFAULT };
        let forms: Vec<_> = self.densities.iter().map(|&density| (options(density), Way::Packets)).collect();
        let mut table = self.common.start()?;
        let mut series = Vec::new();
        for address in &self.scenes {
            let costs = measure(address, self.common.size, &forms, &self.common.animation)?;
            let both = |costs: &Costs| costs.build + costs.see;
            let best = costs.iter().map(both).fold(f64::INFINITY, f64::min);
            for (&density, costs) in self.densities.iter().zip(&costs) {
                let rate = best / both(costs);
                table.push(row(name(address), density, costs, rate))?;
                Series::add(&mut series, short_name(address), [density, rate]);
            }
        }
        let notes = [
            "Built and seen through, in packets of 32x32 pixels. rate_to_best: frames a second by those of the best.",
            "Wald et al. 2006, Figure 6: nearly all scenes are the fastest at about 6.",
        ];
        let (title, x_title, y_title) = ("Cells for each triangle", "cells for each triangle", "rate by the best rate");
        let chart = LineChart { title, x_title, y_title, scales: [Scale::Doubling, Scale::Linear], series };
        self.common.finish(table, &notes, &chart)
    }
}

fn row(name: &str, density: f64, costs: &Costs, rate: f64) -> Row {
    row![
        ("scene", name),
        ("cells_triangle", Cell::Number(density, 1)),
        ("references", costs.references),
        ("bytes_triangle", Cell::Number(costs.bytes as f64 / costs.triangles.max(1) as f64, 1)),
        ("build", costs.build),
        ("see", costs.see),
        ("both", costs.build + costs.see),
        ("rate_to_best", rate),
    ]
}
