use std::path::Path;

use crate::{Error, Frame};

/// Numbered files, one for each frame of an animation; each may have its own topology.
#[derive(Debug)]
pub(crate) struct Sequence {}

impl Sequence {
    /// The sequence that `address` means: a pattern with `%04d` or `*`, or a folder; `None` for a plain file.
    pub(crate) fn find(_address: &Path, _fps: f64) -> Result<Option<Self>, Error> {
        Ok(None)
    }

    pub(crate) fn pose(&self, _seconds: f64, _frame: &mut Frame) -> Result<(), Error> {
        Ok(())
    }

    pub(crate) fn duration_seconds(&self) -> f64 {
        0.0
    }

    pub(crate) fn warnings(&self) -> &[String] {
        &[]
    }
}
