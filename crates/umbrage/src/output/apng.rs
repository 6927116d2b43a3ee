use std::io;

use super::png::Coding;
use super::writer::{Animation, Sink};
use super::{BitDepth, FrameRate, png};
use crate::Image;

/// Writes an animated PNG that repeats forever.
pub(crate) struct ApngWriter {
    encoder: ::png::Writer<Sink>,
    depth: BitDepth,
}

impl ApngWriter {
    /// Starts an animation of exactly `frames` frames (at least one), each `size` pixels wide and high.
    pub(crate) fn new(sink: Sink, size: [u32; 2], frames: u32, rate: FrameRate, coding: Coding) -> io::Result<Self> {
        let [delay_numerator, delay_denominator] = delay(rate);
        let mut encoder = png::encoder(sink, size, coding);
        // A file that promises more frames than it holds is an error rather than a file.
        encoder.validate_sequence(true);
        let encoder = encoder
            .set_animated(frames, 0)
            .and_then(|()| encoder.set_frame_delay(delay_numerator, delay_denominator))
            .and_then(|()| encoder.write_header())
            .map_err(png::failure)?;
        Ok(Self { encoder, depth: coding.depth })
    }
}

impl Animation for ApngWriter {
    fn write(&mut self, image: &Image) -> io::Result<()> {
        self.encoder.write_image_data(&png::rows(image, self.depth)).map_err(png::failure)
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        self.encoder.finish().map_err(png::failure)
    }
}

/// The time that a frame is shown: a fraction of a second, exact where both of its parts fit into 16 bits.
fn delay(rate: FrameRate) -> [u16; 2] {
    match (u16::try_from(rate.denominator()), u16::try_from(rate.numerator())) {
        (Ok(numerator), Ok(denominator)) => [numerator, denominator],
        _ => {
            // The larger part gets the full precision.
            let (numerator, denominator) = (f64::from(rate.denominator()), f64::from(rate.numerator()));
            let scale = f64::from(u16::MAX) / numerator.max(denominator);
            [(numerator * scale).round() as u16, (denominator * scale).round() as u16]
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::io::{BufReader, BufWriter};

    use super::*;
    use crate::output::Compression;

    fn opaque(depth: BitDepth) -> Coding {
        Coding { depth, compression: Compression::Fast, has_alpha: false }
    }

    fn picture(shade: u16) -> Image {
        Image {
            width: 3,
            height: 2,
            pixels: (0..6).map(|pixel| [shade, pixel * 10_000, 65_535 - shade]).collect(),
            ..Image::default()
        }
    }

    #[test]
    fn frames_come_back_exactly() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.apng");
        let rate = FrameRate::new(30_000, 1001).unwrap();
        let sink = BufWriter::new(Box::new(File::create(&path).unwrap()) as _);
        let mut writer = ApngWriter::new(sink, [3, 2], 3, rate, opaque(BitDepth::Sixteen)).unwrap();
        let pictures = [picture(0), picture(300), picture(65_535)];
        for picture in &pictures {
            writer.write(picture).unwrap();
        }
        Box::new(writer).finish().unwrap();

        let mut reader = ::png::Decoder::new(BufReader::new(File::open(&path).unwrap())).read_info().unwrap();
        let control = reader.info().animation_control.unwrap();
        assert_eq!((control.num_frames, control.num_plays), (3, 0));
        for picture in &pictures {
            let mut rows = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut rows).unwrap();
            assert_eq!(rows, png::rows(picture, BitDepth::Sixteen));
            let control = reader.info().frame_control.unwrap();
            assert_eq!((control.delay_num, control.delay_den), (1001, 30_000));
        }
    }

    #[test]
    fn too_few_frames_are_an_error() {
        let sink = BufWriter::new(Box::new(io::sink()) as _);
        let mut writer = ApngWriter::new(sink, [3, 2], 2, FrameRate::default(), opaque(BitDepth::Eight)).unwrap();
        writer.write(&picture(9)).unwrap();
        assert!(Box::new(writer).finish().is_err());
    }

    #[test]
    fn odd_rates_keep_their_ratio() {
        let rate = FrameRate::new(9_999_999, 100_000).unwrap();
        let [numerator, denominator] = delay(rate);
        let error = f64::from(numerator) / f64::from(denominator) / rate.seconds(1) - 1.0;
        assert!(error.abs() < 1e-3, "{numerator}/{denominator}");
    }
}
