use std::sync::atomic::Ordering;

use bytemuck::Pod;

use crate::memory::Taken;
use crate::{Gpu, GpuError, platform};

/// Bytes of a buffer in which nothing is reserved: wgpu has no empty buffers.
const EMPTY_BYTES: u64 = 16;

/// A storage buffer that keeps its memory from frame to frame and grows when it must.
#[derive(Debug)]
pub struct Buffer {
    name: &'static str,
    buffer: wgpu::Buffer,
    usage: wgpu::BufferUsages,
    /// The share of the memory budget; `None` while the buffer is empty.
    taken: Option<Taken>,
}

impl Buffer {
    const STORAGE: wgpu::BufferUsages = wgpu::BufferUsages::STORAGE
        .union(wgpu::BufferUsages::COPY_SRC)
        .union(wgpu::BufferUsages::COPY_DST)
        .union(wgpu::BufferUsages::UNIFORM);
    const SIZES: wgpu::BufferUsages = wgpu::BufferUsages::INDIRECT.union(wgpu::BufferUsages::COPY_DST);
    const UNIFORM: wgpu::BufferUsages = wgpu::BufferUsages::UNIFORM.union(wgpu::BufferUsages::COPY_DST);

    /// An empty buffer that shaders can read and write.
    #[must_use]
    pub fn storage(gpu: &Gpu, name: &'static str) -> Self {
        Self::with_usage(gpu, name, Self::STORAGE)
    }

    /// An empty buffer of parameters that shaders can read.
    #[must_use]
    pub fn uniform(gpu: &Gpu, name: &'static str) -> Self {
        Self::with_usage(gpu, name, Self::UNIFORM)
    }

    /// An empty buffer for the sizes of indirect dispatches. They are copied to it, because a dispatch can't take its
    /// size from a buffer that it writes.
    #[must_use]
    pub fn sizes(gpu: &Gpu, name: &'static str) -> Self {
        Self::with_usage(gpu, name, Self::SIZES)
    }

    pub(crate) fn storage_for_queries(gpu: &Gpu) -> Self {
        Self::with_usage(gpu, "stage times", wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC)
    }

    fn with_usage(gpu: &Gpu, name: &'static str, usage: wgpu::BufferUsages) -> Self {
        Self { name, buffer: create(gpu, name, EMPTY_BYTES, usage), usage, taken: None }
    }

    /// Makes room for `bytes` bytes. A buffer that has less is made anew and loses its contents.
    ///
    /// # Errors
    /// If that is more than the device allows in one buffer, or than it has left. The buffer is empty then.
    pub fn reserve(&mut self, gpu: &Gpu, bytes: u64) -> Result<(), GpuError> {
        let limit = gpu.max_binding_bytes();
        if bytes > limit {
            return Err(GpuError::TooLarge { what: self.name.to_owned(), bytes, limit });
        }
        if bytes > self.buffer.size() {
            // Released first: the device may not have room for both.
            self.buffer.destroy();
            self.taken = None;
            let room = bytes.next_multiple_of(16).min(limit);
            self.taken = gpu.memory.take(room);
            let memory = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
            self.buffer = create(gpu, self.name, if self.taken.is_some() { room } else { EMPTY_BYTES }, self.usage);
            let is_refused = platform::is_refused(memory);
            if is_refused || self.taken.is_none() {
                // A buffer that the driver has refused still reports its size.
                self.buffer = create(gpu, self.name, EMPTY_BYTES, self.usage);
                self.taken = None;
                let taken = gpu.memory.taken();
                let what = format!("{} needs {room} bytes, beside {taken} bytes of everything else", self.name);
                return Err(GpuError::OutOfMemory(what));
            }
        }
        Ok(())
    }

    /// Makes room for the bytes that a frame turned out to need. If the buffer must grow, it grows to one and a half
    /// times that, to spare the next frame.
    ///
    /// # Errors
    /// As [`Buffer::reserve`].
    pub(crate) fn grow(&mut self, gpu: &Gpu, bytes: u64) -> Result<(), GpuError> {
        if bytes <= self.bytes() {
            return Ok(());
        }
        self.reserve(gpu, (bytes + bytes / 2).min(gpu.max_binding_bytes()).max(bytes))
    }

    /// Replaces the buffer's contents from its start, and grows the buffer if it must.
    ///
    /// # Errors
    /// If `contents` are more than the device allows in one buffer.
    pub fn write<T: Pod>(&mut self, gpu: &Gpu, contents: &[T]) -> Result<(), GpuError> {
        let bytes: &[u8] = bytemuck::cast_slice(contents);
        self.reserve(gpu, bytes.len() as u64)?;
        self.upload(gpu, 0, bytes);
        Ok(())
    }

    /// Replaces the buffer's contents from the byte `first_byte` on, a multiple of four.
    ///
    /// # Errors
    /// If that reaches beyond the reserved bytes.
    pub fn write_at<T: Pod>(&self, gpu: &Gpu, first_byte: u64, contents: &[T]) -> Result<(), GpuError> {
        let bytes: &[u8] = bytemuck::cast_slice(contents);
        let (end, limit) = (first_byte + bytes.len() as u64, self.bytes());
        if end > limit {
            return Err(GpuError::TooLarge { what: self.name.to_owned(), bytes: end, limit });
        }
        self.upload(gpu, first_byte, bytes);
        Ok(())
    }

    fn upload(&self, gpu: &Gpu, first_byte: u64, bytes: &[u8]) {
        if !bytes.is_empty() {
            gpu.queue.write_buffer(&self.buffer, first_byte, bytes);
            gpu.uploaded_bytes.fetch_add(bytes.len() as u64, Ordering::Relaxed);
        }
    }

    /// Waits for all submitted work, then returns the first `len` elements, each a whole number of words. During a
    /// frame, [`Recorder::fetch`](crate::Recorder::fetch) is better.
    ///
    /// # Errors
    /// If the device is lost or has reported an error.
    ///
    /// # Panics
    /// If the buffer is smaller than that.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read<T: Pod>(&self, gpu: &Gpu, len: usize) -> Result<Vec<T>, GpuError> {
        let mut recorder = crate::Recorder::new(gpu);
        let fetch = recorder.fetch(self, (len * size_of::<T>() / 4) as u64);
        recorder.submit_and_wait()?.read(fetch)
    }

    /// Number of bytes that it has room for.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.buffer.size()
    }

    #[doc(hidden)]
    #[must_use]
    pub fn raw(&self) -> &wgpu::Buffer {
        &self.buffer
    }
}

fn create(gpu: &Gpu, name: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor { label: Some(name), size, usage, mapped_at_creation: false })
}
