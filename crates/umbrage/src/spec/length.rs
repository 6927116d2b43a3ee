use std::fmt;
use std::str::FromStr;

use super::number;

/// A length from 0: in world units, `0.1`, or as a share of the [scene's size](umbrage_scene::Scene::size), `2%`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Length {
    /// World units.
    World(f32),
    /// Hundredths of the scene's size.
    Percent(f32),
}

impl Length {
    /// The length in world units, in a scene of this size.
    #[must_use]
    pub fn in_scene(self, size: f32) -> f32 {
        match self {
            Self::World(length) => length,
            Self::Percent(percent) => (f64::from(size) * f64::from(percent) / 100.0).min(f32::MAX.into()) as f32,
        }
    }

    /// Whether the length depends on the scene.
    #[must_use]
    pub fn is_share(self) -> bool {
        matches!(self, Self::Percent(_))
    }

    /// Whether the length is above 0.
    #[must_use]
    pub fn is_positive(self) -> bool {
        self.number() > 0.0
    }

    /// The number as it is written.
    pub(super) fn number(self) -> f32 {
        let (Self::World(number) | Self::Percent(number)) = self;
        number
    }
}

impl fmt::Display for Length {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::World(length) => length.fmt(f),
            Self::Percent(percent) => write!(f, "{percent}%"),
        }
    }
}

impl FromStr for Length {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let from_zero = |text: &str| number(text).ok().filter(|number| *number >= 0.0);
        let length = match text.trim_end().strip_suffix('%') {
            Some(percent) => from_zero(percent).map(Self::Percent),
            None => from_zero(text).map(Self::World),
        };
        length.ok_or_else(|| {
            format!("`{text}` is no length: give world units from 0, such as 0.1, or a share of the scene's size, such as 2%")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_world_units_or_shares_of_the_scene() {
        for (text, in_scene) in [("0.5", 0.5), ("2%", 0.08), ("0", 0.0), ("0%", 0.0), ("250%", 10.0)] {
            let length: Length = text.parse().unwrap();
            assert_eq!((length.in_scene(4.0), length.to_string().as_str()), (in_scene, text));
            assert_eq!((length.is_share(), length.is_positive()), (text.contains('%'), in_scene > 0.0));
        }
        assert_eq!(Length::Percent(200.0).in_scene(f32::MAX), f32::MAX);
        for text in ["", "%", "-3%", "-1", "x", "2%%", "% 2", "inf", "nan%", "1e39%"] {
            let refused = text.parse::<Length>().unwrap_err();
            assert!(
                refused.starts_with(&format!("`{text}` is no length")) && refused.contains("such as 2%"),
                "{refused}"
            );
        }
    }
}
