//! The machine's adapter, and what all tests use of it together.

use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use umbrage::Renderer;
use umbrage::gpu::{DeviceLimits, Gpu};

/// A device of the machine's adapter, or none: then says so on the standard error, and CI counts it.
pub(crate) fn open(limits: DeviceLimits) -> Option<Gpu> {
    Gpu::open("", limits).map_err(|error| eprintln!("skipped-gpu: {error}")).ok()
}

/// The same with the limits of every device.
pub(crate) fn gpu() -> Option<Gpu> {
    open(DeviceLimits::Portable)
}

/// A renderer with a device of its own, or none where there is no adapter.
pub(crate) fn open_renderer(limits: DeviceLimits) -> Option<Renderer> {
    Some(Renderer::with_gpu(open(limits)?).expect("room for fixed tables"))
}

/// A renderer with the limits of every device. One for all tests: software adapters take seconds to compile the kernels.
pub(crate) fn renderer() -> Option<MutexGuard<'static, Renderer>> {
    static RENDERER: OnceLock<Option<Mutex<Renderer>>> = OnceLock::new();
    let renderer = RENDERER.get_or_init(|| open_renderer(DeviceLimits::Portable).map(Mutex::new));
    // A test that has failed leaves nothing that the next one would build on.
    renderer.as_ref().map(|renderer| renderer.lock().unwrap_or_else(PoisonError::into_inner))
}
