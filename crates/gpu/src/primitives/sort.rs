use super::Scan;
use crate::{Buffer, Gpu, GpuError, Groups, Kernel, Recorder};

/// The counting-sort stage: sorts keys below a number of bins, alone or with a value each. Elements with equal keys stay
/// in order.
///
/// It takes a pass over all elements for each four bits that keys have. In the grids, points and triangles are put into
/// cells by one atomic addition each instead: their order within a cell is of no account.
#[derive(Debug)]
pub struct CountingSort {
    count_digits: Kernel,
    move_keys: Kernel,
    move_pairs: Kernel,
    scan: Scan,
    /// One for each pass: all are in use in one submission.
    passes: Vec<Buffer>,
    digit_starts: Buffer,
    /// Where passes write to, and the next ones read from.
    keys: Buffer,
    values: Buffer,
    /// What stands for values where there are none: a kernel reads from one and writes to the other.
    none: [Buffer; 2],
    count: u32,
    pass_count: usize,
}

impl CountingSort {
    /// Elements that a workgroup takes.
    const PAGE: u32 = 2048;
    const DIGIT_BITS: u32 = 4;

    /// Ready to sort.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        let kernel = |entry, has_values: bool| {
            Kernel::new(gpu, "primitives::sort", entry, &[("HAS_VALUES", f64::from(u8::from(has_values)))])
        };
        let passes = u32::BITS / Self::DIGIT_BITS;
        Self {
            count_digits: kernel("sort_count", false),
            move_keys: kernel("sort_move", false),
            move_pairs: kernel("sort_move", true),
            scan: Scan::new(gpu),
            passes: (0..passes).map(|_| Buffer::uniform(gpu, "sort pass")).collect(),
            digit_starts: Buffer::storage(gpu, "sort digit starts"),
            keys: Buffer::storage(gpu, "keys to sort"),
            values: Buffer::storage(gpu, "values to sort"),
            none: [Buffer::storage(gpu, "no values"), Buffer::storage(gpu, "no sorted values")],
            count: 0,
            pass_count: 0,
        }
    }

    /// Makes ready for `count` elements with keys below `bins`, until it is called again.
    ///
    /// # Errors
    /// Where there are more elements than the device has room for.
    pub fn prepare(&mut self, gpu: &Gpu, count: u32, bins: u32) -> Result<(), GpuError> {
        let pages = count.div_ceil(Self::PAGE);
        let bits = u32::BITS - bins.saturating_sub(1).leading_zeros();
        self.count = count;
        self.pass_count = bits.div_ceil(Self::DIGIT_BITS) as usize;
        for (buffer, pass) in self.passes.iter_mut().zip(0..) {
            buffer.write(gpu, &[count, pages, pass * Self::DIGIT_BITS, 0])?;
        }
        let counts = pages << Self::DIGIT_BITS;
        self.digit_starts.reserve(gpu, 4 * u64::from(counts))?;
        self.keys.reserve(gpu, 4 * u64::from(count))?;
        self.values.reserve(gpu, 4 * u64::from(count))?;
        self.scan.prepare(gpu, counts)
    }

    /// Sorts the first elements of `keys`, each a u32, and moves those of `values` with them. Keys that are not below
    /// the number of bins may end up anywhere among them.
    pub fn record(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, keys: &Buffer, values: Option<&Buffer>) {
        let groups = Groups::Flat(self.count.div_ceil(Self::PAGE));
        let [none, none_sorted] = &self.none;
        let kernel = if values.is_some() { &self.move_pairs } else { &self.move_keys };
        // Passes go to and fro between the caller's buffers and this stage's.
        let callers = [keys, values.unwrap_or(none)];
        let own = [&self.keys, if values.is_some() { &self.values } else { none_sorted }];
        for (pass, parameters) in self.passes.iter().take(self.pass_count).enumerate() {
            let ([keys, values], [to_keys, to_values]) =
                if pass.is_multiple_of(2) { (callers, own) } else { (own, callers) };
            let buffers = [parameters, keys, values, &self.digit_starts, to_keys, to_values];
            recorder.stage("sort", |pass| {
                self.count_digits.dispatch(gpu, pass, &buffers, groups);
                self.scan.record(gpu, pass, &self.digit_starts);
                kernel.dispatch(gpu, pass, &buffers, groups);
            });
        }
        if !self.pass_count.is_multiple_of(2) && self.count > 0 {
            recorder.copy_words(&self.keys, keys, self.count.into());
            if let Some(values) = values {
                recorder.copy_words(&self.values, values, self.count.into());
            }
        }
    }
}
