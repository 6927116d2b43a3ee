use bytemuck::Pod;

use crate::{Buffer, Gpu, GpuError, platform};

/// Collects a frame's stages and the copies after them, then submits all of it at once.
#[derive(Debug)]
pub struct Recorder<'a> {
    gpu: &'a Gpu,
    encoder: wgpu::CommandEncoder,
    queries: Option<wgpu::QuerySet>,
    names: Vec<&'static str>,
    /// Copies for the CPU to read.
    fetched: Vec<wgpu::Buffer>,
}

/// Key to a fetched copy of a [`Recorder`], for its [`Done`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fetch {
    index: usize,
    bytes: usize,
}

/// A submission that is done.
#[derive(Debug)]
pub struct Done {
    /// Time of each stage, summed over stages of the same name; empty if the device has no timestamps.
    pub times: Vec<StageTime>,
    fetched: Vec<wgpu::Buffer>,
}

impl Done {
    /// Contents of a fetched copy.
    ///
    /// # Errors
    /// If the device is lost.
    ///
    /// # Panics
    /// If the key is of another [`Recorder`], or the copy isn't a whole number of `T`.
    pub fn read<T: Pod>(&self, fetch: Fetch) -> Result<Vec<T>, GpuError> {
        assert_eq!(fetch.bytes % size_of::<T>(), 0, "whole elements");
        let mut contents = vec![T::zeroed(); fetch.bytes / size_of::<T>()];
        self.read_into(fetch, &mut contents)?;
        Ok(contents)
    }

    /// As [`Done::read`], into existing memory.
    ///
    /// # Errors
    /// If the device is lost.
    ///
    /// # Panics
    /// If the key is of another [`Recorder`], or `contents` has another number of bytes.
    pub fn read_into<T: Pod>(&self, fetch: Fetch, contents: &mut [T]) -> Result<(), GpuError> {
        assert_eq!(fetch.bytes, size_of_val(contents), "as many as were fetched");
        if fetch.bytes == 0 {
            return Ok(());
        }
        let mapped = self.fetched[fetch.index].get_mapped_range(..);
        let mapped = mapped.map_err(|cause| GpuError::Lost(cause.to_string()))?;
        bytemuck::cast_slice_mut(contents).copy_from_slice(&mapped[..fetch.bytes]);
        Ok(())
    }
}

/// GPU time of a stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageTime {
    /// The stage's one name.
    pub name: &'static str,
    /// Milliseconds from its first to its last command.
    pub milliseconds: f64,
}

/// Maximum number of timed stages in one submission.
const MOST_STAGES: u32 = 256;

impl<'a> Recorder<'a> {
    /// Begins an empty submission.
    #[must_use]
    pub fn new(gpu: &'a Gpu) -> Self {
        let queries = gpu.has_timestamps().then(|| {
            gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("stages"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * MOST_STAGES,
            })
        });
        let encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") });
        Self { gpu, encoder, queries, names: Vec::new(), fetched: Vec::new() }
    }

    /// Records one stage: all dispatches of `record`, in order.
    pub fn stage(&mut self, name: &'static str, record: impl FnOnce(&mut wgpu::ComputePass<'_>)) {
        let (encoder, queries) = self.begin_stage(name);
        let timestamp_writes = queries.map(|(query_set, first)| wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        });
        let descriptor = wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes };
        record(&mut encoder.begin_compute_pass(&descriptor));
    }

    /// Begins a stage without a compute pass. Returns its encoder and, if it is timed, the query set with the index of
    /// its first query: the stage writes this query when it begins, and the next one when it ends.
    #[doc(hidden)]
    pub fn begin_stage(&mut self, name: &'static str) -> (&mut wgpu::CommandEncoder, Option<(&wgpu::QuerySet, u32)>) {
        let index = self.names.len() as u32;
        self.names.push(name);
        let queries = self.queries.as_ref().filter(|_| index < MOST_STAGES);
        (&mut self.encoder, queries.map(|queries| (queries, 2 * index)))
    }

    /// Fills a buffer with zeros.
    pub fn clear(&mut self, buffer: &Buffer) {
        self.encoder.clear_buffer(buffer.raw(), 0, None);
    }

    /// Fills a buffer's first words with zeros.
    pub fn clear_words(&mut self, buffer: &Buffer, words: u64) {
        self.encoder.clear_buffer(buffer.raw(), 0, Some(4 * words));
    }

    /// Fills `words` words of a buffer from its word `first` on with zeros.
    pub fn clear_range(&mut self, buffer: &Buffer, first: u64, words: u64) {
        self.encoder.clear_buffer(buffer.raw(), 4 * first, Some(4 * words));
    }

    /// Copies `words` words from one buffer's start to another's.
    pub fn copy_words(&mut self, from: &Buffer, to: &Buffer, words: u64) {
        self.copy_range((from, 0), (to, 0), words);
    }

    /// Copies `words` words from a word of one buffer to a word of another.
    pub fn copy_range(&mut self, (from, first): (&Buffer, u64), (to, target): (&Buffer, u64), words: u64) {
        self.encoder.copy_buffer_to_buffer(from.raw(), 4 * first, to.raw(), 4 * target, 4 * words);
    }

    /// Copies pixels of four bytes, in rows `row_pixels` apart, from a buffer to a texture's rows from `first` on.
    pub(crate) fn copy_rows(
        &mut self,
        (from, row_pixels): (&Buffer, u32),
        (to, first): (&wgpu::Texture, u32),
        [width, height]: [u32; 2],
    ) {
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * row_pixels), rows_per_image: None };
        self.encoder.copy_buffer_to_texture(
            wgpu::TexelCopyBufferInfo { buffer: from.raw(), layout },
            wgpu::TexelCopyTextureInfo {
                texture: to,
                mip_level: 0,
                origin: wgpu::Origin3d { x: 0, y: first, z: 0 },
                aspect: wgpu::TextureAspect::All,
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }

    /// Fetches the first `words` words of a buffer, as they are after the commands recorded so far.
    pub fn fetch(&mut self, buffer: &Buffer, words: u64) -> Fetch {
        self.fetch_from(buffer, 0, words)
    }

    /// Fetches `words` words of a buffer from its word `first` on.
    ///
    /// # Panics
    /// If the buffer is smaller than that.
    pub fn fetch_from(&mut self, buffer: &Buffer, first: u64, words: u64) -> Fetch {
        let (first, bytes) = (4 * first, 4 * words);
        assert!(first + bytes <= buffer.bytes(), "{} bytes of {}", first + bytes, buffer.bytes());
        if bytes == 0 {
            return Fetch::default();
        }
        let copy = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("fetched"),
            size: bytes,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.encoder.copy_buffer_to_buffer(buffer.raw(), first, &copy, 0, bytes);
        self.fetched.push(copy);
        Fetch { index: self.fetched.len() - 1, bytes: bytes as usize }
    }

    /// Submits the recorded commands. The future waits for them: natively it blocks its thread, in a browser the page
    /// goes on meanwhile.
    pub fn submit(mut self) -> impl Future<Output = Result<Done, GpuError>> + use<'a> {
        let ticks = self.fetch_ticks();
        self.gpu.queue.submit([self.encoder.finish()]);
        let Self { gpu, names, fetched, .. } = self;
        async move {
            let ticks = ticks?;
            platform::map_all(gpu, &fetched).await?;
            let mut done = Done { times: Vec::new(), fetched };
            if let Some(ticks) = ticks {
                let ticks: Vec<u64> = done.read(ticks)?;
                done.times = sum_by_name(&names, &ticks, f64::from(gpu.queue.get_timestamp_period()));
            }
            Ok(done)
        }
    }

    /// Submits the recorded commands, and waits for them.
    ///
    /// # Errors
    /// If the device is lost or has reported an error.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn submit_and_wait(self) -> Result<Done, GpuError> {
        pollster::block_on(self.submit())
    }

    /// Fetches the start and end times of stages, if the device has timestamps.
    fn fetch_ticks(&mut self) -> Result<Option<Fetch>, GpuError> {
        let count = 2 * (self.names.len() as u32).min(MOST_STAGES);
        let Some(queries) = self.queries.as_ref().filter(|_| count > 0) else { return Ok(None) };
        let mut ticks = Buffer::storage_for_queries(self.gpu);
        ticks.reserve(self.gpu, u64::from(count) * 8)?;
        self.encoder.resolve_query_set(queries, 0..count, ticks.raw(), 0);
        Ok(Some(self.fetch(&ticks, 2 * u64::from(count))))
    }
}

fn sum_by_name(names: &[&'static str], ticks: &[u64], nanoseconds_per_tick: f64) -> Vec<StageTime> {
    let mut stages: Vec<StageTime> = Vec::new();
    for (&name, ticks) in names.iter().zip(ticks.chunks_exact(2)) {
        let milliseconds = ticks[1].saturating_sub(ticks[0]) as f64 * nanoseconds_per_tick * 1e-6;
        match stages.iter_mut().find(|stage| stage.name == name) {
            Some(stage) => stage.milliseconds += milliseconds,
            None => stages.push(StageTime { name, milliseconds }),
        }
    }
    stages
}
