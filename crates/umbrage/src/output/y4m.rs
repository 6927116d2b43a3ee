use std::io::{self, Write};

use super::FrameRate;
use super::writer::{Animation, Sink};
use crate::Image;

/// The resolution of colour in raw video.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Chroma {
    /// 4:2:0: one colour for two by two pixels, at their middle.
    #[default]
    Quarter,
    /// 4:4:4: one colour for each pixel.
    Full,
}

/// Writes YUV4MPEG2 video of 8 bits: limited range, ITU-R BT.709 matrix.
///
/// The format has no field for the matrix: tell the encoder (`-colorspace bt709` for ffmpeg).
pub(crate) struct Y4mWriter {
    sink: Sink,
    chroma: Chroma,
    frame: Vec<u8>,
}

impl Y4mWriter {
    /// Starts a video of frames `size` pixels wide and high.
    pub(crate) fn new(mut sink: Sink, size: [u32; 2], rate: FrameRate, chroma: Chroma) -> io::Result<Self> {
        sink.write_all(header(size, rate, chroma).as_bytes())?;
        Ok(Self { sink, chroma, frame: Vec::new() })
    }
}

impl Animation for Y4mWriter {
    fn write(&mut self, image: &Image) -> io::Result<()> {
        self.frame.clear();
        self.frame.extend_from_slice(b"FRAME\n");
        append_planes(image, self.chroma, &mut self.frame);
        self.sink.write_all(&self.frame)
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        self.sink.flush()
    }
}

fn header([width, height]: [u32; 2], rate: FrameRate, chroma: Chroma) -> String {
    // `420jpeg` means that a colour lies at the middle of its four pixels; the range has a field of its own.
    let space = match chroma {
        Chroma::Quarter => "420jpeg",
        Chroma::Full => "444",
    };
    let (numerator, denominator) = (rate.numerator(), rate.denominator());
    format!("YUV4MPEG2 W{width} H{height} F{numerator}:{denominator} Ip A1:1 C{space} XCOLORRANGE=LIMITED\n")
}

/// Appends the luma plane, then both chroma planes.
fn append_planes(image: &Image, chroma: Chroma, planes: &mut Vec<u8>) {
    planes.extend(image.pixels.iter().map(|&pixel| quantise_luma(Ycc::of(unit(pixel)).luma)));
    let colors: Vec<[f32; 2]> = match chroma {
        Chroma::Full => image.pixels.iter().map(|&pixel| Ycc::of(unit(pixel)).chroma).collect(),
        Chroma::Quarter => quarter_chroma(image),
    };
    for plane in 0..2 {
        planes.extend(colors.iter().map(|color| quantise_chroma(color[plane])));
    }
}

/// The mean colour of every two by two pixels; of fewer at an odd image's right and lower edge.
fn quarter_chroma(image: &Image) -> Vec<[f32; 2]> {
    let (width, height) = (image.width as usize, image.height as usize);
    let block = |column: usize, row: usize| {
        let mut sum = [0.0; 3];
        let mut count = 0.0;
        for y in 2 * row..(2 * row + 2).min(height) {
            for &pixel in &image.pixels[y * width + 2 * column..y * width + (2 * column + 2).min(width)] {
                sum = std::array::from_fn(|channel| sum[channel] + unit(pixel)[channel]);
                count += 1.0;
            }
        }
        // The matrix is linear: the mean's colour is the colours' mean.
        Ycc::of(sum.map(|channel| channel / count)).chroma
    };
    let rows = 0..height.div_ceil(2);
    rows.flat_map(|row| (0..width.div_ceil(2)).map(move |column| block(column, row))).collect()
}

/// Luma 0 … 1, and both colour differences, −½ … ½.
struct Ycc {
    luma: f32,
    chroma: [f32; 2],
}

impl Ycc {
    /// ITU-R BT.709-6, items 3.2 and 3.3, of encoded RGB from 0 to 1.
    fn of([red, green, blue]: [f32; 3]) -> Self {
        let luma = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
        Self { luma, chroma: [(blue - luma) / 1.8556, (red - luma) / 1.5748] }
    }
}

fn unit(pixel: [u16; 3]) -> [f32; 3] {
    pixel.map(|level| f32::from(level) / 65_535.0)
}

/// ITU-R BT.709-6, item 3.4, in 8 bits: 16 is black and 235 white.
fn quantise_luma(luma: f32) -> u8 {
    (16.0 + 219.0 * luma).round() as u8
}

/// As [`quantise_luma`]: 128 is grey.
fn quantise_chroma(difference: f32) -> u8 {
    (128.0 + 224.0 * difference).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: u16 = u16::MAX;

    /// The 8-bit code values of the 100 % colour bars of BT.709, computed by hand from the standard's equations.
    const BARS: [([u16; 3], [u8; 3]); 8] = [
        ([FULL, FULL, FULL], [235, 128, 128]),
        ([FULL, FULL, 0], [219, 16, 138]),
        ([0, FULL, FULL], [188, 154, 16]),
        ([0, FULL, 0], [173, 42, 26]),
        ([FULL, 0, FULL], [78, 214, 230]),
        ([FULL, 0, 0], [63, 102, 240]),
        ([0, 0, FULL], [32, 240, 118]),
        ([0, 0, 0], [16, 128, 128]),
    ];

    #[test]
    fn colour_bars_have_the_standards_codes() {
        for (pixel, codes) in BARS {
            let image = Image { width: 1, height: 1, pixels: vec![pixel], ..Image::default() };
            for chroma in [Chroma::Full, Chroma::Quarter] {
                let mut planes = Vec::new();
                append_planes(&image, chroma, &mut planes);
                assert_eq!(planes, codes, "{pixel:?} {chroma:?}");
            }
        }
    }

    #[test]
    fn full_chroma_keeps_every_pixel() {
        let image = Image { width: 8, height: 1, pixels: BARS.map(|(pixel, _)| pixel).to_vec(), ..Image::default() };
        let mut planes = Vec::new();
        append_planes(&image, Chroma::Full, &mut planes);
        let expected: Vec<u8> = (0..3).flat_map(|plane| BARS.map(|(_, codes)| codes[plane])).collect();
        assert_eq!(planes, expected);
    }

    #[test]
    fn quarter_chroma_averages_blocks_and_rounds_odd_sizes_up() {
        let (red, blue) = ([FULL, 0, 0], [0, 0, FULL]);
        // Two red and two blue pixels, a red and a blue one; below, two blue pixels and a red one.
        let image = Image {
            width: 3,
            height: 3,
            pixels: vec![red, blue, red, blue, red, blue, blue, blue, red],
            ..Image::default()
        };
        let mut planes = Vec::new();
        append_planes(&image, Chroma::Quarter, &mut planes);
        let mixed = [(102.34_f32 + 240.0) / 2.0, (240.0 + 117.73) / 2.0].map(|code| code.round() as u8);
        assert_eq!(planes[..9], [63, 32, 63, 32, 63, 32, 32, 32, 63]);
        assert_eq!(planes[9..13], [mixed[0], mixed[0], 240, 102]);
        assert_eq!(planes[13..], [mixed[1], mixed[1], 118, 240]);
    }
}
