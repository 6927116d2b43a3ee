use glam::{DVec3, Vec3};

use super::Trace;
use crate::Ray;

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

    /// The scanner's cost of the n-th ray from one origin, n from 0, minus its constant cost per ray.
    fn of_ray(&self, number: usize) -> f64 {
        match number {
            0 => Self::ORIGIN,
            1 => 2.0 * Self::SPREAD * self.triangles as f64,
            2..Self::SPREAD_RAYS => Self::SPREAD * self.triangles as f64,
            _ => 0.0,
        }
    }
}

/// Rays grouped for a scanner.
pub(super) struct Runs<'a> {
    /// The index of the first ray of each origin, and that origin.
    pub(super) starts: &'a mut Vec<(usize, DVec3)>,
    pub(super) directions: &'a mut Vec<Vec3>,
}

impl Runs<'_> {
    /// Groups rays into runs with a common origin, interval and mask. Returns whether the scanner can take all of them and is
    /// faster than the hierarchy; stops as soon as it isn't.
    pub(super) fn find(&mut self, trace: &Trace<'_>, costs: &Costs) -> bool {
        self.starts.clear();
        self.directions.clear();
        let mut ahead = costs.ahead();
        let mut last: Option<(Ray, u32)> = None;
        let mut first = 0;
        for index in 0..trace.rays.len() {
            let ray = trace.ray(index);
            let mask = trace.masks.of_ray(index);
            if last.is_none_or(|last| last.1 != mask || !is_of_one_scan(&last.0, &ray)) {
                first = index;
                self.starts.push((index, ray.origin));
            }
            ahead -= costs.of_ray(index - first);
            // A scan has no hits behind an origin, and none for NaN.
            let is_ahead = ray.t_min >= 0.0;
            let Some(direction) = single(ray.direction).filter(|_| is_ahead && ahead > 0.0) else { return false };
            self.directions.push(direction);
            last = Some((ray, mask));
        }
        ahead > 0.0
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
