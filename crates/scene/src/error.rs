use std::path::{Path, PathBuf};

/// Why a scene could not be opened or posed. Every message names the file, the location in it and the cause.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read at all.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file's content breaks its format.
    #[error("{}: {location}: {cause}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Where in the file: a line, a byte or an element.
        location: String,
        /// What is wrong there.
        cause: String,
    },
    /// A file needs something that this program doesn't have.
    #[error("{}: {what} is not supported; {hint}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// What it needs.
        what: String,
        /// What its owner can do.
        hint: String,
    },
    /// Opening a file would take more memory than [`OpenOptions::max_memory`](crate::OpenOptions::max_memory), or than there
    /// is.
    #[error("{}: {cause}", path.display())]
    Memory {
        /// The file.
        path: PathBuf,
        /// What would take how much, and of what.
        cause: String,
    },
    /// The temporary file of textures on demand ([`OpenOptions::texture_memory`](crate::OpenOptions::texture_memory)) can't
    /// be made, written or read.
    #[error("the temporary file for textures (--texture-memory): {0}")]
    TextureFile(String),
    /// A scene was asked for at a moment that is none.
    #[error("a moment of {0} seconds: it must be a finite number")]
    Moment(f64),
    /// The scene's address or an option to it is wrong.
    #[error("{address}: {cause}")]
    Address {
        /// What was asked for.
        address: String,
        /// What is wrong, and what would be right.
        cause: String,
    },
}

impl Error {
    pub(crate) fn read(path: &Path, source: std::io::Error) -> Self {
        Self::Read { path: path.to_owned(), source }
    }

    pub(crate) fn malformed(path: &Path, location: impl Into<String>, cause: impl Into<String>) -> Self {
        Self::Malformed { path: path.to_owned(), location: location.into(), cause: cause.into() }
    }

    pub(crate) fn unsupported(path: &Path, what: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::Unsupported { path: path.to_owned(), what: what.into(), hint: hint.into() }
    }

    pub(crate) fn address(address: impl Into<String>, cause: impl Into<String>) -> Self {
        Self::Address { address: address.into(), cause: cause.into() }
    }
}
