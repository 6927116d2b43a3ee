use std::path::Path;

use umbrage_rays::Choice;

/// A file format for pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Portable Network Graphics, 8 or 16 bits a channel; one file for each frame.
    Png,
    /// JPEG, 8 bits a channel; one file for each frame.
    Jpeg,
    /// WebP without loss, 8 bits a channel; one file for each frame.
    WebP,
    /// OpenEXR: linear radiance, depth, normals and triangle ids; one file for each frame.
    Exr,
    /// An animation of at most 256 colours a frame.
    Gif,
    /// An animated PNG.
    Apng,
    /// H.264 video with colours of ITU-R BT.709, made by the program `ffmpeg`.
    Mp4,
    /// YUV4MPEG2, uncompressed video that encoders read.
    Y4m,
}

impl Format {
    /// The format that a path's extension means, in upper or lower case.
    #[must_use]
    pub fn of_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?;
        if extension.eq_ignore_ascii_case("jpeg") {
            return Some(Self::Jpeg);
        }
        Self::all().find(|format| format.name().eq_ignore_ascii_case(extension))
    }

    /// Whether its files can have the coverage of pixels.
    #[must_use]
    pub fn has_alpha(self) -> bool {
        matches!(self, Self::Png | Self::Apng | Self::WebP | Self::Exr)
    }

    /// Whether one file holds all frames.
    #[must_use]
    pub fn is_animation(self) -> bool {
        matches!(self, Self::Gif | Self::Apng | Self::Mp4 | Self::Y4m)
    }
}

/// The extensions of the formats for which `is_wanted` holds: `.png, .apng or .exr`.
#[must_use]
pub fn extensions(is_wanted: impl Fn(Format) -> bool) -> String {
    let mut names: Vec<String> =
        Format::all().filter(|format| is_wanted(*format)).map(|format| format!(".{}", format.name())).collect();
    let last = names.pop().unwrap_or_default();
    if names.is_empty() { last } else { format!("{} or {last}", names.join(", ")) }
}

/// Quality of a JPEG, 1 to 100.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JpegQuality(u8);

impl JpegQuality {
    /// The quality of this number; `None` unless it is from 1 to 100.
    #[must_use]
    pub fn new(quality: u8) -> Option<Self> {
        (1..=100).contains(&quality).then_some(Self(quality))
    }

    /// The number.
    #[must_use]
    pub fn get(self) -> u8 {
        self.0
    }
}

impl Default for JpegQuality {
    /// 92: differences are hard to see, and colours have every pixel.
    fn default() -> Self {
        Self(92)
    }
}

/// Bits for each channel of a PNG.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BitDepth {
    /// 256 levels.
    #[default]
    Eight,
    /// 65,536 levels.
    Sixteen,
}

/// How hard a PNG or APNG is compressed; its pixels are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// In a small part of the time that a picture takes.
    #[default]
    Fast,
    /// Files about a fifth smaller, in ten times the time.
    Small,
}

/// The nearest of 256 levels.
pub(crate) fn eight_bits(level: u16) -> u8 {
    ((u32::from(level) * 255 + 32_767) / 65_535) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extensions_name_formats_in_either_case() {
        assert_eq!(Format::of_path(Path::new("a/b.PNG")), Some(Format::Png));
        assert_eq!(Format::of_path(Path::new("b.y4m")), Some(Format::Y4m));
        assert_eq!(Format::of_path(Path::new("png")), None);
        for jpeg in ["b.jpeg", "b.JPG"] {
            assert_eq!(Format::of_path(Path::new(jpeg)), Some(Format::Jpeg));
        }
        assert_eq!(Format::of_path(Path::new("b.bmp")), None);
    }

    #[test]
    fn extensions_are_listed_in_words() {
        assert_eq!(extensions(Format::has_alpha), ".png, .webp, .exr or .apng");
        assert_eq!(extensions(|format| format == Format::Mp4), ".mp4");
    }

    #[test]
    fn qualities_are_from_1_to_100() {
        assert_eq!([0, 1, 100, 101].map(|number| JpegQuality::new(number).is_some()), [false, true, true, false]);
    }

    #[test]
    fn eight_bits_round_to_the_nearest_level() {
        for level in 0..=255_u8 {
            let center = u16::from(level) * 257;
            assert_eq!(eight_bits(center), level);
            assert_eq!(eight_bits(center.saturating_sub(128)), level);
            assert_eq!(eight_bits(center.saturating_add(128)), level);
        }
    }
}
