use std::path::Path;

use crate::{Animation, Clip, Error, Frame};

/// A glTF 2.0 scene, ready to be posed.
#[derive(Debug)]
pub(crate) struct GltfScene {}

impl GltfScene {
    pub(crate) fn open(_path: &Path, _clip: &Clip) -> Result<Self, Error> {
        Ok(Self {})
    }

    pub(crate) fn pose(&self, _seconds: f64, _frame: &mut Frame) {}

    pub(crate) fn duration_seconds(&self) -> f64 {
        0.0
    }

    pub(crate) fn animations(&self) -> &[Animation] {
        &[]
    }

    pub(crate) fn warnings(&self) -> &[String] {
        &[]
    }
}
