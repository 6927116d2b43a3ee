//! Charts as SVG files: lines over linear or logarithmic axes, and stacked bars.

use std::ops::Range;

use anyhow::Result;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// A chart that can be written as an SVG file.
pub(crate) trait Chart {
    /// The whole file.
    fn svg(&self) -> Result<String>;
}

/// Lines through points.
#[derive(Clone, Debug)]
pub(crate) struct LineChart<'a> {
    pub(crate) title: &'a str,
    /// Title of each axis, with its unit.
    pub(crate) x_title: &'a str,
    pub(crate) y_title: &'a str,
    /// Scales of the horizontal and the vertical axis.
    pub(crate) scales: [Scale; 2],
    pub(crate) series: Vec<Series>,
}

/// One line.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    pub(crate) name: String,
    /// In drawing order; points that can't be shown are left out.
    pub(crate) points: Vec<[f64; 2]>,
}

/// Bars side by side, each of parts one above the other.
#[derive(Clone, Debug)]
pub(crate) struct BarChart<'a> {
    pub(crate) title: &'a str,
    /// Title of the bars' heights, with their unit.
    pub(crate) y_title: &'a str,
    /// Names of the parts, from below.
    pub(crate) parts: Vec<String>,
    pub(crate) bars: Vec<Bar>,
}

/// One bar.
#[derive(Clone, Debug)]
pub(crate) struct Bar {
    pub(crate) name: String,
    /// The height of each part, none below zero.
    pub(crate) heights: Vec<f64>,
}

/// Colours that people with any colour vision tell apart (Okabe and Ito 2008), with greys
/// instead of yellow, which is too light.
const COLORS: [RGBColor; 8] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0x44, 0x44, 0x44),
    RGBColor(0xa0, 0xa0, 0xa0),
];

/// In pixels: size of the axes' rectangle, room left of it and below, minimum room right of it, and width of a character.
const WIDTH: u32 = 560;
const HEIGHT: u32 = 360;
const LABELS: u32 = 64;
const LEGEND_WIDTH: u32 = 260;
const CHARACTER: u32 = 8;
const FONT: (&str, u32) = ("sans-serif", 16);

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

impl Series {
    /// Adds a point to the line of that name, which begins with it if there is none.
    pub(crate) fn add(series: &mut Vec<Self>, name: &str, point: [f64; 2]) {
        match series.iter_mut().find(|line| line.name == name) {
            Some(line) => line.points.push(point),
            None => series.push(Self { name: name.to_owned(), points: vec![point] }),
        }
    }
}

impl Chart for LineChart<'_> {
    fn svg(&self) -> Result<String> {
        let values = |axis: usize| self.series.iter().flat_map(|series| &series.points).map(move |point| point[axis]);
        let [x_axis, y_axis] = [0, 1].map(|axis| Axis::new(self.scales[axis], values(axis)));
        let names: Vec<_> = self.series.iter().map(|series| series.name.as_str()).enumerate().collect();
        sheet(self.title, [WIDTH, HEIGHT], LABELS, &names, |builder, _| {
            let mut chart = builder.build_cartesian_2d(x_axis.clone(), y_axis.clone())?;
            let mut mesh = chart.configure_mesh();
            mesh.max_light_lines(0).x_labels(8).x_desc(self.x_title).y_desc(self.y_title).label_style(FONT).draw()?;
            for (index, series) in self.series.iter().enumerate() {
                let points = series.points.iter().filter(|&&[x, y]| x_axis.shows(x) && y_axis.shows(y));
                let points: Vec<(f64, f64)> = points.map(|&[x, y]| (x, y)).collect();
                let style = color(index).stroke_width(2);
                if is_repeated(index) {
                    chart.draw_series(DashedLineSeries::new(points.iter().copied(), 6, 4, style))?;
                } else {
                    chart.draw_series(LineSeries::new(points.iter().copied(), style))?;
                }
                chart.draw_series(points.into_iter().map(|point| Circle::new(point, 3, color(index).filled())))?;
            }
            Ok(())
        })
    }
}

impl Chart for BarChart<'_> {
    fn svg(&self) -> Result<String> {
        /// Fraction of its share of the width that a bar fills.
        const FILLED: f64 = 0.7;
        let axis = Axis::new(Scale::Linear, self.bars.iter().map(|bar| bar.heights.iter().sum()));
        let count = self.bars.len().max(1);
        let longest = self.bars.iter().map(|bar| bar.name.chars().count()).max().unwrap_or(0) as u32;
        // From above, as the parts are stacked.
        let parts: Vec<_> = self.parts.iter().map(String::as_str).enumerate().rev().collect();
        let size = [WIDTH.max(30 * count as u32), HEIGHT];
        sheet(self.title, size, LABELS.max(CHARACTER * longest), &parts, |builder, area| {
            let mut chart = builder.build_cartesian_2d(0.0..count as f64, axis)?;
            let mut mesh = chart.configure_mesh();
            mesh.max_light_lines(0).disable_x_mesh().x_labels(0).y_desc(self.y_title).label_style(FONT).draw()?;
            let name = FONT.into_font().transform(FontTransform::Rotate90).color(&BLACK);
            let name = name.pos(Pos::new(HPos::Left, VPos::Center));
            for (index, bar) in self.bars.iter().enumerate() {
                let middle = index as f64 + 0.5;
                let mut below = 0.0;
                for (part, height) in bar.heights.iter().enumerate().filter(|(_, height)| height.is_finite()) {
                    let corners = [(middle - 0.5 * FILLED, below), (middle + 0.5 * FILLED, below + height)];
                    chart.draw_series([Rectangle::new(corners, color(part).filled())])?;
                    below += height;
                }
                let (x, y) = chart.backend_coord(&(middle, 0.0));
                area.draw(&Text::new(bar.name.as_str(), (x, y + 8), &name))?;
            }
            Ok(())
        })
    }
}

/// An SVG file with a title and a legend of series and their names. `draw` gets the axes' rectangle of `width` and
/// `height` pixels with room for labels left of it and, `labels` pixels high, below, and the area around all of this.
fn sheet(
    title: &str,
    [width, height]: [u32; 2],
    labels: u32,
    legend: &[(usize, &str)],
    draw: impl FnOnce(&mut ChartBuilder<'_, '_, SVGBackend<'_>>, &Area<'_>) -> Result<()>,
) -> Result<String> {
    const TITLE: u32 = 48;
    const MARGIN: u32 = 14;
    const LINE: u32 = 20;
    const KEY: u32 = 36;
    let mut text = String::new();
    let width = MARGIN + LABELS + width;
    let longest = legend.iter().map(|(_, name)| name.chars().count()).max().unwrap_or(0) as u32;
    let sheet = (
        width + LEGEND_WIDTH.max(KEY + CHARACTER * longest),
        (TITLE + height + labels).max(TITLE + LINE * legend.len() as u32),
    );
    {
        let root = SVGBackend::with_string(&mut text, sheet).into_drawing_area();
        root.fill(&WHITE)?;
        let (left, right) = root.split_horizontally(width);
        let (left, _) = left.split_vertically(TITLE + height + labels);
        let mut builder = ChartBuilder::on(&left);
        builder
            .caption(title, ("sans-serif", 20))
            .margin_top(MARGIN)
            .margin_left(MARGIN)
            .y_label_area_size(LABELS)
            .x_label_area_size(labels);
        draw(&mut builder, &left)?;
        for (top, &(index, name)) in (TITLE as i32..).step_by(LINE as usize).zip(legend) {
            let style = ShapeStyle { filled: !is_repeated(index), ..color(index).stroke_width(2) };
            right.draw(&Rectangle::new([(16, top), (28, top + 12)], style))?;
            right.draw(&Text::new(name, (KEY as i32, top), FONT))?;
        }
        root.present()?;
    }
    Ok(text)
}

fn color(series: usize) -> RGBColor {
    COLORS[series % COLORS.len()]
}

/// Whether a series has the colour of an earlier one: its line is dashed, and its key in the legend is hollow.
fn is_repeated(series: usize) -> bool {
    series >= COLORS.len()
}

/// Spread of values along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scale {
    /// With zero on the axis.
    Linear,
    /// By orders of magnitude; all values are above zero.
    Logarithmic,
    /// The same, with ticks at powers of two.
    Doubling,
}

/// An axis that holds all values.
#[derive(Clone, Debug)]
enum Axis {
    Linear(Range<f64>),
    /// From the first tick to the last.
    Logarithmic(Vec<f64>),
}

impl Axis {
    /// An axis for `values`; ignores those that a logarithmic one can't show.
    fn new(scale: Scale, values: impl Iterator<Item = f64>) -> Self {
        let shown = values.filter(|value| value.is_finite() && (scale == Scale::Linear || *value > 0.0));
        let (low, high) =
            shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        let (low, high) = if low <= high { (low, high) } else { (1.0, 10.0) };
        // Ticks are powers of the base; where there are few of them, also two and five times each.
        let (base, factors): (f64, &[f64]) = match scale {
            Scale::Linear if low == 0.0 && high == 0.0 => return Self::Linear(0.0..1.0),
            Scale::Linear => return Self::Linear(1.05 * low.min(0.0)..1.05 * high.max(0.0)),
            Scale::Logarithmic if high / low < 500.0 => (10.0, &[1.0, 2.0, 5.0]),
            Scale::Logarithmic => (10.0, &[1.0]),
            Scale::Doubling => (2.0, &[1.0]),
        };
        let powers = low.log(base).floor() as i32 - 1..=high.log(base).ceil() as i32 + 1;
        let ticks: Vec<f64> =
            powers.flat_map(|power| factors.iter().map(move |factor| factor * base.powi(power))).collect();
        let first = ticks.iter().rposition(|tick| *tick <= low).unwrap_or(0);
        let last = ticks.iter().position(|tick| *tick >= high).unwrap_or(ticks.len() - 1).max(first + 1);
        Self::Logarithmic(ticks[first..=last].to_vec())
    }

    fn shows(&self, value: f64) -> bool {
        value.is_finite() && (matches!(self, Self::Linear(_)) || value > 0.0)
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, pixels: (i32, i32)) -> i32 {
        let along = |value: f64| if matches!(self, Self::Linear(_)) { value } else { value.ln() };
        let Range { start, end } = self.range();
        RangedCoordf64::from(along(start)..along(end)).map(&along(*value), pixels)
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        match self {
            Self::Linear(range) => RangedCoordf64::from(range.clone()).key_points(hint),
            Self::Logarithmic(ticks) => ticks.clone(),
        }
    }

    fn range(&self) -> Range<f64> {
        match self {
            Self::Linear(range) => range.clone(),
            Self::Logarithmic(ticks) => ticks[0]..ticks[ticks.len() - 1],
        }
    }
}

impl ValueFormatter<f64> for Axis {
    /// A round number in few characters: thousands and millions are `K` and `M`.
    fn format(value: &f64) -> String {
        let (scaled, unit) = match value.abs() {
            large if large >= 0.9995e6 => (value / 1e6, "M"),
            large if large >= 0.9995e4 => (value / 1e3, "K"),
            _ => (*value, ""),
        };
        let rounded = format!("{scaled:.6}");
        let short = rounded.trim_end_matches('0').trim_end_matches('.');
        format!("{short}{unit}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_hold_all_values() {
        let labels = |scale, values: &[f64]| {
            let axis = Axis::new(scale, values.iter().copied());
            axis.key_points(8).iter().map(Axis::format).collect::<Vec<_>>()
        };
        assert_eq!(labels(Scale::Linear, &[3.0, 17.0])[..3], ["0", "5", "10"]);
        assert_eq!(labels(Scale::Logarithmic, &[1e4, 1e7]), ["10K", "100K", "1M", "10M"]);
        assert_eq!(labels(Scale::Logarithmic, &[3.0, 45.0]), ["2", "5", "10", "20", "50"]);
        assert_eq!(labels(Scale::Doubling, &[0.25, 3.0]), ["0.25", "0.5", "1", "2", "4"]);
        assert_eq!(Axis::new(Scale::Logarithmic, [1e4, 1e7].into_iter()).map(&1e6, (0, 300)), 200);
    }

    #[test]
    fn odd_values_still_make_a_chart() {
        for values in [vec![], vec![f64::NAN], vec![0.0], vec![5.0], vec![-1.0], vec![1e-9, 1e9], vec![1.0; 3]] {
            for scale in [Scale::Linear, Scale::Logarithmic, Scale::Doubling] {
                let points = values.iter().map(|&value| [value, value]).collect();
                let series = vec![Series { name: String::new(), points }];
                let chart = LineChart { title: "t", x_title: "x", y_title: "y", scales: [scale; 2], series };
                assert!(chart.svg().unwrap().matches("<text").count() > 4, "{values:?} {scale:?}");
            }
        }
    }

    #[test]
    fn lines_go_through_their_points() {
        let points = vec![[0.0, 0.0], [5.0, f64::NAN], [10.0, 20.0]];
        let series = vec![Series { name: "a < b".to_owned(), points }];
        let chart = LineChart { title: "t", x_title: "x", y_title: "y", scales: [Scale::Linear; 2], series };
        let svg = chart.svg().unwrap();
        assert_eq!(svg.matches("<circle").count(), 2);
        assert!(svg.contains("a &lt; b") && svg.trim_end().ends_with("</svg>"), "{svg}");
    }

    #[test]
    fn parts_stand_on_each_other() {
        let bars = vec![Bar { name: "a".to_owned(), heights: vec![4.0, 6.0] }];
        let chart = BarChart { title: "t", y_title: "y", parts: vec!["low".to_owned(), "high".to_owned()], bars };
        let svg = chart.svg().unwrap();
        let rectangles: Vec<&str> = svg.lines().filter(|line| line.starts_with("<rect")).collect();
        let number = |rectangle: usize, name: &str| -> i32 {
            let (_, after) = rectangles[rectangle].split_once(&format!(" {name}=\"")).unwrap();
            after.split_once('"').unwrap().0.parse().unwrap()
        };
        // The first is the background.
        let (low, high) = (1, 2);
        assert!(rectangles[low].contains("#0072B2") && rectangles[high].contains("#D55E00"), "{svg}");
        assert_eq!(number(high, "y") + number(high, "height"), number(low, "y"));
        assert!((6 * number(low, "height") - 4 * number(high, "height")).abs() < 10, "{svg}");
    }
}
