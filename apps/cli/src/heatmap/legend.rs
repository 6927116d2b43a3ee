use dot_font::Canvas;
use umbrage::{HeatScale, Image};

/// The legend below a picture: title, counts and their colours.
#[derive(Clone, Copy, Debug)]
pub(super) struct Legend<'a> {
    pub(super) title: &'a str,
    pub(super) scale: HeatScale,
    pub(super) highest: u32,
}

const WHITE: [u16; 3] = [u16::MAX; 3];

impl Legend<'_> {
    /// Height in pixels below a picture of `width` pixels.
    pub(super) fn height(width: u32) -> u32 {
        37 * Self::dot(width)
    }

    /// Side of a letter's dot in pixels.
    fn dot(width: u32) -> u32 {
        (width / 400).max(1)
    }

    /// Draws the legend from row `top` on.
    pub(super) fn draw(&self, image: &mut Image, top: u32) {
        let (width, dot) = (image.width, Self::dot(image.width));
        let mut canvas = Canvas { pixels: &mut image.pixels, width };
        let margin = 4 * dot;
        canvas.text([margin, top + 4 * dot], dot, self.title, WHITE);
        let over = format!(">{}", self.scale.top());
        let over_width = if self.highest > self.scale.top() { (dot_font::width(&over) + 6) * dot } else { 0 };
        let gap = if over_width > 0 { 12 * dot } else { 0 };
        let right = width.saturating_sub(2 * margin + gap + over_width);
        let length = right.saturating_sub(margin).max(1);
        let (bar_top, bar_end) = (top + 14 * dot, top + 22 * dot);
        let x_of = |count: u32| margin + (u64::from(count) * u64::from(length) / u64::from(self.scale.top())) as u32;
        for x in 0..length {
            let count = u64::from(x) * u64::from(self.scale.top() + 1) / u64::from(length);
            let color = self.scale.color(count as u32).map(sixteen_bits);
            canvas.fill([margin + x, bar_top], [1, bar_end - bar_top], color);
        }
        let room = (dot_font::width(&self.scale.top().to_string()) + 12) * dot;
        for count in self.scale.ticks(length, room) {
            let label = count.to_string();
            let x = x_of(count);
            canvas.fill([x, bar_end], [dot, 3 * dot], WHITE);
            let left = x.saturating_sub(dot_font::width(&label) * dot / 2).max(1);
            canvas.text([left, top + 27 * dot], dot, &label, WHITE);
        }
        if over_width > 0 {
            let x = width.saturating_sub(over_width);
            canvas.fill([x, bar_top], [over_width.saturating_sub(margin), bar_end - bar_top], WHITE);
            canvas.text([x, top + 27 * dot], dot, &over, WHITE);
        }
    }
}

/// Widens a level to 16 bits.
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
            let mut image = Image { width, height, pixels, ..Image::default() };
            Legend { title: "CELLS", scale: HeatScale::up_to(90), highest: 1000 }.draw(&mut image, 0);
            assert!(image.pixels.iter().any(|&pixel| pixel != [0; 3]));
        }
    }
}
