use crate::{Animated, Error, Frame};

/// What a reader of a motionless file gives.
#[derive(Clone, Debug, Default)]
pub(crate) struct Still {
    /// Without lights and cameras.
    pub(crate) frame: Frame,
    /// What the reader left out or guessed, for a person.
    pub(crate) warnings: Vec<String>,
}

impl Animated for Still {
    fn duration_seconds(&self) -> f64 {
        0.0
    }

    fn pose(&self, _seconds: f64, frame: &mut Frame) -> Result<(), Error> {
        frame.copy_surfaces(&self.frame);
        Ok(())
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }
}
