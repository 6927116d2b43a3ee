//! Figure 10 of the paper: which stages a frame's time goes to.

use anyhow::Result;
use clap::Args;
use umbrage_papers::{ListedLightOptions, ListedOptions};

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
        let listed = Forms { camera: Some(ListedOptions::DEFAULT), lights: Some(ListedLightOptions::DEFAULT) };
        let forms = [("listed", listed), ("direct", Forms::default())];
        for address in &addresses {
            let all = measure(address, self.common.size, &forms.map(|form| form.1), &self.common.animation, |_| {})?;
            for ((form, _), costs) in forms.iter().zip(all) {
                let stages = stages(&costs);
                let sum: f64 = stages.iter().map(|(_, time)| time).sum();
                let percent = |of: &[&str]| {
                    let of: f64 = stages.iter().filter(|(name, _)| of.contains(name)).map(|(_, time)| time).sum();
                    100.0 * of / sum
                };
                let mut row = row![("scene", name(address)), ("form", *form), ("frame", costs.frame)];
                row.extend(stages.iter().map(|&(title, time)| (title.to_owned(), time.into())));
                row.extend(row![
                    ("rearranging_percent", Cell::Number(percent(&REARRANGING), 0)),
                    ("shadows_percent", Cell::Number(100.0 - percent(&["build", "see"]), 0)),
                ]);
                table.push(row)?;
                bars.push(Bar {
                    name: format!("{}, {form}", short_name(address)),
                    heights: stages.iter().map(|(_, time)| 100.0 * time / sum).collect(),
                });
            }
        }
        viewpoints(&addresses).iter().try_for_each(|viewpoint| table.note(viewpoint))?;
        let notes = [
            "build and see are the camera's; the others are the light's. Rearranging is what the paper calls so: points",
            "brought to the light's view and sorted (survey, map, points). The direct form does that as it traces.",
        ];
        let parts = ["build", "see"].iter().chain(&OF_LIGHT).map(|&stage| stage.to_owned()).collect();
        let chart = BarChart { title: "Where a frame's time goes", y_title: "percent of the frame", parts, bars };
        self.common.finish(table, &notes, &chart)
    }
}

/// The stages of the light's grid.
const OF_LIGHT: [&str; 8] = ["survey", "map", "points", "project", "list", "sort", "trace", "settle"];

/// Stages that the paper calls data rearrangement.
const REARRANGING: [&str; 3] = ["survey", "map", "points"];

/// The camera's stages, and the light's.
fn stages(costs: &Costs) -> Vec<(&'static str, f64)> {
    let of_light = OF_LIGHT.into_iter().map(|name| (name, costs.light_stage(name)));
    [("build", costs.build), ("see", costs.see)].into_iter().chain(of_light).collect()
}
