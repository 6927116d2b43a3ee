//! Figure 11 of the paper: shadows of a light that moves away, by the most rays in a block of work.

use anyhow::Result;
use clap::Args;
use glam::Vec3;
use umbrage::rays::LightSource;
use umbrage_papers::ListedLightOptions;

use crate::flags::ImageFlags;
use crate::grids::Forms;
use crate::measure::{Costs, measure};
use crate::plot::{LineChart, Scale, Series};
use crate::shot::{name, short_name};
use crate::table::row;

#[derive(Args, Debug)]
pub(crate) struct DistanceFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:hall", "demo:shatter"])]
    scenes: Vec<String>,
    /// Distances of the light from the scene's centre, in units of half the diagonal of the scene's box
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = DISTANCES)]
    distances: Vec<f32>,
    /// The most rays in a block of work of the listed light grid: the paper's r, rounded up to a multiple of 16
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = RAYS)]
    rays: Vec<u32>,
    /// Cells a side of the listed light grid
    #[arg(long, value_name = "N", default_value_t = ListedLightOptions::DEFAULT.cells())]
    cells: u32,
    #[command(flatten)]
    common: ImageFlags,
}

const DISTANCES: [f32; 9] = [0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 8.0, 16.0];
const RAYS: [u32; 4] = [16, 64, 256, 1024];

/// Direction of the light from the scene's centre: above, to the right and in front.
const TOWARDS_LIGHT: Vec3 = Vec3::new(0.4, 0.8, 0.45);

impl DistanceFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.common.start()?;
        let mut series = Vec::new();
        // `None` stands for the direct form, which has no blocks.
        let blocks: Vec<_> = std::iter::once(None).chain(self.rays.iter().copied().map(Some)).collect();
        let forms: Vec<Forms> = blocks.iter().map(|&rays| self.forms(rays)).collect::<Result<_>>()?;
        for address in &self.scenes {
            for &distance in &self.distances {
                let all = measure(address, self.common.size, &forms, &self.common.animation, |shot| {
                    let reach = 0.5 * shot.bounds.size().length();
                    let position = shot.bounds.center() + TOWARDS_LIGHT.normalize() * (reach * distance);
                    shot.lights = vec![LightSource::Point { position }];
                })?;
                for (&rays, costs) in blocks.iter().zip(&all) {
                    let mut row = row![
                        ("scene", name(address)),
                        ("triangles", costs.triangles),
                        ("distance", f64::from(distance)),
                        ("rays_a_block", rays),
                    ];
                    row.extend(times(costs).map(|(title, time)| (title.to_owned(), time.into())));
                    table.push(row)?;
                    let form = rays.map_or("direct".to_owned(), |rays| format!("r = {rays}"));
                    let title = format!("{}, {form}", short_name(address));
                    Series::add(&mut series, &title, [f64::from(distance), costs.survey + costs.shadow]);
                }
            }
        }
        let notes = [
            "Rearranging is survey, map and the sorting of points; list is the sorting of triangles by cell.",
            "Without rays a block: the direct form. Distances are in units of half the diagonal of the scene's box.",
        ];
        let chart = LineChart {
            title: "Shadows of a light that moves away",
            x_title: "distance of the light, in half diagonals of the scene's box",
            y_title: "milliseconds for shadows",
            scales: [Scale::Doubling, Scale::Linear],
            series,
        };
        self.common.finish(table, &notes, &chart)
    }

    /// The direct form of the lights' grid, or the listed one with blocks of at most `rays` rays.
    fn forms(&self, rays: Option<u32>) -> Result<Forms> {
        let triangles = ListedLightOptions::DEFAULT.triangles();
        let options = rays.map(|rays| ListedLightOptions::new(self.cells, rays, triangles)).transpose()?;
        Ok(Forms { lights: options, ..Forms::default() })
    }
}

/// Times of rearranging, projecting, listing, tracing and settling, and their sum. The direct form lists nothing, and
/// rearranges as it traces.
fn times(costs: &Costs) -> [(&'static str, f64); 6] {
    let sum = |stages: &[&str]| stages.iter().map(|stage| costs.light_stage(stage)).sum();
    [
        ("rearranging", sum(&["survey", "map", "points"])),
        ("project", sum(&["project"])),
        ("list", sum(&["list", "sort"])),
        ("trace", sum(&["trace"])),
        ("settle", sum(&["settle"])),
        ("shadow", costs.survey + costs.shadow),
    ]
}
