#[cfg(target_arch = "wasm32")]
pub(crate) mod browser;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) mod native;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

use crate::GpuError;
use crate::memory::Memory;
use crate::pipelines::Pipelines;

#[cfg(target_arch = "wasm32")]
pub(crate) use browser as platform;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use native as platform;

/// A GPU that is ready to work. Clones are the same device.
#[derive(Clone, Debug)]
pub struct Gpu {
    #[doc(hidden)]
    pub device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    info: Adapter,
    pub(crate) uploaded_bytes: Arc<AtomicU64>,
    pub(crate) memory: Arc<Memory>,
    pub(crate) pipelines: Arc<Pipelines>,
    /// The first error since [`Gpu::check`] was last called.
    trouble: Arc<Mutex<Option<GpuError>>>,
    /// Cause of the device's loss, if it is lost: every call on a lost device fails, with errors of any kind.
    loss: Arc<OnceLock<String>>,
    /// Whether another owner uses the device as well.
    #[cfg_attr(target_arch = "wasm32", allow(dead_code, reason = "only whoever waits has to know"))]
    is_shared: bool,
    #[cfg(feature = "operations")]
    pub(crate) operations: Arc<crate::operations::Operations>,
}

/// An adapter's description, known without opening it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adapter {
    /// The device's name, from its driver.
    pub name: String,
    /// The driver and its version.
    pub driver: String,
    /// Vulkan, Metal, Dx12 …
    pub backend: String,
    /// Whether it is a program on the CPU rather than a GPU.
    pub is_software: bool,
}

/// Which of the adapter's limits a device gets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DeviceLimits {
    /// The adapter's limit on buffer sizes.
    #[default]
    Adapter,
    /// Limits that every device has: bindings of 128 MiB, buffers of 256 MiB.
    Portable,
    /// Buffers of at most this many bytes, fewer than every device has.
    Buffers(u32),
    /// The adapter's limit on buffer sizes, and at most this many bytes in all buffers together.
    Memory(u64),
}

impl Adapter {
    /// The description that wgpu has of an adapter.
    #[must_use]
    pub fn of(adapter: &wgpu::Adapter) -> Self {
        let info = adapter.get_info();
        let driver = [info.driver, info.driver_info].join(" ").trim().to_owned();
        Self {
            name: info.name,
            driver,
            backend: format!("{:?}", info.backend),
            is_software: info.device_type == wgpu::DeviceType::Cpu,
        }
    }
}

impl Gpu {
    async fn of_adapter(info: Adapter, adapter: &wgpu::Adapter, limits: DeviceLimits) -> Result<Self, GpuError> {
        let memory = match limits {
            DeviceLimits::Memory(bytes) => bytes,
            DeviceLimits::Adapter | DeviceLimits::Portable | DeviceLimits::Buffers(_) => u64::MAX,
        };
        Self::open_as(&Self::descriptor(adapter, limits)?, info, adapter, memory).await
    }

    pub(crate) async fn open_as(
        descriptor: &wgpu::DeviceDescriptor<'_>,
        info: Adapter,
        adapter: &wgpu::Adapter,
        memory: u64,
    ) -> Result<Self, GpuError> {
        let opened = adapter.request_device(descriptor).await;
        let (device, queue) =
            opened.map_err(|cause| GpuError::Device { adapter: info.name.clone(), cause: cause.to_string() })?;
        Ok(Self::new(info, device, queue, memory, false))
    }

    /// Takes a device that the caller has opened, with [`Gpu::descriptor`] or with more, and goes on to use: work that both
    /// submit to its queue is done in the order of submission.
    ///
    /// From now on this `Gpu` handles the device's uncaptured errors and the news of its loss.
    ///
    /// # Errors
    /// If the device lacks a feature or a limit; the error names it.
    pub fn of_device(adapter: &wgpu::Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Result<Self, GpuError> {
        let info = Adapter::of(adapter);
        let mut needed = wgpu::Limits::default();
        // Buffers may be small: images are rendered in bands that fit.
        (needed.max_buffer_size, needed.max_storage_buffer_binding_size) = (0, 0);
        expect_limits(&info, &needed, &device.limits())?;
        Ok(Self::new(info, device, queue, u64::MAX, true))
    }

    /// The least descriptor for opening an adapter's device.
    ///
    /// # Errors
    /// If the adapter lacks a feature or a limit; the error names it.
    pub fn descriptor(
        adapter: &wgpu::Adapter,
        limits: DeviceLimits,
    ) -> Result<wgpu::DeviceDescriptor<'static>, GpuError> {
        let has = adapter.limits();
        let mut required_limits = wgpu::Limits::default();
        match limits {
            DeviceLimits::Adapter | DeviceLimits::Memory(_) => {
                required_limits.max_buffer_size = has.max_buffer_size;
                required_limits.max_storage_buffer_binding_size = has.max_storage_buffer_binding_size;
                let side = &mut required_limits.max_texture_dimension_2d;
                *side = has.max_texture_dimension_2d.max(*side);
            }
            DeviceLimits::Portable => {}
            DeviceLimits::Buffers(bytes) => {
                required_limits.max_buffer_size = bytes.into();
                required_limits.max_storage_buffer_binding_size = bytes.into();
            }
        }
        expect_limits(&Adapter::of(adapter), &required_limits, &has)?;
        Ok(wgpu::DeviceDescriptor {
            label: Some("umbrage"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits,
            ..Default::default()
        })
    }

    /// Recommended flags for the wgpu instance that opens the devices.
    #[must_use]
    pub fn instance_flags() -> wgpu::InstanceFlags {
        // The counts of indirect dispatches come from this crate's stages, which keep to the limits: wgpu needn't
        // validate them.
        if cfg!(debug_assertions) { wgpu::InstanceFlags::DEBUG } else { wgpu::InstanceFlags::empty() }
    }

    fn new(info: Adapter, device: wgpu::Device, queue: wgpu::Queue, memory: u64, is_shared: bool) -> Self {
        let memory = Memory::with_limit(memory);
        let trouble = Arc::new(Mutex::new(None));
        let of_errors = Arc::clone(&trouble);
        device.on_uncaptured_error(Arc::new(move |error| {
            if let Ok(mut trouble) = of_errors.lock() {
                trouble.get_or_insert_with(|| match error {
                    wgpu::Error::OutOfMemory { .. } => GpuError::OutOfMemory(error.to_string()),
                    _ => GpuError::Rejected(error.to_string()),
                });
            }
        }));
        let loss = Arc::new(OnceLock::new());
        let of_loss = Arc::clone(&loss);
        device.set_device_lost_callback(move |_, cause| {
            // The first cause is the one that matters.
            of_loss.set(cause).ok();
        });
        Self {
            device,
            queue,
            info,
            uploaded_bytes: Arc::default(),
            memory,
            pipelines: Arc::default(),
            trouble,
            loss,
            is_shared,
            #[cfg(feature = "operations")]
            operations: Arc::default(),
        }
    }

    /// Which adapter this is.
    #[must_use]
    pub fn adapter(&self) -> &Adapter {
        &self.info
    }

    /// Whether stages can be timed.
    #[must_use]
    pub fn has_timestamps(&self) -> bool {
        self.device.features().contains(wgpu::Features::TIMESTAMP_QUERY)
    }

    /// Maximum bytes of a buffer that a shader can bind.
    #[must_use]
    pub fn max_binding_bytes(&self) -> u64 {
        let limits = self.device.limits();
        limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
    }

    /// Gives the device back to its driver. It then counts as lost for all its users: every later call fails.
    pub fn close(&self) {
        self.loss.set("it was closed".to_owned()).ok();
        self.device.destroy();
    }

    /// The same device with a counter of its own for uploads.
    #[must_use]
    pub fn with_own_counts(self) -> Self {
        Self { uploaded_bytes: Arc::default(), ..self }
    }

    /// Number of shader entry points that the device has compiled.
    #[must_use]
    pub fn compiled_entry_points(&self) -> usize {
        self.pipelines.count()
    }

    /// Bytes written to buffers so far, through this handle and its clones.
    #[must_use]
    pub fn uploaded_bytes(&self) -> u64 {
        self.uploaded_bytes.load(Ordering::Relaxed)
    }

    /// Takes the error that was reported since the last call, if there was one.
    ///
    /// # Errors
    /// If the device is lost; else the first error that it has reported.
    pub fn check(&self) -> Result<(), GpuError> {
        let trouble = self.trouble.lock().ok().and_then(|mut trouble| trouble.take());
        match self.loss.get() {
            Some(cause) => Err(GpuError::Lost(cause.clone())),
            None => trouble.map_or(Ok(()), Err),
        }
    }
}

/// Checks that a device has the needed limits.
fn expect_limits(adapter: &Adapter, needed: &wgpu::Limits, there: &wgpu::Limits) -> Result<(), GpuError> {
    let mut missing = Vec::new();
    needed.check_limits_with_fail_fn(there, false, |name, needed, there| {
        missing.push(format!("{name} is {there} where {needed} is needed"));
    });
    if missing.is_empty() {
        return Ok(());
    }
    Err(GpuError::Device { adapter: adapter.name.clone(), cause: missing.join(", ") })
}
