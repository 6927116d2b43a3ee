use umbrage_rays::{Omitted, OmittedKind};

use crate::{Buffer, Done, Fetch, Geometry, Gpu, GpuError, Groups, Kernel, Recorder};

/// The stage `omit`: counts triangles that no ray can hit, for scenes whose positions only the GPU knows.
#[derive(Debug)]
pub struct Omit {
    kernel: Kernel,
    size: Buffer,
    omitted: Buffer,
    fetch: Fetch,
    triangles: u32,
}

impl Omit {
    /// Triangles of a workgroup.
    const WIDTH: u32 = 64;
    /// Words for each reason: the number of triangles, then the complements of the lowest ids.
    const WORDS: usize = 1 + OmittedKind::IDS;
    /// Reasons to omit a triangle.
    const KINDS: usize = 3;

    /// Compiles the stage.
    ///
    /// # Errors
    /// If the device has no room for a few words.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let mut omitted = Buffer::storage(gpu, "omitted triangles");
        omitted.reserve(gpu, (Self::KINDS * Self::WORDS * 4) as u64)?;
        let (kernel, size) = (Kernel::new(gpu, "omit", "omit", &[]), Buffer::uniform(gpu, "omit size"));
        Ok(Self { kernel, size, omitted, fetch: Fetch::default(), triangles: 0 })
    }

    /// Prepares for the triangles of `geometry`, until the next call.
    ///
    /// # Errors
    /// If the device has no room for a few words.
    pub fn prepare(&mut self, gpu: &Gpu, geometry: &Geometry) -> Result<(), GpuError> {
        self.triangles = geometry.triangle_count();
        self.size.write(gpu, &[self.triangles, geometry.vertex_count(), 0, 0])
    }

    /// Records the stage.
    pub fn record(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, geometry: &Geometry) {
        recorder.clear(&self.omitted);
        recorder.stage("omit", |pass| {
            let buffers = [&self.size, geometry.positions(), geometry.triangles(), &self.omitted];
            self.kernel.dispatch(gpu, pass, &buffers, Groups::Flat(self.triangles.div_ceil(Self::WIDTH)));
        });
        self.fetch = recorder.fetch(&self.omitted, (Self::KINDS * Self::WORDS) as u64);
    }

    /// The triangles that a finished stage has counted.
    ///
    /// # Errors
    /// If the device is lost.
    ///
    /// # Panics
    /// If `done` doesn't contain the stage.
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
