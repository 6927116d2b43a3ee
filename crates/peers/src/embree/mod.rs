//! Embree, through the functions of its shared library: versions 3 and 4.
//!
//! # Safety
//! All unsafe code of this crate is here, for three reasons. Functions are looked up by name and given the types of the
//! headers `rtcore_*.h`; the two versions differ in the two functions that trace, and the library reports its version.
//! Buffers are shared, not copied: a [`Scene`] keeps the [`Posed`](crate::Posed) that owns them, unchanged behind an
//! [`Arc`](std::sync::Arc), until its geometry gets other buffers or is released; indices were checked, and positions have
//! the padding for 16-byte reads. Packets have the layouts of the headers, which tests compare with the headers' numbers.
//!
//! Embree's manual recommends to trace with denormal numbers flushed to zero. Switching that mode on and off for each
//! call saved no time (no difference above the noise on the gallery's cloth and shatter), so the mode is left as Rust
//! needs it.
#![allow(unsafe_code, reason = "calls a C library")]

mod filter;
mod library;
mod point_query;
mod scene;
mod trace;

use std::ffi::c_void;
use std::path::PathBuf;
use std::ptr::NonNull;

pub use library::Embree;
pub use scene::{BuildMethod, Quality, Scene};

type Handle = NonNull<c_void>;

/// Why Embree or tinybvh can't be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No library was found.
    #[error(
        "Embree is not installed (tried {tried}): install the Python package embreex or Debian's libembree-dev, or name a \
         library with --embree PATH or the environment variable UMBRAGE_EMBREE"
    )]
    NotFound {
        /// File names and paths.
        tried: String,
    },
    /// The library can't be used.
    #[error("{}: {cause}", path.display())]
    Unusable {
        /// The library.
        path: PathBuf,
        /// Missing function, or other reason.
        cause: String,
    },
    /// Embree reports an error.
    #[error("Embree could not {what}: error {code}")]
    Failed {
        /// Failed operation.
        what: &'static str,
        /// `RTCError`.
        code: i32,
    },
    /// Triangles that tinybvh can't trace: none at all, or some that aren't opaque.
    #[error("tinybvh takes opaque triangles only, and at least one")]
    NotOpaque,
    /// A triangle with a vertex index that is out of range.
    #[error("triangle {triangle} has a vertex that is out of range")]
    IndexOutOfRange {
        /// Its id.
        triangle: usize,
    },
}
