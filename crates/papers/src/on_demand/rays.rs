//! State of a ray that goes from part to part.

use std::ops::ControlFlow;

use glam::{DVec3, Vec3};
use umbrage_rays::predicate::{ShadowRay, crossing};
use umbrage_rays::{Hit, Ray};

use super::cut::Node;
use super::parts::{Loaded, Scene};

/// An unfinished ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Traveller {
    pub(super) asks: Asks,
    /// Index of its answer.
    pub(super) index: u32,
    /// 0 from the camera, 1 after the bounce.
    pub(super) bounce: u8,
    /// Upper bound on its contribution to the picture, 0 to 1.
    pub(super) weight: f32,
    /// Entry into the box of its current part, and the part's index.
    at: (f64, u32),
}

/// Kind of query.
#[derive(Clone, Copy, Debug)]
pub(super) enum Asks {
    /// The nearest hit; with the nearest so far and the corners of its triangle.
    Nearest(Ray, Option<(Hit, [Vec3; 3])>),
    /// Whether a triangle other than this one blocks the ray.
    Shadow(ShadowRay, u32),
}

impl Traveller {
    /// A ray before its first part.
    pub(super) fn new(asks: Asks, index: u32, bounce: u8, weight: f32) -> Self {
        Self { asks, index, bounce, weight, at: (f64::NEG_INFINITY, 0) }
    }

    /// Its current part.
    pub(super) fn part(&self) -> usize {
        self.at.1 as usize
    }

    fn ray(&self) -> &Ray {
        match &self.asks {
            Asks::Nearest(ray, _) => ray,
            Asks::Shadow(shadow, _) => &shadow.ray,
        }
    }

    /// The t beyond which hits don't matter.
    fn t_max(&self) -> f64 {
        match &self.asks {
            Asks::Nearest(ray, nearest) => nearest.map_or(ray.t_max, |(hit, _)| hit.t),
            Asks::Shadow(shadow, _) => shadow.ray.t_max,
        }
    }

    /// Tests the ray against its current part. Breaks if that answers the query.
    pub(super) fn visit(&mut self, part: &Loaded) -> ControlFlow<()> {
        let slabs = Slabs::new(self.ray());
        let mut waiting = vec![0_u32];
        while let Some(index) = waiting.pop() {
            let node = &part.nodes[index as usize];
            if slabs.enter(node, self.t_max()).is_none() {
                continue;
            }
            if node.count == 0 {
                let enters = [node.first, node.first + 1]
                    .map(|child| slabs.enter(&part.nodes[child as usize], self.t_max()).unwrap_or(f64::INFINITY));
                // The nearer one is visited first.
                let order = if enters[0] <= enters[1] { [1, 0] } else { [0, 1] };
                waiting.extend(order.map(|child| node.first + child));
                continue;
            }
            for triangle in &part.triangles[node.first as usize..][..node.count as usize] {
                self.meet(triangle.id, triangle.corners())?;
            }
        }
        ControlFlow::Continue(())
    }

    fn meet(&mut self, id: u32, corners: [Vec3; 3]) -> ControlFlow<()> {
        match &mut self.asks {
            Asks::Nearest(ray, nearest) => {
                let Some(crossing) = crossing(ray, corners) else { return ControlFlow::Continue(()) };
                let t = crossing.t;
                let is_nearer = nearest.is_none_or(|(hit, _)| t < hit.t || t == hit.t && id < hit.triangle);
                if ray.t_min < t && t < ray.t_max && is_nearer {
                    *nearest = Some((Hit { t, triangle: id, barycentric: crossing.barycentric }, corners));
                }
                ControlFlow::Continue(())
            }
            Asks::Shadow(shadow, own) if id != *own && shadow.blocked_by(corners).is_some() => ControlFlow::Break(()),
            Asks::Shadow(..) => ControlFlow::Continue(()),
        }
    }

    /// Moves to the next part that it may hit, in the order of entry into their boxes; returns `false` if there is none.
    pub(super) fn go_on(&mut self, scene: &Scene) -> bool {
        if !is_sound(self.ray()) {
            return false;
        }
        let slabs = Slabs::new(self.ray());
        let (last, t_max) = (self.at, self.t_max());
        let mut next: Option<(f64, u32)> = None;
        let mut waiting = Vec::with_capacity(32);
        waiting.extend((!scene.above.is_empty()).then_some(0_u32));
        while let Some(index) = waiting.pop() {
            let node = &scene.above[index as usize];
            // No box is entered before the box around it.
            let Some(enter) = slabs.enter(node, t_max).filter(|&enter| next.is_none_or(|(next, _)| enter <= next))
            else {
                continue;
            };
            let part = (enter, node.first);
            if node.count == 0 {
                waiting.extend([node.first, node.first + 1]);
            } else if part > last && next.is_none_or(|next| part < next) {
                next = Some(part);
            }
        }
        self.at = next.unwrap_or(self.at);
        next.is_some()
    }
}

/// Whether a ray can hit anything: it has a finite origin and direction, and its interval isn't empty.
fn is_sound(ray: &Ray) -> bool {
    let goes_somewhere = ray.direction.is_finite() && ray.direction != DVec3::ZERO;
    ray.origin.is_finite() && goes_somewhere && ray.t_min < ray.t_max
}

/// A ray prepared for box tests that err only towards a hit.
///
/// In f64 a difference of corner and origin has an error of one rounding, a reciprocal of two and a product of one,
/// each 2⁻⁵³. Boxes are grown by 2⁻⁴⁰ of the ray's origin, and intervals by 2⁻⁴⁰ of themselves: that leaves room for
/// the roundings of points at which shadow rays end. A ray along a slab has no crossing with it: a finite stand-in for
/// 1/0 gives it a crossing so far away that it doesn't matter for any grown box that holds the ray.
struct Slabs {
    /// Offsets subtracted from a box's lowest corner, and from its highest.
    origins: [DVec3; 2],
    inverse: DVec3,
    /// Factor from the ray's own t to that of the box tests.
    scale: f64,
    t_min: f64,
}

impl Slabs {
    const MARGIN: f64 = 1.0 / (1_u64 << 40) as f64;
    const STEEPEST: f64 = 1e150;
    const SMALLEST: f64 = 1e-100;

    fn new(ray: &Ray) -> Self {
        let scale = ray.direction.abs().max_element();
        let inverse = (ray.direction / scale).to_array();
        let inverse = inverse.map(|component| component.signum() * component.abs().recip().min(Self::STEEPEST));
        let growth = ray.origin.abs().max_element() * Self::MARGIN + Self::SMALLEST;
        let t_min = ray.t_min * scale;
        Self {
            origins: [ray.origin + growth, ray.origin - growth],
            inverse: DVec3::from_array(inverse),
            scale,
            t_min: t_min - t_min.abs() * Self::MARGIN,
        }
    }

    /// Lower bound on the t at which the ray enters a box; `None` if it certainly misses the box before `t_max`.
    fn enter(&self, node: &Node, t_max: f64) -> Option<f64> {
        let [min, max] = [node.min, node.max].map(|corner| Vec3::from(corner).as_dvec3());
        let first = (min - self.origins[0]) * self.inverse;
        let second = (max - self.origins[1]) * self.inverse;
        let (near, far) = (first.min(second), first.max(second));
        let enter = (near - near.abs() * Self::MARGIN).max_element().max(self.t_min);
        let leave = (far + far.abs() * Self::MARGIN).min_element();
        let t_max = t_max * self.scale;
        // An overflow is NaN, which isn't above any number.
        let is_missed = enter > leave || enter > t_max + t_max.abs() * Self::MARGIN;
        (!is_missed).then_some(enter)
    }
}
