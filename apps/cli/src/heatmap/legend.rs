use umbrage::Image;

use super::font;

/// From counts to colours: blue, pink, yellow, as in Guntury and Narayanan 2010, Figure 2.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    /// The count that has the last colour; higher ones are white.
    top: u32,
}

/// Counts in words, and their colours, below a picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Legend<'a> {
    pub(super) title: &'a str,
    pub(super) scale: Scale,
    pub(super) highest: u32,
}

const BLACK: [u8; 3] = [0, 0, 0];
const WHITE: [u8; 3] = [255, 255, 255];

impl Scale {
    /// Goes up to `top`, or a little more so that it ends at a round number.
    pub(super) fn up_to(top: u32) -> Self {
        const PARTS: u32 = 5;
        let step = round_step(top.div_ceil(PARTS));
        Self { top: top.div_ceil(step).max(1).saturating_mul(step) }
    }

    /// The colour of a count: black for zero, then dark blue to yellow.
    pub(super) fn color(self, count: u32) -> [u8; 3] {
        const STOPS: [[u8; 3]; 5] = [[24, 16, 88], [48, 64, 224], [208, 56, 176], [255, 128, 112], [255, 240, 72]];
        match count {
            0 => BLACK,
            count if count > self.top => WHITE,
            count => {
                let along = f64::from(count) / f64::from(self.top) * (STOPS.len() - 1) as f64;
                let first = (along as usize).min(STOPS.len() - 2);
                let part = along - first as f64;
                let mix = |from: u8, to: u8| (f64::from(from) * (1.0 - part) + f64::from(to) * part).round() as u8;
                std::array::from_fn(|channel| mix(STOPS[first][channel], STOPS[first + 1][channel]))
            }
        }
    }

    /// Counts to write beside the colours, so that each has `room` of the `length` for itself.
    fn ticks(self, length: u32, room: u32) -> impl Iterator<Item = u32> {
        let step = round_step((u64::from(self.top) * u64::from(room) / u64::from(length.max(1))) as u32 + 1);
        (0..=self.top / step).map(move |tick| tick * step)
    }
}

/// 1, 2 or 5 times a power of ten that is at least `least`.
fn round_step(least: u32) -> u32 {
    let powers = (0..10).map(|power| 10_u32.pow(power));
    let steps = powers.flat_map(|power| [1, 2, 5].into_iter().filter_map(move |step| power.checked_mul(step)));
    steps.into_iter().find(|&step| step >= least).unwrap_or(u32::MAX)
}

impl Legend<'_> {
    /// How many rows it takes below a picture of some width.
    pub(super) fn height(width: u32) -> u32 {
        37 * Self::dot(width)
    }

    /// Pixels a side of a letter's dot.
    fn dot(width: u32) -> u32 {
        (width / 400).max(1)
    }

    /// Draws it on a picture below row `top`.
    pub(super) fn draw(&self, image: &mut Image, top: u32) {
        let dot = Self::dot(image.width);
        let mut canvas = Canvas { image, dot };
        let margin = 4 * dot;
        canvas.text(margin, top + 4 * dot, self.title);
        let over = format!(">{}", self.scale.top);
        let over_width = if self.highest > self.scale.top { (font::width(&over) + 6) * dot } else { 0 };
        let gap = if over_width > 0 { 12 * dot } else { 0 };
        let right = canvas.image.width.saturating_sub(2 * margin + gap + over_width);
        let length = right.saturating_sub(margin).max(1);
        let (bar_top, bar_end) = (top + 14 * dot, top + 22 * dot);
        let place = |count: u32| margin + (u64::from(count) * u64::from(length) / u64::from(self.scale.top)) as u32;
        for x in 0..length {
            let count = u64::from(x) * u64::from(self.scale.top + 1) / u64::from(length);
            canvas.fill(margin + x, bar_top, 1, bar_end - bar_top, self.scale.color(count as u32));
        }
        let room = (font::width(&self.scale.top.to_string()) + 12) * dot;
        for count in self.scale.ticks(length, room) {
            let label = count.to_string();
            let x = place(count);
            canvas.fill(x, bar_end, dot, 3 * dot, WHITE);
            canvas.text(x.saturating_sub(font::width(&label) * dot / 2).max(1), top + 27 * dot, &label);
        }
        if over_width > 0 {
            let x = canvas.image.width.saturating_sub(over_width);
            canvas.fill(x, bar_top, over_width.saturating_sub(margin), bar_end - bar_top, WHITE);
            canvas.text(x, top + 27 * dot, &over);
        }
    }
}

/// A picture to draw on; what is outside of it is left out.
struct Canvas<'a> {
    image: &'a mut Image,
    dot: u32,
}

impl Canvas<'_> {
    fn fill(&mut self, x: u32, y: u32, width: u32, height: u32, color: [u8; 3]) {
        let columns = x.min(self.image.width)..(x + width).min(self.image.width);
        for y in y..(y + height).min(self.image.height) {
            let row = y as usize * self.image.width as usize;
            self.image.pixels[row + columns.start as usize..row + columns.end as usize].fill(color.map(sixteen_bits));
        }
    }

    fn text(&mut self, x: u32, y: u32, text: &str) {
        let dot = self.dot;
        font::dots(text).for_each(|(column, row)| self.fill(x + column * dot, y + row * dot, dot, dot, WHITE));
    }
}

/// The same level in 16 bits.
pub(super) fn sixteen_bits(level: u8) -> u16 {
    u16::from(level) * 257
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_at_round_numbers() {
        for (top, expected) in [(0, 1), (1, 1), (4, 4), (37, 40), (99, 100), (101, 150), (1234, 1500)] {
            assert_eq!(Scale::up_to(top).top, expected, "{top}");
        }
        for top in (0..3000).chain([u32::MAX]) {
            assert!(Scale::up_to(top).top >= top);
        }
    }

    #[test]
    fn colours_grow_lighter() {
        let scale = Scale::up_to(200);
        let lightness = |count: u32| {
            let [red, green, blue] = scale.color(count).map(f64::from);
            0.2126 * red + 0.7152 * green + 0.0722 * blue
        };
        assert!(lightness(0) < lightness(1) && lightness(200) < lightness(201));
        // Levels are rounded, so not every step is one up.
        assert!((1..=190).all(|count| lightness(count) < lightness(count + 10)));
        assert_eq!((scale.color(0), scale.color(201)), (BLACK, WHITE));
    }

    #[test]
    fn ticks_have_room() {
        for (top, length, room) in [(1, 100, 20), (40, 1000, 30), (1500, 500, 60), (7, 3, 50)] {
            let ticks: Vec<u32> = Scale { top }.ticks(length, room).collect();
            assert!(ticks[0] == 0 && ticks.iter().all(|&tick| tick <= top));
            assert!(ticks.windows(2).all(|pair| (pair[1] - pair[0]) * length >= room * top), "{ticks:?}");
        }
    }

    #[test]
    fn the_smallest_picture_can_hold_it() {
        for width in [1, 16, 100, 2000] {
            let height = Legend::height(width);
            let pixels = vec![[0; 3]; (width * height) as usize];
            let mut image = Image { width, height, pixels };
            Legend { title: "CELLS", scale: Scale::up_to(90), highest: 1000 }.draw(&mut image, 0);
            assert!(image.pixels.iter().any(|&pixel| pixel != [0; 3]));
        }
    }
}
