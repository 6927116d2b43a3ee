use crate::{Error, Frame};

/// A procedural scene of the gallery.
#[derive(Debug)]
pub(crate) struct Demo {}

impl Demo {
    /// The demo that `NAME` or `NAME?triangles=N` means.
    pub(crate) fn open(address: &str) -> Result<Self, Error> {
        Err(Error::address(address, "there is no such demo"))
    }

    pub(crate) fn pose(&self, _seconds: f64, _frame: &mut Frame) {}

    pub(crate) fn duration_seconds(&self) -> f64 {
        0.0
    }
}
