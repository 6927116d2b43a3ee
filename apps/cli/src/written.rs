//! A thread that writes each picture while the next one is rendered.

use std::fs::File;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::time::Instant;

use umbrage::output::{Picture, Writer};

use crate::failure::Failure;
use crate::progress::Progress;
use crate::records::{self, Records};
use crate::report::FrameReport;

/// A frame to be written.
pub(crate) struct Rendered {
    pub(crate) picture: Picture,
    /// The report so far, without the time for writing.
    pub(crate) report: FrameReport,
}

/// The renderer's end of the queue.
pub(crate) struct ToWriter {
    frames: SyncSender<Rendered>,
    /// Written pictures, whose memory is reused.
    spare: Receiver<Picture>,
}

/// Writes frames in order of arrival.
pub(crate) struct FrameWriter<'a> {
    pub(crate) writer: Writer,
    pub(crate) records: Option<&'a Records<'a>>,
    pub(crate) progress: &'a Progress,
}

impl ToWriter {
    /// A picture that has been written, or an empty one.
    pub(crate) fn spare(&self) -> Picture {
        self.spare.try_recv().unwrap_or_default()
    }

    /// Hands a frame over, once the writer is free. Returns false where the writer has failed.
    #[must_use]
    pub(crate) fn send(&self, rendered: Rendered) -> bool {
        self.frames.send(rendered).is_ok()
    }
}

/// Makes the two ends of the queue from renderer to writer. A frame is handed over once the previous one is written, so
/// there are at most two pictures.
pub(crate) fn way() -> (ToWriter, FromRenderer) {
    let ((frames, rendered), (written, spare)) = (sync_channel(0), sync_channel(2));
    (ToWriter { frames, spare }, FromRenderer { rendered, written })
}

/// The writer's end of the queue.
pub(crate) struct FromRenderer {
    rendered: Receiver<Rendered>,
    written: SyncSender<Picture>,
}

impl FrameWriter<'_> {
    /// Writes all frames of the queue, and returns their reports. A single file for all frames is left unfinished, until the
    /// caller knows that all frames came.
    pub(crate) fn write_all(mut self, from: FromRenderer) -> Result<(Writer, Vec<FrameReport>), Failure> {
        let mut reports = Vec::new();
        for rendered in from.rendered {
            let (picture, report) = self.write(rendered)?;
            reports.push(report);
            self.progress.step();
            // Pictures that nobody takes are dropped.
            if let Err(TrySendError::Full(rest) | TrySendError::Disconnected(rest)) = from.written.try_send(picture) {
                drop(rest);
            }
        }
        Ok((self.writer, reports))
    }

    fn write(&mut self, Rendered { picture, mut report }: Rendered) -> Result<(Picture, FrameReport), Failure> {
        let started = Instant::now();
        let frame = report.frame;
        match self.records {
            None => self.writer.write(frame, &picture)?,
            Some(records) => {
                let mut written = (0, String::new());
                let mut look = |file: &File| records::hash(file).map(|hashed| written = hashed);
                self.writer.write_and_look(frame, &picture, &mut look)?;
                records.write(frame, written)?;
            }
        }
        report.write_milliseconds = 1e3 * started.elapsed().as_secs_f64();
        Ok((picture, report))
    }
}
