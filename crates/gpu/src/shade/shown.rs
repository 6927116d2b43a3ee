use umbrage_rays::TileOrder;

use crate::{Buffer, Done, Fetch, Gpu, GpuError, Groups, Kernel, Recorder};

/// The stage `shown`: counts the pixels that show a triangle, for callers that don't fetch them.
#[derive(Debug)]
pub struct Shown {
    kernel: Kernel,
    size: Buffer,
    count: Buffer,
    fetch: Fetch,
    slots: u32,
}

impl Shown {
    /// Slots of a workgroup.
    const WIDTH: u32 = 64;

    /// Compiles the stage.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            kernel: Kernel::new(gpu, "shade::shown", "shown", &[]),
            size: Buffer::uniform(gpu, "size"),
            count: Buffer::storage(gpu, "shown"),
            fetch: Fetch::default(),
            slots: 0,
        }
    }

    /// Prepares for an image of this many pixels, until the next call.
    ///
    /// # Errors
    /// If the device has reported an error.
    pub fn prepare(&mut self, gpu: &Gpu, [width, height]: [u32; 2]) -> Result<(), GpuError> {
        self.slots = TileOrder::new(width, height).slots() as u32;
        self.size.write(gpu, &[width, height, 0, 0])?;
        self.count.reserve(gpu, 4)
    }

    /// Counts the slots of `seen` that are pixels and hold a triangle.
    pub fn record(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, seen: &Buffer) {
        recorder.clear_words(&self.count, 1);
        let groups = Groups::Flat(self.slots / Self::WIDTH);
        recorder.stage("shown", |pass| self.kernel.dispatch(gpu, pass, &[&self.size, seen, &self.count], groups));
        self.fetch = recorder.fetch(&self.count, 1);
    }

    /// The count of a finished stage.
    ///
    /// # Errors
    /// If the device is lost or has reported an error.
    pub fn read(&self, done: &Done) -> Result<u32, GpuError> {
        let mut count = [0];
        done.read_into(self.fetch, &mut count)?;
        Ok(count[0])
    }
}
