//! Stills of 8 bits a channel: JPEG, and WebP without loss.

use std::io::{self, Write};
use std::path::Path;

use super::partial_file::Look;
use super::png::Rows;
use super::{Error, JpegQuality, partial_file};

/// Writes one opaque picture as a JPEG file.
pub(super) fn write_jpeg(rows: &Rows<'_>, path: &Path, quality: JpegQuality, look: Look<'_>) -> Result<(), Error> {
    partial_file::write(path, look, |file| (&*file).write_all(&jpeg(rows, quality)?))
}

/// Writes one picture as a WebP file without loss.
pub(super) fn write_webp(rows: &Rows<'_>, path: &Path, look: Look<'_>) -> Result<(), Error> {
    partial_file::write(path, look, |file| (&*file).write_all(&webp(rows)?))
}

fn jpeg(rows: &Rows<'_>, quality: JpegQuality) -> io::Result<Vec<u8>> {
    use jpeg_encoder::{ColorType, Encoder, EncodingError};
    let sides = rows.size.map(u16::try_from);
    let [Ok(width), Ok(height)] = sides else { return Err(io::Error::other("a JPEG has at most 65535 pixels a side")) };
    let mut bytes = Vec::new();
    let encoder = Encoder::new(&mut bytes, quality.get());
    match encoder.encode(rows.bytes, width, height, ColorType::Rgb) {
        Ok(()) => Ok(bytes),
        Err(EncodingError::IoError(source)) => Err(source),
        Err(other) => Err(io::Error::other(other)),
    }
}

fn webp(rows: &Rows<'_>) -> io::Result<Vec<u8>> {
    use image_webp::{ColorType, EncodingError, WebPEncoder};
    let color = if rows.has_alpha { ColorType::Rgba8 } else { ColorType::Rgb8 };
    let mut bytes = Vec::new();
    let encoder = WebPEncoder::new(&mut bytes);
    let [width, height] = rows.size;
    match encoder.encode(rows.bytes, width, height, color) {
        Ok(()) => Ok(bytes),
        Err(EncodingError::IoError(source)) => Err(source),
        Err(other) => Err(io::Error::other(other)),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use image_webp::WebPDecoder;
    use umbrage_files::image_file::{self, ImageFormat};

    use super::*;
    use crate::Image;
    use crate::output::{BitDepth, png};

    /// Slopes of three colours, of sides that aren't multiples of a JPEG's blocks.
    fn picture() -> Image {
        let pixel = |pixel: u16| [pixel % 37 * 1700, pixel / 37 * 2500, 60_000 - pixel % 37 * 1500];
        Image { width: 37, height: 21, pixels: (0..37 * 21).map(pixel).collect(), ..Image::default() }
    }

    #[test]
    fn pictures_come_back_nearly_and_smaller_ones_less() {
        let coded = |quality| {
            let rows = png::rows(&picture(), BitDepth::Eight);
            let bytes =
                jpeg(&Rows { bytes: &rows, ..Rows::of(&picture()) }, JpegQuality::new(quality).unwrap()).unwrap();
            let decoded = image_file::decode(&bytes, ImageFormat::Jpeg, 1 << 20, &mut |_| Ok(())).unwrap();
            assert_eq!(decoded.size, [37, 21]);
            let levels = decoded.rgba().into_iter().flat_map(|[red, green, blue, _]| [red, green, blue]);
            let expected = png::rows(&picture(), BitDepth::Eight);
            let errors = levels.zip(&expected).map(|(level, expected)| level.abs_diff(*expected));
            (bytes.len(), errors.max().unwrap())
        };
        let [(large, small_error), (small, large_error)] = [coded(92), coded(30)];
        assert!(small_error <= 8 && small < large && small_error < large_error, "{small_error} {large_error}");
    }

    #[test]
    fn pictures_come_back_exactly_with_and_without_alpha() {
        let pixels = (0..13 * 7).map(|pixel: u16| [pixel * 700, 65_535 - pixel * 500, pixel.wrapping_mul(7919)]);
        let opaque = Image { width: 13, height: 7, pixels: pixels.collect(), ..Image::default() };
        let transparent = Image { alpha: (0..13 * 7).map(|pixel| pixel * 720).collect(), ..opaque.clone() };
        for (image, has_alpha) in [(opaque, false), (transparent, true)] {
            let rows = png::rows(&image, BitDepth::Eight);
            let bytes = webp(&Rows { bytes: &rows, ..Rows::of(&image) }).unwrap();
            let mut decoder = WebPDecoder::new(Cursor::new(bytes)).unwrap();
            assert_eq!((decoder.dimensions(), decoder.has_alpha(), decoder.is_lossy()), ((13, 7), has_alpha, false));
            let mut levels = vec![0; decoder.output_buffer_size().unwrap()];
            decoder.read_image(&mut levels).unwrap();
            assert_eq!(levels, rows);
        }
    }
}
