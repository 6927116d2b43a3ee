//! Figure 10 of the paper: which stages a frame's time goes to.

use anyhow::Result;
use clap::Args;

use crate::flags::{ImageFlags, SceneFlags};
use crate::grids::Forms;
use crate::measure::{Costs, measure};
use crate::plot::{Bar, BarChart};
use crate::shot::{name, short_name, viewpoints};
use crate::table::{Cell, row};

#[derive(Args, Debug)]
pub(crate) struct BreakdownFlags {
    #[command(flatten)]
    scenes: SceneFlags,
    #[command(flatten)]
    common: ImageFlags,
}

impl BreakdownFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let addresses = self.scenes.addresses();
        let mut bars = Vec::new();
        let mut table = self.common.start()?;
        for address in &addresses {
            for costs in measure(address, self.common.size, &[Forms::default()], &self.common.animation, |_| {})? {
                let stages = stages(&costs);
                let sum: f64 = stages.iter().map(|(_, time)| time).sum();
                let percent = |of: &[&str]| {
                    let of: f64 = stages.iter().filter(|(name, _)| of.contains(name)).map(|(_, time)| time).sum();
                    100.0 * of / sum
                };
                let mut row = row![("scene", name(address)), ("triangles", costs.triangles), ("frame", costs.frame)];
                row.extend(stages.iter().map(|&(title, time)| (title.to_owned(), time.into())));
                row.extend(row![
                    ("rearranging_percent", Cell::Number(percent(&REARRANGING), 0)),
                    ("shadows_percent", Cell::Number(100.0 - percent(&["build", "see"]), 0)),
                ]);
                table.push(row)?;
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
        let parts = ["build", "see"].iter().chain(&OF_LIGHT).map(|&stage| stage.to_owned()).collect();
        let chart = BarChart { title: "Where a frame's time goes", y_title: "percent of the frame", parts, bars };
        self.common.finish(table, &notes, &chart)
    }
}

/// The stages of the light's grid.
const OF_LIGHT: [&str; 6] = ["survey", "map", "sort", "project", "trace", "settle"];

/// What the paper calls data rearrangement.
const REARRANGING: [&str; 3] = ["survey", "map", "sort"];

/// The camera's stages, and the light's.
fn stages(costs: &Costs) -> Vec<(&'static str, f64)> {
    let of_light = |name: &'static str| costs.light_stages.iter().find(|(stage, _)| *stage == name).copied();
    let lights = OF_LIGHT.iter().filter_map(|&name| of_light(name));
    [("build", costs.build), ("see", costs.see)].into_iter().chain(lights).collect()
}
