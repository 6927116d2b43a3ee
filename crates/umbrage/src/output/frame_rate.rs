use std::fmt;
use std::str::FromStr;

/// Frames for each second, as a fraction: 24, 29.97 or 30000/1001.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRate {
    numerator: u32,
    denominator: u32,
}

impl Default for FrameRate {
    /// 24 frames a second.
    fn default() -> Self {
        Self { numerator: 24, denominator: 1 }
    }
}

impl FrameRate {
    /// The rate `numerator / denominator`; `None` unless it is from 1/100 to 1000 frames a second.
    #[must_use]
    pub fn new(numerator: u32, denominator: u32) -> Option<Self> {
        let (wide_numerator, wide_denominator) = (u64::from(numerator), u64::from(denominator));
        let usable = wide_numerator * 100 >= wide_denominator && wide_numerator <= wide_denominator * 1000;
        if denominator == 0 || !usable {
            return None;
        }
        let divisor = greatest_common_divisor(numerator, denominator);
        Some(Self { numerator: numerator / divisor, denominator: denominator / divisor })
    }

    /// The fraction's upper part.
    #[must_use]
    pub fn numerator(self) -> u32 {
        self.numerator
    }

    /// The fraction's lower part, above zero.
    #[must_use]
    pub fn denominator(self) -> u32 {
        self.denominator
    }

    /// When frame `frame` is shown, in seconds after frame 0.
    #[must_use]
    pub fn seconds(self, frame: u32) -> f64 {
        f64::from(frame) * f64::from(self.denominator) / f64::from(self.numerator)
    }

    /// How many frames start within `seconds`: at least one, at most `u32::MAX`.
    #[must_use]
    pub fn frames_within(self, seconds: f64) -> u32 {
        // A duration computed from a number of frames may be a hair above it.
        const SLACK_FRAMES: f64 = 1e-6;
        let frames = seconds * f64::from(self.numerator) / f64::from(self.denominator);
        (frames - SLACK_FRAMES).ceil().max(1.0) as u32
    }
}

fn greatest_common_divisor(mut a: u32, mut b: u32) -> u32 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

impl fmt::Display for FrameRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.denominator == 1 {
            write!(f, "{}", self.numerator)
        } else {
            write!(f, "{}/{}", self.numerator, self.denominator)
        }
    }
}

impl FromStr for FrameRate {
    type Err = String;

    /// Reads `24`, `29.97` or `30000/1001`.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "give frames a second from 0.01 to 1000, such as 24, 29.97 or 30000/1001".to_owned();
        let (numerator, denominator) = match text.split_once('/') {
            Some((above, below)) => (above.parse().map_err(|_| wrong())?, below.parse().map_err(|_| wrong())?),
            None => decimal_fraction(text).ok_or_else(wrong)?,
        };
        Self::new(numerator, denominator).ok_or_else(wrong)
    }
}

/// A decimal number with at most six digits behind its point, as an exact fraction.
fn decimal_fraction(text: &str) -> Option<(u32, u32)> {
    let (whole, part) = text.split_once('.').unwrap_or((text, ""));
    let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    if whole.is_empty() || part.len() > 6 || !digits(whole) || !digits(part) {
        return None;
    }
    let denominator = 10_u32.pow(part.len() as u32);
    let part: u32 = if part.is_empty() { 0 } else { part.parse().ok()? };
    let numerator = whole.parse::<u32>().ok()?.checked_mul(denominator)?.checked_add(part)?;
    Some((numerator, denominator))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_parse_exactly() {
        for (text, numerator, denominator) in
            [("24", 24, 1), ("29.97", 2997, 100), ("30000/1001", 30_000, 1001), ("12.5", 25, 2), ("48/2", 24, 1)]
        {
            assert_eq!(text.parse(), Ok(FrameRate { numerator, denominator }), "{text}");
        }
        for text in ["", "0", "-1", "1/0", "nan", "1e3", "1001", "0.001", "99999999999", "1/2/3", "."] {
            let parsed: Result<FrameRate, String> = text.parse();
            assert!(parsed.is_err(), "{text}: {parsed:?}");
        }
    }

    #[test]
    fn frames_cover_a_duration() {
        let rate = FrameRate::default();
        assert_eq!(rate.seconds(48), 2.0);
        assert_eq!(rate.frames_within(2.0), 48);
        assert_eq!(rate.frames_within(2.01), 49);
        assert_eq!(rate.frames_within(0.0), 1);
        assert_eq!(rate.frames_within(f64::NAN), 1);
    }
}
