//! Figure 11 of the paper: shadows of a light that moves away.

use anyhow::Result;
use clap::Args;
use glam::Vec3;
use umbrage::rays::LightSource;

use crate::flags::{ExperimentFlags, size, use_threads};
use crate::measure::measure;
use crate::plot::{LineChart, Scale, Series};
use crate::shot::{name, short_name};
use crate::table::{Cell, Table};

#[derive(Args, Debug)]
pub(crate) struct DistanceFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:hall", "demo:shatter"])]
    scenes: Vec<String>,
    /// Distances of the light from the scene's centre, in units of half the diagonal of the scene's box
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = DISTANCES)]
    distances: Vec<f32>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x1024", value_parser = size)]
    size: [u32; 2],
    #[command(flatten)]
    common: ExperimentFlags,
}

const COLUMNS: &[(&str, usize)] = &[
    ("scene", 26),
    ("triangles", 9),
    ("distance", 8),
    ("rearranging", 11),
    ("project", 8),
    ("trace", 8),
    ("decide", 8),
    ("shadow", 8),
];

const DISTANCES: [f32; 9] = [0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 8.0, 16.0];

/// Where the light is, as the scene's centre sees it: above, to the right and in front.
const TOWARDS_LIGHT: Vec3 = Vec3::new(0.4, 0.8, 0.45);

impl DistanceFlags {
    /// Measures, prints and draws.
    pub(crate) fn run(&self) -> Result<()> {
        use_threads(self.common.threads)?;
        let conditions = self.common.conditions(Some(self.size));
        let mut table = Table::start(self.common.form, &conditions, COLUMNS)?;
        let mut lines = Vec::new();
        for address in &self.scenes {
            let mut points = Vec::new();
            for &distance in &self.distances {
                let costs = measure(address, self.size, &[None], &self.common, |shot| {
                    let reach = 0.5 * shot.bounds.size().length();
                    let position = shot.bounds.center() + TOWARDS_LIGHT.normalize() * (reach * distance);
                    shot.lights = vec![LightSource::Point { position }];
                })?;
                for costs in costs {
                    let of = |name: &str| {
                        costs.light_stages.iter().find(|stage| stage.0 == name).map_or(0.0, |stage| stage.1)
                    };
                    let shadow = costs.survey + costs.shadow;
                    let times =
                        [of("survey") + of("map") + of("sort"), of("project"), of("trace"), of("decide"), shadow];
                    let mut row =
                        vec![name(address).into(), costs.triangles.into(), Cell::Number(f64::from(distance), 2)];
                    row.extend(times.map(|time| Cell::Number(time, 2)));
                    table.push(&row)?;
                    points.push([f64::from(distance), shadow]);
                }
            }
            lines.push(Series { name: short_name(address).to_owned(), points });
        }
        table.note(
            "Rearranging is survey, map and sort; distances are in units of half the diagonal of the scene's box.",
        )?;
        table.finish()?;
        self.common.draw(|| {
            let (x_title, y_title) =
                ("distance of the light, in half diagonals of the scene's box", "milliseconds for shadows");
            let title = "Shadows of a light that moves away";
            LineChart { title, x_title, y_title, scales: [Scale::Doubling, Scale::Linear], series: lines }.svg()
        })
    }
}
