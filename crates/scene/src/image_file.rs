//! Image files in memory, as far as the crate `image` reads them.
//!
//! Its decoders are generic, and would be compiled once more wherever else an image is read.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

/// The format that the first bytes name; TGA files, which have none, are `None`.
#[must_use]
pub fn format(bytes: &[u8]) -> Option<ImageFormat> {
    image::guess_format(bytes).ok()
}

/// Decodes an image of the format within `limits`, once `check` has accepted its width and height in texels.
///
/// # Errors
/// Where the file is damaged, exceeds the limits, or has a size that `check` refuses.
pub fn decode(
    bytes: &[u8],
    format: ImageFormat,
    limits: Limits,
    check: &mut dyn FnMut([u32; 2]) -> Result<(), String>,
) -> Result<DynamicImage, String> {
    let unusable = |error| format!("not a usable image: {error}");
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(unusable)?;
    let (width, height) = decoder.dimensions();
    check([width, height])?;
    DynamicImage::from_decoder(decoder).map_err(unusable)
}
