use super::axis::{Axis, Scale};
use super::svg::Sheet;
use super::{COLORS, Chart, color};

/// Lines through points.
#[derive(Clone, Debug)]
pub(crate) struct LineChart<'a> {
    pub(crate) title: &'a str,
    /// What is along each axis, with its unit.
    pub(crate) x_title: &'a str,
    pub(crate) y_title: &'a str,
    /// Along, and upwards.
    pub(crate) scales: [Scale; 2],
    pub(crate) series: Vec<Series>,
}

/// One line.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    pub(crate) name: String,
    /// In the order in which the line goes through them; those that can't be shown are left out.
    pub(crate) points: Vec<[f64; 2]>,
}

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
    fn svg(&self) -> String {
        /// Of the axes' rectangle, in pixels.
        const WIDTH: f64 = 560.0;
        let values = |axis: usize| self.series.iter().flat_map(|series| &series.points).map(move |point| point[axis]);
        let (x_axis, y_axis) = (Axis::new(self.scales[0], values(0)), Axis::new(self.scales[1], values(1)));
        let mut sheet = Sheet::new(self.title, WIDTH, 0.0);
        sheet.rightward_axis(&x_axis, self.x_title);
        sheet.upward_axis(&y_axis, self.y_title);
        for (index, series) in self.series.iter().enumerate() {
            let at = |&[x, y]: &[f64; 2]| Some(sheet.at([x_axis.position(x)?, y_axis.position(y)?]));
            let points: Vec<[f64; 2]> = series.points.iter().filter_map(at).collect();
            sheet.dotted_line(&points, color(index), is_dashed(index));
        }
        let names = self.series.iter().enumerate();
        sheet.frame_and_legend(names.map(|(index, series)| (series.name.as_str(), color(index), is_dashed(index))));
        sheet.finish()
    }
}

/// Whether a line has the colour of an earlier one.
fn is_dashed(index: usize) -> bool {
    index >= COLORS.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_go_through_their_points() {
        let points = vec![[0.0, 0.0], [5.0, f64::NAN], [10.0, 20.0]];
        let series = vec![Series { name: "a < b".to_owned(), points }];
        let chart = LineChart { title: "t", x_title: "x", y_title: "y", scales: [Scale::Linear; 2], series };
        let svg = chart.svg();
        assert_eq!(svg.matches("<circle").count(), 2);
        let sheet = Sheet::new("t", 560.0, 0.0);
        let [[x1, y1], [x2, y2]] = [[0.0, 0.0], [1.0, 1.0]].map(|point| sheet.at(point));
        assert!(svg.contains(&format!("<polyline points=\"{x1:.1},{y1:.1} {x2:.1},{y2:.1}\"")), "{svg}");
        assert!(svg.contains("a &lt; b") && svg.ends_with("</svg>\n"));
    }
}
