use std::io::{self, BufWriter, Write};
use std::path::Path;

use ::png::{ColorType, Compression as Effort, Encoder, EncodingError, SrgbRenderingIntent};

use super::format::eight_bits;
use super::partial_file::Look;
use super::{BitDepth, Compression, Error, partial_file};
use crate::Image;

/// Writes one picture as a PNG file, compressed fast.
///
/// # Errors
/// Where the system refuses to write, or the path is a folder.
pub fn write_png(image: &Image, path: &Path, depth: BitDepth) -> Result<(), Error> {
    partial_file::sweep(path);
    write(&Rows { bytes: &rows(image, depth), ..Rows::of(image) }, path, depth, Compression::Fast, &mut |_| Ok(()))
}

/// A picture's rows as files hold them.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    /// Width and height in pixels.
    pub(super) size: [u32; 2],
    pub(super) has_alpha: bool,
    /// RGB or RGBA; sixteen bits are big-endian.
    pub(super) bytes: &'a [u8],
}

impl Rows<'_> {
    /// Those of an image, still empty.
    pub(super) fn of(image: &Image) -> Self {
        Self { size: [image.width, image.height], has_alpha: !image.alpha.is_empty(), bytes: &[] }
    }
}

/// As [`write_png`], with any compression, but sweeps nothing.
pub(super) fn write(
    rows: &Rows<'_>,
    path: &Path,
    depth: BitDepth,
    compression: Compression,
    look: Look<'_>,
) -> Result<(), Error> {
    partial_file::write(path, look, |file| encode(rows, BufWriter::new(file), depth, compression).map_err(failure))
}

fn encode(rows: &Rows<'_>, target: impl Write, depth: BitDepth, compression: Compression) -> Result<(), EncodingError> {
    let coding = Coding { depth, compression, has_alpha: rows.has_alpha };
    let mut writer = encoder(target, rows.size, coding).write_header()?;
    writer.write_image_data(rows.bytes)?;
    writer.finish()
}

/// The coding of a PNG's pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coding {
    pub(crate) depth: BitDepth,
    pub(crate) compression: Compression,
    pub(crate) has_alpha: bool,
}

/// An encoder for sRGB pictures of one size, in pixels.
pub(crate) fn encoder<W: Write>(
    target: W,
    [width, height]: [u32; 2],
    Coding { depth, compression, has_alpha }: Coding,
) -> Encoder<'static, W> {
    let mut encoder = Encoder::new(target, width, height);
    encoder.set_color(if has_alpha { ColorType::Rgba } else { ColorType::Rgb });
    encoder.set_depth(match depth {
        BitDepth::Eight => ::png::BitDepth::Eight,
        BitDepth::Sixteen => ::png::BitDepth::Sixteen,
    });
    encoder.set_compression(match compression {
        Compression::Fast => Effort::Fast,
        Compression::Small => Effort::Balanced,
    });
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder
}

/// The picture's rows as a PNG holds them: sixteen bits are big-endian.
pub(crate) fn rows(image: &Image, depth: BitDepth) -> Vec<u8> {
    let with_alpha: Vec<[u16; 4]>;
    let levels = if image.alpha.is_empty() {
        image.pixels.as_flattened()
    } else {
        let pixels = image.pixels.iter().zip(&image.alpha);
        with_alpha = pixels.map(|(&[red, green, blue], &alpha)| [red, green, blue, alpha]).collect();
        with_alpha.as_flattened()
    };
    match depth {
        BitDepth::Eight => levels.iter().map(|&level| eight_bits(level)).collect(),
        BitDepth::Sixteen => levels.iter().flat_map(|level| level.to_be_bytes()).collect(),
    }
}

/// The system's own error, where it refused to write.
pub(crate) fn failure(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(source) => source,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    /// Every channel takes many values, and no row or column is like another.
    fn picture() -> Image {
        let pixels = (0..6 * 5).map(|pixel: u16| [pixel * 2184, 65_535 - pixel * 1999, pixel.wrapping_mul(7919)]);
        Image { width: 6, height: 5, pixels: pixels.collect(), ..Image::default() }
    }

    fn coded(depth: BitDepth) -> (::png::OutputInfo, Vec<u8>) {
        let mut bytes = Vec::new();
        let rows = Rows { bytes: &rows(&picture(), depth), ..Rows::of(&picture()) };
        encode(&rows, &mut bytes, depth, Compression::Small).unwrap();
        let mut reader = ::png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
        let mut rows = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut rows).unwrap();
        assert_eq!((info.width, info.height), (6, 5));
        (info, rows)
    }

    #[test]
    fn sixteen_bits_come_back_exactly() {
        let (info, rows) = coded(BitDepth::Sixteen);
        assert_eq!(info.bit_depth, ::png::BitDepth::Sixteen);
        let levels: Vec<u16> = rows.chunks(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect();
        assert_eq!(levels, picture().pixels.as_flattened());
    }

    #[test]
    fn alpha_comes_back() {
        let alpha: Vec<u16> = (0..30).map(|pixel| pixel * 2200).collect();
        let image = Image { alpha: alpha.clone(), ..picture() };
        let mut bytes = Vec::new();
        let rows = Rows { bytes: &rows(&image, BitDepth::Sixteen), ..Rows::of(&image) };
        encode(&rows, &mut bytes, BitDepth::Sixteen, Compression::Fast).unwrap();
        let mut reader = ::png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
        let mut rows = vec![0; reader.output_buffer_size().unwrap()];
        assert_eq!(reader.next_frame(&mut rows).unwrap().color_type, ColorType::Rgba);
        for ((pixel, color), alpha) in rows.chunks(8).zip(&image.pixels).zip(alpha) {
            let levels = [0, 2, 4, 6].map(|byte| u16::from_be_bytes([pixel[byte], pixel[byte + 1]]));
            assert_eq!(levels, [color[0], color[1], color[2], alpha]);
        }
    }

    #[test]
    fn eight_bits_come_back_rounded() {
        let (info, rows) = coded(BitDepth::Eight);
        assert_eq!(info.bit_depth, ::png::BitDepth::Eight);
        for (byte, level) in rows.iter().zip(picture().pixels.as_flattened()) {
            assert!((f64::from(*byte) - f64::from(*level) / 257.0).abs() <= 0.5);
        }
    }
}
