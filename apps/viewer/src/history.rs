//! Times of the last pictures.

use std::collections::VecDeque;

use crate::order::Picture;

/// Stage times of the last pictures.
#[derive(Debug, Default)]
pub(crate) struct History {
    /// Names of stages in order of first appearance, which determines their colours.
    names: Vec<&'static str>,
    /// Milliseconds by stage.
    pictures: VecDeque<Vec<f64>>,
}

impl History {
    /// Number of pictures kept.
    pub(crate) const LENGTH: usize = 120;

    pub(crate) fn add(&mut self, picture: &Picture) {
        let mut times = vec![0.0; self.names.len()];
        for stage in &picture.stats.stages {
            let index = self.names.iter().position(|name| *name == stage.name).unwrap_or_else(|| {
                self.names.push(stage.name);
                times.push(0.0);
                self.names.len() - 1
            });
            times[index] += stage.milliseconds;
        }
        if self.pictures.len() == Self::LENGTH {
            self.pictures.pop_front();
        }
        self.pictures.push_back(times);
    }

    /// Forgets all pictures, since other settings have other stages.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }

    pub(crate) fn names(&self) -> &[&'static str] {
        &self.names
    }

    /// Milliseconds by stage, the oldest picture first. Stages that appeared later are missing at the end.
    pub(crate) fn pictures(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.pictures.iter().map(Vec::as_slice)
    }

    /// The longest picture's time in milliseconds.
    pub(crate) fn longest(&self) -> f64 {
        self.pictures().map(|times| times.iter().sum()).fold(0.0, f64::max)
    }
}
