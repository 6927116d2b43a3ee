use umbrage::{HeatScale, Image};

/// Counts in words, and their colours, below a picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Legend<'a> {
    pub(super) title: &'a str,
    pub(super) scale: HeatScale,
    pub(super) highest: u32,
}

const WHITE: [u8; 3] = [255, 255, 255];

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
        let over = format!(">{}", self.scale.top());
        let over_width = if self.highest > self.scale.top() { (dot_font::width(&over) + 6) * dot } else { 0 };
        let gap = if over_width > 0 { 12 * dot } else { 0 };
        let right = canvas.image.width.saturating_sub(2 * margin + gap + over_width);
        let length = right.saturating_sub(margin).max(1);
        let (bar_top, bar_end) = (top + 14 * dot, top + 22 * dot);
        let x_of = |count: u32| margin + (u64::from(count) * u64::from(length) / u64::from(self.scale.top())) as u32;
        for x in 0..length {
            let count = u64::from(x) * u64::from(self.scale.top() + 1) / u64::from(length);
            canvas.fill(margin + x, bar_top, 1, bar_end - bar_top, self.scale.color(count as u32));
        }
        let room = (dot_font::width(&self.scale.top().to_string()) + 12) * dot;
        for count in self.scale.ticks(length, room) {
            let label = count.to_string();
            let x = x_of(count);
            canvas.fill(x, bar_end, dot, 3 * dot, WHITE);
            canvas.text(x.saturating_sub(dot_font::width(&label) * dot / 2).max(1), top + 27 * dot, &label);
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
        dot_font::dots(text).for_each(|(column, row)| self.fill(x + column * dot, y + row * dot, dot, dot, WHITE));
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
    fn the_smallest_picture_can_hold_it() {
        for width in [1, 16, 100, 2000] {
            let height = Legend::height(width);
            let pixels = vec![[0; 3]; (width * height) as usize];
            let mut image = Image { width, height, pixels };
            Legend { title: "CELLS", scale: HeatScale::up_to(90), highest: 1000 }.draw(&mut image, 0);
            assert!(image.pixels.iter().any(|&pixel| pixel != [0; 3]));
        }
    }
}
