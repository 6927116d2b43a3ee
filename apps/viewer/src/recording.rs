//! A recording of the whole animation, frame by frame.

use std::path::PathBuf;
use std::time::Instant;

use crate::timeline::Timeline;

/// The progress of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Recording {
    /// A .gif, or .png files, with `%04d` for the number.
    pub(crate) path: PathBuf,
    /// The next frame.
    pub(crate) frame: u32,
    pub(crate) frames: u32,
    /// Size of every frame in pixels, independent of the window's.
    pub(crate) size: [u32; 2],
    started: Instant,
}

impl Recording {
    /// Starts a recording of an animation of `seconds`; a motionless scene has one frame.
    pub(crate) fn new(path: PathBuf, seconds: f64, size: [u32; 2]) -> Self {
        let frames = (seconds * f64::from(Timeline::FPS)).ceil().clamp(1.0, 1e6) as u32;
        Self { path, frame: 0, frames, size, started: Instant::now() }
    }

    /// Estimated remaining time, from the frames so far; `None` before the first frame.
    pub(crate) fn seconds_left(&self, now: Instant) -> Option<f64> {
        let seconds = now.duration_since(self.started).as_secs_f64();
        (self.frame > 0).then(|| seconds / f64::from(self.frame) * f64::from(self.frames.saturating_sub(self.frame)))
    }

    /// The next frame's moment.
    pub(crate) fn seconds(&self) -> f64 {
        f64::from(self.frame) / f64::from(Timeline::FPS)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn the_rest_takes_as_long_as_frames_took() {
        let mut recording = Recording::new("a.gif".into(), 4.0, [64, 48]);
        let now = recording.started + Duration::from_secs(10);
        assert_eq!(recording.seconds_left(now), None);
        recording.frame = recording.frames / 4;
        let left = recording.seconds_left(now).expect("an estimate");
        assert!((left - 30.0).abs() < 1e-9, "{left}");
    }
}
