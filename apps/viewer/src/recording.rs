//! A recording of the whole animation, frame by frame.

use std::path::PathBuf;

use crate::timeline::Timeline;

/// How far a recording has come.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Recording {
    /// A .gif, or .png files, with `%04d` for the number.
    pub(crate) path: PathBuf,
    /// The next frame.
    pub(crate) frame: u32,
    pub(crate) frames: u32,
    /// Of every frame, whatever becomes of the window.
    pub(crate) size: [u32; 2],
}

impl Recording {
    /// Of an animation of some length; a motionless scene is one frame.
    pub(crate) fn new(path: PathBuf, seconds: f64, size: [u32; 2]) -> Self {
        let frames = (seconds * f64::from(Timeline::FPS)).ceil().clamp(1.0, 1e6) as u32;
        Self { path, frame: 0, frames, size }
    }

    /// The next frame's moment.
    pub(crate) fn seconds(&self) -> f64 {
        f64::from(self.frame) / f64::from(Timeline::FPS)
    }
}
