use std::path::Path;

use umbrage_rays::Choice;

/// A file format for pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Portable Network Graphics, 8 or 16 bits a channel; one file for each frame.
    Png,
    /// OpenEXR: linear radiance, depth, normals and triangle ids; one file for each frame.
    Exr,
    /// An animation of at most 256 colours a frame.
    Gif,
    /// An animated PNG.
    Apng,
    /// YUV4MPEG2, uncompressed video that encoders read.
    Y4m,
}

impl Format {
    /// The format that a path's extension means, in upper or lower case.
    #[must_use]
    pub fn of_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?;
        Self::all().find(|format| format.name().eq_ignore_ascii_case(extension))
    }

    /// Whether its files can say how much of a pixel is covered.
    #[must_use]
    pub fn has_alpha(self) -> bool {
        matches!(self, Self::Png | Self::Apng | Self::Exr)
    }

    /// Whether one file holds all frames.
    #[must_use]
    pub fn is_animation(self) -> bool {
        matches!(self, Self::Gif | Self::Apng | Self::Y4m)
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
        assert_eq!(Format::of_path(Path::new("b.jpeg")), None);
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
