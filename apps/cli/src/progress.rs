use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A bar on standard error, for a person who would otherwise wait without a sign: it comes after two seconds, and
/// never where standard error is no terminal.
pub(crate) struct Progress {
    bar: ProgressBar,
    /// Dropped to say that the render is over.
    over: Option<Sender<()>>,
    patience: Option<JoinHandle<()>>,
}

const PATIENCE: Duration = Duration::from_secs(2);

impl Progress {
    /// Starts to wait for `frames` frames; a `quiet` one never shows.
    pub(crate) fn start(frames: u32, quiet: bool) -> Self {
        let bar = ProgressBar::with_draw_target(Some(u64::from(frames)), ProgressDrawTarget::hidden());
        let template = if frames > 1 {
            "{wide_bar} frame {pos} of {len}, {eta} left"
        } else {
            "{spinner} rendering, {elapsed} so far"
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        if quiet {
            return Self { bar, over: None, patience: None };
        }
        let (over, ended) = mpsc::channel();
        let shown = bar.clone();
        let patience = thread::spawn(move || {
            if ended.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                shown.set_draw_target(ProgressDrawTarget::stderr());
                shown.enable_steady_tick(Duration::from_millis(200));
            }
        });
        Self { bar, over: Some(over), patience: Some(patience) }
    }

    /// One more frame is written.
    pub(crate) fn step(&self) {
        self.bar.inc(1);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        drop(self.over.take());
        if let Some(patience) = self.patience.take() {
            // It can't have panicked, and nothing would follow from that.
            let _ = patience.join();
        }
        self.bar.finish_and_clear();
    }
}
