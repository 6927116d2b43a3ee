//! What all charts share: a sheet with a title, axes and a legend.

use std::fmt::Write as _;

use super::axis::Axis;

/// Pixel coordinates of the axes' rectangle, and what is right of it and below.
const LEFT: f64 = 76.0;
const TOP: f64 = 48.0;
const BOTTOM: f64 = 408.0;
const LEGEND_WIDTH: f64 = 230.0;
const LABELS_HEIGHT: f64 = 72.0;

/// An SVG file that is being written.
pub(super) struct Sheet {
    text: String,
    /// Right border of the axes' rectangle.
    right: f64,
}

impl Sheet {
    /// A sheet whose axes' rectangle is `width` pixels wide. `slant` is how far below names of the longest kind reach.
    pub(super) fn new(title: &str, width: f64, slant: f64) -> Self {
        let right = LEFT + width;
        let (width, height) = (right + LEGEND_WIDTH, BOTTOM + LABELS_HEIGHT.max(slant));
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" \
             height=\"{height:.0}\" font-family=\"sans-serif\" font-size=\"13\" fill=\"#222\">\n\
             <rect width=\"{width:.0}\" height=\"{height:.0}\" fill=\"white\"/>\n"
        );
        let mut sheet = Self { text, right };
        sheet.write(16, [0.5 * (LEFT + right), TOP - 20.0], "middle", title);
        sheet
    }

    /// Where a point of the axes' rectangle is on the sheet, from (0, 0) at its lower left to (1, 1).
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [LEFT + x * (self.right - LEFT), BOTTOM + y * (TOP - BOTTOM)]
    }

    /// Values upwards, with lines across.
    pub(super) fn upward_axis(&mut self, axis: &Axis, title: &str) {
        for (position, label) in axis.ticks() {
            let [_, y] = self.at([0.0, position]);
            self.line([LEFT, y], [self.right, y]);
            self.write(13, [LEFT - 8.0, y + 4.5], "end", &label);
        }
        let middle = 0.5 * (TOP + BOTTOM);
        let _ = writeln!(
            self.text,
            "<text transform=\"translate(20 {middle}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            escaped(title)
        );
    }

    /// Values to the right, with lines upwards.
    pub(super) fn rightward_axis(&mut self, axis: &Axis, title: &str) {
        for (position, label) in axis.ticks() {
            let [x, _] = self.at([position, 0.0]);
            self.line([x, TOP], [x, BOTTOM]);
            self.write(13, [x, BOTTOM + 20.0], "middle", &label);
        }
        self.write(13, [0.5 * (LEFT + self.right), BOTTOM + 46.0], "middle", title);
    }

    /// The name of something that stands at `x`, from 0 to 1, on the lower border, slanted so that names don't overlap.
    pub(super) fn name_below(&mut self, x: f64, name: &str) {
        let [x, y] = self.at([x, 0.0]);
        let y = y + 16.0;
        let _ = writeln!(
            self.text,
            "<text transform=\"translate({x:.1} {y:.1}) rotate(-40)\" text-anchor=\"end\">{}</text>",
            escaped(name)
        );
    }

    /// The rectangle's border and, to its right, names with their colours and whether they are dashed, from above.
    pub(super) fn frame_and_legend<'a>(&mut self, entries: impl IntoIterator<Item = (&'a str, &'a str, bool)>) {
        let (right, width, height) = (self.right, self.right - LEFT, BOTTOM - TOP);
        let _ = writeln!(
            self.text,
            "<rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{width}\" height=\"{height}\" fill=\"none\" stroke=\"#444\"/>"
        );
        for (row, (name, color, is_dashed)) in entries.into_iter().enumerate() {
            let y = TOP + 10.0 + 22.0 * row as f64;
            if is_dashed {
                self.rectangle([right + 16.0, y - 6.0], [right + 21.0, y + 6.0], color);
                self.rectangle([right + 25.0, y - 6.0], [right + 30.0, y + 6.0], color);
            } else {
                self.rectangle([right + 16.0, y - 6.0], [right + 30.0, y + 6.0], color);
            }
            self.write(13, [right + 38.0, y + 4.5], "start", name);
        }
    }

    fn line(&mut self, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2]) {
        let _ =
            writeln!(self.text, "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"#ddd\"/>");
    }

    /// A line through points, and a dot at each.
    pub(super) fn dotted_line(&mut self, points: &[[f64; 2]], color: &str, is_dashed: bool) {
        let points_text: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        let dashes = if is_dashed { " stroke-dasharray=\"7 4\"" } else { "" };
        let _ = writeln!(
            self.text,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"{dashes}/>",
            points_text.join(" ")
        );
        for [x, y] in points {
            let _ = writeln!(self.text, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.5\" fill=\"{color}\"/>");
        }
    }

    pub(super) fn rectangle(&mut self, [left, top]: [f64; 2], [right, bottom]: [f64; 2], color: &str) {
        let (width, height) = (right - left, bottom - top);
        let _ = writeln!(
            self.text,
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"{color}\"/>"
        );
    }

    /// Text whose `anchor` (start, middle or end) is at a point of the sheet, in pixels.
    pub(super) fn write(&mut self, size: u32, [x, y]: [f64; 2], anchor: &str, text: &str) {
        let _ = writeln!(
            self.text,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" text-anchor=\"{anchor}\">{}</text>",
            escaped(text)
        );
    }

    pub(super) fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
