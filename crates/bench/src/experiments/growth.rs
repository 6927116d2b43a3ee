//! How time and memory grow with triangles, pixels and lights.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use umbrage::rays::Bytes;

use crate::flags::{AnimationFlags, write_chart};
use crate::grids::Forms;
use crate::measure::{Costs, measure};
use crate::plot::{LineChart, Scale, Series};
use crate::shot::{Shot, name, short_name};
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
    /// Numbers of lights, at 1024x1024 pixels: the scene's first one, turned around the scene
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [1, 2, 4, 8, 16, 32, 64])]
    lights: Vec<u32>,
    /// Draw the bytes for each triangle, and for each pixel, as well
    #[arg(long, value_name = "FILE.svg")]
    plot_bytes: Option<PathBuf>,
    #[command(flatten)]
    common: AnimationFlags,
}

const TRIANGLES: [u32; 7] = [10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000, 10_000_000];

/// Width and height while triangles grow, in pixels.
const SIDE: u32 = 1024;

/// A step of growth: a scene, an image size and a number of lights.
#[derive(Clone, Debug)]
struct Step {
    address: String,
    side: u32,
    lights: u32,
}

impl GrowthFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.common.output.start(&self.common.prepare(None)?)?;
        let (mut times, mut bytes) = (Vec::new(), Vec::new());
        for address in &self.scenes {
            for (grows, steps) in self.steps(address) {
                let mut points: Vec<[f64; 2]> = Vec::new();
                for Step { address: stepped, side, lights } in steps {
                    let arrange = |shot: &mut Shot<'_>| shot.make_lights(lights);
                    for costs in measure(&stepped, [side, side], &[Forms::default()], &self.common, arrange)? {
                        let pixels = side as usize * side as usize;
                        let size = match grows {
                            "triangles" => costs.triangles,
                            "pixels" => pixels,
                            _ => lights as usize,
                        };
                        let point = [size as f64, costs.frame];
                        let slope = points.last().map(|&last| slope(&[last, point]));
                        let counts = [costs.triangles, pixels, lights as usize];
                        table.push(row(name(address), grows, &costs, counts, (point, slope)))?;
                        points.push(point);
                        let [of_triangle, of_pixel] = bytes_each(&costs, pixels);
                        let line = |of: &str| format!("{}, {of}", short_name(address));
                        match grows {
                            "triangles" => Series::add(&mut bytes, &line("a triangle"), [point[0], of_triangle]),
                            "pixels" => Series::add(&mut bytes, &line("a pixel"), [point[0], of_pixel]),
                            _ => {}
                        }
                    }
                }
                table.note(&format!(
                    "{}, in {grows}: time grows with power {:.2}, fitted to all steps",
                    name(address),
                    slope(&points)
                ))?;
                times.push(Series { name: format!("{}, {grows}", short_name(address)), points });
            }
        }
        let notes = ["slope: the power with which time grows from the step before; 1 is linear."];
        let (x_title, y_title) = ("triangles (at 1024x1024 pixels), pixels, or lights", "milliseconds a frame");
        let chart = LineChart { title: "Growth", x_title, y_title, scales: [Scale::Logarithmic; 2], series: times };
        self.common.output.finish(table, &notes, &chart)?;
        let (x_title, y_title) = ("triangles, or pixels", "bytes for each");
        let scales = [Scale::Logarithmic, Scale::Linear];
        let chart = LineChart { title: "Memory", x_title, y_title, scales, series: bytes };
        self.plot_bytes.iter().try_for_each(|path| write_chart(path, &chart))
    }

    /// The steps of triangles, of pixels and of lights.
    fn steps(&self, address: &str) -> [(&'static str, Vec<Step>); 3] {
        let usual = Step { address: address.to_owned(), side: SIDE, lights: 1 };
        let triangles = self.triangles.iter().map(|count| format!("{address}?triangles={count}"));
        [
            ("triangles", triangles.map(|address| Step { address, ..usual.clone() }).collect()),
            ("pixels", self.sides.iter().map(|&side| Step { side, ..usual.clone() }).collect()),
            ("lights", self.lights.iter().map(|&lights| Step { lights, ..usual.clone() }).collect()),
        ]
    }
}

/// Bytes for each triangle, and for each pixel and light.
fn bytes_each(costs: &Costs, pixels: usize) -> [f64; 2] {
    let Bytes { triangles, points } = costs.bytes;
    [triangles as f64 / costs.triangles.max(1) as f64, points as f64 / pixels as f64]
}

fn row(
    scene: &str,
    grows: &str,
    costs: &Costs,
    [triangles, pixels, lights]: [usize; 3],
    (point, slope): ([f64; 2], Option<f64>),
) -> Row {
    let [size, milliseconds] = point;
    let [of_triangle, of_pixel] = bytes_each(costs, pixels);
    row![
        ("scene", scene),
        ("grows", grows),
        ("triangles", triangles),
        ("pixels", pixels),
        ("lights", lights),
        ("build", costs.build),
        ("see", costs.see),
        ("shadow", costs.survey + costs.shadow),
        ("frame", costs.frame),
        ("ns_for_each", Cell::Number(1e6 * milliseconds / size, 1)),
        ("slope", slope),
        ("bytes_triangle", Cell::Number(of_triangle, 1)),
        ("light_bytes_pixel", Cell::Number(of_pixel, 1)),
        ("bytes_both", costs.bytes.triangles + costs.bytes.points),
    ]
}

/// Slope of the best line through the points on logarithmic axes; NaN for fewer than two.
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
