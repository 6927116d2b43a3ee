//! Pictures are written by a thread of their own, while the next one is rendered.

use std::fs::File;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::time::Instant;

use umbrage::output::Writer;
use umbrage::{Film, Settings};

use crate::failure::Failure;
use crate::progress::Progress;
use crate::records::{self, Records};
use crate::report::FrameReport;

/// A frame that is to be written.
pub(crate) struct Rendered {
    pub(crate) film: Film,
    pub(crate) settings: Settings,
    /// But for what writing took.
    pub(crate) report: FrameReport,
}

/// Where rendered frames are handed over.
pub(crate) struct ToWriter {
    frames: SyncSender<Rendered>,
    /// Films that were written, whose memory the next ones take.
    spare: Receiver<Film>,
}

/// What writes frames in the order in which they come.
pub(crate) struct FrameWriter<'a> {
    pub(crate) writer: Writer,
    pub(crate) records: Option<&'a Records<'a>>,
    pub(crate) progress: &'a Progress,
}

impl ToWriter {
    /// A film that has been written, or an empty one.
    pub(crate) fn spare(&self) -> Film {
        self.spare.try_recv().unwrap_or_default()
    }

    /// Hands a frame over once the one before is being written. False where the writer has failed.
    #[must_use]
    pub(crate) fn send(&self, rendered: Rendered) -> bool {
        self.frames.send(rendered).is_ok()
    }
}

/// The two ends of the way from what renders to what writes. A frame is handed over when the one before is written, so that
/// there are two films.
pub(crate) fn way() -> (ToWriter, FromRenderer) {
    let ((frames, rendered), (written, spare)) = (sync_channel(0), sync_channel(2));
    (ToWriter { frames, spare }, FromRenderer { rendered, written })
}

/// Where rendered frames come from.
pub(crate) struct FromRenderer {
    rendered: Receiver<Rendered>,
    written: SyncSender<Film>,
}

impl FrameWriter<'_> {
    /// Writes what comes, until nothing more does, and says what each frame took. What is in one file isn't finished: that is
    /// done once it is known that all frames came.
    pub(crate) fn write_all(mut self, from: FromRenderer) -> Result<(Writer, Vec<FrameReport>), Failure> {
        let mut reports = Vec::new();
        for rendered in from.rendered {
            let (film, report) = self.write(rendered)?;
            reports.push(report);
            self.progress.step();
            // Where nobody takes them, films are dropped.
            if let Err(TrySendError::Full(film) | TrySendError::Disconnected(film)) = from.written.try_send(film) {
                drop(film);
            }
        }
        Ok((self.writer, reports))
    }

    fn write(&mut self, Rendered { film, settings, mut report }: Rendered) -> Result<(Film, FrameReport), Failure> {
        let started = Instant::now();
        let frame = report.frame;
        match self.records {
            None => self.writer.write(frame, &film, &settings)?,
            Some(records) => {
                let mut written = (0, String::new());
                let mut look = |file: &File| records::hash(file).map(|hashed| written = hashed);
                self.writer.write_and_look(frame, &film, &settings, &mut look)?;
                records.write(frame, written)?;
            }
        }
        report.write_milliseconds = 1e3 * started.elapsed().as_secs_f64();
        Ok((film, report))
    }
}
