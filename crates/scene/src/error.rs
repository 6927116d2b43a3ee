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
        /// The system's error.
        source: std::io::Error,
    },
    /// A file's content breaks its format.
    #[error("{}: {location}: {cause}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Where in the file: a line, a byte or an element.
        location: String,
        /// The fault, in words.
        cause: String,
    },
    /// A file needs something that this program doesn't have.
    #[error("{}: {what} is not supported; {hint}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The missing feature.
        what: String,
        /// Advice for the file's owner.
        hint: String,
    },
    /// Opening a file would take more memory than it may, or than there is.
    #[error("{}: {cause}", path.display())]
    Memory {
        /// The file.
        path: PathBuf,
        /// The part of the file, the bytes that it needs and the limit.
        cause: String,
    },
    /// The temporary file of textures on demand can't be made, written or read.
    #[error("the temporary file for textures (--texture-memory): {0}")]
    TextureFile(String),
    /// The time of a pose isn't a finite number.
    #[error("a moment of {0} seconds: it must be a finite number")]
    Moment(f64),
    /// The scene's address or an option to it is wrong.
    #[error("{address}: {cause}")]
    Address {
        /// The address as given.
        address: String,
        /// The fault and its remedy.
        cause: String,
    },
}

impl Error {
    /// [`Error::Read`].
    #[must_use]
    pub fn read(path: &Path, source: std::io::Error) -> Self {
        Self::Read { path: path.to_owned(), source }
    }

    /// [`Error::Malformed`].
    #[must_use]
    pub fn malformed(path: &Path, location: impl Into<String>, cause: impl Into<String>) -> Self {
        Self::Malformed { path: path.to_owned(), location: location.into(), cause: cause.into() }
    }

    /// [`Error::Unsupported`].
    #[must_use]
    pub fn unsupported(path: &Path, what: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::Unsupported { path: path.to_owned(), what: what.into(), hint: hint.into() }
    }

    /// [`Error::Address`].
    #[must_use]
    pub fn address(address: impl Into<String>, cause: impl Into<String>) -> Self {
        Self::Address { address: address.into(), cause: cause.into() }
    }
}
