use std::path::Path;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A progress bar on standard error: it appears after two seconds, and only if standard error is a terminal.
pub(crate) struct Progress {
    bar: ProgressBar,
    /// Dropped at the end of the render.
    over: Option<Sender<()>>,
    patience: Option<JoinHandle<()>>,
}

const PATIENCE: Duration = Duration::from_secs(2);
const TICK: Duration = Duration::from_millis(200);
/// Steps of the bar for a single frame.
const STEPS: u64 = 1000;

impl Progress {
    /// Starts a bar for `frames` frames; a `quiet` one never shows. For a single frame, `part` is the progress within it,
    /// if it is known.
    pub(crate) fn start(frames: u32, part: Option<umbrage::Progress>, quiet: bool) -> Self {
        let part = part.filter(|_| frames == 1);
        let steps = if part.is_some() { STEPS } else { u64::from(frames) };
        let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::hidden());
        let template = match (frames, &part) {
            (1, None) => "{spinner} rendering, {elapsed} so far",
            (1, Some(_)) => "{wide_bar} {percent} %, {eta} left",
            _ => "{wide_bar} frame {pos} of {len}, {eta} left",
        };
        Self::shown_later(bar, template, part, quiet)
    }

    /// Starts a spinner for a task of unknown progress, such as opening a scene; a `quiet` one never shows.
    pub(crate) fn task(name: &str, scene: &Path, quiet: bool) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        bar.set_message(format!("{name} {}", scene.display()));
        Self::shown_later(bar, "{spinner} {msg}, {elapsed} so far", None, quiet)
    }

    fn shown_later(bar: ProgressBar, template: &str, part: Option<umbrage::Progress>, quiet: bool) -> Self {
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
                shown.enable_steady_tick(TICK);
            }
            let Some(part) = part else { return };
            while ended.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
                shown.set_position((part.part() * STEPS as f32) as u64);
            }
        });
        Self { bar, over: Some(over), patience: Some(patience) }
    }

    /// Counts a written frame.
    pub(crate) fn step(&self) {
        self.bar.inc(1);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        drop(self.over.take());
        if let Some(patience) = self.patience.take() {
            // The thread doesn't panic; if it did, the render would still be complete.
            let _ = patience.join();
        }
        self.bar.finish_and_clear();
    }
}
