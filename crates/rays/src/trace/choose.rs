use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::Trace;
use crate::Ray;
use crate::parallel::Parallel;
use crate::simd::lanes::bits_of;

/// The structure that answered a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TracedBy {
    /// [`Scanner`](crate::Scanner).
    Scanner,
    /// [`Bvh`](crate::Bvh).
    Hierarchy,
}

crate::choices! { TracedBy, "structure for any rays":
    "scanner" => Scanner, "is built in no time, and answers rays from one origin together";
    "hierarchy" => Hierarchy, "takes a while to build, and answers every ray alone";
}

/// The inputs of the choice that are known before rays are read.
pub(super) struct Costs {
    pub(super) triangles: usize,
    pub(super) rays: usize,
    pub(super) is_scanner_built: bool,
    pub(super) is_hierarchy_built: bool,
}

/// Costs in nanoseconds on two threads of an Intel Xeon with AVX-512, in `demo:cloth` of 9,971 and 1,000,308 triangles
/// (`umbrage-bench trace`), with the time that it takes to read rays for the scanner (20 each) and to sort those that are
/// others than in the last call (15). Measured times there, build + query in milliseconds, for scanner and hierarchy:
///
/// | triangles | rays | of each origin | scanner | hierarchy |
/// |---|---|---|---|---|
/// | 9,971 | 1,000 | 1 | 0.10 + 0.80 | 0.36 + 0.27 |
/// | 9,971 | 1,000 | 1,000 | 0.06 + 0.31 | 0.19 + 0.29 |
/// | 9,971 | 30,000 | 30,000 | 0.09 + 1.1 | 0.22 + 2.2 |
/// | 9,971 | 1,000,000 | 1,000,000 | 0.16 + 29 | 0.37 + 68 |
/// | 9,971 | 1,000,000 | 4,096 | 0.17 + 82 | 0.33 + 70 |
/// | 1,000,308 | 1,000 | 1 | 3.0 + 0.8 | 14 + 0.3 |
/// | 1,000,308 | 1,000 | 16 | 3.4 + 35 | 13 + 0.3 |
/// | 1,000,308 | 30,000 | 30,000 | 3.2 + 12 | 14 + 3.4 |
/// | 1,000,308 | 1,000,000 | 1,000,000 | 3.7 + 43 | 14 + 101 |
impl Costs {
    /// Build, per triangle.
    const BUILD_HIERARCHY: f64 = 13.7;
    const BUILD_SCANNER: f64 = 3.4;
    /// Query, per ray.
    const ASK_HIERARCHY: f64 = 90.0;
    const ASK_SCANNER: f64 = 65.0;
    /// The scanner's cost per origin.
    const ORIGIN: f64 = 2_000.0;
    /// The scanner's cost per triangle for each of an origin's first rays: together they touch nearly all triangles. A
    /// single one touches hardly any.
    const SPREAD: f64 = 12.0 / Self::SPREAD_RAYS as f64;
    const SPREAD_RAYS: usize = 64;

    /// The hierarchy's cost minus the scanner's, before the scanner's cost of origins and first rays.
    fn ahead(&self) -> f64 {
        let build = |is_built: bool, each: f64| if is_built { 0.0 } else { self.triangles as f64 * each };
        let hierarchy = build(self.is_hierarchy_built, Self::BUILD_HIERARCHY);
        let scanner = build(self.is_scanner_built, Self::BUILD_SCANNER);
        hierarchy - scanner + self.rays as f64 * (Self::ASK_HIERARCHY - Self::ASK_SCANNER)
    }

    /// The scanner's cost of a run of rays from one origin, minus its constant cost per ray.
    fn of_run(&self, rays: usize) -> f64 {
        // The second ray counts twice.
        let spread = if rays < 2 { 0 } else { rays.min(Self::SPREAD_RAYS) };
        let origin = if rays > 0 { Self::ORIGIN } else { 0.0 };
        origin + spread as f64 * Self::SPREAD * self.triangles as f64
    }
}

/// Rays grouped for a scanner, in reused memory: about 12 bytes a ray.
#[derive(Debug, Default)]
pub(super) struct Runs {
    /// The index of the first ray of each origin, and that origin.
    pub(super) starts: Vec<(usize, DVec3)>,
    pub(super) directions: Vec<Vec3>,
    /// A bit for each ray that begins a run, of a block's rays.
    firsts: Vec<u64>,
}

/// Rays that are read at once, by all threads.
const BLOCK: usize = 1 << 16;

/// Rays of a word of bits.
const WORD: usize = u64::BITS as usize;

impl Runs {
    /// Groups rays into runs with a common origin, interval and mask. Returns whether the scanner can take all of them and is
    /// faster than the hierarchy; stops after the block in which it isn't.
    pub(super) fn find(&mut self, trace: &Trace<'_>, costs: &Costs) -> bool {
        let count = trace.rays.len();
        self.starts.clear();
        self.directions.resize(count, Vec3::ZERO);
        let mut ahead = costs.ahead();
        for first in (0..count).step_by(BLOCK) {
            let end = count.min(first + BLOCK);
            if !self.read(trace, first, end) {
                return false;
            }
            for (word, &bits) in self.firsts.iter().enumerate() {
                for bit in bits_of(bits) {
                    let start = first + word * WORD + bit;
                    ahead -= costs.of_run(self.starts.last().map_or(0, |&(last, _)| start - last));
                    self.starts.push((start, trace.rays.get(start).origin));
                }
            }
            if ahead <= 0.0 {
                return false;
            }
        }
        ahead > costs.of_run(self.starts.last().map_or(0, |&(last, _)| count - last))
    }

    /// Reads the directions of a block's rays, and finds where runs begin. Returns whether the scanner can take the rays.
    fn read(&mut self, trace: &Trace<'_>, first: usize, end: usize) -> bool {
        self.firsts.resize((end - first).div_ceil(WORD), 0);
        let words = self.firsts.par_iter_mut().zip(self.directions[first..end].par_chunks_mut(WORD));
        let can_scan = words.enumerate().with_min_len(8).map(|(word, (bits, directions))| {
            let start = first + word * WORD;
            let masked = |index: usize| (trace.ray(index), trace.masks.of_ray(index));
            let mut last = (start > 0).then(|| masked(start - 1));
            let mut can_scan = true;
            *bits = 0;
            for (bit, to) in directions.iter_mut().enumerate() {
                let (ray, mask) = masked(start + bit);
                let goes_on = last.is_some_and(|last| last.1 == mask && is_of_one_scan(&last.0, &ray));
                *bits |= u64::from(!goes_on) << bit;
                // A scan has no hits behind an origin, and none for NaN.
                let direction = single(ray.direction).filter(|_| ray.t_min >= 0.0);
                can_scan &= direction.is_some();
                *to = direction.unwrap_or(Vec3::ZERO);
                last = Some((ray, mask));
            }
            can_scan
        });
        can_scan.merge(|a, b| a && b).unwrap_or(true)
    }

    pub(super) fn bytes(&self) -> usize {
        self.starts.capacity() * size_of::<(usize, DVec3)>()
            + self.directions.capacity() * size_of::<Vec3>()
            + self.firsts.capacity() * size_of::<u64>()
    }
}

fn is_of_one_scan(a: &Ray, b: &Ray) -> bool {
    (a.origin, a.t_min, a.t_max) == (b.origin, b.t_min, b.t_max)
}

/// The direction in f32 if f32 holds it exactly, or if it isn't finite.
fn single(direction: DVec3) -> Option<Vec3> {
    let single = direction.as_vec3();
    let is_same = single.as_dvec3() == direction || !direction.is_finite();
    is_same.then_some(single)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Triangles;

    #[test]
    fn runs_begin_where_origins_or_intervals_change() {
        let triangles = Triangles { positions: &[], indices: &[] };
        let lengths = [1, 63, 64, 65, 1000, BLOCK + 70, 3, 2 * BLOCK];
        let (mut rays, mut expected) = (Vec::new(), Vec::new());
        for (number, length) in lengths.into_iter().enumerate() {
            // Every other run has the origin of the last, and another interval.
            let origin = DVec3::X * (number / 2) as f64;
            expected.push((rays.len(), origin));
            let direction = |of: usize| DVec3::new(1.0, of as f64, number as f64);
            rays.extend((0..length).map(|of| Ray { t_max: 2.0 + number as f64, ..Ray::new(origin, direction(of)) }));
        }
        let costs = |rays: usize| Costs { triangles: 0, rays, is_scanner_built: true, is_hierarchy_built: true };
        for threads in [1, 2, 3, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let mut runs = Runs::default();
            let can_scan = pool.install(|| runs.find(&Trace::new(triangles, &rays), &costs(rays.len())));
            assert!(can_scan && runs.starts == expected, "{threads} threads");
            assert!(runs.directions.iter().zip(&rays).all(|(found, ray)| found.as_dvec3() == ray.direction));
            let mut precise = rays.clone();
            precise[rays.len() - 1].direction.x = 0.1;
            assert!(!pool.install(|| runs.find(&Trace::new(triangles, &precise), &costs(rays.len()))));
        }
        // Origins cost more than they save where each has few rays.
        let few: Vec<Ray> =
            rays.iter().enumerate().map(|(of, ray)| Ray { origin: DVec3::X * of as f64, ..*ray }).collect();
        let mut runs = Runs::default();
        assert!(!runs.find(&Trace::new(triangles, &few), &costs(few.len())));
        assert!(runs.starts.len() <= BLOCK, "it stops early");
    }
}
