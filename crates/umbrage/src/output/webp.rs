use std::io::{self, Write};
use std::path::Path;

use image_webp::{ColorType, EncodingError, WebPEncoder};

use super::partial_file::Look;
use super::{BitDepth, Error, partial_file, png};
use crate::Image;

/// Writes one picture as a WebP file without loss.
pub(super) fn write(image: &Image, path: &Path, look: Look<'_>) -> Result<(), Error> {
    partial_file::write(path, look, |file| (&*file).write_all(&encode(image)?))
}

fn encode(image: &Image) -> io::Result<Vec<u8>> {
    let color = if image.alpha.is_empty() { ColorType::Rgb8 } else { ColorType::Rgba8 };
    let mut bytes = Vec::new();
    let encoder = WebPEncoder::new(&mut bytes);
    encoder.encode(&png::rows(image, BitDepth::Eight), image.width, image.height, color).map_err(failure)?;
    Ok(bytes)
}

fn failure(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(source) => source,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use image_webp::WebPDecoder;

    use super::*;

    #[test]
    fn pictures_come_back_exactly_with_and_without_alpha() {
        let pixels = (0..13 * 7).map(|pixel: u16| [pixel * 700, 65_535 - pixel * 500, pixel.wrapping_mul(7919)]);
        let opaque = Image { width: 13, height: 7, pixels: pixels.collect(), ..Image::default() };
        let transparent = Image { alpha: (0..13 * 7).map(|pixel| pixel * 720).collect(), ..opaque.clone() };
        for (image, has_alpha) in [(opaque, false), (transparent, true)] {
            let mut decoder = WebPDecoder::new(Cursor::new(encode(&image).unwrap())).unwrap();
            assert_eq!((decoder.dimensions(), decoder.has_alpha(), decoder.is_lossy()), ((13, 7), has_alpha, false));
            let mut levels = vec![0; decoder.output_buffer_size().unwrap()];
            decoder.read_image(&mut levels).unwrap();
            assert_eq!(levels, png::rows(&image, BitDepth::Eight));
        }
    }
}
