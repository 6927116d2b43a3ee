use glam::DVec3;
use umbrage_rays::predicate::HitPoint;
use umbrage_rays::{LightSource, Ray};

use crate::kernel::GROUPS_OF_ROW;
use crate::{Buffer, Gpu, GpuError, Recorder};

/// Rays or shadow questions in a GPU buffer: 80 bytes each.
#[derive(Debug)]
pub struct RayRecords {
    records: Buffer,
    sizes: Buffer,
    /// The last uploaded words; kept to reuse the memory.
    words: Vec<u32>,
}

impl RayRecords {
    /// Words of the header, as in `records.wgsl`.
    pub const HEADER: u64 = 8;
    pub(super) const WORDS: usize = 20;
    /// Word of a record with the error of the ray's start, as in `records.wgsl`.
    const ERROR: usize = 18;
    const LANES: u32 = 64;
    /// Header word of the workgroups for records, …
    pub const GROUPS: u32 = 1;
    /// … and of those for packets of records.
    pub(super) const PACKETS: u32 = 4;
    /// The most bytes that a ray takes in one buffer: its record, and its share of a header.
    pub const RAY_BYTES: u64 = 96;
    /// Stands for no triangle.
    pub const NO_TRIANGLE: u32 = u32::MAX;

    /// Makes an empty buffer.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            records: Buffer::storage(gpu, "rays"),
            sizes: Buffer::sizes(gpu, "rays' dispatch sizes"),
            words: Vec::new(),
        }
    }

    /// Uploads rays, each with the triangle that it passes through without hitting it, if any. `packet` is the number
    /// of rays that are traced together, if packets are used.
    ///
    /// # Errors
    /// If they exceed the largest buffer of the device.
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

    /// Uploads rays that start at points of triangles, each with its direction. They pass through that triangle, and
    /// through all whose planes the [point is on](HitPoint::is_on), without hitting them: for a tracer of rays [from
    /// triangles](super::RayTracerOptions::from_triangles).
    ///
    /// # Errors
    /// If they exceed the largest buffer of the device.
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

    /// Uploads questions whether any triangle other than a point's own is between a light and the point.
    ///
    /// # Errors
    /// If they exceed the largest buffer of the device.
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

    /// Makes room for `count` records, which a stage writes.
    ///
    /// # Errors
    /// If they exceed the largest buffer of the device.
    pub fn reserve(&mut self, gpu: &Gpu, count: u32) -> Result<(), GpuError> {
        self.sizes.reserve(gpu, 4 * Self::HEADER)?;
        self.records.reserve(gpu, 4 * (Self::HEADER + Self::WORDS as u64 * u64::from(count)))
    }

    /// Writes the header for records that a stage writes or has written: their number, and the size of packets.
    ///
    /// # Errors
    /// If the device has reported an error.
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

    /// Updates the dispatch sizes from the header.
    pub fn record_sizes(&self, recorder: &mut Recorder<'_>) {
        recorder.copy_words(&self.records, &self.sizes, Self::HEADER);
    }

    /// Sizes for indirect dispatches.
    #[must_use]
    pub fn sizes(&self) -> &Buffer {
        &self.sizes
    }

    /// Eight words of header, first the number of records, then twenty for each record (`records.wgsl`).
    #[must_use]
    pub fn buffer(&self) -> &Buffer {
        &self.records
    }
}

/// Appends the low word, then the high word.
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

/// Workgroups in rows, as in `dispatch.wgsl`.
fn groups(count: u32) -> [u32; 3] {
    [count.min(GROUPS_OF_ROW), count.div_ceil(GROUPS_OF_ROW), 1]
}
