use glam::{DVec3, Vec3};
use umbrage_rays::{Ray, Triangles};
use umbrage_verify::{Oracle, Random, TestMesh};

use super::Rays;
use crate::cases::{BALL, FAR, scene, stadium};

/// Rays of every kind through meshes of every kind.
pub(crate) fn all() -> Vec<Rays> {
    let mut random = Random::new(1);
    let mut all = Vec::new();
    let mesh = scene(&mut random);
    for reach in [0.5, 3.0, 40.0, 3e6, 1e15] {
        let rays = (0..100).map(|_| random_ray(&mut random, reach)).collect();
        all.push(Rays::new(format!("from {reach}"), mesh.clone(), rays));
    }
    let rays = rays_with_intervals(mesh.triangles(), &mut random, 80);
    all.push(Rays::new("intervals", mesh.clone(), rays));
    let rays = grazing_rays(mesh.triangles(), &mut random, 150);
    all.push(Rays::new("grazing", mesh.clone(), rays));
    let rays = rays_of_unusual_numbers();
    all.push(Rays::new("unusual numbers", mesh, rays));

    let mesh = blocks(&mut random, 80);
    let rays = rays_in_planes(&mut random, 150);
    all.push(Rays::new("in planes", mesh, rays));
    let (mesh, rays) = corners_of_cells();
    all.push(Rays::new("corners of cells", mesh, rays.into_iter().step_by(3).collect()));
    let (mesh, rays) = corners_of_cells_in_a_room();
    all.push(Rays::new("corners of nested cells", mesh, rays.into_iter().step_by(3).collect()));

    // Each triangle twice more, at other ids.
    let mut mesh = blocks(&mut random, 30);
    let twins = mesh.clone();
    mesh.append(&twins);
    mesh.indices.reverse();
    mesh.append(&twins);
    let mut rays = Vec::new();
    for _ in 0..100 {
        let target = (random.point() * 5.0).round().as_dvec3();
        let origin = (random.point() * 12.0).round().as_dvec3();
        rays.push(Ray::new(origin, target - origin));
    }
    rays.retain(|ray| ray.direction != DVec3::ZERO);
    all.push(Rays::new("equal t", mesh, rays));

    for count in 0..20 {
        let mesh = TestMesh::soup(&mut random, count, 0.1);
        let rays = (0..10).map(|_| random_ray(&mut random, 3.0)).collect();
        all.push(Rays::new(format!("{count} triangles"), mesh, rays));
    }
    for (scale, offset) in [(1.0, Vec3::ZERO), (1e-30, Vec3::ZERO), (1e-43, Vec3::ZERO), (1e30, Vec3::ZERO)]
        .into_iter()
        .chain([(1.0, FAR), (1.0, Vec3::new(3e8, 0.0, 0.0))])
    {
        all.extend(worlds(scale, offset));
    }
    for smallness in [1e-2, 1e-5, 1e-6] {
        all.push(to_a_ball(&mut random, smallness));
    }
    for (name, mesh) in odd_meshes(&mut random) {
        let rays = rays_at(&mesh, &mut random);
        all.push(Rays::new(name, mesh, rays));
    }
    for rays in &all {
        let hits = rays.nearest.iter().flatten().count();
        let is_expected = rays.mesh.indices.len() < 60 || rays.name.starts_with('×');
        assert!(hits * 10 > rays.rays.len() || is_expected, "{}: {hits} hits", rays.name);
    }
    all
}

/// Meshes that careless builders or traversals get wrong.
fn odd_meshes(random: &mut Random) -> Vec<(&'static str, TestMesh)> {
    let mut identical = TestMesh::default();
    (0..300).for_each(|_| identical.push([Vec3::new(-1.0, -1.0, 0.0), Vec3::X, Vec3::Y]));
    let mut uneven = TestMesh::ball(1);
    uneven.push([Vec3::new(-1e6, -0.5, -1e6), Vec3::new(1e6, -0.5, -1e6), Vec3::new(0.0, -0.5, 1e6)]);
    for _ in 0..50 {
        let tip = random.point();
        uneven.push([tip, tip + random.point() * 1e-4, tip + Vec3::X * 3.0]);
    }
    let mut flat = TestMesh::default();
    (0..100).for_each(|_| flat.push([(); 3].map(|()| random.point().with_y(0.25))));
    let mut broken = TestMesh::ball(1);
    broken.push([Vec3::NAN, Vec3::X, Vec3::Y]);
    broken.push([Vec3::X, Vec3::new(f32::INFINITY, 0.0, 0.0), Vec3::Y]);
    broken.push([Vec3::X; 3]);
    broken.push([Vec3::X, Vec3::X, Vec3::Y]);
    vec![
        ("identical triangles", identical),
        ("a ball, a huge floor and needles", uneven),
        ("coplanar triangles", flat),
        ("a tiny ball", TestMesh::ball(2).placed(1e-6, Vec3::ZERO)),
        ("a huge ball", TestMesh::ball(2).placed(1e6, Vec3::ZERO)),
        ("a ball far away", TestMesh::ball(2).placed(1.0, FAR)),
        ("a ball with broken triangles", broken),
    ]
}

/// Rays of every kind at a mesh: along axes, through corners and from corners to corners.
fn rays_at(mesh: &TestMesh, random: &mut Random) -> Vec<Ray> {
    let bounds = mesh.triangles().bounds();
    let (center, size) = (bounds.center().as_dvec3(), f64::from(bounds.size().max_element()).max(1e-30));
    let usable: Vec<Vec3> = mesh.positions.iter().copied().filter(|position| position.is_finite()).collect();
    let mut rays = Vec::new();
    for kind in 0..150 {
        let mut point = || center + random.point().as_dvec3() * size;
        let (from, to, beside) = (point(), point(), point());
        let [corner, other] = [(); 2].map(|()| usable[random.below(usable.len())].as_dvec3());
        rays.push(match kind % 6 {
            0 => Ray::new(from, to - center),
            1 => Ray::new(from, DVec3::AXES[kind / 6 % 3] * size),
            2 => Ray::new(from, corner - from),
            3 => Ray::new(corner, other - corner),
            4 => Ray { t_min: 0.5, t_max: 1.0, ..Ray::new(from, corner - from) },
            _ => Ray::new(center + (from - center) * 100.0, (beside - center) * 1e-20),
        });
    }
    rays.retain(|ray| ray.direction != DVec3::ZERO);
    rays
}

/// Flat, uneven and thin scenes, scaled and moved.
fn worlds(scale: f32, offset: Vec3) -> Vec<Rays> {
    let random = &mut Random::new(6);
    let mut line = TestMesh::default();
    line.push([Vec3::ZERO, Vec3::X, Vec3::X * 2.0]);
    let mut coplanar = TestMesh::default();
    coplanar.quad([Vec3::ZERO, Vec3::X, Vec3::new(1.0, 0.0, 1.0), Vec3::Z]);
    let mut slivers = TestMesh::default();
    for _ in 0..40 {
        let (a, b) = (random.point(), random.point());
        slivers.push([a, b, a + (b - a) * 0.4 + random.point() * 1e-6]);
    }
    slivers.append(&TestMesh::plane(1, 1.0));
    let soup = TestMesh::soup(random, 60, 0.05);
    let mut two_sizes = TestMesh::soup(random, 100, 0.1).placed(1e-4, Vec3::ZERO);
    two_sizes.append(&TestMesh::plane(2, 1000.0));
    let mut worlds = Vec::new();
    for mesh in [line, coplanar, slivers, soup, TestMesh::plane(9, 2.0), two_sizes] {
        let rays = (0..40).map(|_| {
            let Ray { origin, direction, .. } = random_ray(random, 3.0);
            let scale = f64::from(scale);
            Ray::new(origin * scale + offset.as_dvec3(), direction * scale)
        });
        let rays = rays.collect();
        worlds.push(Rays::new(format!("× {scale} at {offset}"), mesh.placed(scale, offset), rays));
    }
    worlds
}

/// Rays to a ball in a stadium.
fn to_a_ball(random: &mut Random, smallness: f32) -> Rays {
    let target = |random: &mut Random| (random.point() * smallness + BALL).as_dvec3();
    let mut rays = Vec::new();
    for step in 0..100 {
        // From the room, from near the ball, from inside of it, and from so far away that rounding merges its cells.
        let origin = match step % 4 {
            0 => random.point().as_dvec3() * 0.9,
            1 => target(random) + random.point().as_dvec3() * f64::from(smallness) * 5.0,
            2 => random.point().as_dvec3() * 1e6,
            _ => target(random),
        };
        rays.push(Ray::new(origin, target(random) - origin));
    }
    Rays::new(format!("to a ball of {smallness}"), stadium(8, smallness), rays)
}

/// Triangles with a corner exactly, or to 2⁻²¹, at the corners of cells of a uniform grid with 16 cells for each
/// triangle. Rays go exactly through those corners, from nearby and from so far away that crossings with cells' faces
/// are rounded.
fn corners_of_cells() -> (TestMesh, Vec<Ray>) {
    let mut random = Random::new(21);
    let mut mesh = TestMesh::default();
    // 16³ cells in a cube of 8³ have edges of one half; a grid begins 1/64 of that before its bounds, so at zero.
    let [low, high] = [Vec3::splat(1.0 / 128.0), Vec3::splat(8.0 + 1.0 / 128.0)];
    mesh.push([low, low + Vec3::X, low + Vec3::Y]);
    mesh.push([high, high - Vec3::X, high - Vec3::Y]);
    let mut rays = Vec::new();
    while mesh.indices.len() < 256 {
        let [corner, octant] = [random.point(), random.point()];
        let beside = random.point().round() * if random.unit() < 0.5 { 1.0 / (1 << 21) as f32 } else { 0.0 };
        let corner = (corner * 6.0 + 8.0).round() * 0.5 + beside;
        // From the corner into one of the eight cells around it.
        let mut inside = || (random.point() * 30.0).round().abs().max(Vec3::ONE) / 64.0 * octant.signum();
        mesh.push([corner, corner + inside(), corner + inside()]);
        for away in [0.25, 1.0, 4.0, f64::from(1 << 20), f64::from(1 << 30)] {
            for _ in 0..6 {
                // Few digits, so that the ray goes through the corner exactly.
                let direction = (random.point() * 3.0).round().as_dvec3();
                if direction.length() > 0.0 {
                    rays.push(Ray::new(corner.as_dvec3() - direction * away, direction));
                }
            }
        }
    }
    (mesh, rays)
}

/// The triangles of [`corners_of_cells`] inside one cell of a room. There a grid with 16 cells for each triangle
/// contains the same grid as for them alone; and the same rays.
fn corners_of_cells_in_a_room() -> (TestMesh, Vec<Ray>) {
    let (mut mesh, rays) = corners_of_cells();
    // 17 cells with an edge of 62 on each axis, of which the ninth is from about -31 to 31.
    for (corner, inwards) in [(-530.0, 1.0), (470.0, -1.0)] {
        let corner = Vec3::splat(corner);
        mesh.push([corner, corner + Vec3::X * inwards, corner + Vec3::Y * inwards]);
    }
    (mesh, rays)
}

/// Triangles and boxes with small whole numbers for coordinates, so that planes, faces, corners and rays coincide.
fn blocks(random: &mut Random, count: usize) -> TestMesh {
    let mut mesh = TestMesh::default();
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
fn random_ray(random: &mut Random, reach: f32) -> Ray {
    let origin = (random.point() * reach).as_dvec3();
    let length = f64::from(random.unit()) * 3.0 + 0.01;
    Ray::new(origin, ((random.point() * 1.5).as_dvec3() - origin) * length)
}

/// Rays in planes of [`blocks`], along axes, diagonally through corners, and almost along axes, down to components
/// without a finite inverse.
fn rays_in_planes(random: &mut Random, count: usize) -> Vec<Ray> {
    let mut rays = Vec::new();
    for step in 0..count {
        // In the planes of faces, between them, and at corners.
        let mut origin = (random.point() * 6.0).round().as_dvec3();
        if step % 3 == 0 {
            origin += (random.point() * 2.0).round().as_dvec3() * 0.25;
        }
        let axis = [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z][step % 6];
        let flat = (random.point() * 3.0).round().as_dvec3() * (DVec3::ONE - axis.abs());
        rays.push(Ray::new(origin - axis * 16.0, axis * [1.0, 1e-90, 1e90][step % 3]));
        rays.push(Ray::new(origin - axis * f64::from(1 << 30), axis));
        // Zeros with both signs.
        rays.push(Ray::new(origin, axis * DVec3::new(1.0, -1.0, 1.0)));
        // Diagonally through corners, and in a plane.
        let diagonal = (random.point() * 2.0).round().as_dvec3();
        for direction in [diagonal, flat] {
            if direction != DVec3::ZERO {
                rays.push(Ray::new(origin - direction * 8.0, direction));
                rays.push(Ray::new(origin - direction * f64::from(1 << 26), direction));
            }
        }
        // Almost along an axis, down to components without a finite inverse.
        let tilt = random.point().as_dvec3() * 10.0_f64.powi(-((step % 20) as i32 * 17));
        rays.push(Ray::new(origin - axis * 16.0, axis + tilt * (DVec3::ONE - axis.abs())));
    }
    rays
}

/// Rays with ends before, behind and at their origin, and at hits.
fn rays_with_intervals(triangles: Triangles<'_>, random: &mut Random, count: usize) -> Vec<Ray> {
    let mut rays = Vec::new();
    for _ in 0..count {
        let mut ray = random_ray(random, 3.0);
        (ray.t_min, ray.t_max) = (f64::from(random.unit()) * 0.5, f64::from(random.unit()) * 2.0);
        rays.push(ray);
        // Behind the origin, and from a hit to itself and to another.
        rays.push(Ray { t_min: -3.0, t_max: -0.01, ..ray });
        rays.push(Ray { t_min: f64::NEG_INFINITY, ..ray });
        if let Some(hit) = Oracle::new(triangles).nearest(&ray, |_| true) {
            rays.push(Ray { t_min: hit.t, ..ray });
            rays.push(Ray { t_min: hit.t.next_down(), t_max: hit.t.next_up(), ..ray });
            rays.push(Ray { t_max: hit.t, ..ray });
            rays.push(Ray { t_max: hit.t.next_up(), ..ray });
        }
    }
    rays
}

/// Rays to corners, edges and insides of triangles: in the triangle's plane, almost in it, and from anywhere; from near
/// and far.
fn grazing_rays(triangles: Triangles<'_>, random: &mut Random, count: usize) -> Vec<Ray> {
    let mut rays = Vec::new();
    for step in 0..count {
        let id = (random.bits() % (triangles.len() as u64 - 2)) as u32;
        let [a, b, c] = triangles.corners(id).map(Vec3::as_dvec3);
        let weight = f64::from(random.unit());
        let on_edge = a + (b - a) * weight;
        let target = [a, on_edge, on_edge + (c - on_edge) * f64::from(random.unit())][step % 3];
        let along = (b - a) * f64::from(random.unit() - 0.5) + (c - a) * f64::from(random.unit() - 0.5);
        let lifted = along + (b - a).cross(c - a) * 10.0_f64.powi(-((step % 17) as i32));
        for direction in [along, lifted, (random.point() * 3.0).as_dvec3() - target] {
            if direction.length() > 1e-6 {
                rays.push(Ray::new(target - direction, direction));
                rays.push(Ray::new(target - direction * 100.0, direction));
            }
        }
    }
    rays
}

/// Zero, infinities, NaN and the ends of f64's range, in each part of a ray.
fn rays_of_unusual_numbers() -> Vec<Ray> {
    let plain = Ray::new(DVec3::new(0.1, 0.2, 4.0), DVec3::new(0.0, 0.1, -1.0));
    let mut rays = vec![plain; 20];
    for value in [0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -1e308, 1e-320] {
        for axis in 0..3 {
            let mut others = [plain; 3];
            others[0].origin[axis] = value;
            others[1].direction[axis] = value;
            others[2].direction = DVec3::ZERO.with_z(-1e-3);
            others[2].direction[axis] = value;
            rays.extend(others);
        }
        rays.extend([Ray { t_min: value, ..plain }, Ray { t_max: value, ..plain }]);
        rays.push(Ray { direction: DVec3::splat(value), ..plain });
        rays.push(Ray { origin: DVec3::splat(value), t_max: value, ..plain });
        rays.push(Ray { direction: plain.direction * value, ..plain });
    }
    rays
}
