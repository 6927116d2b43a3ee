//! Scans: the hits of any directions from one origin.
//!
//! A scan is the camera grid's counterpart for directions in any order, all around: for a lidar or a panorama. Directions
//! are sorted into tiles on the six faces around the origin. A thread takes a tile from its directions to their hits before
//! it takes another: it finds the [patches](crate::patches) in the tile's frustum, nearest first, transforms their vertices
//! to coordinates of the tile, and tests triangles in f32 against the lines within their bounds. The
//! [predicate](crate::predicate) settles undecided pairs and the position of the nearest hit, eight pairs of a ray and a
//! triangle at a time.
//!
//! One verb a file: `spread` sorts lines, `slots` takes a tile's lines to a face, `cull` finds patches, `worker` transforms triangles and finds their lines, `test` tests sixteen pairs, `settle` decides. `lit` asks the
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

use std::sync::{Mutex, PoisonError};

use crate::dispatch;
use crate::parallel::Parallel;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

pub(crate) use answers::make_room;
pub use answers::{Scanned, Wanted};
use lines::{Face, Lines};
use lit::LitPoints;
pub use lit::{Lit, LitBits, LitShare, Receivers};
use spread::{LineTile, Spread};
use worker::ScanWorker;

use crate::patches::{BoxTree, Patches};
use crate::{Hit, Masks, Omitted, Opacity, Opaque, Ray, Sides, SimdLevel, Triangles};

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
    /// Masks of triangles and sweeps.
    pub masks: Masks<'a>,
    /// Parts of the answer.
    pub wanted: Wanted,
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
    /// All parts of all hits ahead of the origins, with both sides of all triangles opaque.
    #[must_use]
    pub fn new(triangles: Triangles<'a>, sweeps: &'a [Sweep<'a>]) -> Self {
        let (t_min, t_max, masks, wanted) = (0.0, f64::INFINITY, Masks::default(), Wanted::ALL);
        Self { triangles, sweeps, t_min, t_max, opacity: &Opaque, sides: Sides::Both, masks, wanted }
    }
}

/// Answers [scans](Scan), rebuilt for every frame.
///
/// Keep it and use it again: its memory is reused, and directions that are the same as in the last call, or turned, need no
/// sorting. It holds about 23 bytes a triangle, 48 a direction, and 32 for each of several hits until it is delivered.
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
    /// The nearest hit at each place of the order, or its triangle.
    nearest: Vec<Hit>,
    nearest_ids: Vec<u32>,
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
    /// If it was built for another number of triangles, or a sweep has no mask.
    pub fn scan(&mut self, scan: &Scan<'_>, returns: usize, scanned: &mut Scanned) {
        let counts = scan.sweeps.iter().map(|sweep| sweep.directions.len());
        if returns == 1 {
            scanned.make_room(counts.sum(), scan.wanted);
            self.scan_nearest(scan, 0, scanned);
            return;
        }
        scanned.clear(counts.sum(), returns, scan.wanted);
        if returns == 0 {
            return;
        }
        scanned.without_direction = self.ask(scan, Asked::All);
        for worker in &mut self.workers {
            scanned.note(0, &worker.hits);
            worker.hits.clear();
        }
    }

    /// Finds the first hits of all sweeps, and writes them from answer `first` on.
    pub(crate) fn scan_nearest(&mut self, scan: &Scan<'_>, first: usize, scanned: &mut Scanned) {
        let asked = if scan.wanted == Wanted::IDS { Asked::NearestIds } else { Asked::Nearest };
        scanned.without_direction += self.ask(scan, asked);
        let mut before = 0;
        for places in self.spread.places() {
            let range = before..before + places.len();
            match asked {
                Asked::NearestIds => scanned.deliver_ids(first + before, &self.nearest_ids[range], places),
                _ => scanned.deliver(first + before, &self.nearest[range], places),
            }
            before += places.len();
        }
    }

    /// Finds which directions hit anything, which is faster than finding the hits: direction i is bit i % 64 of word i / 64.
    /// Returns the number of directions that are zero or not finite.
    ///
    /// # Panics
    /// As [`scan`](Self::scan).
    pub fn hits_any(&mut self, scan: &Scan<'_>, hit: &mut Vec<u64>) -> usize {
        let count: usize = scan.sweeps.iter().map(|sweep| sweep.directions.len()).sum();
        hit.clear();
        hit.resize(count.div_ceil(64), 0);
        let without_direction = self.ask(scan, Asked::Any);
        for worker in &mut self.workers {
            for line in worker.met.drain(..) {
                hit[line / 64] |= 1 << (line % 64);
            }
        }
        without_direction
    }

    /// Leaves the answers for all sweeps with the workers, and the nearest hits in the order of lines. Returns the number of
    /// directions that are zero or not finite.
    fn ask(&mut self, scan: &Scan<'_>, asked: Asked) -> usize {
        let Scan { triangles, sweeps, t_min, opacity, sides, masks, .. } = *scan;
        self.patches.expect(triangles);
        self.spread.update(sweeps);
        let Self { level, patches, boxes, spread, workers, nearest, nearest_ids, .. } = self;
        workers.resize_with(rayon::current_num_threads(), ScanWorker::default);
        let count = sweeps.iter().map(|sweep| sweep.directions.len()).sum();
        match asked {
            Asked::Nearest => nearest.resize(count, Scanned::MISS),
            Asked::NearestIds => nearest_ids.resize(count, Scanned::NONE),
            Asked::All | Asked::Any => {}
        }
        let all_stop = opacity.are_all_opaque() && sides == Sides::Both && masks.hide_nothing();
        let t_min = t_min.max(0.0);
        let scan = Scan { t_min, ..*scan };
        let job = Job { scan, patches, boxes, asked, all_stop, mask: u32::MAX, level: *level };
        tiles(&job, spread, workers, NearestAt { hits: nearest, ids: nearest_ids });
        workers.iter_mut().map(|worker| std::mem::take(&mut worker.nowhere)).sum()
    }

    /// Bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let workers: usize = self.workers.iter().map(ScanWorker::bytes).sum();
        let nearest = self.nearest.capacity() * size_of::<Hit>() + self.nearest_ids.capacity() * size_of::<u32>();
        self.patches.bytes() + self.boxes.bytes() + self.spread.bytes() + workers + nearest + self.points.bytes()
    }
}

/// Has the workers trace all tiles of lines.
fn tiles(job: &Job<'_>, spread: &Spread, workers: &mut [ScanWorker], nearest: NearestAt<'_>) {
    let left = Mutex::new((spread.tiles(), nearest));
    let next = || {
        let mut left = left.lock().unwrap_or_else(PoisonError::into_inner);
        let (tile, tiles) = left.0.split_first()?;
        left.0 = tiles;
        Some((tile, left.1.take(job.asked, tile.lines)))
    };
    workers.par_iter_mut().with_max_len(1).each(|worker| {
        while let Some((tile, mut nearest)) = next() {
            let (lines, order) = (job.lines(tile), spread.lines(tile));
            if lines.may_hit() {
                let job = job.of_tile(tile);
                dispatch!(job.level, simd => worker.trace(simd, &job, &lines, order, nearest));
            } else {
                nearest.miss();
                worker.nowhere += order.iter().filter(|line| Face::of(lines.get(**line as usize)).is_none()).count();
            }
        }
    });
}

/// The kind of answer for lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    /// The nearest hit.
    Nearest,
    /// Its triangle alone.
    NearestIds,
    /// All hits, the nearest first.
    All,
    /// Whether there is any hit.
    Any,
}

/// Room for the nearest hits of some places, or for their triangles: the other is empty, as both are where neither is
/// asked for.
#[derive(Default)]
struct NearestAt<'a> {
    hits: &'a mut [Hit],
    ids: &'a mut [u32],
}

impl<'a> NearestAt<'a> {
    /// Splits off the first `count` places.
    fn take(&mut self, asked: Asked, count: usize) -> Self {
        let room = |is_asked: bool| if is_asked { count } else { 0 };
        let (hits, other_hits) = std::mem::take(&mut self.hits).split_at_mut(room(asked == Asked::Nearest));
        let (ids, other_ids) = std::mem::take(&mut self.ids).split_at_mut(room(asked == Asked::NearestIds));
        *self = Self { hits: other_hits, ids: other_ids };
        Self { hits, ids }
    }

    /// Writes that nothing is hit.
    fn miss(&mut self) {
        self.hits.fill(Scanned::MISS);
        self.ids.fill(Scanned::NONE);
    }
}

/// The inputs of tracing tiles.
#[derive(Clone, Copy)]
struct Job<'a> {
    scan: Scan<'a>,
    patches: &'a Patches,
    boxes: &'a BoxTree,
    asked: Asked,
    /// Whether all sides of all triangles stop all lines.
    all_stop: bool,
    /// The mask of the tile's sweep.
    mask: u32,
    level: SimdLevel,
}

impl<'a> Job<'a> {
    /// For the lines of a tile.
    fn of_tile(&self, tile: &LineTile) -> Self {
        Self { mask: self.scan.masks.of_ray(tile.sweep), ..*self }
    }

    /// The lines of a tile's sweep.
    fn lines(&self, tile: &LineTile) -> Lines<'a> {
        let Sweep { origin, directions } = self.scan.sweeps[tile.sweep];
        let Scan { t_min, t_max, .. } = self.scan;
        let scale = scale(f64::from(self.boxes.reach) + origin.abs().max_element());
        Lines { before: tile.before, scale, origin, directions, t_min, t_max }
    }

    /// Whether masks hide a triangle from the tile's lines.
    fn is_hidden(&self, id: u32) -> bool {
        !self.all_stop && !self.scan.masks.sees(self.mask, id)
    }

    /// Whether a triangle that isn't hidden stops every line that meets it.
    fn always_stops(&self, id: u32) -> bool {
        self.all_stop || (self.scan.opacity.is_opaque(id) && self.scan.sides.has_back(id))
    }

    /// Whether a triangle that isn't hidden stops a ray that hits it at these weights.
    fn stops(&self, ray: &Ray, id: u32, barycentric: [f32; 2]) -> bool {
        let Scan { triangles, opacity, sides, .. } = self.scan;
        sides.stop(ray, id, triangles.corners(id)) && opacity.is_stopped_at(id, barycentric)
    }
}

/// The power of two that makes a length about 2¹⁰. Then products of lengths don't overflow, and underflow only where they
/// are far below the rounding errors of the others.
fn scale(length: f64) -> f64 {
    // The factor itself is an f32 far from the smallest and the largest.
    if length > 0.0 && length.is_finite() { f64::exp2((10.0 - length.log2().ceil()).clamp(-122.0, 110.0)) } else { 1.0 }
}
