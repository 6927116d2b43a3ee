use super::axis::{Axis, Scale};
use super::svg::Sheet;
use super::{Chart, color};

/// Bars side by side, each of parts one above the other.
#[derive(Clone, Debug)]
pub(crate) struct BarChart<'a> {
    pub(crate) title: &'a str,
    /// What the bars' heights are, with their unit.
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

impl Chart for BarChart<'_> {
    fn svg(&self) -> String {
        /// How much of its share of the width a bar takes.
        const FILLED: f64 = 0.7;
        /// How far below a character of a slanted name reaches, in pixels.
        const SLANT: f64 = 6.0;
        let axis = Axis::new(Scale::Linear, self.bars.iter().map(|bar| bar.heights.iter().sum()));
        let longest = self.bars.iter().map(|bar| bar.name.chars().count()).max().unwrap_or(0) as f64;
        let mut sheet = Sheet::new(self.title, width(self.bars.len()), SLANT * longest);
        sheet.upward_axis(&axis, self.y_title);
        let share = 1.0 / self.bars.len().max(1) as f64;
        for (index, bar) in self.bars.iter().enumerate() {
            let middle = (index as f64 + 0.5) * share;
            let (left, right) = (middle - 0.5 * FILLED * share, middle + 0.5 * FILLED * share);
            let mut below = 0.0;
            for (part, &height) in bar.heights.iter().enumerate() {
                let above = below + height;
                if let (Some(low), Some(high)) = (axis.position(below), axis.position(above)) {
                    let (corner, opposite) = (sheet.at([left, high]), sheet.at([right, low]));
                    sheet.rectangle(corner, opposite, color(part));
                    below = above;
                }
            }
            sheet.name_below(middle, &bar.name);
        }
        // From above, as the parts are stacked.
        let names = self.parts.iter().enumerate().rev();
        sheet.frame_and_legend(names.map(|(part, name)| (name.as_str(), color(part), false)));
        sheet.finish()
    }
}

/// How wide the axes' rectangle is for a number of bars, in pixels.
fn width(bars: usize) -> f64 {
    (30.0 * bars as f64).max(560.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_stand_on_each_other() {
        let bars = vec![Bar { name: "a".to_owned(), heights: vec![4.0, 6.0] }];
        let chart = BarChart { title: "t", y_title: "y", parts: vec!["low".to_owned(), "high".to_owned()], bars };
        let svg = chart.svg();
        let sheet = Sheet::new("t", width(1), 0.0);
        for (part, low, high) in [(0, 0.0, 0.4), (1, 0.4, 1.0)] {
            let ([left, top], [right, bottom]) = (sheet.at([0.15, high]), sheet.at([0.85, low]));
            let (width, height) = (right - left, bottom - top);
            let rectangle = format!(
                "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"{}\"/>",
                color(part)
            );
            assert!(svg.contains(&rectangle), "{rectangle} in {svg}");
        }
    }
}
