//! Image files, animations and raw video.
//!
//! [`Writer`] takes finished frames and writes any of the formats. A file appears under its own name only when it is
//! whole: until then it is a hidden file beside it, `.NAME.partial-…`, which is removed when the writer is dropped
//! unfinished. Only killing the process can leave such a file behind; the next writer of the same name removes it.
//! Programs that end on a signal call [`remove_partial_files`] first.

mod apng;
mod eight_bits;
mod exr;
mod format;
mod frame_rate;
mod gif;
mod mp4;
mod numbered_path;
mod palette;
mod partial_file;
mod png;
mod writer;
mod y4m;

use std::io;
use std::path::{Path, PathBuf};

pub use exr::FloatDepth;
pub(crate) use format::eight_bits;
pub use format::{BitDepth, Compression, Format, JpegQuality, extensions};
pub use frame_rate::FrameRate;
pub use numbered_path::NumberedPath;
pub use partial_file::{remove_partial_files, sweep, write_whole};
pub use png::write_png;
pub use writer::{Options, Picture, PictureForm, Target, Writer};
pub use y4m::Chroma;

/// Why a picture could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The system refused to write.
    #[error("{}: can't be written: {source}", path.display())]
    Write {
        /// The file, or `-` for standard output.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The format or the file's name can't hold what should be written.
    #[error("{}: {cause}", path.display())]
    Unsuitable {
        /// The file, or `-` for standard output.
        path: PathBuf,
        /// The mismatch, and suitable alternatives.
        cause: String,
    },
}

impl Error {
    /// Whether the reader of a pipe has closed it, which is no failure of the writer's.
    #[must_use]
    pub fn is_broken_pipe(&self) -> bool {
        matches!(self, Self::Write { source, .. } if source.kind() == io::ErrorKind::BrokenPipe)
    }

    fn write(path: &Path, source: io::Error) -> Self {
        Self::Write { path: path.to_owned(), source }
    }

    fn unsuitable(path: &Path, cause: impl Into<String>) -> Self {
        Self::Unsuitable { path: path.to_owned(), cause: cause.into() }
    }
}
