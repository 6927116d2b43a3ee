use super::Scan;
use crate::{Buffer, Gpu, GpuError, Groups, Kernel, Recorder};

/// The compaction stage: keeps the elements whose flags are set, in order.
///
/// The grids keep what they leave open by one atomic addition each instead, as its order is of no account there.
#[derive(Debug)]
pub struct Compaction {
    mark: Kernel,
    keep: Kernel,
    count_kept: Kernel,
    scan: Scan,
    size: Buffer,
    starts: Buffer,
    kept_count: Buffer,
    sizes: Buffer,
    count: u32,
}

impl Compaction {
    /// Words of the number of kept elements and of the groups that take them.
    const COUNT_WORDS: u64 = 4;

    /// Ready to compact.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        let kernel = |entry| Kernel::new(gpu, "primitives::compact", entry, &[]);
        Self {
            mark: kernel("compact_mark"),
            keep: kernel("compact_keep"),
            count_kept: kernel("compact_count"),
            scan: Scan::new(gpu),
            size: Buffer::uniform(gpu, "compaction size"),
            starts: Buffer::storage(gpu, "starts of kept elements"),
            kept_count: Buffer::storage(gpu, "number of kept elements"),
            sizes: Buffer::sizes(gpu, "kept elements' dispatch sizes"),
            count: 0,
        }
    }

    /// Makes ready for `count` elements, until it is called again, of which a workgroup of the next stage takes
    /// `per_group`, one or more.
    ///
    /// # Errors
    /// Where there are more elements than the device has room for.
    pub fn prepare(&mut self, gpu: &Gpu, count: u32, per_group: u32) -> Result<(), GpuError> {
        self.count = count;
        self.scan.prepare(gpu, count)?;
        self.size.write(gpu, &[count, self.scan.total_word(), per_group.max(1), 0])?;
        self.starts.reserve(gpu, 4 * u64::from(count))
    }

    /// Copies those of the first `elements`, a u32 each, whose u32 among `flags` isn't zero to the start of `kept`,
    /// which has room for as many as there are.
    pub fn record(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, flags: &Buffer, elements: &Buffer, kept: &Buffer) {
        let groups = Groups::Flat(self.count.div_ceil(256));
        let buffers = [&self.size, flags, elements, &self.starts, self.scan.totals(), kept, &self.kept_count];
        recorder.stage("compact", |pass| {
            self.mark.dispatch(gpu, pass, &buffers, groups);
            self.scan.record(gpu, pass, &self.starts);
            self.keep.dispatch(gpu, pass, &buffers, groups);
            self.count_kept.dispatch(gpu, pass, &buffers, Groups::Flat(1));
        });
        recorder.copy_words(&self.kept_count, &self.sizes, Self::COUNT_WORDS);
    }

    /// Holds in its first word how many elements are kept.
    #[must_use]
    pub fn kept_count(&self) -> &Buffer {
        &self.kept_count
    }

    /// The workgroups that take all kept elements.
    #[must_use]
    pub fn groups(&self) -> Groups<'_> {
        Groups::Indirect(&self.sizes, 1)
    }
}
