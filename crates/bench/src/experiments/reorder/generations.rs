//! Rays of all generations of a picture, in the order in which a queue has them, with their kinds.

use glam::{DVec3, Vec3};
use umbrage::rays::predicate::{HitPoint, ShadowRay};
use umbrage::rays::{Bvh, Hit, LightSource, Ray};

use crate::rays::{Hits, hits_of, mirrored_ray, of_camera_by_tiles, on_sphere, point_off, same_for_all, scattered_ray};
use crate::shot::Shot;

/// How rays go on from their hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Path {
    /// As if every triangle were a flat mirror, and through glass as well: a transmissive surface spawns two rays.
    Mirrors,
    /// In a cosine-distributed direction.
    Diffuse,
}

impl Path {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Mirrors => "mirrors",
            Self::Diffuse => "diffuse",
        }
    }
}

/// The rays of a generation.
#[derive(Clone, Default)]
pub(super) struct Rays {
    pub(super) rays: Vec<Ray>,
    /// 0 for mirrored and scattered ones, 1 for refracted ones.
    pub(super) kinds: Vec<u32>,
    /// Each ray's share of its pixel's light, 0 to 1.
    weights: Vec<f64>,
}

/// The shadow rays of a generation: from each of its rays' hits to each light, with the light's number as their kind.
#[derive(Default)]
pub(super) struct ShadowRays {
    pub(super) rays: Vec<ShadowRay>,
    pub(super) own: Vec<u32>,
    pub(super) kinds: Vec<u32>,
}

/// Rays of a batch: 64×64.
pub(super) const WINDOW: usize = 64 * 64;

/// Maximum number of rays of a generation that spawn the next one.
const MOST: usize = 1 << 20;

/// Minimum weight of a ray, as in pictures.
const LEAST_WEIGHT: f64 = 0.002;

const REFRACTIVE_INDEX: f64 = 1.5;

impl Rays {
    pub(super) fn of_camera(shot: &Shot<'_>) -> Self {
        let rays = of_camera_by_tiles(shot);
        let count = rays.len();
        Self { rays, kinds: vec![0; count], weights: vec![1.0; count] }
    }

    pub(super) fn hits(&self, shot: &Shot<'_>, bvh: &Bvh) -> Hits {
        hits_of(bvh, shot.frame.triangles(), &self.rays)
    }

    /// The next generation.
    pub(super) fn next(&self, shot: &Shot<'_>, hits: &Hits, path: Path) -> Self {
        let mut next = Self::default();
        for (number, (ray, hit)) in self.rays.iter().zip(hits).enumerate() {
            let Some(hit) = hit else { continue };
            let corners = shot.frame.triangles().corners(hit.triangle);
            let weight = self.weights[number];
            match path {
                Path::Diffuse => next.push(scattered_ray(number, ray, hit, corners), 0, weight),
                Path::Mirrors => {
                    let materials = &shot.frame.materials.materials;
                    let material = &materials[shot.frame.mesh.material_of_triangle[hit.triangle as usize] as usize];
                    let behind = (material.transmission > 0.0).then(|| refracted(ray, hit, corners)).flatten();
                    let mirrored = mirrored_ray(ray, hit, corners);
                    let reflected = behind.map_or(1.0, |(_, reflected)| reflected);
                    next.push(mirrored, 0, weight * reflected);
                    if let Some((behind, reflected)) = behind {
                        next.push(behind, 1, weight * (1.0 - reflected));
                    }
                }
            }
        }
        next.thinned(MOST)
    }

    fn push(&mut self, ray: Ray, kind: u32, weight: f64) {
        if weight >= LEAST_WEIGHT {
            self.rays.push(ray);
            self.kinds.push(kind);
            self.weights.push(weight);
        }
    }

    /// At most `most` rays: batches spread over all.
    pub(super) fn thinned(self, most: usize) -> Self {
        let kept = spread(self.rays.len(), most);
        Self { rays: kept.of(&self.rays), kinds: kept.of(&self.kinds), weights: kept.of(&self.weights) }
    }
}

impl ShadowRays {
    /// Shadow rays to points anywhere on lights of a size.
    pub(super) fn new(shot: &Shot<'_>, rays: &[Ray], hits: &Hits, most: usize) -> Self {
        let radius = 0.02 * shot.bounds.size().length();
        let mut shadow = Self::default();
        for (number, (ray, hit)) in rays.iter().zip(hits).enumerate() {
            let Some(hit) = hit else { continue };
            for (kind, light) in shot.lights.iter().enumerate() {
                let away = on_sphere((number * shot.lights.len() + kind) as u64).as_vec3();
                let light = match *light {
                    LightSource::Point { position } | LightSource::Spot { position, .. } => {
                        LightSource::Point { position: position + away * radius }
                    }
                    LightSource::Directional { direction } => {
                        LightSource::Directional { direction: direction.normalize() + away * 0.02 }
                    }
                };
                shadow.rays.push(ShadowRay::new(&light, HitPoint::new(ray, hit.t)));
                shadow.own.push(hit.triangle);
                shadow.kinds.push(kind as u32);
            }
        }
        let kept = spread(shadow.rays.len(), most);
        Self { rays: kept.of(&shadow.rays), own: kept.of(&shadow.own), kinds: kept.of(&shadow.kinds) }
    }
}

/// Step between kept batches.
struct Spread(usize);

fn spread(count: usize, most: usize) -> Spread {
    Spread(count.div_ceil(most.max(WINDOW)).max(1))
}

impl Spread {
    fn of<T: Copy>(&self, all: &[T]) -> Vec<T> {
        all.chunks(WINDOW).step_by(self.0).flatten().copied().collect()
    }
}

/// The refracted ray behind a glass surface, and the reflectance (Schlick's approximation); `None` for total reflection.
fn refracted(ray: &Ray, hit: &Hit, corners: [Vec3; 3]) -> Option<(Ray, f64)> {
    let (off, normal) = point_off(corners, ray, hit);
    let point = HitPoint::new(ray, hit.t).position;
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let enters = (b - a).cross(c - a).dot(ray.direction) < 0.0;
    let ratio = if enters { 1.0 / REFRACTIVE_INDEX } else { REFRACTIVE_INDEX };
    let direction = ray.direction.normalize();
    let behind = direction.refract(normal, ratio);
    if behind == DVec3::ZERO {
        return None;
    }
    let cosine = if enters { -direction.dot(normal) } else { -behind.dot(normal) };
    let reflected = 0.04 + 0.96 * (1.0 - cosine).powi(5);
    Some((same_for_all(point + (point - off), behind), reflected))
}
