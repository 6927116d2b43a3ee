//! Figure 10 of the paper: which stages a frame's time goes to.

use anyhow::Result;
use clap::Args;

use crate::flags::{ImageFlags, SceneFlags};
use crate::grids::Forms;
use crate::measure::{Costs, measure};
use crate::plot::{Bar, BarChart};
use crate::shot::{name, short_name, viewpoints};
use crate::table::Cell;

#[derive(Args, Debug)]
pub(crate) struct BreakdownFlags {
    #[command(flatten)]
    scenes: SceneFlags,
    #[command(flatten)]
    common: ImageFlags,
}

const COLUMNS: &[(&str, usize)] = &[
    ("scene", 26),
    ("triangles", 9),
    ("frame", 8),
    ("build", 8),
    ("see", 8),
    ("survey", 8),
    ("map", 8),
    ("sort", 8),
    ("project", 8),
    ("trace", 8),
    ("settle", 8),
    ("rearranging_percent", 19),
    ("shadows_percent", 15),
];

impl BreakdownFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let addresses = self.scenes.addresses();
        let mut bars = Vec::new();
        let mut table = self.common.start(COLUMNS)?;
        for address in &addresses {
            for costs in measure(address, self.common.size, &[Forms::default()], &self.common.animation, |_| {})? {
                let stages = stages(&costs);
                let sum: f64 = stages.iter().map(|(_, time)| time).sum();
                let percent = |of: &[&str]| {
                    let of: f64 = stages.iter().filter(|(name, _)| of.contains(name)).map(|(_, time)| time).sum();
                    100.0 * of / sum
                };
                let mut row = vec![name(address).into(), costs.triangles.into(), Cell::Number(costs.frame, 2)];
                row.extend(stages.iter().map(|&(_, time)| Cell::Number(time, 2)));
                row.push(Cell::Number(percent(&REARRANGING), 0));
                row.push(Cell::Number(100.0 - percent(&["build", "see"]), 0));
                table.push(&row)?;
                bars.push(Bar {
                    name: short_name(address).to_owned(),
                    heights: stages.iter().map(|(_, time)| 100.0 * time / sum).collect(),
                });
            }
        }
        viewpoints(&addresses).iter().try_for_each(|viewpoint| table.note(viewpoint))?;
        let notes = [
            "build and see are the camera's; the others are the light's. Rearranging is what the paper calls so:",
            "points brought to the light's view and sorted (survey, map, sort).",
        ];
        let parts = COLUMNS[3..11].iter().map(|&(title, _)| title.to_owned()).collect();
        let chart = BarChart { title: "Where a frame's time goes", y_title: "percent of the frame", parts, bars };
        self.common.finish(table, &notes, &chart)
    }
}

/// What the paper calls data rearrangement.
const REARRANGING: [&str; 3] = ["survey", "map", "sort"];

/// The camera's stages, and the light's.
fn stages(costs: &Costs) -> Vec<(&'static str, f64)> {
    let of_light = |name: &'static str| costs.light_stages.iter().find(|(stage, _)| *stage == name).copied();
    let lights = COLUMNS[5..11].iter().filter_map(|&(name, _)| of_light(name));
    [("build", costs.build), ("see", costs.see)].into_iter().chain(lights).collect()
}
