//! Packets of any rays through the uniform grid against the predicate.

use glam::{DVec3, Vec3};
use umbrage_papers::uniform::any_rays::{blocked_of_packet, nearest_of_packet};
use umbrage_papers::{PacketSide, UniformGrid, UniformOptions};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Hit, LightSource, Ray, SingleRays as _};

use crate::support::{self, Mesh, Random, nearest_of_all as nearest};
use crate::uniform_grid::corner_options;

fn grid(mesh: &Mesh, packet: PacketSide) -> UniformGrid {
    grid_of(mesh, UniformOptions { packet, ..UniformOptions::DEFAULT })
}

/// A coarse grid with grids in many of its cells.
fn nested(mesh: &Mesh, packet: PacketSide) -> UniformGrid {
    let nested = UniformOptions { cells_per_triangle: 0.3, nested_above: Some(8), ..UniformOptions::DEFAULT };
    grid_of(mesh, UniformOptions { packet, ..nested })
}

fn grid_of(mesh: &Mesh, options: UniformOptions) -> UniformGrid {
    let mut grid = UniformGrid::default();
    grid.set_options(options).expect("possible options");
    grid.build(mesh.triangles());
    grid.check(mesh.triangles()).expect("a valid grid");
    grid
}

fn lights(scale: f32, offset: Vec3) -> Vec<LightSource> {
    let at = |x: f32, y: f32, z: f32| LightSource::Point { position: Vec3::new(x, y, z) * scale + offset };
    let sun = |x: f32, y: f32, z: f32| LightSource::Directional { direction: Vec3::new(x, y, z).normalize() };
    let spot = LightSource::Spot {
        position: Vec3::new(2.0, 3.0, 1.0) * scale + offset,
        direction: Vec3::new(-2.0, -3.0, -1.0).normalize(),
        inner_radians: 0.2,
        outer_radians: 0.4,
    };
    vec![
        at(3.0, 5.0, 2.0),
        at(0.3, 0.2, 0.1),
        at(0.0, -1.0, 0.0),
        at(-0.6, -0.999, 0.7),
        at(500.0, 900.0, 300.0),
        at(0.0, 1.7, -6.0),
        spot,
        sun(0.3, -1.0, 0.2),
        sun(0.0, -1.0, 0.0),
        sun(1.0, -0.01, 0.0),
    ]
}

/// A bumpy ball above a floor.
fn room() -> Mesh {
    let mut mesh = Mesh::default();
    mesh.ball(Vec3::new(0.0, 0.1, 0.0), 0.8, 14, 0.1);
    mesh.append(&Mesh::floor(3, 4.0).moved(1.0, Vec3::NEG_Y));
    mesh
}

/// Rays side by side, in all directions, along axes, from far away and with all kinds of intervals.
fn bundles(random: &mut Random) -> Vec<Vec<Ray>> {
    let mut bundles = Vec::new();
    for step in 0..40 {
        let reach = [0.5, 3.0, 30.0, 3e6][step % 4];
        let (origin, target) = (random.point() * reach, random.point());
        let spread = [0.01, 0.1, 1.0][step % 3];
        let mut bundle: Vec<Ray> = (0..[1, 7, 64, 300][step / 4 % 4])
            .map(|_| {
                let origin = (origin + random.point() * spread).as_dvec3();
                Ray::new(origin, (target + random.point() * spread).as_dvec3() - origin)
            })
            .collect();
        if step % 5 == 0 {
            let axis = [DVec3::X, DVec3::NEG_Y, DVec3::Z][step % 3];
            bundle.iter_mut().for_each(|ray| ray.direction = axis * if random.unit() < 0.2 { -1.0 } else { 0.5 });
        }
        if step % 7 == 0 {
            bundle.iter_mut().for_each(|ray| ray.direction = random.point().as_dvec3());
        }
        if step % 3 == 0 {
            bundle.iter_mut().for_each(|ray| {
                (ray.t_min, ray.t_max) = (f64::from(random.unit()) - 0.5, f64::from(random.unit()) * 2.0);
            });
        }
        bundles.push(bundle);
    }
    bundles
}

#[test]
fn packets_of_rays_through_corners_of_cells_hit_what_the_predicate_says() {
    let (mesh, rays) = support::corners_of_cells();
    let cells_per_triangle = support::CORNER_CELLS;
    check_corners(&mesh, &rays, UniformOptions { cells_per_triangle, ..UniformOptions::DEFAULT });
}

#[test]
fn packets_of_rays_through_corners_of_nested_cells_hit_what_the_predicate_says() {
    let (mesh, rays) = support::corners_of_cells_in_a_room();
    check_corners(&mesh, &rays, corner_options());
}

/// Compares packets of few rays with the predicate.
fn check_corners(mesh: &Mesh, rays: &[Ray], options: UniformOptions) {
    let grid = grid_of(mesh, options);
    assert_eq!(grid.nested_grids(), usize::from(options.nested_above.is_some()));
    let expected: Vec<_> = rays.iter().map(|ray| nearest(mesh.triangles(), ray, |_| true)).collect();
    // Alone, and with others from and to anywhere.
    for together in [1, 3] {
        for (rays, expected) in rays.chunks(together).zip(expected.chunks(together)) {
            let mut found = [None; 3];
            let found = &mut found[..rays.len()];
            nearest_of_packet(&grid, mesh.triangles(), rays, |_| true, found);
            assert_eq!(found, expected, "{rays:?}");
        }
    }
    assert!(expected.iter().flatten().count() > rays.len() / 2);
}

#[test]
fn rays_that_are_not_numbers_leave_the_others_of_a_packet_alone() {
    let mut random = Random(12);
    let mut mesh = Mesh::soup(&mut random, 60, 0.05);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 10));
    let triangles = mesh.triangles();
    let grid = grid(&mesh, PacketSide::Eight);
    let plain = Ray::new(DVec3::new(0.1, 0.2, 4.0), DVec3::new(0.0, 0.1, -1.0));
    let mut unusual = Vec::new();
    for value in [0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -1e308, 1e-320] {
        for axis in 0..3 {
            let mut other = [plain; 3];
            other[0].origin[axis] = value;
            other[1].direction[axis] = value;
            other[2].direction = DVec3::ZERO.with_z(-1e-3);
            other[2].direction[axis] = value;
            unusual.extend(other);
        }
        unusual.extend([Ray { t_min: value, ..plain }, Ray { t_max: value, ..plain }]);
        unusual.push(Ray { direction: DVec3::splat(value), ..plain });
        unusual.push(Ray { origin: DVec3::splat(value), t_max: value, ..plain });
        unusual.push(Ray { direction: plain.direction * value, ..plain });
    }
    let mut hits = 0;
    for (step, other) in unusual.into_iter().enumerate() {
        let origin = (random.point() * 4.0).as_dvec3();
        let mut rays: Vec<Ray> = (0..20).map(|_| Ray::new(origin, random.point().as_dvec3() - origin)).collect();
        rays.insert([0, 7][step % 2], other);
        let mut found = vec![None; rays.len()];
        nearest_of_packet(&grid, triangles, &rays, |_| true, &mut found);
        for (ray, found) in rays.iter().zip(&found) {
            let expected = nearest(triangles, ray, |_| true);
            assert_eq!(*found, expected, "{ray:?} with {other:?}");
            assert_eq!(grid.nearest(triangles, ray, &|_| true), expected, "{ray:?} alone");
            hits += usize::from(expected.is_some());
        }
    }
    assert!(hits > 500, "{hits}");
}

#[test]
fn packets_of_any_rays_hit_what_the_predicate_says() {
    let mut random = Random(9);
    let mut mesh = Mesh::soup(&mut random, 200, 0.02);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 10));
    mesh.append(&Mesh::floor(6, 3.0));
    let triangles = mesh.triangles();
    let grids = [grid, nested].map(|form| form(&mesh, PacketSide::Eight));
    let counts = |hit: &Hit| !hit.triangle.is_multiple_of(7) || hit.barycentric[0] < 0.5;
    let (mut hits, mut misses) = (0, 0);
    for bundle in bundles(&mut random) {
        let expected: Vec<_> = bundle.iter().map(|ray| nearest(triangles, ray, counts)).collect();
        for grid in &grids {
            let mut found = vec![None; bundle.len()];
            nearest_of_packet(grid, triangles, &bundle, counts, &mut found);
            assert!(found == expected, "{bundle:?} through {grid:?}");
        }
        hits += expected.iter().flatten().count();
        misses += expected.iter().filter(|expected| expected.is_none()).count();
    }
    assert!(hits > 500 && misses > 500, "{hits} {misses}");
}

#[test]
fn packets_of_any_shadow_rays_are_blocked_as_the_predicate_says() {
    let mut random = Random(10);
    let mut mesh = Mesh::soup(&mut random, 60, 0.05);
    mesh.append(&room());
    let triangles = mesh.triangles();
    let grid = grid(&mesh, PacketSide::Eight);
    let nested = nested(&mesh, PacketSide::Eight);
    let counts = |id: u32, [b, _]: [f32; 2]| !id.is_multiple_of(5) || b < 0.5;
    let (mut lit, mut shadowed) = (0, 0);
    for (step, bundle) in bundles(&mut random).into_iter().enumerate() {
        let all = lights(1.0, Vec3::ZERO);
        // From one light, or from another for each ray.
        let light = |place: usize| all[if step % 2 == 0 { step % all.len() } else { place % all.len() }];
        let (mut rays, mut own) = (Vec::new(), Vec::new());
        for (place, ray) in bundle.iter().enumerate() {
            if let Some(hit) = grid.nearest(triangles, ray, &|_| true) {
                rays.push(ShadowRay::new(&light(place), HitPoint::new(ray, hit.t)));
                own.push(hit.triangle);
            }
        }
        let mut blocked = vec![true; rays.len()];
        blocked_of_packet(&grid, triangles, &rays, &own, counts, &mut blocked);
        let mut nested_blocked = vec![true; rays.len()];
        blocked_of_packet(&nested, triangles, &rays, &own, counts, &mut nested_blocked);
        assert!(nested_blocked == blocked, "{rays:?}");
        for (place, ray) in rays.iter().enumerate() {
            let others = (0..triangles.len() as u32).filter(|&id| id != own[place]);
            let expected = others
                .filter_map(|id| Some((id, ray.blocked_by(triangles.corners(id))?)))
                .any(|(id, barycentric)| counts(id, barycentric));
            assert_eq!(blocked[place], expected, "{ray:?}");
            if expected { shadowed += 1 } else { lit += 1 }
        }
    }
    assert!(lit > 100 && shadowed > 100, "{lit} {shadowed}");
}
