use glam::{DVec3, Vec3};

use super::Trace;
use crate::Ray;

/// What answered rays.
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

/// What a question would take.
pub(super) struct Costs {
    pub(super) triangles: usize,
    pub(super) rays: usize,
    pub(super) is_scanner_built: bool,
    pub(super) is_hierarchy_built: bool,
}

impl Costs {
    /// Nanoseconds
    const BUILD_HIERARCHY: f64 = 80.0;
    const ASK_HIERARCHY: f64 = 150.0;
    const BUILD_SCANNER: f64 = 2.5;
    const ASK_SCANNER: f64 = 60.0;
    const RUN: f64 = 10_000.0;

    /// How many origins there may be, one after the other, for the scanner to take less than the hierarchy.
    pub(super) fn most_runs(&self) -> usize {
        let count = |number: usize| number as f64;
        let build = |is_built: bool, each: f64| if is_built { 0.0 } else { count(self.triangles) * each };
        let hierarchy = build(self.is_hierarchy_built, Self::BUILD_HIERARCHY) + count(self.rays) * Self::ASK_HIERARCHY;
        let scanner = build(self.is_scanner_built, Self::BUILD_SCANNER) + count(self.rays) * Self::ASK_SCANNER;
        // Saturates, and is zero where the scanner takes longer whatever the rays.
        ((hierarchy - scanner) / Self::RUN) as usize
    }
}

/// Rays as a scanner takes them.
pub(super) struct Runs<'a> {
    /// Where rays from another origin begin, and that origin.
    pub(super) starts: &'a mut Vec<(usize, DVec3)>,
    pub(super) directions: &'a mut Vec<Vec3>,
}

impl Runs<'_> {
    /// Sorts rays to runs that have an origin and an interval in common; whether there are at most so many, and all of them are
    /// rays that a scanner takes.
    pub(super) fn find(&mut self, trace: &Trace<'_>, most: usize) -> bool {
        self.starts.clear();
        self.directions.clear();
        if most == 0 {
            return false;
        }
        let mut last: Option<Ray> = None;
        for index in 0..trace.rays.len() {
            let ray = trace.ray(index);
            if last.is_none_or(|last| !is_of_one_scan(&last, &ray)) {
                // What is behind an origin, or within NaN, is nothing for a scan.
                let is_ahead = ray.t_min >= 0.0;
                if self.starts.len() == most || !is_ahead {
                    return false;
                }
                self.starts.push((index, ray.origin));
            }
            let Some(direction) = single(ray.direction) else { return false };
            self.directions.push(direction);
            last = Some(ray);
        }
        true
    }
}

fn is_of_one_scan(a: &Ray, b: &Ray) -> bool {
    (a.origin, a.t_min, a.t_max) == (b.origin, b.t_min, b.t_max)
}

/// A direction in f32, where that is the same one, or goes nowhere as it does.
fn single(direction: DVec3) -> Option<Vec3> {
    let single = direction.as_vec3();
    let is_same = single.as_dvec3() == direction || !direction.is_finite();
    is_same.then_some(single)
}
