use glam::Vec3;

use super::vector;
use crate::panorama::linear_from_srgb;
use crate::structure::edits;

/// A linear colour: by a name of CSS in upper or lower case, as `#rrggbb` of sRGB, or as linear `R,G,B`.
pub(super) fn color(text: &str) -> Result<Vec3, String> {
    if let Some(digits) = text.strip_prefix('#') {
        return hexadecimal(digits).ok_or_else(|| "give a colour as #rrggbb, such as #203040".to_owned());
    }
    if is_name(text) {
        return named(text);
    }
    match vector(text) {
        Ok(color) if color.min_element() < 0.0 => Err("a colour isn't below zero".to_owned()),
        Ok(color) => Ok(color),
        Err(_) => Err(format!("`{text}` is no colour: give a name such as orange, #rrggbb, or linear R,G,B")),
    }
}

/// Whether a word looks like a colour's name.
pub(super) fn is_name(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|letter| letter.is_ascii_alphabetic())
}

fn named(name: &str) -> Result<Vec3, String> {
    let known = names().find(|(known, _)| known.eq_ignore_ascii_case(name));
    if let Some(color) = known.and_then(|(_, digits)| hexadecimal(digits)) {
        return Ok(color);
    }
    let lower = name.to_ascii_lowercase();
    let nearest = names().map(|(known, _)| known).min_by_key(|known| edits(&lower, known)).unwrap_or_default();
    Err(format!("there is no colour `{name}`; the nearest name is `{nearest}`"))
}

fn hexadecimal(digits: &str) -> Option<Vec3> {
    if digits.len() != 6 || !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return None;
    }
    u32::from_str_radix(digits, 16).ok().map(linear)
}

/// The linear colour of `0xrrggbb` of sRGB.
fn linear(color: u32) -> Vec3 {
    Vec3::from_slice(&color.to_be_bytes().map(|byte| linear_from_srgb(f32::from(byte) / 255.0))[1..])
}

/// The named colours of CSS Color Module Level 4, section 6.1, each with its digits.
fn names() -> impl Iterator<Item = (&'static str, &'static str)> {
    include_str!("colors.txt").lines().filter_map(|line| line.split_once(' '))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_names_digits_or_numbers() {
        assert_eq!(color("blue"), Ok(Vec3::Z));
        assert_eq!(color("RebeccaPurple"), color("#663399"));
        assert_eq!(color("grey"), color("#808080"));
        assert_eq!(color("0,0.5,2"), Ok(Vec3::new(0.0, 0.5, 2.0)));
        assert!(names().is_sorted() && names().count() == 148 && names().all(|(name, _)| color(name).is_ok()));
    }

    #[test]
    fn unknown_names_suggest_the_nearest() {
        for (name, nearest) in [
            ("bleu", "blue"),
            ("orang", "orange"),
            ("Rebecapurple", "rebeccapurple"),
            ("darkslategry", "darkslategray"),
        ] {
            let refused = color(name).unwrap_err();
            assert_eq!(refused, format!("there is no colour `{name}`; the nearest name is `{nearest}`"));
        }
        for (text, part) in
            [("#12345", "#rrggbb"), ("#+12345", "#rrggbb"), ("0,-1,0", "below zero"), ("1,2", "no colour")]
        {
            assert!(color(text).unwrap_err().contains(part), "{text}");
        }
    }
}
