use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use umbrage::Settings;
use umbrage::spec::Length;

/// Maximum side of an image, in pixels.
const MAX_SIDE_PIXELS: u32 = Settings::MAX_SIDE;
/// Maximum pixels of an image, which take several gigabytes.
const MAX_PIXELS: u64 = 1 << 26;
/// Maximum number of frames of one render.
const MAX_FRAMES: u32 = 1_000_000;

/// An image's width and height in pixels: `1280x720`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "give width and height in pixels, such as 1280x720".to_owned();
        let (width, height) = text.split_once(['x', 'X']).ok_or_else(wrong)?;
        // Wide enough that the error for an absurd size names the limit.
        let (width, height): (u64, u64) = (width.parse().map_err(|_| wrong())?, height.parse().map_err(|_| wrong())?);
        if width == 0 || height == 0 {
            return Err("an image has at least one pixel".to_owned());
        }
        match (u32::try_from(width), u32::try_from(height)) {
            (Ok(width), Ok(height)) if width.max(height) <= MAX_SIDE_PIXELS => {
                if u64::from(width) * u64::from(height) > MAX_PIXELS {
                    return Err(format!("at most {MAX_PIXELS} pixels in all"));
                }
                Ok(Self { width, height })
            }
            _ => Err(format!("at most {MAX_SIDE_PIXELS} pixels a side")),
        }
    }
}

/// Frames from A up to, but without, B: `0..24`, or `0..=23`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FrameRange(pub(crate) Range<u32>);

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "give frames as A..B (without B) or A..=B (with B), counted from 0, such as 0..24".to_owned();
        let (first, last) = text.split_once("..").ok_or_else(wrong)?;
        let start: u32 = first.parse().map_err(|_| wrong())?;
        let end = match last.strip_prefix('=') {
            Some(last) => last.parse::<u32>().ok().and_then(|last| last.checked_add(1)),
            None => last.parse().ok(),
        };
        let end = end.ok_or_else(wrong)?;
        match end.checked_sub(start) {
            None | Some(0) => Err("there is no frame in that range".to_owned()),
            Some(count) if count > MAX_FRAMES => Err(format!("at most {MAX_FRAMES} frames at a time")),
            Some(_) => Ok(Self(start..end)),
        }
    }
}

/// One of several contiguous shares of the frames, counted from 1: `3/8`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    number: u32,
    of: u32,
}

impl Shard {
    /// Its share of the frames. Shares differ by one frame at most, and may be empty if there are fewer frames than
    /// shards.
    pub(crate) fn share(self, frames: &Range<u32>) -> Range<u32> {
        let count = u64::from(frames.end.saturating_sub(frames.start));
        // No more than `count`.
        let before = |shards: u32| frames.start + (count * u64::from(shards) / u64::from(self.of)) as u32;
        before(self.number - 1)..before(self.number)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "give a shard and how many there are, such as 3/8 for the third of eight".to_owned();
        let (number, of) = text.split_once('/').ok_or_else(wrong)?;
        let (number, of): (u32, u32) = (number.parse().map_err(|_| wrong())?, of.parse().map_err(|_| wrong())?);
        match number {
            _ if of == 0 || of > MAX_FRAMES => Err(format!("there are 1 to {MAX_FRAMES} shards")),
            0 => Err(format!("shards are counted from 1: 1/{of} to {of}/{of}")),
            _ if number > of => Err(format!("there is no shard {number} of {of}: the last is {of}/{of}")),
            _ => Ok(Self { number, of }),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

/// Camera rays for each pixel.
pub(crate) fn samples(text: &str) -> Result<u32, String> {
    let most = Settings::MAX_SAMPLES;
    let samples = text.parse().ok().filter(|samples| (1..=most).contains(samples));
    samples.ok_or_else(|| format!("give whole samples from 1 to {most}, such as 16"))
}

/// A moment: finite and not negative.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse::<f64>().ok().filter(|seconds| seconds.is_finite() && *seconds >= 0.0);
    seconds.ok_or_else(|| "give seconds from 0, such as 1.5".to_owned())
}

/// A finite number, not negative.
pub(crate) fn from_zero(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|number| number.is_finite() && *number >= 0.0);
    number.ok_or_else(|| "give a number from 0, such as 0.1".to_owned())
}

/// A length; a share of the scene's size is at most the whole size.
pub(crate) fn length(text: &str) -> Result<Length, String> {
    match text.parse()? {
        Length::Percent(percent) if percent > 100.0 => {
            Err(format!("`{text}` is more than the whole scene; give a share of its size, such as 2%"))
        }
        length => Ok(length),
    }
}

/// A distance above zero. Cameras are farther away than the scene is large.
pub(crate) fn distance(text: &str) -> Result<Length, String> {
    let distance: Length = text.parse()?;
    if distance.is_positive() { Ok(distance) } else { Err("give a distance above 0, such as 2.5 or 80%".to_owned()) }
}

/// The size of points, or the width of lines, in pixels.
pub(crate) fn mark_size(text: &str) -> Result<f32, String> {
    let sizes = Settings::MARK_SIZES;
    let size = text.parse::<f32>().ok().filter(|size| sizes.contains(size));
    size.ok_or_else(|| format!("give pixels from {} to {}, such as 3", sizes.start(), sizes.end()))
}

/// Files of a sequence for each second.
pub(crate) fn sequence_fps(text: &str) -> Result<f64, String> {
    let fps = text.parse::<f64>().ok().filter(|fps| (0.01..=1000.0).contains(fps));
    fps.ok_or_else(|| "give files a second from 0.01 to 1000, such as 24".to_owned())
}

/// An angle between triangles in degrees.
pub(crate) fn crease(text: &str) -> Result<f32, String> {
    let degrees = text.parse::<f32>().ok().filter(|degrees| (0.0..=180.0).contains(degrees));
    degrees.ok_or_else(|| "give degrees from 0 to 180, such as 30".to_owned())
}

/// The exposure of pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ExposureFlag {
    /// Measured exposure.
    Auto,
    Stops(f32),
}

impl FromStr for ExposureFlag {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        let stops = text.parse::<f32>().ok().filter(|stops| (-60.0..=60.0).contains(stops));
        stops.map(Self::Stops).ok_or("give `auto`, or stops from -60 to 60, such as -0.5")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_limits() {
        assert_eq!("640x360".parse(), Ok(Size { width: 640, height: 360 }));
        let refused = |text: &str| text.parse::<Size>().unwrap_err();
        for text in ["", "640", "640x", "x360", "-1x4", "640x360x3", "axb"] {
            assert!(refused(text).contains("such as 1280x720"), "{text}");
        }
        assert!(refused("0x4").contains("at least one pixel"));
        assert!(refused("4x16385").contains("16384 pixels a side"));
        assert!(refused("99999999999x2").contains("16384 pixels a side"));
        assert!(refused("16384x16384").contains("67108864 pixels in all"));
    }

    #[test]
    fn frames_are_half_open_or_closed() {
        assert_eq!("3..5".parse(), Ok(FrameRange(3..5)));
        assert_eq!("3..=5".parse(), Ok(FrameRange(3..6)));
        for text in ["", "3", "3..", "..5", "5..3", "3..3", "a..b", "0..=4294967295", "0..2000000", "0...4"] {
            assert!(text.parse::<FrameRange>().is_err(), "{text}");
        }
    }

    #[test]
    fn shards_are_all_frames_in_even_shares() {
        for (frames, of) in
            [(0..1000, 8), (5..12, 3), (7..8, 3), (0..MAX_FRAMES, MAX_FRAMES), (4_294_966_000..u32::MAX, 7)]
        {
            let shares: Vec<Range<u32>> = (1..=of).map(|number| Shard { number, of }.share(&frames)).collect();
            assert_eq!((shares[0].start, shares[shares.len() - 1].end), (frames.start, frames.end));
            assert!(shares.windows(2).all(|pair| pair[0].end == pair[1].start), "{frames:?} {of}");
            let sizes = || shares.iter().map(ExactSizeIterator::len);
            assert!(sizes().max().unwrap() - sizes().min().unwrap() <= 1, "{frames:?} {of}");
        }
        assert_eq!("3/8".parse(), Ok(Shard { number: 3, of: 8 }));
        for (text, part) in [
            ("0/8", "counted from 1"),
            ("9/8", "no shard 9 of 8"),
            ("1/0", "1 to 1000000"),
            ("3", "such as 3/8"),
            ("-1/8", "such as 3/8"),
        ] {
            assert!(text.parse::<Shard>().unwrap_err().contains(part), "{text}");
        }
    }

    #[test]
    fn numbers_are_finite() {
        assert!(seconds("-1").is_err() && seconds("nan").is_err() && seconds("0.5") == Ok(0.5));
        assert!(from_zero("-0.1").is_err() && from_zero("inf").is_err() && distance("0%").is_err());
        assert!(length("100%").is_ok() && length("200%").unwrap_err().contains("more than the whole scene"));
        assert_eq!(distance("200%"), Ok(Length::Percent(200.0)));
        assert!(mark_size("0.4").is_err() && mark_size("nan").is_err() && mark_size("100") == Ok(100.0));
        assert!(sequence_fps("0").is_err() && "inf".parse::<ExposureFlag>().is_err() && crease("-1").is_err());
    }
}
