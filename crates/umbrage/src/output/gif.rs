use std::io::{self, Write};
use std::path::Path;

use ::gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};

use super::palette::Palette;
use super::writer::{Animation, Sink};
use super::{Error, FrameRate};
use crate::Image;

/// Writes an animated GIF that repeats forever; each frame has a palette of its own.
pub(crate) struct GifWriter {
    encoder: Encoder<Sink>,
    size: [u16; 2],
    rate: FrameRate,
    frames_written: u32,
}

impl GifWriter {
    /// Starts an animation of frames `size` pixels wide and high.
    pub(crate) fn new(sink: Sink, size: [u16; 2], rate: FrameRate) -> io::Result<Self> {
        let mut encoder = Encoder::new(sink, size[0], size[1], &[]).map_err(failure)?;
        encoder.set_repeat(Repeat::Infinite).map_err(failure)?;
        Ok(Self { encoder, size, rate, frames_written: 0 })
    }
}

impl Animation for GifWriter {
    fn write(&mut self, image: &Image) -> io::Result<()> {
        let mut palette = Palette::of(image);
        let rows = image.pixels.chunks(image.width.max(1) as usize).enumerate();
        let pixels = rows.flat_map(|(y, row)| row.iter().enumerate().map(move |(x, &pixel)| (x, y, pixel)));
        let indices: Vec<u8> = pixels.map(|(x, y, pixel)| palette.pick(pixel, x, y)).collect();
        let frame = Frame {
            width: self.size[0],
            height: self.size[1],
            delay: delay_hundredths(self.rate, self.frames_written),
            dispose: DisposalMethod::Keep,
            palette: Some(palette.bytes()),
            buffer: indices.into(),
            ..Frame::default()
        };
        self.encoder.write_frame(&frame).map_err(failure)?;
        self.frames_written += 1;
        Ok(())
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        self.encoder.into_inner().map_err(failure)?.flush()
    }
}

/// A picture's size as a GIF holds it.
///
/// # Errors
/// Where a GIF can't be that large, or show its frames at that rate.
pub(crate) fn size(path: &Path, size: [u32; 2], rate: FrameRate) -> Result<[u16; 2], Error> {
    // Viewers slow frames of less than two hundredths of a second down to ten.
    if rate.seconds(1) < 0.02 {
        return Err(Error::unsuitable(path, "a GIF shows at most 50 frames a second; use fewer, or an APNG"));
    }
    match size.map(u16::try_from) {
        [Ok(width), Ok(height)] => Ok([width, height]),
        _ => Err(Error::unsuitable(path, format!("a GIF has at most {} pixels a side", u16::MAX))),
    }
}

/// The system's own error, where it refused to write.
fn failure(error: EncodingError) -> io::Error {
    match error {
        EncodingError::Io(source) => source,
        other => io::Error::other(other),
    }
}

/// The time that frame `frame` is shown, rounded so that errors don't add up.
fn delay_hundredths(rate: FrameRate, frame: u32) -> u16 {
    let start = |frame: u32| (100.0 * rate.seconds(frame)).round();
    (start(frame.saturating_add(1)) - start(frame)) as u16
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::io::BufWriter;

    use ::gif::{ColorOutput, DecodeOptions};

    use super::*;

    /// A smooth picture of far more colours than a palette has.
    fn gradient(side: u32) -> Image {
        let pixel = |index: u32| {
            let (x, y) = (index % side, index / side);
            [x * 65_535 / (side - 1), y * 65_535 / (side - 1), (x + y) * 65_535 / (2 * side - 2)]
                .map(|level| level as u16)
        };
        Image { width: side, height: side, pixels: (0..side * side).map(pixel).collect(), ..Image::default() }
    }

    fn decode(path: &Path) -> Vec<(u16, Vec<[u8; 3]>)> {
        let mut options = DecodeOptions::new();
        options.set_color_output(ColorOutput::RGBA);
        let mut decoder = options.read_info(File::open(path).unwrap()).unwrap();
        assert_eq!(decoder.repeat(), Repeat::Infinite);
        let mut frames = Vec::new();
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            let pixels = frame.buffer.chunks(4).map(|rgba| [rgba[0], rgba[1], rgba[2]]).collect();
            frames.push((frame.delay, pixels));
        }
        frames
    }

    #[test]
    fn pictures_come_back_within_the_palettes_error() {
        const SIDE: u32 = 64;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gif");
        let image = gradient(SIDE);
        let sink = BufWriter::new(Box::new(File::create(&path).unwrap()) as _);
        let mut writer = GifWriter::new(sink, [SIDE as u16; 2], FrameRate::default()).unwrap();
        writer.write(&image).unwrap();
        writer.write(&Image { pixels: vec![[257 * 200, 0, 257]; (SIDE * SIDE) as usize], ..image.clone() }).unwrap();
        Box::new(writer).finish().unwrap();

        let frames = decode(&path);
        assert_eq!(frames.len(), 2);
        assert!(frames[1].1.iter().all(|&pixel| pixel == [200, 0, 1]));
        // 256 colours on a plane of 255 by 255 levels are about 16 levels apart, and mixing reaches the next one.
        let error = |(shown, pixel): (&[u8; 3], &[u16; 3])| -> [f64; 3] {
            std::array::from_fn(|channel| f64::from(shown[channel]) - f64::from(pixel[channel]) / 257.0)
        };
        let errors: Vec<[f64; 3]> = frames[0].1.iter().zip(&image.pixels).map(error).collect();
        let worst = errors.as_flattened().iter().fold(0.0_f64, |worst, error| worst.max(error.abs()));
        assert!(worst < 40.0, "{worst}");
        // Over 8 by 8 pixels, dithering mixes to the picture's own colours.
        for block in 0..64 {
            let inside = (0..64).map(|index| (block / 8 * 8 + index / 8) * 64 + block % 8 * 8 + index % 8);
            let sum = inside.fold([0.0; 3], |sum, pixel: usize| -> [f64; 3] {
                std::array::from_fn(|channel| sum[channel] + errors[pixel][channel])
            });
            assert!(sum.iter().all(|sum| sum.abs() < 64.0 * 5.0), "block {block}: {sum:?} over 64 pixels");
        }
    }

    #[test]
    fn delays_add_up_to_the_rate() {
        let rate = FrameRate::new(30, 1).unwrap();
        let delays: Vec<u16> = (0..30).map(|frame| delay_hundredths(rate, frame)).collect();
        assert_eq!(delays.iter().sum::<u16>(), 100);
        assert!(delays.iter().all(|delay| [3, 4].contains(delay)));
    }

    #[test]
    fn what_a_gif_cannot_hold_is_refused() {
        let path = Path::new("a.gif");
        let refused = |sides, rate| size(path, sides, rate).unwrap_err().to_string();
        assert!(refused([8, 8], FrameRate::new(60, 1).unwrap()).contains("at most 50 frames"));
        assert!(refused([70_000, 8], FrameRate::default()).contains("65535 pixels"));
    }
}
