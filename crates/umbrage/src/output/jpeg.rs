use std::io::{self, Write};
use std::path::Path;

use jpeg_encoder::{ColorType, Encoder, EncodingError};

use super::partial_file::Look;
use super::{BitDepth, Error, JpegQuality, partial_file, png};
use crate::Image;

/// Writes one opaque picture as a JPEG file.
pub(super) fn write(image: &Image, path: &Path, quality: JpegQuality, look: Look<'_>) -> Result<(), Error> {
    partial_file::write(path, look, |file| (&*file).write_all(&encode(image, quality)?))
}

fn encode(image: &Image, quality: JpegQuality) -> io::Result<Vec<u8>> {
    let sides = [image.width, image.height].map(u16::try_from);
    let [Ok(width), Ok(height)] = sides else { return Err(io::Error::other("a JPEG has at most 65535 pixels a side")) };
    let mut bytes = Vec::new();
    let encoder = Encoder::new(&mut bytes, quality.get());
    encoder.encode(&png::rows(image, BitDepth::Eight), width, height, ColorType::Rgb).map_err(failure)?;
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
    use umbrage_files::image_file::{self, ImageFormat};

    use super::*;

    /// Slopes of three colours, of sides that aren't multiples of a JPEG's blocks.
    fn picture() -> Image {
        let pixel = |pixel: u16| [pixel % 37 * 1700, pixel / 37 * 2500, 60_000 - pixel % 37 * 1500];
        Image { width: 37, height: 21, pixels: (0..37 * 21).map(pixel).collect(), ..Image::default() }
    }

    #[test]
    fn pictures_come_back_nearly_and_smaller_ones_less() {
        let coded = |quality| {
            let bytes = encode(&picture(), JpegQuality::new(quality).unwrap()).unwrap();
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
}
