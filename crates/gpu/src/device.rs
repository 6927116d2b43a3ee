use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

use crate::GpuError;
use crate::memory::Memory;

/// A GPU that is ready to work. Clones are the same device.
#[derive(Clone, Debug)]
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    info: Adapter,
    pub(crate) uploaded_bytes: Arc<AtomicU64>,
    pub(crate) memory: Arc<Memory>,
    /// The first thing that went wrong, until it is asked for.
    trouble: Arc<Mutex<Option<GpuError>>>,
    /// Why the device is lost, if it is: from then on it answers anything with errors of any kind.
    loss: Arc<OnceLock<String>>,
}

/// What is known about an adapter without opening it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adapter {
    /// The device's name, as its driver says it.
    pub name: String,
    /// The driver and its version.
    pub driver: String,
    /// Vulkan, Metal, Dx12 …
    pub backend: String,
    /// Whether it is a program on the CPU rather than a GPU.
    pub is_software: bool,
}

/// How much of what the adapter can do is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DeviceLimits {
    /// As large buffers as the adapter has.
    #[default]
    Adapter,
    /// What every device has: bindings of 128 MiB, buffers of 256 MiB.
    Portable,
    /// Buffers of at most so many bytes, fewer than every device has.
    Buffers(u32),
    /// As large buffers as the adapter has, but all of them together at most so many bytes.
    Memory(u64),
}

impl Adapter {
    /// All adapters of this machine, GPUs before software, in an order of the driver's otherwise.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let mut all: Vec<_> = enumerate().iter().map(Self::of).collect();
        all.sort_by_key(|adapter| adapter.is_software);
        all
    }

    fn of(adapter: &wgpu::Adapter) -> Self {
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
    /// Opens the first adapter whose name contains `name`, whatever the case; the first GPU, or else the first software
    /// adapter, where `name` is empty.
    ///
    /// # Errors
    /// Where there is no such adapter, or it can't be opened.
    pub fn open(name: &str, limits: DeviceLimits) -> Result<Self, GpuError> {
        let wanted = name.to_lowercase();
        let mut found: Vec<_> = enumerate().into_iter().map(|adapter| (Adapter::of(&adapter), adapter)).collect();
        found.sort_by_key(|(info, _)| info.is_software);
        let names = found.iter().map(|(info, _)| info.name.clone()).collect::<Vec<_>>().join(", ");
        let chosen = found.into_iter().find(|(info, _)| info.name.to_lowercase().contains(&wanted));
        let Some((info, adapter)) = chosen else {
            return Err(GpuError::NoAdapter(if names.is_empty() {
                "was found: install a Vulkan driver (on Debian, mesa-vulkan-drivers has one in software)".to_owned()
            } else {
                format!("has \"{name}\" in its name; there is {names}")
            }));
        };
        Self::open_adapter(info, &adapter, limits)
    }

    fn open_adapter(info: Adapter, adapter: &wgpu::Adapter, limits: DeviceLimits) -> Result<Self, GpuError> {
        let has = adapter.limits();
        let mut required_limits = wgpu::Limits::default();
        let (buffer, binding) = match limits {
            DeviceLimits::Adapter | DeviceLimits::Memory(_) => {
                (has.max_buffer_size, has.max_storage_buffer_binding_size)
            }
            DeviceLimits::Portable => {
                (required_limits.max_buffer_size, required_limits.max_storage_buffer_binding_size)
            }
            DeviceLimits::Buffers(bytes) => (bytes.into(), bytes.into()),
        };
        required_limits.max_buffer_size = buffer;
        required_limits.max_storage_buffer_binding_size = binding;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("umbrage"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|cause| GpuError::Device { adapter: info.name.clone(), cause: cause.to_string() })?;
        let memory = Memory::with_limit(match limits {
            DeviceLimits::Memory(bytes) => bytes,
            DeviceLimits::Adapter | DeviceLimits::Portable | DeviceLimits::Buffers(_) => u64::MAX,
        });
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
        Ok(Self { device, queue, info, uploaded_bytes: Arc::default(), memory, trouble, loss })
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

    /// The most bytes that a shader can see of one buffer.
    #[must_use]
    pub fn max_binding_bytes(&self) -> u64 {
        let limits = self.device.limits();
        limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
    }

    /// Gives the device back to its driver. From then on it is as lost: whatever it is asked for is an error.
    pub fn close(&self) {
        self.loss.set("it was closed".to_owned()).ok();
        self.device.destroy();
    }

    /// Bytes that were written to buffers so far.
    #[must_use]
    pub fn uploaded_bytes(&self) -> u64 {
        self.uploaded_bytes.load(Ordering::Relaxed)
    }

    /// Bytes of all buffers on the device.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        self.memory.taken()
    }

    /// What went wrong since this was last asked.
    ///
    /// # Errors
    /// Where the device is lost; else the first of the errors that it has reported.
    pub fn check(&self) -> Result<(), GpuError> {
        let trouble = self.trouble.lock().ok().and_then(|mut trouble| trouble.take());
        match self.loss.get() {
            Some(cause) => Err(GpuError::Lost(cause.clone())),
            None => trouble.map_or(Ok(()), Err),
        }
    }

    /// Waits until all that was submitted is done.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn wait(&self) -> Result<(), GpuError> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|cause| GpuError::Lost(cause.to_string()))
            .and_then(|_| self.check())
    }
}

fn enumerate() -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    // Counts of indirect dispatches come from our own stages, which keep to the limits.
    descriptor.flags = wgpu::InstanceFlags::empty();
    if cfg!(debug_assertions) {
        descriptor.flags |= wgpu::InstanceFlags::DEBUG;
    }
    let instance = wgpu::Instance::new(descriptor);
    pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY))
}
