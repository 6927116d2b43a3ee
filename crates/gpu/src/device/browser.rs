//! Opens a device and waits for it where no thread may block: all of it is asynchronous.

use futures_channel::oneshot;

use super::{Adapter, DeviceLimits, Gpu};
use crate::GpuError;

impl Gpu {
    /// Opens the adapter that the browser prefers.
    ///
    /// # Errors
    /// If the browser has no WebGPU or no adapter, or the adapter can't be opened.
    pub async fn open_in_browser(limits: DeviceLimits) -> Result<Self, GpuError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        let adapter = instance.request_adapter(&options).await;
        let adapter = adapter.map_err(|cause| GpuError::NoAdapter(format!("is there for this page: {cause}")))?;
        Self::of_adapter(Adapter::of(&adapter), &adapter, limits).await
    }
}

/// Waits until all submitted work is done and `buffers` can be read.
pub(crate) async fn map_all(gpu: &Gpu, buffers: &[wgpu::Buffer]) -> Result<(), GpuError> {
    let lost = |cause: String| GpuError::Lost(cause);
    let told = buffers.iter().map(|buffer| {
        let (tell, told) = oneshot::channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |mapped| drop(tell.send(mapped)));
        told
    });
    for told in told.collect::<Vec<_>>() {
        let mapped = told.await.map_err(|cause| lost(cause.to_string()))?;
        // An earlier error says more.
        mapped.map_err(|cause| gpu.check().err().unwrap_or_else(|| lost(cause.to_string())))?;
    }
    if buffers.is_empty() {
        let (tell, told) = oneshot::channel();
        gpu.queue.on_submitted_work_done(move || {
            tell.send(()).ok();
        });
        told.await.map_err(|cause| lost(cause.to_string()))?;
    }
    gpu.check()
}

/// Always `false`: a browser reports later that memory was short, and then the frame fails.
pub(crate) fn is_refused(memory: wgpu::ErrorScopeGuard) -> bool {
    // The scope is dropped, so that the error reaches the device's handler.
    drop(memory);
    false
}
