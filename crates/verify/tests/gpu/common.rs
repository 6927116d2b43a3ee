//! The machine's adapter, and the devices and renderers that tests share.

use std::fmt::Display;
use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;

use umbrage::Renderer;
use umbrage::gpu::{Adapter, DeviceLimits, Gpu, GpuError, wgpu};

/// A device, for stages and for wgpu's own commands.
pub(crate) struct Device {
    pub(crate) gpu: Gpu,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
}

impl Device {
    /// On the machine's adapter, opened as a window would open it.
    fn open(limits: DeviceLimits) -> Result<Self, GpuError> {
        let adapter = find_adapter()?;
        let descriptor = Gpu::descriptor(&adapter, limits)?;
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).expect("a device");
        Ok(Self { gpu: Gpu::of_device(&adapter, device.clone(), queue.clone())?, device, queue })
    }
}

/// The default adapter.
fn find_adapter() -> Result<wgpu::Adapter, GpuError> {
    let expected = Adapter::find("")?;
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let all = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    Ok(all.into_iter().find(|adapter| Adapter::of(adapter) == expected).expect("it was there before"))
}

/// Reports a missing adapter on standard error, so that the checks count it.
fn expect_adapter<T, E: Display>(found: Result<T, E>) -> Option<T> {
    found.map_err(|error| eprintln!("skipped-gpu: {error}")).ok()
}

/// The machine's adapter in wgpu's form, to open devices as a window does. `None` without one.
pub(crate) fn adapter() -> Option<wgpu::Adapter> {
    expect_adapter(find_adapter())
}

/// A device for one test that loses it or needs special limits. `None` without an adapter.
pub(crate) fn open(limits: DeviceLimits) -> Option<Gpu> {
    expect_adapter(Gpu::open("", limits))
}

/// The device of all other tests, with portable limits: it compiles each kernel once. `None` without an adapter.
pub(crate) fn device() -> Option<&'static Device> {
    static DEVICE: OnceLock<Result<Device, GpuError>> = OnceLock::new();
    expect_adapter(DEVICE.get_or_init(|| Device::open(DeviceLimits::Portable)).as_ref())
}

/// The shared device with buffers of a megabyte at most.
pub(crate) fn small_device() -> Option<&'static Device> {
    static DEVICE: OnceLock<Result<Device, GpuError>> = OnceLock::new();
    expect_adapter(DEVICE.get_or_init(|| Device::open(DeviceLimits::Buffers(1 << 20))).as_ref())
}

/// The shared device, to run stages on.
pub(crate) fn gpu() -> Option<Gpu> {
    device().map(|device| device.gpu.clone())
}

/// Objects for tests to use in turn, one for each test that runs at the same time.
pub(crate) struct Pool<T>(Mutex<Vec<T>>);

/// An object of a pool, returned when it is dropped.
pub(crate) struct Pooled<T: 'static> {
    pool: &'static Pool<T>,
    /// `None` once it is dropped.
    object: Option<T>,
}

impl<T> Pool<T> {
    pub(crate) const fn new() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    /// An object that no test uses, or a new one.
    pub(crate) fn take(&'static self, make: impl FnOnce() -> T) -> Pooled<T> {
        let unused = self.lock().pop();
        Pooled { pool: self, object: Some(unused.unwrap_or_else(make)) }
    }

    fn lock(&self) -> MutexGuard<'_, Vec<T>> {
        // No code panics while it holds the lock.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T> Deref for Pooled<T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.object.as_ref().expect("it isn't dropped")
    }
}

impl<T> DerefMut for Pooled<T> {
    fn deref_mut(&mut self) -> &mut T {
        self.object.as_mut().expect("it isn't dropped")
    }
}

impl<T> Drop for Pooled<T> {
    fn drop(&mut self) {
        // A failed test leaves nothing for the next one.
        if !thread::panicking() {
            self.pool.lock().extend(self.object.take());
        }
    }
}

fn new_renderer(device: &Device) -> Renderer {
    Renderer::with_gpu(device.gpu.clone()).expect("room for fixed tables")
}

/// A renderer on the shared device.
pub(crate) fn renderer() -> Option<Pooled<Renderer>> {
    static RENDERERS: Pool<Renderer> = Pool::new();
    device().map(|device| RENDERERS.take(|| new_renderer(device)))
}

/// A renderer whose buffers have a megabyte at most.
pub(crate) fn small_renderer() -> Option<Pooled<Renderer>> {
    static RENDERERS: Pool<Renderer> = Pool::new();
    small_device().map(|device| RENDERERS.take(|| new_renderer(device)))
}
