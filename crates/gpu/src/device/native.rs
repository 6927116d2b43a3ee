//! Opening devices and waiting for them where threads may wait.

use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use super::{Adapter, DeviceLimits, Gpu};
use crate::GpuError;

impl Adapter {
    /// All adapters of this machine: GPUs before software, each in the driver's order.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let mut all: Vec<_> = enumerate().iter().map(Self::of).collect();
        all.sort_by_key(|adapter| adapter.is_software);
        all
    }

    /// The first adapter whose name contains `name`, in any case. If `name` is empty, the first GPU, or else the first
    /// software adapter.
    ///
    /// # Errors
    /// If there is no such adapter.
    pub fn find(name: &str) -> Result<Self, GpuError> {
        choose(name).map(|(info, _)| info)
    }
}

impl Gpu {
    /// For this long a shared device is polled without sleep.
    const SHORT_WAIT: Duration = Duration::from_micros(300);
    /// Interval between polls from then on.
    const STEP_OF_WAITING: Duration = Duration::from_micros(200);

    /// Opens the first adapter whose name contains `name`, in any case. If `name` is empty, opens the first GPU, or
    /// else the first software adapter.
    ///
    /// # Errors
    /// If there is no such adapter, or it can't be opened.
    pub fn open(name: &str, limits: DeviceLimits) -> Result<Self, GpuError> {
        let (info, adapter) = choose(name)?;
        pollster::block_on(Self::of_adapter(info, &adapter, limits))
    }

    /// Waits until all submitted work is done.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn wait(&self) -> Result<(), GpuError> {
        if self.is_shared {
            return self.wait_beside_others();
        }
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        waited.map_err(|cause| GpuError::Lost(cause.to_string())).and_then(|_| self.check())
    }

    /// [`Gpu::wait`] without the locks that wgpu holds while it waits, so that other threads can present a window meanwhile.
    fn wait_beside_others(&self) -> Result<(), GpuError> {
        let lost = |cause: String| GpuError::Lost(cause);
        let (tell, told) = mpsc::channel();
        self.queue.on_submitted_work_done(move || {
            tell.send(()).ok();
        });
        let start = Instant::now();
        loop {
            // With a time limit of wgpu's own, wgpu 30 sometimes panics where other threads poll as well (gfx-rs/wgpu#9958).
            self.device.poll(wgpu::PollType::Poll).map_err(|cause| lost(cause.to_string()))?;
            let is_short = start.elapsed() < Self::SHORT_WAIT;
            match told.recv_timeout(if is_short { Duration::ZERO } else { Self::STEP_OF_WAITING }) {
                Ok(()) => return self.check(),
                Err(RecvTimeoutError::Timeout) if self.loss.get().is_none() => {}
                Err(cause) => return self.check().and(Err(lost(cause.to_string()))),
            }
            if is_short {
                std::thread::yield_now();
            }
        }
    }
}

/// Waits until all submitted work is done and `buffers` can be read.
pub(crate) async fn map_all(gpu: &Gpu, buffers: &[wgpu::Buffer]) -> Result<(), GpuError> {
    let (tell, told) = mpsc::channel();
    for buffer in buffers {
        let tell = tell.clone();
        buffer.map_async(wgpu::MapMode::Read, .., move |mapped| drop(tell.send(mapped)));
    }
    gpu.wait()?;
    let lost = |cause: String| GpuError::Lost(cause);
    for _ in buffers {
        // On a shared device, another thread's poll may be the one that maps the buffer.
        told.recv().map_err(|cause| lost(cause.to_string()))?.map_err(|cause| lost(cause.to_string()))?;
    }
    Ok(())
}

/// Whether an allocation since `memory` was pushed ran out of memory.
pub(crate) fn is_refused(memory: wgpu::ErrorScopeGuard) -> bool {
    pollster::block_on(memory.pop()).is_some()
}

fn enumerate() -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.flags = Gpu::instance_flags();
    let instance = wgpu::Instance::new(descriptor);
    pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY))
}

/// The first adapter whose name contains `name`, GPUs before software.
pub(crate) fn choose(name: &str) -> Result<(Adapter, wgpu::Adapter), GpuError> {
    let wanted = name.to_lowercase();
    let mut found: Vec<_> = enumerate().into_iter().map(|adapter| (Adapter::of(&adapter), adapter)).collect();
    found.sort_by_key(|(info, _)| info.is_software);
    let names = found.iter().map(|(info, _)| info.name.clone()).collect::<Vec<_>>().join(", ");
    let chosen = found.into_iter().find(|(info, _)| info.name.to_lowercase().contains(&wanted));
    chosen.ok_or_else(|| {
        GpuError::NoAdapter(if names.is_empty() {
            "was found: install a Vulkan driver (on Debian, mesa-vulkan-drivers has one in software)".to_owned()
        } else {
            format!("has \"{name}\" in its name; there is {names}")
        })
    })
}
