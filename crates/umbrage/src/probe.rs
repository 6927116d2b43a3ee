use glam::{DVec3, Vec3};
use rayon::prelude::*;
use umbrage_rays::predicate::{HitPoint, ShadowRay, crossing};
use umbrage_rays::{self as rays, Camera, Hit, Opacity as _, Ray, View};
use umbrage_scene::{Frame, Light};

use crate::Sides;
use crate::cpu::stops;
use crate::sampling::Sample;
use crate::sides::TriangleSides;

/// The hit of the ray through the middle of a pixel, found by asking the predicate about every triangle.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// The pixel's column and row.
    pub pixel: [u32; 2],
    /// Id of the nearest triangle hit.
    pub triangle: u32,
    /// The weights of its second and third corner at the hit.
    pub barycentric: [f32; 2],
    /// World position.
    pub position: DVec3,
    /// Distance from the camera; for a parallel view, from the camera's plane.
    pub distance: f64,
    /// Depth along [`Camera::forward`].
    pub depth: f64,
    /// The triangle's unit normal, on the side that the camera sees.
    pub normal: Vec3,
    /// Whether the camera sees the triangle's corners counterclockwise.
    pub is_front: bool,
    /// For each light of the frame, its blocker.
    pub shadows: Vec<Option<Blocker>>,
}

/// The triangle that stands between a point and a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blocker {
    /// Id of the triangle: of several the one nearest to the point, and the lowest id at equal distance.
    pub triangle: u32,
    /// Its distance from the point.
    pub distance: f64,
}

impl Probe {
    /// Probes the pixel in column `x` and row `y`; `None` for a miss. The time grows with the number of triangles, a few
    /// milliseconds for a million.
    #[must_use]
    pub fn new(frame: &Frame, view: &View, [x, y]: [u32; 2], sides: Sides) -> Option<Self> {
        let mut of_triangles = TriangleSides::default();
        of_triangles.find(frame, sides);
        let sides = of_triangles.get();
        let ray = Sample::MIDDLE.ray(view, x, y);
        let hit = nearest(frame, &ray, sides)?;
        let crossing = crossing(&ray, frame.triangles().corners(hit.triangle))?;
        let point = HitPoint::new(&ray, hit.t);
        let Camera { forward, .. } = view.camera;
        let [a, b, c] = frame.triangles().corners(hit.triangle).map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
        Some(Self {
            pixel: [x, y],
            triangle: hit.triangle,
            barycentric: hit.barycentric,
            position: point.position,
            distance: (point.position - ray.origin).length(),
            depth: (point.position - ray.origin).dot(forward.as_dvec3()),
            normal: if crossing.front { normal } else { -normal },
            is_front: crossing.front,
            shadows: frame.lights.iter().map(|light| blocker(frame, light, point, hit.triangle, sides)).collect(),
        })
    }
}

/// The depth of the hit in the middle of a view's image, or without one that of the middle of the scene; `None` where that
/// is behind the camera.
pub(crate) fn middle_depth(frame: &Frame, view: &View, sides: Sides) -> Option<f64> {
    let mut of_triangles = TriangleSides::default();
    of_triangles.find(frame, sides);
    let ray = view.ray(0.5 * f64::from(view.width), 0.5 * f64::from(view.height));
    let hit = nearest(frame, &ray, of_triangles.get());
    let Camera { position, forward, .. } = view.camera;
    let of_scene = || (frame.animation_bounds.center() - position).as_dvec3().dot(forward.as_dvec3());
    Some(hit.map_or_else(of_scene, |hit| hit.t)).filter(|depth| depth.is_finite() && *depth > 0.0)
}

fn nearest(frame: &Frame, ray: &Ray, sides: rays::Sides<'_>) -> Option<Hit> {
    let triangles = frame.triangles();
    let hits = (0..triangles.len() as u32).into_par_iter().filter_map(|id| {
        let hit = umbrage_rays::predicate::hit(ray, triangles, id)?;
        stops(frame, ray, &hit, sides).then_some(hit)
    });
    hits.min_by(|one, other| one.t.total_cmp(&other.t).then(one.triangle.cmp(&other.triangle)))
}

fn blocker(frame: &Frame, light: &Light, point: HitPoint, own: u32, sides: rays::Sides<'_>) -> Option<Blocker> {
    if !light.casts_shadow {
        return None;
    }
    let (triangles, opacity) = (frame.triangles(), frame.shadow_opacity());
    let segment = ShadowRay::new(&light.source, point);
    let blockers = (0..triangles.len() as u32).into_par_iter().filter(|&id| id != own).filter_map(|id| {
        let corners = triangles.corners(id);
        let barycentric = segment.blocked_by(corners)?;
        let [v, w] = barycentric.map(f64::from);
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let distance = (a * (1.0 - v - w) + b * v + c * w).distance(point.position);
        let is_there = sides.stop_light(&light.source, id, corners);
        (is_there && opacity.stops(id, barycentric)).then_some(Blocker { triangle: id, distance })
    });
    blockers.min_by(|one, other| one.distance.total_cmp(&other.distance).then(one.triangle.cmp(&other.triangle)))
}
