//! Rays that experiments trace, in rows of [`PACKET`] that belong together.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use umbrage::rays::predicate::HitPoint;
use umbrage::rays::{Hit, LightSource, Ray, SingleRays, Triangles};

use crate::shot::Shot;

/// Rays of a packet.
pub(crate) const PACKET: usize = 256;

/// Hits of rays.
pub(crate) type Hits = Vec<Option<Hit>>;

/// Indices in a packet of the rays of its upper left, upper right, lower left and lower right pixel.
pub(crate) const PACKET_CORNERS: [usize; 4] = [0, 51, 204, 255];

/// The rays of a shot's first sample: squares of 16×16 pixels, and squares of 4×4 in these.
pub(crate) fn of_camera(shot: &Shot<'_>) -> Vec<Ray> {
    in_squares(shot, &[16, 4])
}

/// As [`of_camera`], in squares of 128×128 pixels and of 32×32 in these; those at the image's edges may have fewer.
pub(crate) fn of_camera_by_tiles(shot: &Shot<'_>) -> Vec<Ray> {
    in_squares(shot, &[128, 32, 16, 4])
}

/// The rays of a shot's first sample in nested squares with these sides.
fn in_squares(shot: &Shot<'_>, sides: &[u32]) -> Vec<Ray> {
    let (width, height) = (shot.view.width, shot.view.height);
    let first = shot.samples[0].as_slice()[0];
    let mut corners = vec![[0, 0]];
    let mut outer = [width, height];
    for &side in sides.iter().chain(&[1]) {
        let within = |[x, y]: [u32; 2]| {
            let steps = move |end: u32| (0..end).step_by(side as usize);
            steps(outer[1]).flat_map(move |down| steps(outer[0]).map(move |right| [x + right, y + down]))
        };
        corners = corners.into_iter().flat_map(within).filter(|&[x, y]| x < width && y < height).collect();
        outer = [side; 2];
    }
    corners.into_iter().map(|[x, y]| first.ray(&shot.view, x, y)).collect()
}

/// Nearest hits of rays.
pub(crate) fn hits_of(structure: &dyn SingleRays, triangles: Triangles<'_>, rays: &[Ray]) -> Hits {
    rays.par_iter().with_min_len(PACKET).map(|ray| structure.nearest(triangles, ray, &|_| true)).collect()
}

/// The rays of a diffuse bounce: one from each hit, in a cosine-distributed direction; the same every time.
pub(crate) fn scattered(triangles: Triangles<'_>, rays: &[Ray], hits: &Hits) -> Vec<Ray> {
    let scattered = |(number, (ray, hit)): (usize, (&Ray, &Option<Hit>))| {
        let hit = hit.as_ref()?;
        Some(scattered_ray(number, ray, hit, triangles.corners(hit.triangle)))
    };
    rays.iter().zip(hits).enumerate().filter_map(scattered).collect()
}

/// The ray of a diffuse bounce from the hit of ray `number` on a triangle.
pub(crate) fn scattered_ray(number: usize, ray: &Ray, hit: &Hit, corners: [Vec3; 3]) -> Ray {
    let (origin, normal) = point_off(corners, ray, hit);
    same_for_all(origin, normal + on_sphere(number as u64))
}

/// The rays of a mirror bounce: one from each hit, as if every triangle were a flat mirror.
pub(crate) fn mirrored(triangles: Triangles<'_>, rays: &[Ray], hits: &Hits) -> Vec<Ray> {
    let mirrored = |(ray, hit): (&Ray, &Option<Hit>)| {
        let hit = hit.as_ref()?;
        Some(mirrored_ray(ray, hit, triangles.corners(hit.triangle)))
    };
    rays.iter().zip(hits).filter_map(mirrored).collect()
}

/// The ray that a flat mirror reflects at a ray's hit on a triangle.
pub(crate) fn mirrored_ray(ray: &Ray, hit: &Hit, corners: [Vec3; 3]) -> Ray {
    let (origin, normal) = point_off(corners, ray, hit);
    let direction = ray.direction.normalize();
    same_for_all(origin, direction - normal * (2.0 * normal.dot(direction)))
}

/// The rays from hits to a light; to the first light, or to one above.
pub(crate) fn to_light(triangles: Triangles<'_>, rays: &[Ray], hits: &Hits, light: Option<&LightSource>) -> Vec<Ray> {
    let to_light = |(ray, hit): (&Ray, &Option<Hit>)| {
        let hit = hit.as_ref()?;
        let (point, _) = point_off(triangles.corners(hit.triangle), ray, hit);
        Some(match light {
            Some(LightSource::Point { position } | LightSource::Spot { position, .. }) => {
                Ray { t_max: 1.0, ..same_for_all(point, position.as_dvec3() - point) }
            }
            Some(LightSource::Directional { direction }) => same_for_all(point, -direction.as_dvec3()),
            None => same_for_all(point, DVec3::Y),
        })
    };
    rays.iter().zip(hits).filter_map(to_light).collect()
}

/// A hit's point, far enough from the surface for single precision, and the normal on the ray's side.
pub(crate) fn point_off(corners: [Vec3; 3], ray: &Ray, hit: &Hit) -> (DVec3, DVec3) {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let normal = (b - a).cross(c - a).normalize();
    let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
    let point = HitPoint::new(ray, hit.t).position;
    (point + normal * (1e-4 * (point - ray.origin).length()), normal)
}

/// A ray in single precision, so that all sides get the same numbers.
pub(crate) fn same_for_all(origin: DVec3, direction: DVec3) -> Ray {
    Ray::new(origin.as_vec3().as_dvec3(), direction.as_vec3().as_dvec3())
}

/// A point of the unit sphere for each number, about evenly spread.
pub(crate) fn on_sphere(number: u64) -> DVec3 {
    // Multiples of the golden ratio and of the root of two, which have no small multiple in common.
    let fraction = |step: f64| (number as f64 * step).fract();
    let (height, turn) = (2.0 * fraction(0.618_033_988_749_895) - 1.0, fraction(0.414_213_562_373_095));
    let radius = (1.0 - height * height).sqrt();
    let (sine, cosine) = (turn * TAU).sin_cos();
    DVec3::new(radius * cosine, radius * sine, height)
}
