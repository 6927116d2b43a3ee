//! How time and memory grow with triangles and pixels.

use anyhow::Result;
use clap::Args;

use umbrage::rays::Bytes;

use crate::flags::AnimationFlags;
use crate::grids::Forms;
use crate::measure::{Costs, measure};
use crate::plot::{LineChart, Scale, Series};
use crate::shot::{name, short_name};
use crate::table::{Cell, Row, row};

#[derive(Args, Debug)]
pub(crate) struct GrowthFlags {
    /// Scenes of the gallery
    #[arg(default_values = ["demo:statue", "demo:cloth"])]
    scenes: Vec<String>,
    /// Triangles of each scene, at 1024x1024 pixels
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = TRIANGLES)]
    triangles: Vec<u32>,
    /// Widths and heights of the image, for the number of triangles that each scene has by itself
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [256, 512, 1024, 2048, 4096])]
    sides: Vec<u32>,
    #[command(flatten)]
    common: AnimationFlags,
}

const TRIANGLES: [u32; 7] = [10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000, 10_000_000];

/// Width and height while triangles grow, in pixels.
const SIDE: u32 = 1024;

impl GrowthFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.common.output.start(&self.common.prepare(None)?)?;
        let mut series = Vec::new();
        for address in &self.scenes {
            let triangles = self.triangles.iter().map(|count| (format!("{address}?triangles={count}"), SIDE));
            let pixels = self.sides.iter().map(|&side| (address.clone(), side));
            for (grows, steps) in [("triangles", triangles.collect::<Vec<_>>()), ("pixels", pixels.collect())] {
                let mut points: Vec<[f64; 2]> = Vec::new();
                for (step, side) in steps {
                    for costs in measure(&step, [side, side], &[Forms::default()], &self.common, |_| {})? {
                        let pixels = side as usize * side as usize;
                        let size = if grows == "triangles" { costs.triangles } else { pixels };
                        let point = [size as f64, costs.frame];
                        let slope = points.last().map(|&last| slope(&[last, point]));
                        table.push(row(name(address), grows, &costs, pixels, (point, slope)))?;
                        points.push(point);
                    }
                }
                table.note(&format!(
                    "{}, in {grows}: time grows with power {:.2}, fitted to all steps",
                    name(address),
                    slope(&points)
                ))?;
                series.push(Series { name: format!("{}, {grows}", short_name(address)), points });
            }
        }
        let notes = ["slope: the power with which time grows from the step before; 1 is linear."];
        let (x_title, y_title) = ("triangles (at 1024x1024 pixels), or pixels", "milliseconds a frame");
        let chart = LineChart { title: "Growth", x_title, y_title, scales: [Scale::Logarithmic; 2], series };
        self.common.output.finish(table, &notes, &chart)
    }
}

fn row(scene: &str, grows: &str, costs: &Costs, pixels: usize, (point, slope): ([f64; 2], Option<f64>)) -> Row {
    let Bytes { triangles, points } = costs.bytes;
    let [size, milliseconds] = point;
    row![
        ("scene", scene),
        ("grows", grows),
        ("triangles", costs.triangles),
        ("pixels", pixels),
        ("build", costs.build),
        ("see", costs.see),
        ("shadow", costs.survey + costs.shadow),
        ("frame", costs.frame),
        ("ns_for_each", Cell::Number(1e6 * milliseconds / size, 1)),
        ("slope", slope),
        ("bytes_triangle", Cell::Number(triangles as f64 / costs.triangles.max(1) as f64, 1)),
        ("light_bytes_pixel", Cell::Number(points as f64 / pixels as f64, 1)),
        ("bytes_both", triangles + points),
    ]
}

/// The slope of the line that fits the points best, both axes being logarithmic; NaN for fewer than two.
fn slope(points: &[[f64; 2]]) -> f64 {
    let logs: Vec<[f64; 2]> = points.iter().map(|point| point.map(f64::ln)).collect();
    let mean = |axis: usize| logs.iter().map(|log| log[axis]).sum::<f64>() / logs.len() as f64;
    let [x, y] = [mean(0), mean(1)];
    let sum = |of: fn([f64; 2]) -> f64| logs.iter().map(|log| of([log[0] - x, log[1] - y])).sum::<f64>();
    sum(|[x, y]| x * y) / sum(|[x, _]| x * x)
}

#[cfg(test)]
mod tests {
    use super::slope;

    #[test]
    fn slopes_are_powers() {
        let points = |power: f64| [1e4, 3e4, 1e7].map(|x: f64| [x, 7.0 * x.powf(power)]);
        for power in [0.0, 0.5, 1.0, 2.0] {
            assert!((slope(&points(power)) - power).abs() < 1e-9, "{power}");
        }
        assert!(slope(&[[1.0, 1.0]]).is_nan());
    }
}
