use umbrage::Image;

/// From a line of text to the next one: a letter and a gap.
pub(crate) const LINE_PIXELS: u32 = dot_font::HEIGHT + 3;

/// A dark picture to draw on; what is outside of it is not drawn.
pub(crate) struct Canvas {
    image: Image,
}

impl Canvas {
    /// A canvas of a size in pixels.
    pub(crate) fn new(width: u32, height: u32) -> Self {
        const DARK: [u16; 3] = [0x1400; 3];
        Self { image: Image { width, height, pixels: vec![DARK; width as usize * height as usize] } }
    }

    pub(crate) fn into_image(self) -> Image {
        self.image
    }

    /// Draws a picture with its upper left corner at (`x`, `y`).
    pub(crate) fn picture(&mut self, x: u32, y: u32, picture: &Image) {
        let rows = picture.pixels.chunks(picture.width.max(1) as usize);
        for (row, pixels) in (0..).zip(rows) {
            for (column, &pixel) in (0..).zip(pixels) {
                self.set(x + column, y + row, pixel);
            }
        }
    }

    /// Fills a rectangle.
    pub(crate) fn fill(&mut self, x: u32, y: u32, [width, height]: [u32; 2], color: [u16; 3]) {
        for row in 0..height {
            for column in 0..width {
                self.set(x + column, y + row, color);
            }
        }
    }

    /// Writes text into at most `lines` lines that are `width` pixels wide, broken wherever a line is full.
    pub(crate) fn text(&mut self, x: u32, y: u32, width: u32, lines: u32, text: &str) {
        const BRIGHT: [u16; 3] = [0xe000; 3];
        let letters: Vec<char> = text.chars().collect();
        let in_line = (width / dot_font::ADVANCE).max(1) as usize;
        for (line, letters) in (0..lines).zip(letters.chunks(in_line)) {
            for (column, row) in dot_font::dots(&String::from_iter(letters)) {
                self.set(x + column, y + line * LINE_PIXELS + row, BRIGHT);
            }
        }
    }

    fn set(&mut self, x: u32, y: u32, color: [u16; 3]) {
        if x < self.image.width && y < self.image.height {
            self.image.pixels[y as usize * self.image.width as usize + x as usize] = color;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drawing_stays_inside() {
        let mut canvas = Canvas::new(8, 9);
        canvas.text(0, 0, 100, 3, "WIDE TEXT THAT LEAVES THE CANVAS");
        canvas.fill(6, 7, [5, 5], [1, 2, 3]);
        let image = canvas.into_image();
        assert_eq!(image.pixels.len(), 72);
        assert_eq!(image.pixels[71], [1, 2, 3]);
    }
}
