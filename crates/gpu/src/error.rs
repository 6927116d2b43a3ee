/// Why a GPU operation failed.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no adapter, or none of that name.
    #[error("no GPU adapter {0}")]
    NoAdapter(String),
    /// The adapter refused to become a device, or the device lacks a feature or limit.
    #[error("{adapter}: {cause}")]
    Device {
        /// The adapter's name.
        adapter: String,
        /// The driver's message, or the missing feature or limit.
        cause: String,
    },
    /// The device went away: it was reset, unplugged or its driver stopped.
    #[error("the GPU was lost: {0}")]
    Lost(String),
    /// The device has no memory left.
    #[error("the GPU is out of memory: {0}")]
    OutOfMemory(String),
    /// A buffer would need more bytes than the device allows.
    #[error("{what} needs {bytes} bytes in one buffer; this GPU allows {limit}")]
    TooLarge {
        /// The buffer's name.
        what: String,
        /// The bytes that it needs.
        bytes: u64,
        /// The most bytes that one buffer may have.
        limit: u64,
    },
    /// A picture has more pixels on a side than the device's textures.
    #[error("a picture of {width}×{height} pixels is too large: this GPU's textures have at most {limit} on a side")]
    PictureTooLarge {
        /// Its width in pixels.
        width: u32,
        /// Its height in pixels.
        height: u32,
        /// The most pixels that either may have.
        limit: u32,
    },
    /// A mistake of this crate, found by the driver's or wgpu's validation.
    #[error("the GPU rejected a command: {0}")]
    Rejected(String),
}
