//! Contents of point caches, in their two formats.

use std::path::Path;

use glam::{DVec3, Vec3};
use umbrage_scene::Error;

use crate::folder;
use crate::memory::Budget;
use crate::origin::{FarBounds, local};

/// First bytes of PC2 files.
const MAGIC: &[u8] = b"POINTCACHE2\0";
/// Bytes of a point: three coordinates.
const POINT_BYTES: usize = 12;

/// Positions of points at some moments; there is at least one point and one moment.
#[derive(Debug)]
pub(super) struct Samples {
    /// The seconds of each sample; rising, from 0.
    times: Vec<f64>,
    points: usize,
    /// The file; numbers are decoded on use, so they are in memory only once.
    bytes: Vec<u8>,
    /// Offset of the first sample in bytes.
    start: usize,
    big_endian: bool,
    /// Origin of positions in the world, from the first sample.
    origin: DVec3,
}

/// A moment between two samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment<'a> {
    earlier: &'a [u8],
    /// The next sample and its weight, 0 to 1; `None` at a sample.
    later: Option<(&'a [u8], f32)>,
    big_endian: bool,
    origin: DVec3,
}

impl Samples {
    /// Reads a cache: in big-endian order, times in seconds (`.mdd`), or else in little-endian order, times in frames of
    /// which `fps` make a second (`.pc2`). The first sample is at second 0, regardless of the file's own time.
    ///
    /// # Errors
    /// Where the file can't be read or breaks its format, or `fps` is invalid.
    pub(super) fn read(path: &Path, fps: f64, budget: &Budget, warnings: &mut Vec<String>) -> Result<Self, Error> {
        let bytes = folder::read(path, budget).map_err(|source| Error::read(path, source))?;
        let big_endian = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("mdd"));
        let file = CacheFile { path, bytes: &bytes, big_endian };
        let header = if big_endian { file.mdd_header()? } else { file.pc2_header()? };
        let end = file.end(&header)?;
        let times = if big_endian { file.mdd_times(&header, budget)? } else { file.pc2_times(&header, fps, budget)? };
        if end < bytes.len() {
            warnings.push(format!("left out {} bytes after the last sample", bytes.len() - end));
        }
        // No more than `end`.
        let start = header.start as usize;
        let mut samples = Self { times, points: header.points, bytes, start, big_endian, origin: DVec3::ZERO };
        let first = samples.at(0.0);
        let points = (0..samples.points).map(|point| first.position(point).as_dvec3());
        samples.origin = FarBounds::origin_of(points);
        Ok(samples)
    }

    pub(super) fn origin(&self) -> DVec3 {
        self.origin
    }

    pub(super) fn points(&self) -> usize {
        self.points
    }

    pub(super) fn duration_seconds(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// The moment `seconds`, clamped to the first and last sample.
    pub(super) fn at(&self, seconds: f64) -> Moment<'_> {
        let next = self.times.partition_point(|&time| time <= seconds).max(1);
        let begin = self.times[next - 1];
        let passed = (seconds - begin).max(0.0);
        let later = self.times.get(next).filter(|_| passed > 0.0);
        let later = later.map(|end| (self.sample(next), (passed / (end - begin)) as f32));
        Moment { earlier: self.sample(next - 1), later, big_endian: self.big_endian, origin: self.origin }
    }

    fn sample(&self, index: usize) -> &[u8] {
        let length = self.points * POINT_BYTES;
        &self.bytes[self.start + index * length..][..length]
    }
}

impl Moment<'_> {
    #[inline]
    pub(super) fn position(&self, point: usize) -> Vec3 {
        let earlier = self.decoded(self.earlier, point);
        self.later.map_or(earlier, |(later, part)| earlier + (self.decoded(later, point) - earlier) * part)
    }

    #[inline]
    fn decoded(&self, sample: &[u8], point: usize) -> Vec3 {
        let bytes = &sample[point * POINT_BYTES..][..POINT_BYTES];
        let coordinate = |at: usize| float([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]], self.big_endian);
        let world = Vec3::new(coordinate(0), coordinate(4), coordinate(8));
        if self.origin == DVec3::ZERO { world } else { local(world.as_dvec3(), self.origin) }
    }
}

/// A file's header, before its samples.
#[derive(Debug)]
struct Header {
    samples: usize,
    points: usize,
    /// Offset of the samples in bytes, perhaps past the end of the file.
    start: u64,
}

/// A file while its header is read.
#[derive(Clone, Copy, Debug)]
struct CacheFile<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    big_endian: bool,
}

impl CacheFile<'_> {
    /// POINTCACHE2, version, points, first frame, frames between samples, samples.
    fn pc2_header(&self) -> Result<Header, Error> {
        if !self.bytes.starts_with(MAGIC) {
            return Err(self.wrong(0, "a PC2 file begins with `POINTCACHE2` and a zero"));
        }
        let version = self.integer(12)?;
        if version != 1 {
            return Err(self.wrong(12, format!("version {version}, where only 1 is known")));
        }
        let (points, samples) = (self.count(16, "points")?, self.count(28, "samples")?);
        Ok(Header { samples, points, start: 32 })
    }

    /// Samples, points, the time of each sample.
    fn mdd_header(&self) -> Result<Header, Error> {
        let (samples, points) = (self.count(0, "samples")?, self.count(4, "points")?);
        Ok(Header { samples, points, start: 8 + 4 * samples as u64 })
    }

    /// Offset of the end of the last sample in bytes.
    fn end(&self, header: &Header) -> Result<usize, Error> {
        let (length, sample) = (self.bytes.len() as u64, header.points as u64 * POINT_BYTES as u64);
        let end = (header.samples as u64).checked_mul(sample).and_then(|bytes| bytes.checked_add(header.start));
        end.filter(|&end| end <= length).map(|end| end as usize).ok_or_else(|| {
            let (there, all) = (length.saturating_sub(header.start) / sample, header.samples);
            let points = header.points;
            let cause = format!("the file ends here, after {there} of the {all} samples of {points} points it claims");
            self.wrong(self.bytes.len(), cause)
        })
    }

    fn pc2_times(&self, header: &Header, fps: f64, budget: &Budget) -> Result<Vec<f64>, Error> {
        if !(fps.is_finite() && fps > 0.0) {
            let cause = format!("{fps} frames a second: give a number above 0");
            return Err(Error::address(self.path.display().to_string(), cause));
        }
        let frames = f64::from(self.float(24)?);
        self.times(header, budget, |sample| Ok((24, if sample == 0 { 0.0 } else { sample as f64 * frames / fps })))
    }

    fn mdd_times(&self, header: &Header, budget: &Budget) -> Result<Vec<f64>, Error> {
        self.times(header, budget, |sample| {
            let at = 8 + 4 * sample;
            Ok((at, f64::from(self.float(at)?)))
        })
    }

    /// The times of all samples from the first one on; `time` gives the offset of each in the file, and its seconds.
    fn times(
        &self,
        header: &Header,
        budget: &Budget,
        time: impl Fn(usize) -> Result<(usize, f64), Error>,
    ) -> Result<Vec<f64>, Error> {
        let mut times = Vec::new();
        budget.reserve(&mut times, header.samples, "samples' times").map_err(|cause| self.wrong(0, cause))?;
        let (_, first) = time(0)?;
        for sample in 0..header.samples {
            let (at, seconds) = time(sample)?;
            let since = seconds - first;
            if !since.is_finite() {
                return Err(self.wrong(at, format!("sample {sample} is at {seconds} seconds, which is no moment")));
            }
            if times.last().is_some_and(|last| since <= *last) {
                return Err(self.wrong(at, format!("sample {sample} isn't later than the one before it")));
            }
            times.push(since);
        }
        Ok(times)
    }

    fn count(&self, at: usize, what: &str) -> Result<usize, Error> {
        let count = self.integer(at)?;
        let positive = usize::try_from(count).ok().filter(|&count| count > 0);
        positive.ok_or_else(|| self.wrong(at, format!("{count} {what}, where a cache has at least one")))
    }

    fn integer(&self, at: usize) -> Result<i32, Error> {
        let word = self.word(at)?;
        Ok(if self.big_endian { i32::from_be_bytes(word) } else { i32::from_le_bytes(word) })
    }

    fn float(&self, at: usize) -> Result<f32, Error> {
        Ok(float(self.word(at)?, self.big_endian))
    }

    fn word(&self, at: usize) -> Result<[u8; 4], Error> {
        let word = self.bytes.get(at..).and_then(<[u8]>::first_chunk);
        word.copied().ok_or_else(|| self.wrong(self.bytes.len(), "the file ends here, before its samples"))
    }

    fn wrong(&self, at: usize, cause: impl Into<String>) -> Error {
        Error::malformed(self.path, format!("byte {at}"), cause)
    }
}

#[inline]
fn float(word: [u8; 4], big_endian: bool) -> f32 {
    if big_endian { f32::from_be_bytes(word) } else { f32::from_le_bytes(word) }
}
