//! Scans: the hits of any directions from one origin.
//!
//! A scan is the camera grid's counterpart for directions in any order, all around: for a lidar or a panorama. Directions
//! are sorted into tiles on the six faces around the origin. A thread takes a tile from its directions to their hits before
//! it takes another: it finds the [patches](crate::patches) in the tile's frustum, nearest first, transforms their vertices
//! to coordinates of the tile, and tests triangles in f32 against the lines within their bounds. The
//! [predicate](crate::predicate) settles undecided pairs and the position of the nearest hit, eight pairs of a ray and a
//! triangle at a time.
//!
//! One verb a file: `spread` sorts lines into tiles, `cull` finds patches, `slots` sorts a tile's lines into cells, `worker`
//! transforms triangles and finds their lines, `test` tests sixteen pairs, `settle` decides. `lit` asks the
//! light grid which points lights reach.

mod answers;
mod cull;
mod lines;
mod lit;
mod settle;
mod slots;
mod spread;
mod test;
mod worker;

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::dispatch;
use crate::parallel::Parallel;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

pub use answers::Scanned;
use lines::Lines;
use lit::LitPoints;
pub use lit::{Lit, LitBits, LitShare, Receivers};
use spread::Spread;
use worker::ScanWorker;

use crate::patches::{BoxTree, Patches};
use crate::{Omitted, Opacity, Opaque, Ray, Sides, SimdLevel, Triangles};

/// Directions from one or more origins, and the triangles that they may hit.
#[derive(Clone, Copy)]
pub struct Scan<'a> {
    /// World-space triangles.
    pub triangles: Triangles<'a>,
    /// Origins with their directions.
    pub sweeps: &'a [Sweep<'a>],
    /// Hits at or before this t don't count, in lengths of a direction; at least zero.
    pub t_min: f64,
    /// Hits at or after this t don't count.
    pub t_max: f64,
    /// Opacity of the triangles.
    pub opacity: &'a dyn Opacity,
    /// Sides of triangles that stop rays.
    pub sides: Sides<'a>,
}

/// Directions from one origin.
#[derive(Clone, Copy, Debug)]
pub struct Sweep<'a> {
    /// World position.
    pub origin: DVec3,
    /// Directions of any length, which is the unit of t, in any order. Those that are zero or not finite hit nothing.
    pub directions: &'a [Vec3],
}

impl<'a> Scan<'a> {
    /// All hits ahead of the origins, with both sides of all triangles opaque.
    #[must_use]
    pub fn new(triangles: Triangles<'a>, sweeps: &'a [Sweep<'a>]) -> Self {
        Self { triangles, sweeps, t_min: 0.0, t_max: f64::INFINITY, opacity: &Opaque, sides: Sides::Both }
    }
}

/// Answers [scans](Scan), rebuilt for every frame.
///
/// Keep it and use it again: its memory is reused. It holds about 23 bytes a triangle, 8 a direction, and 32 for each hit
/// until it is delivered.
///
/// ```
/// use glam::{DVec3, Vec3};
/// use umbrage_rays::{LightSource, Lit, LitBits, Receivers, Scan, Scanned, Scanner, Sweep, Triangles};
///
/// // A square two units below the origin.
/// let positions = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, z]| Vec3::new(x, -2.0, z));
/// let triangles = Triangles { positions: &positions, indices: &[[0, 1, 2], [0, 2, 3]] };
/// let (mut scanner, mut scanned) = (Scanner::default(), Scanned::default());
/// // For each frame:
/// scanner.build(triangles);
/// let directions = [Vec3::NEG_Y, Vec3::new(0.2, -1.0, -0.1), Vec3::Y, Vec3::ZERO];
/// let sweeps = [Sweep { origin: DVec3::ZERO, directions: &directions }];
/// scanner.scan(&Scan::new(triangles, &sweeps), 1, &mut scanned);
/// assert_eq!(scanned.t, [2.0, 2.0, f64::INFINITY, f64::INFINITY]);
/// assert_eq!(scanned.triangle, [0, 0, Scanned::NONE, Scanned::NONE]);
/// assert_eq!(scanned.without_direction, 1);
///
/// // Which centroids of triangles does the sun reach?
/// let (mut bits, sun) = (LitBits::default(), LightSource::Directional { direction: Vec3::NEG_Y });
/// scanner.lit(&Lit::new(triangles, Receivers::Faces), &[sun], &mut bits);
/// assert!(bits.is_lit(0, 0) && bits.is_lit(0, 1));
/// ```
#[derive(Default)]
pub struct Scanner {
    level: SimdLevel,
    patches: Patches,
    boxes: BoxTree,
    spread: Spread,
    workers: Vec<ScanWorker>,
    points: LitPoints,
}

debug_some!(Scanner as scanner: "patches" => scanner.patches.len());

impl Scanner {
    /// Uses the instructions of a level instead of the widest; answers are the same bit for bit.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        Self { level, points: LitPoints::with_level(level), ..Self::default() }
    }

    /// Updates the scanner for the triangles of a frame; call it before any query about them.
    pub fn build(&mut self, triangles: Triangles<'_>) {
        self.patches.update(triangles, self.level);
        self.boxes.find(&self.patches);
    }

    /// The triangles that no ray can hit, as of the last [`build`](Self::build).
    #[must_use]
    pub fn omitted(&self) -> &Omitted {
        self.patches.omitted()
    }

    /// Finds the first hits of directions, up to `returns` each, nearest first; at equal t the lowest id first.
    ///
    /// # Panics
    /// If it was built for another number of triangles.
    pub fn scan(&mut self, scan: &Scan<'_>, returns: usize, scanned: &mut Scanned) {
        let counts = scan.sweeps.iter().map(|sweep| sweep.directions.len());
        scanned.clear(counts.sum(), returns);
        if returns == 0 {
            return;
        }
        let asked = if returns == 1 { Asked::Nearest } else { Asked::All };
        let mut first = 0;
        for sweep in scan.sweeps {
            self.note_sweep(scan, sweep, asked, first, scanned);
            first += sweep.directions.len();
        }
    }

    /// Finds the first hits of a sweep's directions, and writes them from answer `first` on.
    pub(crate) fn scan_sweep(&mut self, scan: &Scan<'_>, sweep: &Sweep<'_>, first: usize, scanned: &mut Scanned) {
        self.note_sweep(scan, sweep, Asked::Nearest, first, scanned);
    }

    fn note_sweep(&mut self, scan: &Scan<'_>, sweep: &Sweep<'_>, asked: Asked, first: usize, scanned: &mut Scanned) {
        scanned.without_direction += self.sweep(scan, sweep, asked);
        for worker in &mut self.workers {
            scanned.note(first, &worker.hits);
            worker.hits.clear();
        }
    }

    /// Finds which directions hit anything, which is faster than finding the hits: direction i is bit i % 64 of word i / 64.
    /// Returns the number of directions that are zero or not finite.
    ///
    /// # Panics
    /// If it was built for another number of triangles.
    pub fn hits_any(&mut self, scan: &Scan<'_>, hit: &mut Vec<u64>) -> usize {
        let count: usize = scan.sweeps.iter().map(|sweep| sweep.directions.len()).sum();
        hit.clear();
        hit.resize(count.div_ceil(64), 0);
        let (mut first, mut without_direction) = (0, 0);
        for sweep in scan.sweeps {
            without_direction += self.sweep(scan, sweep, Asked::Any);
            for worker in &mut self.workers {
                for line in worker.met.drain(..) {
                    let index = first + line as usize;
                    hit[index / 64] |= 1 << (index % 64);
                }
            }
            first += sweep.directions.len();
        }
        without_direction
    }

    /// Leaves the answers for a sweep with the workers. Returns the number of its directions that are zero or not finite.
    fn sweep(&mut self, scan: &Scan<'_>, sweep: &Sweep<'_>, asked: Asked) -> usize {
        self.patches.expect(scan.triangles);
        let Scan { triangles, t_min, t_max, opacity, sides, .. } = *scan;
        let Sweep { origin, directions } = *sweep;
        let t_min = t_min.max(0.0);
        if !origin.is_finite() || t_min >= t_max || t_max.is_nan() {
            return directions.iter().filter(|of| !of.is_finite() || **of == Vec3::ZERO).count();
        }
        let lines = Lines { origin, directions, t_min, t_max };
        let (mut spread, mut workers) = (std::mem::take(&mut self.spread), std::mem::take(&mut self.workers));
        spread.spread(&lines);
        workers.resize_with(rayon::current_num_threads(), ScanWorker::default);
        let reach = f64::from(self.boxes.reach) + origin.abs().max_element();
        tiles(&self.job(triangles, (opacity, sides), lines, asked, reach), &spread, &mut workers);
        (self.spread, self.workers) = (spread, workers);
        self.spread.nowhere
    }

    /// The job of tracing lines; no length is above `reach`.
    fn job<'a>(
        &'a self,
        triangles: Triangles<'a>,
        (opacity, sides): (&'a dyn Opacity, Sides<'a>),
        lines: Lines<'a>,
        asked: Asked,
        reach: f64,
    ) -> Job<'a> {
        let scale = scale(reach);
        let all_stop = opacity.are_all_opaque() && sides == Sides::Both;
        let Self { patches, boxes, level, .. } = self;
        Job { triangles, patches, boxes, opacity, sides, lines, asked, scale, all_stop, level: *level }
    }

    /// Bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let workers: usize = self.workers.iter().map(ScanWorker::bytes).sum();
        self.patches.bytes() + self.boxes.bytes() + self.spread.bytes() + workers + self.points.bytes()
    }
}

/// Has the workers trace all tiles of lines.
fn tiles(job: &Job<'_>, spread: &Spread, workers: &mut [ScanWorker]) {
    let next = AtomicUsize::new(0);
    workers.par_iter_mut().with_max_len(1).each(|worker| {
        while let Some(tile) = spread.tiles.get(next.fetch_add(1, Ordering::Relaxed)) {
            dispatch!(job.level, simd => worker.trace(simd, job, tile, &spread.order));
        }
    });
}

/// The kind of answer for lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    /// The nearest hit.
    Nearest,
    /// All hits, the nearest first.
    All,
    /// Whether there is any hit.
    Any,
}

/// The inputs of tracing tiles.
struct Job<'a> {
    triangles: Triangles<'a>,
    patches: &'a Patches,
    boxes: &'a BoxTree,
    opacity: &'a dyn Opacity,
    sides: Sides<'a>,
    lines: Lines<'a>,
    asked: Asked,
    /// Factor for lengths: a power of two.
    scale: f64,
    /// Whether all sides of all triangles stop all lines.
    all_stop: bool,
    level: SimdLevel,
}

impl Job<'_> {
    /// Whether a triangle stops every line that meets it.
    fn always_stops(&self, id: u32) -> bool {
        self.all_stop || (self.opacity.is_opaque(id) && self.sides.has_back(id))
    }

    /// Whether a triangle stops a ray that hits it at these weights.
    fn stops(&self, ray: &Ray, id: u32, barycentric: [f32; 2]) -> bool {
        self.all_stop
            || (self.sides.stop(ray, id, self.triangles.corners(id)) && self.opacity.is_stopped_at(id, barycentric))
    }
}

/// The power of two that makes a length about 2¹⁰. Then products of lengths don't overflow, and underflow only where they
/// are far below the rounding errors of the others.
fn scale(length: f64) -> f64 {
    // The factor itself is an f32 far from the smallest and the largest.
    if length > 0.0 && length.is_finite() { f64::exp2((10.0 - length.log2().ceil()).clamp(-122.0, 110.0)) } else { 1.0 }
}
