//! Charts as SVG files: lines over linear or logarithmic axes, and stacked bars.

mod axis;
mod bars;
mod lines;
mod svg;

pub(crate) use axis::Scale;
pub(crate) use bars::{Bar, BarChart};
pub(crate) use lines::{LineChart, Series};

/// What is written as an SVG file.
pub(crate) trait Chart {
    /// The whole file.
    fn svg(&self) -> String;
}

/// Colours that people with any colour vision tell apart (Okabe and Ito 2008), with greys
/// instead of yellow, which is too light.
const COLORS: [&str; 8] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#444444", "#a0a0a0"];

fn color(series: usize) -> &'static str {
    COLORS[series % COLORS.len()]
}
