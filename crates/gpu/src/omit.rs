use umbrage_rays::{Omitted, OmittedKind};

use crate::{Buffer, Done, Fetch, Geometry, Gpu, GpuError, Groups, Kernel, Recorder};

/// The stage `omit`: which triangles no ray can hit, for scenes whose positions only the GPU knows.
#[derive(Debug)]
pub struct Omit {
    kernel: Kernel,
    size: Buffer,
    omitted: Buffer,
    fetch: Fetch,
    triangles: u32,
}

impl Omit {
    /// Triangles that a workgroup takes.
    const WIDTH: u32 = 64;
    /// The number of triangles, then the complements of the first ids.
    const WORDS: usize = 1 + OmittedKind::IDS;
    /// Reasons to omit a triangle.
    const KINDS: usize = 3;

    /// Ready to count.
    ///
    /// # Errors
    /// Where the device has no room for a few words.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let mut omitted = Buffer::storage(gpu, "omitted triangles");
        omitted.reserve(gpu, (Self::KINDS * Self::WORDS * 4) as u64)?;
        let (kernel, size) = (Kernel::new(gpu, "omit", "omit", &[]), Buffer::uniform(gpu, "omit size"));
        Ok(Self { kernel, size, omitted, fetch: Fetch::default(), triangles: 0 })
    }

    /// Makes ready for the triangles of `geometry`, until it is called again.
    ///
    /// # Errors
    /// Where the device has no room for a few words.
    pub fn prepare(&mut self, gpu: &Gpu, geometry: &Geometry) -> Result<(), GpuError> {
        self.triangles = geometry.triangle_count();
        self.size.write(gpu, &[self.triangles, geometry.vertex_count(), 0, 0])
    }

    /// Counts them.
    pub fn record(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, geometry: &Geometry) {
        recorder.clear(&self.omitted);
        recorder.stage("omit", |pass| {
            let buffers = [&self.size, geometry.positions(), geometry.triangles(), &self.omitted];
            self.kernel.dispatch(gpu, pass, &buffers, Groups::Flat(self.triangles.div_ceil(Self::WIDTH)));
        });
        self.fetch = recorder.fetch(&self.omitted, (Self::KINDS * Self::WORDS) as u64);
    }

    /// What the stage found that is done.
    ///
    /// # Errors
    /// Where the device is lost.
    ///
    /// # Panics
    /// If the stage isn't in what is done.
    pub fn omitted(&self, done: &Done) -> Result<Omitted, GpuError> {
        let words: Vec<u32> = done.read(self.fetch)?;
        let kind = |index: usize| {
            let words = &words[index * Self::WORDS..][..Self::WORDS];
            let ids = words[1..].iter().take(words[0] as usize);
            OmittedKind { count: words[0], first_ids: ids.map(|complement| !complement).collect() }
        };
        Ok(Omitted { not_finite: kind(0), zero_area: kind(1), index_out_of_range: kind(2) })
    }
}
