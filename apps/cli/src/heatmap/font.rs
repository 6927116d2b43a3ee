//! Letters of five by seven dots.

/// Dots from the start of one letter to that of the next.
pub(super) const ADVANCE: u32 = 6;
/// Dots from top to bottom of a letter.
pub(super) const HEIGHT: u32 = 7;

/// Where the dots of a text are, as columns and rows from its upper left. Lower case is shown as upper case; what has
/// no letter here is left blank.
pub(super) fn dots(text: &str) -> impl Iterator<Item = (u32, u32)> {
    text.chars().enumerate().flat_map(|(place, letter)| {
        let first = place as u32 * ADVANCE;
        let rows = (0..).zip(rows(letter.to_ascii_uppercase()));
        rows.flat_map(move |(row, bits)| {
            (0..5).filter(move |column| bits >> (4 - column) & 1 == 1).map(move |column| (first + column, row))
        })
    })
}

/// Dots from the start of a text to its end.
pub(super) fn width(text: &str) -> u32 {
    (text.chars().count() as u32 * ADVANCE).saturating_sub(1)
}

/// The rows of a letter from the top, the leftmost dot in the highest of five bits.
fn rows(letter: char) -> [u8; HEIGHT as usize] {
    match letter {
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
        '>' => [0b01000, 0b00100, 0b00010, 0b00001, 0b00010, 0b00100, 0b01000],
        'A' => [0b01110, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001],
        'C' => [0b01110, 0b10001, 0b10000, 0b10000, 0b10000, 0b10001, 0b01110],
        'D' => [0b11110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b11110],
        'E' => [0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b11111],
        'G' => [0b01110, 0b10001, 0b10000, 0b10111, 0b10001, 0b10001, 0b01110],
        'I' => [0b01110, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110],
        'L' => [0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b11111],
        'M' => [0b10001, 0b11011, 0b10101, 0b10101, 0b10001, 0b10001, 0b10001],
        'N' => [0b10001, 0b11001, 0b10101, 0b10011, 0b10001, 0b10001, 0b10001],
        'O' => [0b01110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110],
        'P' => [0b11110, 0b10001, 0b10001, 0b11110, 0b10000, 0b10000, 0b10000],
        'R' => [0b11110, 0b10001, 0b10001, 0b11110, 0b10100, 0b10010, 0b10001],
        'S' => [0b01111, 0b10000, 0b10000, 0b01110, 0b00001, 0b00001, 0b11110],
        'T' => [0b11111, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100],
        'U' => [0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110],
        'V' => [0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01010, 0b00100],
        'X' => [0b10001, 0b10001, 0b01010, 0b00100, 0b01010, 0b10001, 0b10001],
        _ => [0; HEIGHT as usize],
    }
}

#[cfg(test)]
mod tests {
    use umbrage::HeatKind;
    use umbrage::rays::Choice;

    use super::*;

    #[test]
    fn letters_stand_beside_each_other() {
        assert_eq!(width(""), 0);
        assert_eq!(width("10"), 11);
        let dots: Vec<_> = dots("1l").collect();
        assert!(dots.contains(&(2, 0)) && dots.contains(&(6, 0)) && dots.contains(&(10, 6)));
        assert!(dots.iter().all(|&(x, y)| x < 11 && y < HEIGHT));
    }

    #[test]
    fn what_is_written_has_letters() {
        for title in HeatKind::all().map(HeatKind::title) {
            let letters = title.chars().filter(|letter| !letter.is_whitespace());
            assert!(letters.clone().all(|letter| dots(&letter.to_string()).count() > 2), "{title}");
        }
        assert!("0123456789.>MINMEANMAX".chars().all(|letter| dots(&letter.to_string()).count() > 2));
    }
}
