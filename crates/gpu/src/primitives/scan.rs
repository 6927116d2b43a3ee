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
    /// Values that a workgroup takes.
    const PAGE: u32 = 2048;

    /// Ready to scan.
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

    /// Makes ready for `count` values, until it is called again.
    ///
    /// # Errors
    /// Where there are more than the device has room for.
    pub fn prepare(&mut self, gpu: &Gpu, count: u32) -> Result<(), GpuError> {
        self.count = count;
        self.size.write(gpu, &[count, 0, 0, 0])?;
        self.pages.reserve(gpu, (u64::from(count.div_ceil(Self::PAGE)) + 1) * 4)
    }

    /// Replaces each of the first values by the sum of those before it, modulo 2³².
    pub fn record(&self, gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>, values: &Buffer) {
        let pages = self.count.div_ceil(Self::PAGE);
        let buffers = [&self.size, values, &self.pages];
        self.reduce.dispatch(gpu, pass, &buffers, Groups::Flat(pages));
        self.starts.dispatch(gpu, pass, &buffers, Groups::Flat(1));
        self.spread.dispatch(gpu, pass, &buffers, Groups::Flat(pages));
    }

    /// Holds the sum of all values, in the word at [`Scan::total_word`].
    #[must_use]
    pub fn totals(&self) -> &Buffer {
        &self.pages
    }

    /// Where the sum of all values is in [`Scan::totals`].
    #[must_use]
    pub fn total_word(&self) -> u32 {
        self.count.div_ceil(Self::PAGE)
    }
}
