use std::io::{self, BufWriter, Write};
use std::path::Path;

use ::png::{ColorType, Encoder, EncodingError, SrgbRenderingIntent};

use super::format::eight_bits;
use super::{BitDepth, Error, partial_file};
use crate::Image;

/// Writes one picture as a PNG file.
///
/// # Errors
/// Where the system refuses to write, or the path is a folder.
pub fn write_png(image: &Image, path: &Path, depth: BitDepth) -> Result<(), Error> {
    partial_file::sweep(path);
    write(image, path, depth)
}

/// As [`write_png`], but sweeps nothing.
pub(super) fn write(image: &Image, path: &Path, depth: BitDepth) -> Result<(), Error> {
    partial_file::write(path, |file| encode(image, BufWriter::new(file), depth).map_err(failure))
}

fn encode(image: &Image, target: impl Write, depth: BitDepth) -> Result<(), EncodingError> {
    let mut writer = encoder(target, [image.width, image.height], depth).write_header()?;
    writer.write_image_data(&rows(image, depth))?;
    writer.finish()
}

/// An encoder for sRGB pictures of one size, in pixels.
pub(crate) fn encoder<W: Write>(target: W, [width, height]: [u32; 2], depth: BitDepth) -> Encoder<'static, W> {
    let mut encoder = Encoder::new(target, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(match depth {
        BitDepth::Eight => ::png::BitDepth::Eight,
        BitDepth::Sixteen => ::png::BitDepth::Sixteen,
    });
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder
}

/// The picture's rows as a PNG holds them: sixteen bits are big-endian.
pub(crate) fn rows(image: &Image, depth: BitDepth) -> Vec<u8> {
    let levels = image.pixels.as_flattened();
    match depth {
        BitDepth::Eight => levels.iter().map(|&level| eight_bits(level)).collect(),
        BitDepth::Sixteen => levels.iter().flat_map(|level| level.to_be_bytes()).collect(),
    }
}

/// What the system said, where it refused to write.
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
        Image { width: 6, height: 5, pixels: pixels.collect() }
    }

    fn coded(depth: BitDepth) -> (::png::OutputInfo, Vec<u8>) {
        let mut bytes = Vec::new();
        encode(&picture(), &mut bytes, depth).unwrap();
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
    fn eight_bits_come_back_rounded() {
        let (info, rows) = coded(BitDepth::Eight);
        assert_eq!(info.bit_depth, ::png::BitDepth::Eight);
        for (byte, level) in rows.iter().zip(picture().pixels.as_flattened()) {
            assert!((f64::from(*byte) - f64::from(*level) / 257.0).abs() <= 0.5);
        }
    }
}
