//! Scenes and rays that are hard for a kd-tree, as in the Rust crate's own tests.

use glam::{DVec3, Vec3};
use umbrage_rays::Ray;

use crate::support::{Mesh, Random};

/// Some of everything, with triangles that can't be hit.
pub(crate) fn scene(random: &mut Random) -> Mesh {
    let mut mesh = Mesh::soup(random, 60, 0.02);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 8));
    mesh.append(&Mesh::floor(5, 3.0));
    mesh.positions[5].x = f32::NAN;
    mesh.indices.push([0, 1, u32::MAX]);
    mesh.indices.push([7, 7, 8]);
    mesh
}

/// Triangles and boxes with small whole numbers for coordinates, so that planes, faces, corners and rays coincide.
pub(crate) fn blocks(random: &mut Random, count: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let whole = |random: &mut Random, reach: f32| (random.point() * reach).round();
    for step in 0..count {
        let corner = whole(random, 4.0);
        match step % 4 {
            0 => mesh.push([corner, whole(random, 4.0), whole(random, 4.0)]),
            // In a plane across an axis.
            1 => {
                let mut corners = [corner, whole(random, 4.0), whole(random, 4.0)];
                corners.iter_mut().for_each(|other| other[step / 4 % 3] = corner[step / 4 % 3]);
                mesh.push(corners);
            }
            2 => mesh.push([corner, corner + whole(random, 1.0), corner + whole(random, 1.0)]),
            _ => {
                let size = whole(random, 1.0).abs() + 1.0;
                let [x, y, z] = [Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z];
                for [along, across, to] in [[x, y, z], [y, z, x], [z, x, y]] {
                    for start in [corner, corner + to] {
                        mesh.quad([start, start + along, start + along + across, start + across]);
                    }
                }
            }
        }
    }
    mesh
}

/// From a cube of twice `reach` to a point of the scene.
pub(crate) fn random_ray(random: &mut Random, reach: f32) -> Ray {
    let origin = (random.point() * reach).as_dvec3();
    let length = f64::from(random.unit()) * 3.0 + 0.01;
    Ray::new(origin, ((random.point() * 1.5).as_dvec3() - origin) * length)
}

/// Rays in the planes of [`blocks`], along axes and diagonally through corners.
pub(crate) fn rays_in_planes(random: &mut Random, count: usize) -> Vec<Ray> {
    let mut rays = Vec::new();
    for step in 0..count {
        let mut origin = (random.point() * 6.0).round().as_dvec3();
        if step % 3 == 0 {
            origin += (random.point() * 2.0).round().as_dvec3() * 0.25;
        }
        let axis = [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z][step % 6];
        let flat = (random.point() * 3.0).round().as_dvec3() * (DVec3::ONE - axis.abs());
        rays.push(Ray::new(origin - axis * 16.0, axis * [1.0, 1e-90, 1e90][step % 3]));
        rays.push(Ray::new(origin - axis * f64::from(1 << 30), axis));
        // Zeros with either sign.
        rays.push(Ray::new(origin, axis * DVec3::new(1.0, -1.0, 1.0)));
        let diagonal = (random.point() * 2.0).round().as_dvec3();
        for direction in [diagonal, flat] {
            rays.push(Ray::new(origin - direction * 8.0, direction));
            rays.push(Ray::new(origin - direction * f64::from(1 << 26), direction));
        }
        // Almost along an axis, down to what has no inverse.
        let tilt = random.point().as_dvec3() * 10.0_f64.powi(-((step % 20) as i32 * 17));
        rays.push(Ray::new(origin - axis * 16.0, axis + tilt * (DVec3::ONE - axis.abs())));
    }
    rays
}

/// The intervals of rays around their own nearest hits.
pub(crate) fn with_intervals(random: &mut Random, ray: Ray, t: Option<f64>) -> Vec<Ray> {
    let ray = Ray { t_min: f64::from(random.unit()) * 0.5, t_max: f64::from(random.unit()) * 2.0, ..ray };
    // Behind the origin as well.
    let mut rays = vec![ray, Ray { t_min: -3.0, t_max: -0.01, ..ray }, Ray { t_min: f64::NEG_INFINITY, ..ray }];
    if let Some(t) = t {
        rays.push(Ray { t_min: t, t_max: f64::INFINITY, ..ray });
        rays.push(Ray { t_min: t.next_down(), t_max: t.next_up(), ..ray });
        rays.push(Ray { t_min: 0.0, t_max: t, ..ray });
        rays.push(Ray { t_min: 0.0, t_max: t.next_up(), ..ray });
    }
    rays
}
