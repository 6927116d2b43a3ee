//! Reads rays and their hits back, one buffer after the other: for tests and experiments.

use umbrage_rays::predicate::HitPoint;
use umbrage_rays::{Hit, LightSource, Ray};

use super::records::RayRecords;
use super::tracer::RayTracer;
use crate::{Gpu, GpuError};

impl RayRecords {
    /// Reads back the buffer's rays, with their own triangles.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn read_rays(&self, gpu: &Gpu) -> Result<Vec<(Ray, Option<u32>)>, GpuError> {
        let words: Vec<u32> = self.read(gpu)?;
        let rays = words[Self::HEADER as usize..].chunks_exact(Self::WORDS).map(|words| {
            let number = |index: usize| number(words, 2 * index);
            let vector = |index: usize| glam::DVec3::new(number(index), number(index + 1), number(index + 2));
            let ray = Ray { origin: vector(0), direction: vector(3), t_min: number(6), t_max: number(7) };
            (ray, Some(words[16]).filter(|&own| own != Self::NO_TRIANGLE))
        });
        Ok(rays.collect())
    }

    /// Reads back the buffer's shadow questions: the light, the point, and the point's triangle.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn read_shadows(&self, gpu: &Gpu) -> Result<Vec<(LightSource, HitPoint, u32)>, GpuError> {
        let words: Vec<u32> = self.read(gpu)?;
        let questions = words[Self::HEADER as usize..].chunks_exact(Self::WORDS).map(|words| {
            let number = |index: usize| number(words, 2 * index);
            let position = glam::DVec3::new(number(0), number(1), number(2));
            let vector = glam::Vec3::from_array([8, 9, 10].map(|word| f32::from_bits(words[word])));
            let light = if words[11] == 0 {
                LightSource::Point { position: vector }
            } else {
                LightSource::Directional { direction: vector }
            };
            (light, HitPoint { position, error: number(3) }, words[16])
        });
        Ok(questions.collect())
    }

    fn read(&self, gpu: &Gpu) -> Result<Vec<u32>, GpuError> {
        let count = self.buffer().read::<u32>(gpu, 1)?[0] as usize;
        self.buffer().read(gpu, Self::HEADER as usize + count * Self::WORDS)
    }
}

impl RayTracer {
    /// Reads back the first hit of each of `count` rays.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn read_hits(&self, gpu: &Gpu, count: usize) -> Result<Vec<Option<Hit>>, GpuError> {
        let words: Vec<u32> = self.hits().read(gpu, Self::HIT_WORDS * count)?;
        let hits = words.chunks_exact(Self::HIT_WORDS).map(|words| {
            let barycentric = [words[4], words[5]].map(f32::from_bits);
            let hit = Hit { t: number(words, 2), triangle: words[0], barycentric };
            (words[0] != RayRecords::NO_TRIANGLE).then_some(hit)
        });
        Ok(hits.collect())
    }

    /// Reads back whether each of `count` points is shadowed.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn read_shadows(&self, gpu: &Gpu, count: usize) -> Result<Vec<bool>, GpuError> {
        let words: Vec<[u32; 4]> = self.shadows().read(gpu, count)?;
        Ok(words.into_iter().map(|[is_blocked, ..]| is_blocked != 0).collect())
    }
}

fn number(words: &[u32], index: usize) -> f64 {
    f64::from_bits(u64::from(words[index]) | (u64::from(words[index + 1]) << 32))
}
