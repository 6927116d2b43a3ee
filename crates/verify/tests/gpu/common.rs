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

/// What is opened once for all tests: software adapters take seconds to compile the kernels.
pub(crate) type Once<T> = OnceLock<Option<Mutex<T>>>;

/// Has what is opened once to itself; none where there is no adapter.
pub(crate) fn lock<T>(once: &'static Once<T>, open: impl FnOnce() -> Option<T>) -> Option<MutexGuard<'static, T>> {
    let opened = once.get_or_init(|| open().map(Mutex::new)).as_ref();
    // A test that has failed leaves nothing that the next one would build on.
    opened.map(|opened| opened.lock().unwrap_or_else(PoisonError::into_inner))
}

fn open_renderer(limits: DeviceLimits) -> Option<Renderer> {
    Some(Renderer::with_gpu(open(limits)?).expect("room for fixed tables"))
}

/// A renderer with the limits of every device.
pub(crate) fn renderer() -> Option<MutexGuard<'static, Renderer>> {
    static RENDERER: Once<Renderer> = OnceLock::new();
    lock(&RENDERER, || open_renderer(DeviceLimits::Portable))
}

/// A renderer whose buffers have a megabyte at most.
pub(crate) fn small_renderer() -> Option<MutexGuard<'static, Renderer>> {
    static RENDERER: Once<Renderer> = OnceLock::new();
    lock(&RENDERER, || open_renderer(DeviceLimits::Buffers(1 << 20)))
}
