//! The referee: hits, shadows and distances by definitions in real numbers.
//!
//! It shares no code with the predicate and has no tolerance of its own. u is 2⁻⁵³, and arithmetic is exact unless a
//! definition says that it is rounded. Rays and triangles that aren't finite meet nothing.
//!
//! - **Hit.** A ray's line meets a triangle if the edge functions d · ((p − o) × (q − o)) of its three edges have no
//!   two opposite signs and aren't all zero, at t = n · (a − o) / n · d, rounded to the nearest f64, with
//!   n = (b − a) × (c − a). The ray hits it if t is in its open interval; the least t is the nearest hit, and of equal
//!   ones the lowest id.
//! - **Point.** A hit at t is at P = o + t d in f64, and in truth in the box between the f64 P − e and P + e on each axis,
//!   e being 4 u times the sum of the largest components of t d and of P in f64.
//! - **Shadow.** A light at L, with d = P − L in f64, leaves the point in the shadow of a triangle other than its own if the
//!   line through L along d meets the triangle, L is strictly on the side of its plane that d comes from, and the whole box
//!   strictly on the side that d goes to. Parallel light along v does if the line through P along −v meets it, and the
//!   whole box is strictly on the side that −v comes from.
//! - **Cone.** A spot at L with the axis a and the half-angle θ lights P if a · d > 0 and (a · d)² ≥ cos² θ |a|² |d|², with
//!   d = P − L, all of it in f64 from left to right.

mod distances;
mod real;
mod scenes;
mod sequence;
mod trial;

use std::cmp::Ordering;

use glam::{DVec3, Vec3};
use umbrage_rays::{LightSource, Ray, Triangles};

use crate::{Case, Truth};
pub use distances::{DistanceTrial, DistanceTruth, distances, random_points};
use real::{Big, Interval, Real, nearest_quotient};
pub use scenes::random_case;
pub use sequence::{KeptRenderers, check_frame, random_sequence, random_structure};
pub use trial::{Trial, compare};

/// A vector of real numbers.
type Vector<R> = [R; 3];

fn vector<R: Real>(v: DVec3) -> Vector<R> {
    v.to_array().map(R::of)
}

fn minus<R: Real>(a: &Vector<R>, b: &Vector<R>) -> Vector<R> {
    [a[0].minus(&b[0]), a[1].minus(&b[1]), a[2].minus(&b[2])]
}

fn dot<R: Real>(a: &Vector<R>, b: &Vector<R>) -> R {
    a[0].times(&b[0]).plus(&a[1].times(&b[1])).plus(&a[2].times(&b[2]))
}

fn cross<R: Real>(a: &Vector<R>, b: &Vector<R>) -> Vector<R> {
    let component = |next: usize, last: usize| a[next].times(&b[last]).minus(&a[last].times(&b[next]));
    [component(1, 2), component(2, 0), component(0, 1)]
}

/// A formula whose sign is wanted.
trait Formula {
    fn value<R: Real>(&self) -> R;

    /// The sign, from intervals if they can tell, else from big numbers.
    fn sign(&self) -> Ordering {
        self.value::<Interval>().sign().or_else(|| self.value::<Big>().sign()).expect("big numbers have signs")
    }
}

/// d · ((p − o) × (q − o)).
struct Edge {
    origin: DVec3,
    direction: DVec3,
    p: DVec3,
    q: DVec3,
}

impl Formula for Edge {
    fn value<R: Real>(&self) -> R {
        let origin = vector(self.origin);
        dot(&vector(self.direction), &cross(&minus(&vector(self.p), &origin), &minus(&vector(self.q), &origin)))
    }
}

fn normal<R: Real>(corners: [DVec3; 3]) -> Vector<R> {
    let [a, b, c] = corners.map(vector::<R>);
    cross(&minus(&b, &a), &minus(&c, &a))
}

/// n · (x − a): the side of the triangle's plane that a point is on.
struct Height {
    corners: [DVec3; 3],
    point: DVec3,
}

impl Formula for Height {
    fn value<R: Real>(&self) -> R {
        dot(&normal(self.corners), &minus(&vector(self.point), &vector(self.corners[0])))
    }
}

/// n · d: the side of the triangle's plane that a direction goes to.
struct Slope {
    corners: [DVec3; 3],
    direction: DVec3,
}

impl Formula for Slope {
    fn value<R: Real>(&self) -> R {
        dot(&normal(self.corners), &vector(self.direction))
    }
}

fn is_met(origin: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    if ![origin, direction, a, b, c].iter().all(|v| v.is_finite()) {
        return false;
    }
    let signs = [(b, c), (c, a), (a, b)].map(|(p, q)| Edge { origin, direction, p, q }.sign());
    signs.contains(&Ordering::Less) != signs.contains(&Ordering::Greater)
}

/// t at which a ray hits a triangle: from the side on which its corners are counterclockwise, and from the other side
/// too if it has a back.
#[must_use]
pub fn hit(ray: &Ray, corners: [Vec3; 3], has_back: bool) -> Option<f64> {
    let corners = corners.map(Vec3::as_dvec3);
    if !is_met(ray.origin, ray.direction, corners) {
        return None;
    }
    let slope = Slope { corners, direction: ray.direction };
    if !has_back && slope.sign() != Ordering::Less {
        return None;
    }
    // The ray's origin is as far above the plane as t n · d goes down.
    let t = -nearest_quotient(&Height { corners, point: ray.origin }.value(), &slope.value());
    (ray.t_min < t && t < ray.t_max).then_some(t)
}

/// A point that may be shadowed.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// P.
    position: DVec3,
    /// Two opposite corners of the box.
    ends: [DVec3; 2],
}

impl Point {
    /// The point of a hit at t.
    #[must_use]
    pub fn new(ray: &Ray, t: f64) -> Self {
        const FOUR_ROUNDINGS: f64 = 1.0 / (1_u64 << 51) as f64;
        let largest = |v: DVec3| v.x.abs().max(v.y.abs()).max(v.z.abs());
        let step = ray.direction * t;
        let position = ray.origin + step;
        let error = FOUR_ROUNDINGS * (largest(step) + largest(position));
        Self { position, ends: [position - error, position + error] }
    }

    /// The side of a plane that the whole box is strictly on; `Equal` if the plane meets it.
    fn side(&self, corners: [DVec3; 3]) -> Ordering {
        let [low, high] = self.ends;
        let end = |corner: usize, axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
        let mut sides = (0..8)
            .map(|corner| Height { corners, point: DVec3::new(end(corner, 0), end(corner, 1), end(corner, 2)) }.sign());
        let first = sides.next().expect("a corner");
        if sides.all(|side| side == first) { first } else { Ordering::Equal }
    }

    /// Whether the point is in the light's cone, if it has one.
    #[must_use]
    pub fn is_in_cone(&self, light: &LightSource) -> bool {
        let LightSource::Spot { position, direction, outer_radians, .. } = *light else { return true };
        let [d, a] = [self.position - position.as_dvec3(), direction.as_dvec3()].map(|v| v.to_array());
        let sum = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let cosine = f64::from(outer_radians).cos().max(0.0);
        let squared_cosine = cosine * cosine * sum(a, a);
        if !position.is_finite() || !squared_cosine.is_finite() || direction == Vec3::ZERO {
            return true;
        }
        sum(a, d) > 0.0 && sum(a, d) * sum(a, d) >= squared_cosine * sum(d, d)
    }

    /// Whether a triangle other than the point's own leaves it in shadow: if the light falls on its front, on which its
    /// corners are counterclockwise, and on the other side too if it has a back.
    #[must_use]
    pub fn is_shadowed(&self, light: &LightSource, corners: [Vec3; 3], has_back: bool) -> bool {
        let corners = corners.map(Vec3::as_dvec3);
        let (origin, direction) = match *light {
            LightSource::Point { position } | LightSource::Spot { position, .. } => {
                (position.as_dvec3(), self.position - position.as_dvec3())
            }
            LightSource::Directional { direction } => (self.position, -direction.as_dvec3()),
        };
        if !is_met(origin, direction, corners) {
            return false;
        }
        let ahead = Slope { corners, direction }.sign();
        // Shadow rays of parallel light go against it.
        let on_front = match light {
            LightSource::Directional { .. } => Ordering::Greater,
            LightSource::Point { .. } | LightSource::Spot { .. } => Ordering::Less,
        };
        if !has_back && ahead != on_front {
            return false;
        }
        match light {
            LightSource::Directional { .. } => self.side(corners) == ahead.reverse(),
            LightSource::Point { .. } | LightSource::Spot { .. } => {
                self.side(corners) == ahead && Height { corners, point: origin }.sign() == ahead.reverse()
            }
        }
    }
}

/// The truth for each pixel of a case; takes its triangles as opaque.
#[must_use]
pub fn truth(case: &Case) -> Truth {
    truth_of_some(case, 1)
}

/// The same for the first of each `every` pixels.
#[must_use]
pub fn truth_of_some(case: &Case, every: u32) -> Truth {
    let (shot, triangles) = (case.shot(), case.mesh.triangles());
    let usable: Vec<(u32, [Vec3; 3])> =
        (0..triangles.len() as u32).filter_map(|id| Some((id, corners(triangles, id)?))).collect();
    case.truth_by(every, |x, y| {
        let ray = shot.ray(x, y);
        let hits = usable.iter().filter_map(|&(id, corners)| Some((hit(&ray, corners, case.sides.has_back(id))?, id)));
        let (t, own) = hits.min_by(|a, b| a.partial_cmp(b).expect("numbers"))?;
        let point = Point::new(&ray, t);
        let is_shadowed = |light: &LightSource, id, corners| point.is_shadowed(light, corners, case.sides.has_back(id));
        let is_lit = |light: &LightSource| {
            point.is_in_cone(light) && !usable.iter().any(|&(id, corners)| id != own && is_shadowed(light, id, corners))
        };
        Some((own, case.lights.iter().map(is_lit).collect()))
    })
}

/// A triangle's corners, if all exist.
fn corners(triangles: Triangles<'_>, id: u32) -> Option<[Vec3; 3]> {
    let [a, b, c] = triangles.indices[id as usize].map(|vertex| triangles.positions.get(vertex as usize));
    Some([*a?, *b?, *c?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seams_belong_to_both_sides_and_planes_hide_nothing_in_them() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let down = |x: f64, y: f64| Ray::new(DVec3::new(x, y, 1.0), DVec3::NEG_Z);
        assert_eq!(hit(&down(0.0, 0.5), corners, false), Some(1.0));
        assert_eq!(hit(&down(0.5, 0.5), corners, true), Some(1.0));
        assert_eq!(hit(&down(0.5, 0.5_f64.next_up()), corners, true), None);
        assert_eq!(hit(&Ray::new(DVec3::NEG_Z, DVec3::Z), corners, false), None);
        assert_eq!(hit(&Ray::new(DVec3::NEG_X, DVec3::X), corners, true), None, "edge-on");
        // A point in the triangle's plane, and one below it by its own error.
        let light = LightSource::Point { position: Vec3::new(0.2, 0.2, 3.0) };
        let at = |z: f64| Point::new(&Ray::new(DVec3::new(0.2, 0.2, z + 1.0), DVec3::NEG_Z), 1.0);
        assert!(!at(0.0).is_shadowed(&light, corners, true));
        assert!(!at(-4e-16).is_shadowed(&light, corners, true));
        assert!(at(-2e-15).is_shadowed(&light, corners, true));
        assert!(!at(2e-15).is_shadowed(&light, corners, true));
        // The front is towards positive z.
        let sun = |direction| LightSource::Directional { direction };
        assert!(at(-1.0).is_shadowed(&sun(Vec3::NEG_Z), corners, false));
        assert!(!at(-1.0).is_shadowed(&sun(Vec3::Z), corners, true));
        assert!(at(1.0).is_shadowed(&sun(Vec3::Z), corners, true));
        assert!(!at(1.0).is_shadowed(&sun(Vec3::Z), corners, false));
        let below = LightSource::Point { position: Vec3::new(0.2, 0.2, -3.0) };
        assert!(at(-1.0).is_shadowed(&light, corners, false) && at(1.0).is_shadowed(&below, corners, true));
        assert!(!at(1.0).is_shadowed(&below, corners, false));
    }
}
