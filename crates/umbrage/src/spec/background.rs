use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use glam::Vec3;
use umbrage_files::OpenOptions;

use super::color::{color, is_name};
use super::{Words, vector};
use crate::{Background, Error};

/// A scene's background: `sky`, `none`, a colour by its name in CSS, as `#rrggbb` or as linear `R,G,B`, or
/// the path of a latitude–longitude image.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum BackgroundSpec {
    /// The sky.
    #[default]
    Sky,
    /// Nothing, and the sky's light.
    Transparent,
    /// A linear colour.
    Color(Vec3),
    /// An image.
    File(PathBuf),
}

impl BackgroundSpec {
    /// The background itself, read from its file where it has one.
    ///
    /// # Errors
    /// As [`Background::open`].
    pub fn open(&self) -> Result<Background, Error> {
        self.open_within(OpenOptions::default().max_memory)
    }

    /// As [`BackgroundSpec::open`], with a limit of `max_memory` bytes.
    ///
    /// # Errors
    /// As [`Background::open`].
    pub fn open_within(&self, max_memory: u64) -> Result<Background, Error> {
        match self {
            Self::Sky => Ok(Background::Sky),
            Self::Transparent => Ok(Background::Transparent),
            Self::Color(color) => Ok(Background::Color(*color)),
            Self::File(path) => Background::open_within(path, max_memory),
        }
    }
}

impl fmt::Display for BackgroundSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sky => f.write_str("sky"),
            Self::Transparent => f.write_str("none"),
            Self::Color(color) => Words(color.to_array()).fmt(f),
            Self::File(path) => path.display().fmt(f),
        }
    }
}

impl FromStr for BackgroundSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "sky" => return Ok(Self::Sky),
            "none" => return Ok(Self::Transparent),
            _ => {}
        }
        // A file without an extension is named with its folder: `./sky`.
        if text.starts_with('#') || is_name(text) || vector(text).is_ok() {
            return color(text).map(Self::Color);
        }
        Ok(Self::File(text.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backgrounds_are_colours_or_files() {
        assert_eq!("sky".parse(), Ok(BackgroundSpec::Sky));
        assert_eq!("none".parse(), Ok(BackgroundSpec::Transparent));
        assert_eq!("#ff0000".parse(), Ok(BackgroundSpec::Color(Vec3::X)));
        assert_eq!("0,0.5,2".parse(), Ok(BackgroundSpec::Color(Vec3::new(0.0, 0.5, 2.0))));
        assert_eq!("a,b.hdr".parse(), Ok(BackgroundSpec::File("a,b.hdr".into())));
        assert_eq!("blue".parse(), Ok(BackgroundSpec::Color(Vec3::Z)));
        assert_eq!("./blue".parse(), Ok(BackgroundSpec::File("./blue".into())));
        assert!("bleu".parse::<BackgroundSpec>().unwrap_err().contains("`blue`"));
        for bad in ["#12345", "#+12345", "0,-1,0"] {
            assert!(bad.parse::<BackgroundSpec>().is_err(), "{bad}");
        }
        for text in ["sky", "none", "0.1,0.2,3", "a,b.hdr"] {
            assert_eq!(text.parse::<BackgroundSpec>().unwrap().to_string(), text);
        }
    }
}
