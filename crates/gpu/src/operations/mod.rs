//! Work of kernels: operations and bytes, counted while they run, on any device.
//!
//! Unlike times, counts are the same on every machine, so they predict the work of a GPU that isn't at hand. Every
//! kernel is compiled with counters in each of its blocks, which makes it slower and changes no answer.

mod cost;
mod instrument;

use std::sync::{Mutex, MutexGuard, PoisonError};

use instrument::instrument;

use crate::{Buffer, DeviceLimits, Gpu, GpuError, Recorder, platform};

/// Counts of a kernel, over all its invocations.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct KernelOperations {
    /// The module's path and the entry point, such as `camera::trace::trace`.
    pub kernel: String,
    /// Number of dispatches.
    pub dispatches: u64,
    /// Invocations, including those without work.
    pub invocations: u64,
    /// Operations on f32, counted for each component; includes comparisons. Divisions, roots and transcendental
    /// functions count as 8.
    pub floats: u64,
    /// Operations on integers and booleans, counted for each component; conversions, computed indices and branches. A
    /// division counts as 20.
    pub integers: u64,
    /// Loads and stores of up to 16 bytes, and atomics, in buffers.
    pub accesses: u64,
    /// The same in workgroup memory.
    pub shared: u64,
    /// Bytes loaded from storage buffers, counted at each load.
    pub bytes_read: u64,
    /// Bytes stored to storage buffers.
    pub bytes_written: u64,
    /// `floats` and `integers` of the busiest of each 32 invocations, which most GPUs run together, times 32. If their
    /// branches diverge, a GPU waits longer than that.
    pub lockstep: u64,
}

/// The counters of all kernels of a device.
#[derive(Debug, Default)]
pub(crate) struct Operations {
    /// `None` unless kernels are counted.
    kernels: Mutex<Option<Vec<Counted>>>,
}

#[derive(Debug)]
struct Counted {
    kernel: String,
    dispatches: u64,
    sums: Buffer,
}

/// Counters of a kernel: see `counters.wgsl`.
const COUNTERS: usize = 8;

/// A kernel's counters, which all its dispatches bind.
#[derive(Debug)]
pub(crate) struct Counter {
    index: usize,
    group: wgpu::BindGroup,
}

impl Counter {
    /// Makes the counters of a new kernel.
    pub(crate) fn new(gpu: &Gpu, kernel: String, layout: &wgpu::BindGroupLayout) -> Self {
        let mut sums = Buffer::storage(gpu, "counted operations");
        sums.reserve(gpu, 8 * COUNTERS as u64).expect("some bytes");
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("counted operations"),
            layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: sums.raw().as_entire_binding() }],
        });
        let mut kernels = gpu.operations.lock();
        let kernels = kernels.get_or_insert_default();
        kernels.push(Counted { kernel, dispatches: 0, sums });
        Self { index: kernels.len() - 1, group }
    }

    /// Binds the counters for a dispatch.
    pub(crate) fn bind(&self, gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>) {
        pass.set_bind_group(1, &self.group, &[]);
        if let Some(kernels) = gpu.operations.lock().as_mut() {
            kernels[self.index].dispatches += 1;
        }
    }
}

impl Gpu {
    /// As [`Gpu::open`], for a device whose kernels count their operations.
    ///
    /// # Errors
    /// As [`Gpu::open`]. If kernels can't bind one buffer more than the portable eight, the first frame fails.
    pub fn open_counting(name: &str) -> Result<Self, GpuError> {
        let (info, adapter) = platform::choose(name)?;
        let mut descriptor = Self::descriptor(&adapter, DeviceLimits::Adapter)?;
        descriptor.required_limits.max_storage_buffers_per_shader_stage =
            adapter.limits().max_storage_buffers_per_shader_stage;
        let gpu = pollster::block_on(Self::open_as(&descriptor, info, &adapter, u64::MAX))?;
        *gpu.operations.lock() = Some(Vec::new());
        Ok(gpu)
    }

    /// Takes the counts of all kernels since the last call; kernels without any are left out.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn take_operations(&self) -> Result<Vec<KernelOperations>, GpuError> {
        let mut kernels = self.operations.lock();
        let kernels = kernels.as_mut().map_or(&mut [][..], Vec::as_mut_slice);
        let mut recorder = Recorder::new(self);
        let fetched: Vec<_> = kernels.iter().map(|kernel| recorder.fetch(&kernel.sums, 2 * COUNTERS as u64)).collect();
        kernels.iter().for_each(|kernel| recorder.clear(&kernel.sums));
        let done = recorder.submit_and_wait()?;
        let mut all = Vec::new();
        for (kernel, fetched) in kernels.iter_mut().zip(fetched) {
            let sums: Vec<u64> = done.read(fetched)?;
            let [invocations, floats, integers, accesses, shared, bytes_read, bytes_written, lockstep] = sums[..]
            else {
                unreachable!("as many as were fetched")
            };
            all.push(KernelOperations {
                kernel: kernel.kernel.clone(),
                dispatches: std::mem::take(&mut kernel.dispatches),
                invocations,
                floats,
                integers,
                accesses,
                shared,
                bytes_read,
                bytes_written,
                lockstep,
            });
        }
        all.retain(|kernel| kernel.invocations > 0);
        Ok(all)
    }
}

impl Operations {
    fn lock(&self) -> MutexGuard<'_, Option<Vec<Counted>>> {
        // No code panics while it holds the lock.
        self.kernels.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The shader with counters, if the device counts.
    pub(crate) fn instrumented(&self, text: &str) -> Option<naga::Module> {
        self.lock().is_some().then(|| instrument(text))
    }
}
