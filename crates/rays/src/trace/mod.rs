//! Any rays, with the structure chosen for each question.
//!
//! A [hierarchy](crate::Bvh) answers unrelated rays and takes long to build. A [scanner](crate::Scanner) takes hardly any
//! time to build, and answers many directions from one origin together. `choose` compares their costs.

mod batch;
mod choose;
mod rays;

use batch::{Answers, Batch};
pub use choose::TracedBy;
use choose::{Costs, Runs};
use glam::DVec3;
pub use rays::Rays;

use crate::scan::make_room;
use crate::{
    Bvh, Hit, Masks, Opacity, Opaque, Ray, RayMasks, Scan, Scanned, Scanner, Sides, SimdLevel, Sweep, Triangles, Wanted,
};

/// Any rays, and the triangles that they may hit.
#[derive(Clone, Copy)]
pub struct Trace<'a> {
    /// World-space triangles.
    pub triangles: Triangles<'a>,
    /// The rays.
    pub rays: Rays<'a>,
    /// Hits at or before this t don't count, in lengths of a direction; nor do those outside of a ray's own interval.
    pub t_min: f64,
    /// Hits at or after this t don't count.
    pub t_max: f64,
    /// Opacity of the triangles.
    pub opacity: &'a dyn Opacity,
    /// Sides of triangles that stop rays.
    pub sides: Sides<'a>,
    /// Masks of triangles and rays.
    pub masks: Masks<'a>,
    /// Parts of the answer.
    pub wanted: Wanted,
}

impl<'a> Trace<'a> {
    /// All parts of all hits within the rays' own intervals, with both sides of all triangles opaque.
    #[must_use]
    pub fn new(triangles: Triangles<'a>, rays: impl Into<Rays<'a>>) -> Self {
        let (t_min, t_max) = (f64::NEG_INFINITY, f64::INFINITY);
        let (rays, masks, wanted) = (rays.into(), Masks::default(), Wanted::ALL);
        Self { triangles, rays, t_min, t_max, opacity: &Opaque, sides: Sides::Both, masks, wanted }
    }

    /// A ray with its interval cut to the trace's: an empty one where an end is NaN.
    fn ray(&self, index: usize) -> Ray {
        let ray = self.rays.get(index);
        let t_min = if self.t_min > ray.t_min || self.t_min.is_nan() { self.t_min } else { ray.t_min };
        let t_max = if self.t_max < ray.t_max || self.t_max.is_nan() { self.t_max } else { ray.t_max };
        Ray { t_min, t_max, ..ray }
    }

    /// Whether all triangles stop all rays.
    fn all_stop(&self) -> bool {
        self.sides == Sides::Both && self.opacity.are_all_opaque() && self.masks.hide_nothing()
    }

    /// Whether a hit stops a ray with a mask.
    fn stops(&self, ray: &Ray, mask: u32, hit: &Hit) -> bool {
        let id = hit.triangle;
        if !self.masks.sees(mask, id) {
            return false;
        }
        // Skips the lookup of corners where both sides stop rays.
        let is_there = self.sides == Sides::Both || self.sides.stop(ray, id, self.triangles.corners(id));
        is_there && self.opacity.is_stopped_at(id, hit.barycentric)
    }
}

/// Answers [any rays](Trace) with the structure that is fastest for them, and returns which it was. Answers don't depend on
/// it.
///
/// Keep it and use it again: its memory is reused. A structure is built when it is first chosen, and stays until
/// [`forget`](Self::forget). It holds about 40 bytes a triangle for a hierarchy, 23 for a scanner, and 12 a ray.
///
/// ```
/// use glam::{DVec3, Vec3};
/// use umbrage_rays::{Ray, Scanned, Trace, TracedBy, Tracer, Triangles};
///
/// // A square two units below the origin.
/// let mut positions = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, z]| Vec3::new(x, -2.0, z));
/// let indices = [[0, 1, 2], [0, 2, 3]];
/// let rays = [Ray::new(DVec3::ZERO, DVec3::NEG_Y), Ray::new(DVec3::X * 3.0, DVec3::NEG_Y), Ray::new(DVec3::ZERO, DVec3::ZERO)];
/// let (mut tracer, mut traced) = (Tracer::default(), Scanned::default());
/// for frame in 0..3 {
///     positions.iter_mut().for_each(|corner| corner.y -= 1.0);
///     tracer.forget();
///     let triangles = Triangles { positions: &positions, indices: &indices };
///     let by: TracedBy = tracer.trace(&Trace::new(triangles, &rays), &mut traced);
///     println!("answered by the {by}");
///     assert_eq!(traced.t, [3.0 + f64::from(frame), f64::INFINITY, f64::INFINITY]);
///     assert_eq!(traced.triangle, [0, Scanned::NONE, Scanned::NONE]);
///     assert_eq!(traced.without_direction, 1);
/// }
/// ```
#[derive(Debug, Default)]
pub struct Tracer {
    scanner: Built<Scanner>,
    hierarchy: Built<Bvh>,
    runs: Runs,
}

/// A structure, and whether it is built for the current triangles.
#[derive(Debug, Default)]
struct Built<S> {
    structure: S,
    is_current: bool,
}

impl<S> Built<S> {
    fn brought(&mut self, build: impl FnOnce(&mut S)) -> &mut S {
        if !self.is_current {
            build(&mut self.structure);
            self.is_current = true;
        }
        &mut self.structure
    }
}

/// The most runs of rays that are swept together.
const SWEEPS: usize = 64;

impl Tracer {
    /// Uses the instructions of a level instead of the widest; answers are the same bit for bit.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        let built = |structure| Built { structure, is_current: false };
        let hierarchy = Built { structure: Bvh::with_level(level), is_current: false };
        Self { scanner: built(Scanner::with_level(level)), hierarchy, ..Self::default() }
    }

    /// Marks the triangles as changed: each structure is rebuilt when it is next chosen.
    pub fn forget(&mut self) {
        (self.scanner.is_current, self.hierarchy.is_current) = (false, false);
    }

    /// The scanner, built for these triangles unless it is current.
    pub fn scanner(&mut self, triangles: Triangles<'_>) -> &mut Scanner {
        self.scanner.brought(|scanner| scanner.build(triangles))
    }

    /// The hierarchy, built for these triangles unless it is current.
    pub fn hierarchy(&mut self, triangles: Triangles<'_>) -> &Bvh {
        self.hierarchy.brought(|hierarchy| hierarchy.build(triangles))
    }

    /// Finds the first hit of each ray; at equal t the one with the lowest id. Returns the structure that answered.
    ///
    /// `traced` has one hit for each ray, in their order. Rays whose direction is zero or not finite hit nothing and are
    /// counted in [`Scanned::without_direction`]. Rays whose origin isn't finite or whose interval is empty hit nothing
    /// either.
    ///
    /// # Panics
    /// If the number of triangles has changed since the last [`forget`](Self::forget), or a ray has no mask.
    pub fn trace(&mut self, trace: &Trace<'_>, traced: &mut Scanned) -> TracedBy {
        traced.make_room(trace.rays.len(), trace.wanted);
        let chosen = self.choose(trace);
        match chosen {
            TracedBy::Scanner => self.by_scanner(trace, traced),
            TracedBy::Hierarchy => self.by_hierarchy(trace, traced),
        }
        chosen
    }

    /// Finds whether each ray hits anything that stops it, through the hierarchy: faster than to find what it hits.
    ///
    /// `hit` has a value for each ray, in their order; false for rays that [`trace`](Self::trace) doesn't count.
    ///
    /// # Panics
    /// As [`trace`](Self::trace).
    pub fn hits_any(&mut self, trace: &Trace<'_>, hit: &mut Vec<bool>) {
        make_room(hit, trace.rays.len());
        self.batch(trace).count(1, hit, |count| count > 0);
    }

    /// Counts the triangles that each ray meets and that would stop it, through the hierarchy. A ray through an edge that
    /// two triangles share meets both.
    ///
    /// `counts` has a value for each ray, in their order; 0 for rays that [`trace`](Self::trace) doesn't count.
    ///
    /// # Panics
    /// As [`trace`](Self::trace).
    pub fn count_hits(&mut self, trace: &Trace<'_>, counts: &mut Vec<u32>) {
        make_room(counts, trace.rays.len());
        self.batch(trace).count(u32::MAX, counts, |count| count);
    }

    /// The rays, and the hierarchy that answers them.
    fn batch<'a>(&'a mut self, trace: &'a Trace<'a>) -> Batch<'a> {
        Batch { hierarchy: self.hierarchy(trace.triangles), trace, all_stop: trace.all_stop() }
    }

    /// Chooses the faster structure; for the scanner, leaves the rays as runs of directions.
    fn choose(&mut self, trace: &Trace<'_>) -> TracedBy {
        let costs = Costs {
            triangles: trace.triangles.len(),
            rays: trace.rays.len(),
            is_scanner_built: self.scanner.is_current,
            is_hierarchy_built: self.hierarchy.is_current,
        };
        if self.runs.find(trace, &costs) { TracedBy::Scanner } else { TracedBy::Hierarchy }
    }

    fn by_scanner(&mut self, trace: &Trace<'_>, traced: &mut Scanned) {
        let Trace { triangles, opacity, sides, masks, wanted, .. } = *trace;
        let Runs { starts, directions, .. } = &self.runs;
        let scanner = self.scanner.brought(|scanner| scanner.build(triangles));
        let interval = |&(first, _): &(usize, DVec3)| {
            let Ray { t_min, t_max, .. } = trace.ray(first);
            [t_min, t_max]
        };
        let mut ends = starts.iter().skip(1).map(|&(next, _)| next).chain([directions.len()]);
        // Runs with the same interval are swept together.
        for runs in starts.chunk_by(|a, b| interval(a) == interval(b)).flat_map(|runs| runs.chunks(SWEEPS)) {
            let mut sweeps = [Sweep { origin: DVec3::ZERO, directions: &[] }; SWEEPS];
            let mut of_sweeps = [0; SWEEPS];
            let each = sweeps.iter_mut().zip(&mut of_sweeps).zip(runs.iter().zip(&mut ends));
            for ((sweep, mask), (&(first, origin), end)) in each {
                *sweep = Sweep { origin, directions: &directions[first..end] };
                *mask = masks.of_ray(first);
            }
            let ([t_min, t_max], sweeps) = (interval(&runs[0]), &sweeps[..runs.len()]);
            let rays = if let RayMasks::Each(_) = masks.rays { RayMasks::Each(&of_sweeps) } else { masks.rays };
            let masks = Masks { rays, ..masks };
            let scan = Scan { triangles, sweeps, t_min, t_max, opacity, sides, masks, wanted };
            scanner.scan_nearest(&scan, runs[0].0, traced);
        }
    }

    fn by_hierarchy(&mut self, trace: &Trace<'_>, traced: &mut Scanned) {
        let Scanned { t, triangle, barycentric, .. } = traced;
        traced.without_direction = self.batch(trace).answer(0, Answers { t, triangle, barycentric });
    }

    /// Bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.scanner.structure.bytes()
            + crate::Structure::bytes(&self.hierarchy.structure).triangles
            + self.runs.bytes()
    }
}
