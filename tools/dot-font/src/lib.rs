//! Letters of five by seven dots, and a canvas to write them on pictures.
#![forbid(unsafe_code)]

/// Width of a letter in dots.
const WIDTH: u32 = 5;
/// Distance between the starts of neighbouring letters, in dots.
pub const ADVANCE: u32 = WIDTH + 1;
/// Height of a letter in dots.
pub const HEIGHT: u32 = 7;

/// A picture to draw on, in rows from the upper left corner. Drawing is clipped to it.
#[derive(Debug)]
pub struct Canvas<'a, P> {
    /// All rows.
    pub pixels: &'a mut [P],
    /// Pixels of a row.
    pub width: u32,
}

impl<P: Copy> Canvas<'_, P> {
    /// Fills a rectangle.
    pub fn fill(&mut self, [x, y]: [u32; 2], [width, height]: [u32; 2], color: P) {
        let columns = x.min(self.width) as usize..(x + width).min(self.width) as usize;
        let rows = self.pixels.chunks_mut(self.width.max(1) as usize);
        rows.skip(y as usize).take(height as usize).for_each(|row| row[columns.clone()].fill(color));
    }

    /// Writes a line of text, each dot a square of `dot` pixels a side.
    pub fn text(&mut self, [x, y]: [u32; 2], dot: u32, text: &str, color: P) {
        dots(text).for_each(|(column, row)| self.fill([x + column * dot, y + row * dot], [dot; 2], color));
    }
}

/// The dots of a text, as columns and rows from its upper left corner. Lower case is shown as upper case, and characters
/// without a glyph as a box.
fn dots(text: &str) -> impl Iterator<Item = (u32, u32)> {
    (0..).zip(text.chars()).flat_map(|(index, letter)| {
        (0..).zip(rows(letter)).flat_map(move |(row, bits)| {
            let columns = (0..WIDTH).filter(move |column| bits >> (WIDTH - 1 - column) & 1 == 1);
            columns.map(move |column| (index * ADVANCE + column, row))
        })
    })
}

/// Width of a text in dots.
pub fn width(text: &str) -> u32 {
    (text.chars().count() as u32 * ADVANCE).saturating_sub(ADVANCE - WIDTH)
}

/// The rows of a letter from the top; the leftmost dot is the highest of five bits.
fn rows(letter: char) -> [u8; HEIGHT as usize] {
    match letter.to_ascii_uppercase() {
        ' ' => [0; HEIGHT as usize],
        'A' => [0b01110, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001],
        'B' => [0b11110, 0b10001, 0b10001, 0b11110, 0b10001, 0b10001, 0b11110],
        'C' => [0b01110, 0b10001, 0b10000, 0b10000, 0b10000, 0b10001, 0b01110],
        'D' => [0b11110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b11110],
        'E' => [0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b11111],
        'F' => [0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b10000],
        'G' => [0b01110, 0b10001, 0b10000, 0b10111, 0b10001, 0b10001, 0b01110],
        'H' => [0b10001, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001],
        'I' => [0b01110, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110],
        'J' => [0b00111, 0b00010, 0b00010, 0b00010, 0b00010, 0b10010, 0b01100],
        'K' => [0b10001, 0b10010, 0b10100, 0b11000, 0b10100, 0b10010, 0b10001],
        'L' => [0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b11111],
        'M' => [0b10001, 0b11011, 0b10101, 0b10101, 0b10001, 0b10001, 0b10001],
        'N' => [0b10001, 0b11001, 0b10101, 0b10011, 0b10001, 0b10001, 0b10001],
        'O' => [0b01110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110],
        'P' => [0b11110, 0b10001, 0b10001, 0b11110, 0b10000, 0b10000, 0b10000],
        'Q' => [0b01110, 0b10001, 0b10001, 0b10001, 0b10101, 0b10010, 0b01101],
        'R' => [0b11110, 0b10001, 0b10001, 0b11110, 0b10100, 0b10010, 0b10001],
        'S' => [0b01111, 0b10000, 0b10000, 0b01110, 0b00001, 0b00001, 0b11110],
        'T' => [0b11111, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100],
        'U' => [0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110],
        'V' => [0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01010, 0b00100],
        'W' => [0b10001, 0b10001, 0b10001, 0b10101, 0b10101, 0b11011, 0b10001],
        'X' => [0b10001, 0b10001, 0b01010, 0b00100, 0b01010, 0b10001, 0b10001],
        'Y' => [0b10001, 0b10001, 0b01010, 0b00100, 0b00100, 0b00100, 0b00100],
        'Z' => [0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b10000, 0b11111],
        '0' => [0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110],
        '1' => [0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110],
        '2' => [0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111],
        '3' => [0b01110, 0b10001, 0b00001, 0b00110, 0b00001, 0b10001, 0b01110],
        '4' => [0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010],
        '5' => [0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110],
        '6' => [0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110],
        '7' => [0b11111, 0b00001, 0b00010, 0b00100, 0b00100, 0b01000, 0b01000],
        '8' => [0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110],
        '9' => [0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100],
        '.' => [0, 0, 0, 0, 0, 0b01100, 0b01100],
        ',' => [0, 0, 0, 0, 0b00110, 0b00100, 0b01000],
        ':' => [0, 0b01100, 0b01100, 0, 0b01100, 0b01100, 0],
        ';' => [0, 0b00110, 0b00110, 0, 0b00110, 0b00100, 0b01000],
        '-' => [0, 0, 0, 0b01110, 0, 0, 0],
        '+' => [0, 0b00100, 0b00100, 0b11111, 0b00100, 0b00100, 0],
        '=' => [0, 0, 0b11111, 0, 0b11111, 0, 0],
        '_' => [0, 0, 0, 0, 0, 0, 0b11111],
        '/' => [0b00001, 0b00001, 0b00010, 0b00100, 0b01000, 0b10000, 0b10000],
        '(' => [0b00010, 0b00100, 0b01000, 0b01000, 0b01000, 0b00100, 0b00010],
        ')' => [0b01000, 0b00100, 0b00010, 0b00010, 0b00010, 0b00100, 0b01000],
        '[' => [0b01110, 0b01000, 0b01000, 0b01000, 0b01000, 0b01000, 0b01110],
        ']' => [0b01110, 0b00010, 0b00010, 0b00010, 0b00010, 0b00010, 0b01110],
        '?' => [0b01110, 0b10001, 0b00001, 0b00110, 0b00100, 0, 0b00100],
        '!' => [0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0, 0b00100],
        '%' => [0b11001, 0b11001, 0b00010, 0b00100, 0b01000, 0b10011, 0b10011],
        '#' => [0b01010, 0b01010, 0b11111, 0b01010, 0b11111, 0b01010, 0b01010],
        '`' => [0b01000, 0b00100, 0, 0, 0, 0, 0],
        '\'' => [0b00100, 0b00100, 0, 0, 0, 0, 0],
        '"' => [0b01010, 0b01010, 0, 0, 0, 0, 0],
        '*' => [0, 0b10101, 0b01110, 0b11111, 0b01110, 0b10101, 0],
        '<' => [0b00010, 0b00100, 0b01000, 0b10000, 0b01000, 0b00100, 0b00010],
        '>' => [0b01000, 0b00100, 0b00010, 0b00001, 0b00010, 0b00100, 0b01000],
        _ => [0b11111, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b11111],
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn letters_differ_and_fit() {
        let letters = (b' '..=b'`').map(char::from).filter(|letter| rows(*letter) != rows('\u{1}'));
        let mut seen = BTreeMap::new();
        for letter in letters {
            let rows = rows(letter);
            assert!(rows.iter().all(|row| *row < 1 << WIDTH), "{letter}");
            assert_eq!(seen.insert(rows, letter), None, "{letter}");
        }
        for letter in ('0'..='9').chain('A'..='Z').chain(".,:;-+=_/()[]?!%#`'\"*<>".chars()) {
            assert_eq!(seen.get(&rows(letter)), Some(&letter), "it has a letter");
        }
    }

    #[test]
    fn drawing_stays_inside() {
        let mut pixels = vec![0; 72];
        let mut canvas = Canvas { pixels: &mut pixels, width: 8 };
        canvas.text([0, 0], 2, "WIDE TEXT THAT LEAVES THE CANVAS", 1);
        canvas.fill([6, 7], [5, 5], 2);
        canvas.fill([9, 20], [1, 1], 3);
        assert_eq!((pixels[2], pixels[71], pixels.contains(&3)), (0, 2, false));
    }

    #[test]
    fn letters_stand_beside_each_other() {
        assert_eq!(width(""), 0);
        assert_eq!(width("10"), 11);
        let dots: Vec<_> = dots("1l").collect();
        assert!(dots.contains(&(2, 0)) && dots.contains(&(6, 0)) && dots.contains(&(10, 6)));
        assert!(dots.iter().all(|&(x, y)| x < 11 && y < HEIGHT));
    }
}
