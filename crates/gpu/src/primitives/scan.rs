use crate::{Buffer, Gpu, GpuError, Groups, Kernel};

/// The prefix-sum stage: turns counts into starts.
#[derive(Debug)]
pub struct Scan {
    reduce: Kernel,
    starts: Kernel,
    spread: Kernel,
    size: Buffer,
    pages: Buffer,
    count: u32,
}

impl Scan {
    /// Values of a workgroup.
    const PAGE: u32 = 2048;

    /// Compiles the stage.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        let entries = ["scan_reduce", "scan_starts", "scan_spread"];
        let [reduce, starts, spread] = Kernel::all(gpu, "primitives::scan", entries, &[]);
        Self {
            reduce,
            starts,
            spread,
            size: Buffer::uniform(gpu, "scan size"),
            pages: Buffer::storage(gpu, "scan pages"),
            count: 0,
        }
    }

    /// Prepares for `count` values, until the next call.
    ///
    /// # Errors
    /// If they exceed the device's memory.
    pub fn prepare(&mut self, gpu: &Gpu, count: u32) -> Result<(), GpuError> {
        self.count = count;
        self.size.write(gpu, &[count, 0, 0, 0])?;
        self.pages.reserve(gpu, (u64::from(count.div_ceil(Self::PAGE)) + 1) * 4)
    }

    /// Replaces each of the first `count` values by the sum of those before it, modulo 2³².
    pub fn record(&self, gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>, values: &Buffer) {
        let pages = self.count.div_ceil(Self::PAGE);
        let buffers = [&self.size, values, &self.pages];
        self.reduce.dispatch(gpu, pass, &buffers, Groups::Flat(pages));
        self.starts.dispatch(gpu, pass, &buffers, Groups::Flat(1));
        self.spread.dispatch(gpu, pass, &buffers, Groups::Flat(pages));
    }

    /// The buffer with the sum of all values, in the word [`Scan::total_word`].
    #[must_use]
    pub fn totals(&self) -> &Buffer {
        &self.pages
    }

    /// Word of the sum of all values in [`Scan::totals`].
    #[must_use]
    pub fn total_word(&self) -> u32 {
        self.count.div_ceil(Self::PAGE)
    }
}
