use glam::DVec3;
use umbrage_rays::predicate::HitPoint;
use umbrage_rays::{LightSource, Ray};

use crate::kernel::GROUPS_OF_ROW;
use crate::{Buffer, Gpu, GpuError, Recorder};

/// Rays, or questions about shadows, in a buffer on the GPU: 80 bytes each.
#[derive(Debug)]
pub struct KdRecords {
    records: Buffer,
    sizes: Buffer,
    /// What was uploaded last; kept for its memory.
    words: Vec<u32>,
}

impl KdRecords {
    /// Words of the header, as in `records.wgsl`.
    pub const HEADER: u64 = 8;
    pub(super) const WORDS: usize = 20;
    /// Where a record has the error of a ray's start, as in `records.wgsl`.
    const ERROR: usize = 18;
    const LANES: u32 = 64;
    /// The word where workgroups for records are …
    pub const GROUPS: u32 = 1;
    /// … and for packets of them.
    pub(super) const PACKETS: u32 = 4;
    /// Stands for no triangle.
    pub const NO_TRIANGLE: u32 = u32::MAX;

    /// Nothing yet.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            records: Buffer::storage(gpu, "kd-tree rays"),
            sizes: Buffer::sizes(gpu, "kd-tree rays' dispatch sizes"),
            words: Vec::new(),
        }
    }

    /// Takes over rays, each with the triangle that it goes through without hitting it, if any. `packet` is how many go
    /// together where they go in packets.
    ///
    /// # Errors
    /// Where there are more than one buffer of the device has room for.
    pub fn write_rays(
        &mut self,
        gpu: &Gpu,
        rays: impl IntoIterator<Item = (Ray, Option<u32>)>,
        packet: u32,
    ) -> Result<(), GpuError> {
        self.write(gpu, packet, rays, |words, (ray, own)| {
            let numbers = [ray.origin, ray.direction].into_iter().flat_map(|vector| vector.to_array());
            numbers.chain([ray.t_min, ray.t_max]).for_each(|number| push(words, number));
            own
        })
    }

    /// Takes over rays that start at points of triangles, each with its direction. They go through that triangle, and through
    /// all whose planes the [point is on](HitPoint::is_on), without hitting them: for a tracer of rays
    /// [from triangles](super::KdTracerOptions::from_triangles).
    ///
    /// # Errors
    /// Where there are more than one buffer of the device has room for.
    pub fn write_rays_from(
        &mut self,
        gpu: &Gpu,
        rays: impl IntoIterator<Item = (HitPoint, DVec3, u32)>,
        packet: u32,
    ) -> Result<(), GpuError> {
        self.write(gpu, packet, rays, |words, (point, direction, own)| {
            let start = words.len();
            let numbers = [point.position, direction].into_iter().flat_map(|vector| vector.to_array());
            numbers.chain([0.0, f64::INFINITY]).for_each(|number| push(words, number));
            words.resize(start + Self::ERROR, 0);
            push(words, point.error);
            Some(own)
        })
    }

    /// Takes over questions whether anything but a point's own triangle is between a light and the point.
    ///
    /// # Errors
    /// Where there are more than one buffer of the device has room for.
    pub fn write_shadows(
        &mut self,
        gpu: &Gpu,
        questions: impl IntoIterator<Item = (LightSource, HitPoint, u32)>,
        packet: u32,
    ) -> Result<(), GpuError> {
        self.write(gpu, packet, questions, |words, (light, point, own)| {
            point.position.to_array().into_iter().chain([point.error]).for_each(|number| push(words, number));
            words.extend(light_words(&light));
            Some(own)
        })
    }

    fn write<T>(
        &mut self,
        gpu: &Gpu,
        packet: u32,
        records: impl IntoIterator<Item = T>,
        push_record: impl Fn(&mut Vec<u32>, T) -> Option<u32>,
    ) -> Result<(), GpuError> {
        self.words.clear();
        self.words.resize(Self::HEADER as usize, 0);
        let mut count = 0;
        for record in records {
            let start = self.words.len();
            let own = push_record(&mut self.words, record);
            self.words.resize(start + Self::WORDS, 0);
            self.words[start + 16] = own.unwrap_or(Self::NO_TRIANGLE);
            self.words[start + 17] = count;
            count += 1;
        }
        self.words[..Self::HEADER as usize].copy_from_slice(&Self::header(count, packet));
        self.sizes.reserve(gpu, 4 * Self::HEADER)?;
        self.records.write(gpu, &self.words)
    }

    /// Makes room for `count` records that a stage writes.
    ///
    /// # Errors
    /// Where there are more than one buffer of the device has room for.
    pub fn reserve(&mut self, gpu: &Gpu, count: u32) -> Result<(), GpuError> {
        self.sizes.reserve(gpu, 4 * Self::HEADER)?;
        self.records.reserve(gpu, 4 * (Self::HEADER + Self::WORDS as u64 * u64::from(count)))
    }

    /// Says how many records there are that a stage writes or has written, and how many go together in packets.
    ///
    /// # Errors
    /// Where the device has reported an error.
    pub(crate) fn write_count(&mut self, gpu: &Gpu, count: u32, packet: u32) -> Result<(), GpuError> {
        self.records.write_at(gpu, 0, &Self::header(count, packet))
    }

    fn header(count: u32, packet: u32) -> [u32; Self::HEADER as usize] {
        let mut header = [0; Self::HEADER as usize];
        header[0] = count;
        for (word, lanes) in [(Self::GROUPS, Self::LANES), (Self::PACKETS, packet.max(1))] {
            let word = word as usize;
            header[word..word + 3].copy_from_slice(&groups(count.div_ceil(lanes)));
        }
        header
    }

    /// Lets dispatches take their sizes from what the header says now.
    pub fn record_sizes(&self, recorder: &mut Recorder<'_>) {
        recorder.copy_words(&self.records, &self.sizes, Self::HEADER);
    }

    /// What dispatches take their sizes from.
    #[must_use]
    pub fn sizes(&self) -> &Buffer {
        &self.sizes
    }

    /// Eight words with how many records there are at first, then twenty for each (`records.wgsl`).
    #[must_use]
    pub fn buffer(&self) -> &Buffer {
        &self.records
    }
}

/// Low word, high word.
fn push(words: &mut Vec<u32>, number: f64) {
    words.extend([number.to_bits() as u32, (number.to_bits() >> 32) as u32]);
}

/// The vector of a light in bits of f32, and whether it is a direction.
#[must_use]
pub fn light_words(light: &LightSource) -> [u32; 4] {
    let (vector, is_directional) = match *light {
        LightSource::Point { position } | LightSource::Spot { position, .. } => (position, 0),
        LightSource::Directional { direction } => (direction, 1),
    };
    let [x, y, z] = vector.to_array().map(f32::to_bits);
    [x, y, z, is_directional]
}

/// As in `dispatch.wgsl`.
fn groups(count: u32) -> [u32; 3] {
    [count.min(GROUPS_OF_ROW), count.div_ceil(GROUPS_OF_ROW), 1]
}
