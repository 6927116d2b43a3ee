//! Image files in memory.
//!
//! Each format's own decoder is called: the crate that wraps them includes colour management, which isn't needed here and
//! takes longer to compile than all decoders.

use std::fmt::Display;
use std::io::Cursor;

use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;

mod bmp;
mod radiance;
mod tga;

/// The recognised image formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// Windows bitmap.
    Bmp,
    /// Radiance's RGBE.
    Hdr,
    /// JPEG.
    Jpeg,
    /// OpenEXR, which [`decode`] refuses: callers use the crate `exr`.
    OpenExr,
    /// PNG.
    Png,
    /// Truevision TGA.
    Tga,
    /// WebP.
    WebP,
}

/// A decoded image: rows of texels, the upper row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width and height in texels.
    pub size: [u32; 2],
    /// Samples per texel: grey (1), grey and opacity (2), RGB (3), RGB and opacity (4).
    channels: usize,
    samples: Samples,
}

#[derive(Clone, Debug, PartialEq)]
enum Samples {
    /// sRGB-encoded; 255 stands for 1.
    Bytes(Vec<u8>),
    /// sRGB-encoded big-endian pairs of bytes; 65,535 stands for 1.
    Words(Vec<u8>),
    /// Linear radiance.
    Floats(Vec<f32>),
}

/// Accepts an image's width and height in texels, or says why not.
pub type Check<'c> = &'c mut dyn FnMut([u32; 2]) -> Result<(), String>;

/// Detects the format by the first bytes; `None` for TGA files, which have no signature, and for all other formats.
#[must_use]
pub fn format(bytes: &[u8]) -> Option<ImageFormat> {
    const SIGNATURES: [(&[u8], ImageFormat); 6] = [
        (b"\x89PNG\r\n\x1a\n", ImageFormat::Png),
        (&[0xff, 0xd8, 0xff], ImageFormat::Jpeg),
        (b"BM", ImageFormat::Bmp),
        (b"#?RADIANCE", ImageFormat::Hdr),
        (b"#?RGBE", ImageFormat::Hdr),
        (&[0x76, 0x2f, 0x31, 0x01], ImageFormat::OpenExr),
    ];
    if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
        return Some(ImageFormat::WebP);
    }
    SIGNATURES.iter().find(|(signature, _)| bytes.starts_with(signature)).map(|&(_, format)| format)
}

/// Decodes an image, after `check` has accepted its width and height in texels.
///
/// Decoders with a memory limit take at most `max_memory` bytes besides the texels.
///
/// # Errors
/// Where the file is damaged or OpenEXR, or has a size that `check` refuses.
pub fn decode(bytes: &[u8], format: ImageFormat, max_memory: u64, check: Check<'_>) -> Result<Image, String> {
    let max_memory = usize::try_from(max_memory).unwrap_or(usize::MAX);
    match format {
        ImageFormat::Bmp => bmp::decode(bytes, check),
        ImageFormat::Hdr => radiance::decode(bytes, check),
        ImageFormat::Jpeg => jpeg(bytes, check),
        ImageFormat::OpenExr => Err(unusable("OpenEXR is for backgrounds")),
        ImageFormat::Png => png(bytes, max_memory, check),
        ImageFormat::Tga => tga::decode(bytes, check),
        ImageFormat::WebP => webp(bytes, max_memory, check),
    }
}

fn unusable(cause: impl Display) -> String {
    format!("not a usable image: {cause}")
}

/// Bytes of an image with `channels` samples of `of_sample` bytes per texel.
fn bytes_of([width, height]: [u32; 2], channels: usize, of_sample: usize) -> Result<usize, String> {
    let texels = (width as usize).checked_mul(height as usize);
    texels.and_then(|texels| texels.checked_mul(channels * of_sample)).ok_or_else(|| unusable("it is too large"))
}

/// Converts the size reported by a decoder.
fn size_of(dimensions: Option<(usize, usize)>) -> Result<[u32; 2], String> {
    let size = dimensions.and_then(|(width, height)| Some([width.try_into().ok()?, height.try_into().ok()?]));
    size.ok_or_else(|| unusable("it is too large"))
}

fn png(bytes: &[u8], max_memory: usize, check: Check<'_>) -> Result<Image, String> {
    let limits = png::Limits { bytes: max_memory };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    // Palettes and fewer than eight bits become bytes.
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(unusable)?;
    let (width, height) = reader.info().size();
    check([width, height])?;
    let (color, depth) = reader.output_color_type();
    let (channels, wide) = (color.samples(), depth == png::BitDepth::Sixteen);
    let mut samples = vec![0; bytes_of([width, height], channels, 1 + usize::from(wide))?];
    reader.next_frame(&mut samples).map_err(unusable)?;
    let samples = if wide { Samples::Words(samples) } else { Samples::Bytes(samples) };
    Ok(Image { size: [width, height], channels, samples })
}

fn jpeg(bytes: &[u8], check: Check<'_>) -> Result<Image, String> {
    let options = DecoderOptions::default().set_strict_mode(false).set_max_width(usize::MAX).set_max_height(usize::MAX);
    let mut decoder = zune_jpeg::JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(unusable)?;
    let size = size_of(decoder.dimensions())?;
    check(size)?;
    let grey = decoder.input_colorspace() == Some(ColorSpace::Luma);
    let colors = if grey { ColorSpace::Luma } else { ColorSpace::RGB };
    decoder.set_options(options.jpeg_set_out_colorspace(colors));
    let samples = decoder.decode().map_err(unusable)?;
    let channels = colors.num_components();
    if samples.len() != bytes_of(size, channels, 1)? {
        return Err(unusable("its texels aren't as many as its size says"));
    }
    Ok(Image { size, channels, samples: Samples::Bytes(samples) })
}

fn webp(bytes: &[u8], max_memory: usize, check: Check<'_>) -> Result<Image, String> {
    let mut decoder = image_webp::WebPDecoder::new(Cursor::new(bytes)).map_err(unusable)?;
    decoder.set_memory_limit(max_memory);
    let (width, height) = decoder.dimensions();
    check([width, height])?;
    let channels = if decoder.has_alpha() { 4 } else { 3 };
    let mut samples = vec![0; bytes_of([width, height], channels, 1)?];
    decoder.read_image(&mut samples).map_err(unusable)?;
    Ok(Image { size: [width, height], channels, samples: Samples::Bytes(samples) })
}

impl Image {
    /// Whether the samples are linear radiance; otherwise they are encoded by the sRGB transfer function.
    #[must_use]
    pub fn is_linear(&self) -> bool {
        matches!(self.samples, Samples::Floats(_))
    }

    /// Red, green, blue and opacity of each texel; 255 stands for 1.
    #[must_use]
    pub fn rgba(&self) -> Vec<[u8; 4]> {
        let narrow = |high, low| ((u32::from(u16::from_be_bytes([high, low])) + 128) / 257) as u8;
        match &self.samples {
            Samples::Bytes(samples) => self.texels(samples, 255, |&sample| sample),
            Samples::Words(samples) => self.texels(samples.as_chunks().0, 255, |&[high, low]| narrow(high, low)),
            Samples::Floats(samples) => {
                self.texels(samples, 255, |sample| (sample.clamp(0.0, 1.0) * 255.0).round() as u8)
            }
        }
    }

    /// Red, green and blue of each texel: linear radiance, or encoded from 0 to 1.
    #[must_use]
    pub fn rgb(&self) -> Vec<[f32; 3]> {
        let texels = match &self.samples {
            Samples::Bytes(samples) => self.texels(samples, 1.0, |&sample| f32::from(sample) / 255.0),
            Samples::Words(samples) => {
                self.texels(samples.as_chunks().0, 1.0, |&sample| f32::from(u16::from_be_bytes(sample)) / 65_535.0)
            }
            Samples::Floats(samples) => self.texels(samples, 1.0, |&sample| sample),
        };
        texels.into_iter().map(|[red, green, blue, _]| [red, green, blue]).collect()
    }

    fn texels<S, T: Copy>(&self, samples: &[S], opaque: T, read: impl Fn(&S) -> T) -> Vec<[T; 4]> {
        let texel = |samples: &[S]| match samples {
            [grey] => [read(grey), read(grey), read(grey), opaque],
            [grey, opacity] => [read(grey), read(grey), read(grey), read(opacity)],
            [red, green, blue] => [read(red), read(green), read(blue), opaque],
            [red, green, blue, opacity] => [read(red), read(green), read(blue), read(opacity)],
            _ => unreachable!("a texel has one to four samples"),
        };
        samples.chunks_exact(self.channels).map(texel).collect()
    }
}

/// Splits off the first `count` bytes.
fn take<'a>(bytes: &mut &'a [u8], count: usize) -> Result<&'a [u8], String> {
    bytes.split_off(..count).ok_or_else(|| unusable("it ends too early"))
}

/// Appends the samples of a texel of at most four bytes, the lowest first: a mask of its bits for each sample, which is rounded
/// to the nearest of 255, and 0 for an empty mask.
fn unmask(texel: &[u8], masks: &[u32], samples: &mut Vec<u8>) {
    let texel = texel.iter().rev().fold(0, |texel, &byte| texel << 8 | u32::from(byte));
    samples.extend(masks.iter().map(|&mask| {
        let shift = mask.trailing_zeros().min(31);
        match (u64::from((texel & mask) >> shift), u64::from(mask >> shift)) {
            (value, 255) => value as u8,
            (value, most) => ((value * 255 + most / 2) / most.max(1)) as u8,
        }
    }));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A PNG of 2×1 texels.
    fn png(color: png::ColorType, depth: png::BitDepth, palette: Option<&'static [u8]>, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if let Some(palette) = palette {
            encoder.set_palette(palette);
        }
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    }

    fn open(bytes: &[u8]) -> Image {
        decode(bytes, format(bytes).unwrap(), u64::MAX, &mut |_| Ok(())).unwrap()
    }

    #[test]
    fn all_kinds_of_texels_are_read() {
        use png::{BitDepth, ColorType};
        let cases = [
            (ColorType::Grayscale, BitDepth::One, None, &[0b0100_0000][..], [[0, 0, 0, 255], [255; 4]]),
            (ColorType::GrayscaleAlpha, BitDepth::Eight, None, &[7, 8, 9, 10], [[7, 7, 7, 8], [9, 9, 9, 10]]),
            (
                ColorType::Indexed,
                BitDepth::Two,
                Some(&[1, 2, 3, 4, 5, 6][..]),
                &[0b0100_0000],
                [[4, 5, 6, 255], [1, 2, 3, 255]],
            ),
            (ColorType::Rgb, BitDepth::Eight, None, &[1, 2, 3, 4, 5, 6], [[1, 2, 3, 255], [4, 5, 6, 255]]),
            // 0x0180 is 1.49 of 255, and 0x0181 is 1.50.
            (
                ColorType::Rgba,
                BitDepth::Sixteen,
                None,
                &[1, 0x80, 1, 0x81, 255, 255, 0, 0, 0, 0, 0, 128, 0, 129, 128, 0],
                [[1, 1, 255, 0], [0, 0, 1, 128]],
            ),
        ];
        for (color, depth, palette, data, expected) in cases {
            let image = open(&png(color, depth, palette, data));
            assert_eq!((image.size, image.rgba().as_slice()), ([2, 1], &expected[..]), "{color:?}");
            assert!(!image.is_linear());
            let rgb = expected.map(|[red, green, blue, _]| [red, green, blue].map(|sample| f32::from(sample) / 255.0));
            for (texel, expected) in image.rgb().iter().zip(rgb) {
                assert!(texel.iter().zip(expected).all(|(sample, expected)| (sample - expected).abs() < 2e-3));
            }
        }
    }

    #[test]
    fn sizes_are_checked_before_texels_are_read() {
        let bytes = png(png::ColorType::Grayscale, png::BitDepth::Eight, None, &[1, 2]);
        let refused = decode(&bytes, ImageFormat::Png, u64::MAX, &mut |size| Err(format!("{size:?}")));
        assert_eq!(refused.unwrap_err(), "[2, 1]");
        let cut = decode(&bytes[..bytes.len() - 16], ImageFormat::Png, u64::MAX, &mut |_| Ok(()));
        assert!(cut.unwrap_err().starts_with("not a usable image: "));
        assert_eq!(format(b"nothing"), None);
    }
}
