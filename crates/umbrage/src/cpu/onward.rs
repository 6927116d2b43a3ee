//! Rays that go on from what others have met, to what is behind it or in mirrors: queued, and answered together.

use std::mem;

use fearless_simd::{Level, dispatch};
use glam::Vec3;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Hit, Opacity as _, Ray};

use super::shade::{Shading, Strip};
use super::stops;
use crate::shade::lanes::LANES;

/// How many surfaces one behind the other are seen through.
const MOST_LAYERS: u32 = 32;

/// What becomes of the light that comes along a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    /// The pixel that shows it, by its index in a [`Strip`].
    pub(super) pixel: u32,
    /// How much of it reaches the camera.
    pub(super) through: Vec3,
    /// How far it goes from the ray's origin to the camera.
    pub(super) travelled: f32,
    /// By how many mirrors it comes.
    pub(super) bounces: u32,
    /// Through how many surfaces it comes to the last of these.
    pub(super) layers: u32,
}

/// A ray that goes on from what another has met.
#[derive(Clone, Copy, Debug)]
pub(super) struct Onward {
    pub(super) ray: Ray,
    pub(super) path: Path,
    from: From,
}

/// Where a ray starts.
#[derive(Clone, Copy, Debug)]
enum From {
    /// On the line of the ray that it continues, behind what that has met.
    Behind,
    /// At a point of a triangle.
    Surface { point: HitPoint, triangle: u32 },
}

/// What a ray has met, and what becomes of the light that comes from there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    pub(super) ray: Ray,
    pub(super) hit: Hit,
    pub(super) path: Path,
}

impl Meeting {
    /// The ray that goes straight on, of whose light so much comes `through`.
    pub(super) fn behind(&self, through: Vec3) -> Onward {
        let ray = Ray { t_min: self.hit.t, ..self.ray };
        let path = Path { through, layers: self.path.layers + 1, ..self.path };
        Onward { ray, path, from: From::Behind }
    }

    /// The ray that starts in a `direction` of about unit length, of whose light so much comes `through`, and goes so far to
    /// the camera.
    pub(super) fn towards(&self, direction: Vec3, through: Vec3, travelled: f32) -> Onward {
        let point = HitPoint::new(&self.ray, self.hit.t);
        let ray = Ray::new(point.position, direction.as_dvec3());
        let path = Path { through, travelled, bounces: self.path.bounces + 1, layers: 0, ..self.path };
        Onward { ray, path, from: From::Surface { point, triangle: self.hit.triangle } }
    }
}

/// What a light adds to a pixel, unless something is in between.
pub(super) struct Shadow {
    pub(super) ray: ShadowRay,
    /// The triangle that the point is on.
    pub(super) triangle: u32,
    /// Which light it is.
    pub(super) light: usize,
    pub(super) pixel: u32,
    pub(super) radiance: Vec3,
}

/// Rays that wait to be answered, from generation to generation. What is shaded is added in the order of the queue, so that
/// pictures don't depend on the order in which its rays are answered.
#[derive(Default)]
pub(super) struct Queue {
    /// Those that are answered next.
    pub(super) next: Vec<Onward>,
    /// Those that are being answered, and what they meet.
    now: Vec<Onward>,
    found: Vec<Option<Hit>>,
    shadows: Vec<Shadow>,
}

impl Queue {
    /// Answers all rays, and those that go on from these, and adds what they see to the film.
    pub(super) fn follow(&mut self, level: Level, shading: &Shading<'_>, film: &mut Strip<'_>) {
        let Self { next, now, found, shadows } = self;
        while !next.is_empty() {
            mem::swap(next, now);
            next.clear();
            found.clear();
            found.extend(now.iter().map(|onward| shading.nearest(onward)));
            for (now, found) in now.chunks(LANES).zip(found.chunks(LANES)) {
                dispatch!(level, simd => shading.shade_onward(simd, now, found, next, shadows, film));
            }
            for shadow in shadows.drain(..) {
                if !shading.is_blocked(&shadow) {
                    film.add(shadow.pixel, shadow.radiance, 0.0);
                }
            }
        }
    }
}

impl Shading<'_> {
    /// What a ray meets.
    fn nearest(&self, Onward { ray, path, from }: &Onward) -> Option<Hit> {
        if path.layers >= MOST_LAYERS {
            return None;
        }
        let triangles = self.frame.triangles();
        match from {
            From::Behind => {
                self.rays_onward.nearest(triangles, ray, &|other| stops(self.frame, ray, other, self.sides))
            }
            // As with shadows: neither the surface itself nor what the point touches, as far as anybody can tell.
            From::Surface { point, triangle } => self.rays_onward.nearest(triangles, ray, &|other| {
                other.triangle != *triangle
                    && !point.is_on(triangles.corners(other.triangle))
                    && stops(self.frame, ray, other, self.sides)
            }),
        }
    }

    fn is_blocked(&self, shadow: &Shadow) -> bool {
        let (triangles, opacity) = (self.frame.triangles(), self.frame.shadow_opacity());
        let source = &self.lights[shadow.light].source;
        self.rays_onward.blocked(triangles, &shadow.ray, shadow.triangle, &|id, barycentric| {
            self.sides.stop_light(source, id, triangles.corners(id)) && opacity.stops(id, barycentric)
        })
    }
}
