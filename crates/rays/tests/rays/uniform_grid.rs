//! The uniform grid, ray by ray, against the hierarchy and the predicate asked about every triangle.

use glam::{DVec3, Vec3};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{
    Bvh, Hit, Insertion, LightSource, Ray, SingleRays as _, Structure as _, Triangles, UniformGrid, UniformOptions,
};

use crate::support::{self, Mesh, Random, blocked_by_any, nearest_of_all as nearest, random_ray};

/// Grids of every kind.
fn options() -> [UniformOptions; 7] {
    let plain = UniformOptions::DEFAULT;
    let nested = UniformOptions { nested_above: Some(8), ..plain };
    [
        plain,
        UniformOptions { insertion: Insertion::Exact, ..plain },
        UniformOptions { cells_per_triangle: 0.3, macrocell: 1, ..plain },
        UniformOptions { cells_per_triangle: 60.0, macrocell: 4, insertion: Insertion::Exact, ..plain },
        // Coarse, so that many cells are crowded, and grids are inside of grids.
        UniformOptions { cells_per_triangle: 0.1, ..nested },
        UniformOptions { cells_per_triangle: 0.5, macrocell: 2, insertion: Insertion::Exact, ..nested },
        UniformOptions { nested_above: Some(1), ..plain },
    ]
}

fn grid(triangles: Triangles<'_>, options: UniformOptions) -> UniformGrid {
    let mut grid = UniformGrid::default();
    grid.set_options(options).expect("possible options");
    grid.build(triangles);
    grid.check(triangles).unwrap_or_else(|broken| panic!("{options:?}: {broken}"));
    grid
}

/// Compares all grids, and the hierarchy, with the predicate for each ray; how many rays hit.
fn check(mesh: &Mesh, rays: &[Ray]) -> usize {
    let triangles = mesh.triangles();
    let expected: Vec<_> = rays.iter().map(|ray| nearest(triangles, ray, |_| true)).collect();
    let bits = |hit: &Option<Hit>| hit.map(|hit| (hit.triangle, hit.t.to_bits(), hit.barycentric));
    let mut bvh = Bvh::default();
    bvh.build(triangles);
    for (ray, expected) in rays.iter().zip(&expected) {
        assert_eq!(bits(&bvh.nearest(triangles, ray, &|_| true)), bits(expected), "{ray:?} through the hierarchy");
    }
    for options in options() {
        let grid = grid(triangles, options);
        for (ray, expected) in rays.iter().zip(&expected) {
            let found = grid.nearest(triangles, ray, &|_| true);
            assert_eq!(bits(&found), bits(expected), "{ray:?} through {grid:?}, {options:?}");
        }
    }
    expected.iter().flatten().count()
}

fn scene(random: &mut Random) -> Mesh {
    let mut mesh = Mesh::soup(random, 150, 0.02);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 10));
    mesh.append(&Mesh::floor(6, 3.0));
    mesh.positions[5].x = f32::NAN;
    mesh.indices.push([0, 1, u32::MAX]);
    mesh.indices.push([7, 7, 8]);
    mesh
}

#[test]
fn random_rays_hit_what_the_predicate_says() {
    let mut random = Random(1);
    let mesh = scene(&mut random);
    for options in options() {
        let nested = grid(mesh.triangles(), options).nested_grids();
        assert_eq!(nested > 0, options.nested_above.is_some(), "{options:?}: {nested}");
    }
    for reach in [0.5, 3.0, 40.0, 3e6, 1e15] {
        let rays: Vec<_> = (0..200).map(|_| random_ray(&mut random, reach)).collect();
        let hits = check(&mesh, &rays);
        assert!(hits > 50, "{hits} hits from {reach}");
    }
}

#[test]
fn intervals_are_kept() {
    let mut random = Random(2);
    let mesh = scene(&mut random);
    let mut rays = Vec::new();
    for _ in 0..150 {
        let mut ray = random_ray(&mut random, 3.0);
        (ray.t_min, ray.t_max) = (f64::from(random.unit()) * 0.5, f64::from(random.unit()) * 2.0);
        rays.push(ray);
        // Behind the origin, and from a hit to itself and to another.
        rays.push(Ray { t_min: -3.0, t_max: -0.01, ..ray });
        if let Some(hit) = nearest(mesh.triangles(), &ray, |_| true) {
            rays.push(Ray { t_min: hit.t, ..ray });
            rays.push(Ray { t_max: hit.t, ..ray });
            rays.push(Ray { t_max: hit.t.next_up(), ..ray });
        }
    }
    assert!(check(&mesh, &rays) > 100);
}

#[test]
fn rays_along_axes_and_in_planes_of_cells_hit_what_the_predicate_says() {
    let mut random = Random(3);
    let mut mesh = scene(&mut random);
    // Cubes whose sides are likely to be where cells meet.
    for size in [0.25, 0.5, 2.0] {
        for axis in 0..3 {
            let place = |a: f32, b: f32| {
                let mut corner = [a, b, size];
                corner.rotate_right(axis);
                Vec3::from(corner)
            };
            mesh.quad([place(-size, -size), place(size, -size), place(size, size), place(-size, size)]);
        }
    }
    let lattice = grid(mesh.triangles(), UniformOptions::DEFAULT);
    let mut rays = Vec::new();
    for step in 0..400 {
        let mut origin = (random.point() * 3.5).as_dvec3();
        if step % 2 == 0 {
            origin = (origin * 4.0).round() * 0.25;
        }
        let direction =
            [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_X, DVec3::new(1.0, -1.0, 0.0), DVec3::ONE][step % 6];
        rays.push(Ray::new(origin, direction * [1.0, 1e-90, 1e90][step % 3]));
        // Almost along an axis.
        let tilt = random.point().as_dvec3() * 10.0_f64.powi(-((step % 20) as i32));
        rays.push(Ray::new(origin, direction + tilt));
        // Through corners of cells.
        let [low, high] = [lattice.cell_corner([0; 3]), lattice.cell_corner(lattice.cells())];
        let cell = (random.point() * 0.5 + 0.5).as_dvec3() * f64::from(lattice.cells()[0]);
        let corner = low + (high - low) / glam::UVec3::from(lattice.cells()).as_dvec3() * cell.floor();
        rays.push(Ray::new(corner, direction));
        rays.push(Ray::new(corner - direction * 8.0, direction));
    }
    assert!(check(&mesh, &rays) > 300);
}

#[test]
fn triangles_in_planes_of_cells_are_hit() {
    let mut random = Random(11);
    let mut mesh = scene(&mut random);
    let first = mesh.positions.len();
    (0..60).for_each(|_| mesh.push([0; 3].map(|_| random.point() * 0.5)));
    let before = grid(mesh.triangles(), UniformOptions::DEFAULT);
    let mut rays = Vec::new();
    for triangle in 0..60 {
        let axis = triangle % 3;
        let mut cell = before.cells().map(|cells| cells / 4 + (random.bits() % u64::from(cells / 2)) as u32);
        let corner = before.cell_corner(cell);
        cell[axis] += 1;
        let sides = before.cell_corner(cell.map(|at| at + 1)) - corner;
        let normal = [DVec3::X, DVec3::Y, DVec3::Z][axis] * sides;
        let across = [DVec3::Y, DVec3::Z, DVec3::X][axis] * sides;
        let along = [DVec3::Z, DVec3::X, DVec3::Y][axis] * sides;
        let positions = match triangle % 4 {
            // In the plane of the corner but for an ulp, and around the corner.
            0 => [corner - across - along, corner + across * 2.0 - along, corner + along * 2.0 - across],
            // Touching the corner, from one of the cells around it.
            1 => [corner, corner + across * 0.5 + along * 0.2 + normal * 0.3, corner + along * 0.5 + normal * 0.1],
            2 => [corner, corner - across * 0.5 - along * 0.2 - normal * 0.3, corner - along * 0.5 - normal * 0.1],
            _ => [corner, corner - across * 0.5 + along * 0.2 + normal * 0.3, corner + along * 0.5 - across * 0.1],
        };
        let positions = positions.map(DVec3::as_vec3);
        mesh.positions[first + 3 * triangle..][..3].copy_from_slice(&positions);
        for step in 0..40 {
            // Few digits, so that the ray goes through the target exactly.
            let tilt = (random.point() * 64.0).round().as_dvec3() / 64.0 * 2.0_f64.powi(-(step / 2));
            let direction = [DVec3::X, DVec3::Y, DVec3::Z][axis] + tilt;
            let target = positions[0].as_dvec3() + if step % 4 == 0 { across * 0.3 } else { DVec3::ZERO };
            // From far away crossings are rounded, so that the walk may be beside the target.
            let away = if step % 3 == 0 { 0.125 } else { f64::from(1 << 24) };
            rays.push(Ray::new(target - direction * away, direction));
            rays.push(Ray::new(target + direction * away, -direction));
        }
    }
    assert_eq!(grid(mesh.triangles(), UniformOptions::DEFAULT).cells(), before.cells());
    assert!(check(&mesh, &rays) > 4000);
}

#[test]
fn triangles_that_end_where_cells_meet_are_hit() {
    let (mesh, rays) = support::corners_of_cells();
    let triangles = mesh.triangles();
    let expected: Vec<_> = rays.iter().map(|ray| nearest(triangles, ray, |_| true)).collect();
    for insertion in [Insertion::BoundingBox, Insertion::Exact] {
        for macrocell in [1, 2, 6] {
            let cells_per_triangle = support::CORNER_CELLS;
            let grid =
                grid(triangles, UniformOptions { cells_per_triangle, insertion, macrocell, ..UniformOptions::DEFAULT });
            assert_eq!((grid.cells(), grid.cell_corner([2, 4, 6])), ([17; 3], DVec3::new(1.0, 2.0, 3.0)));
            for (ray, expected) in rays.iter().zip(&expected) {
                assert_eq!(grid.nearest(triangles, ray, &|_| true), *expected, "{ray:?}, {insertion:?}");
            }
        }
    }
    assert!(expected.iter().flatten().count() > rays.len() / 2);
}

#[test]
fn triangles_that_end_where_nested_cells_meet_are_hit() {
    // Inside of one of the room's cells, the same lattice as around the triangles alone.
    let (mesh, rays) = support::corners_of_cells_in_a_room();
    let triangles = mesh.triangles();
    let expected: Vec<_> = rays.iter().map(|ray| nearest(triangles, ray, |_| true)).collect();
    for insertion in [Insertion::BoundingBox, Insertion::Exact] {
        for macrocell in [1, 2, 6] {
            let options = UniformOptions { insertion, macrocell, ..support::corner_options() };
            let grid = grid(triangles, options);
            assert_eq!(grid.nested_grids(), 1, "{grid:?}");
            for (ray, expected) in rays.iter().zip(&expected) {
                assert_eq!(grid.nearest(triangles, ray, &|_| true), *expected, "{ray:?}, {insertion:?}");
            }
        }
    }
    assert!(expected.iter().flatten().count() > rays.len() / 2);
}

#[test]
fn balls_in_stadiums_are_hit_through_grids_in_grids() {
    let mut random = Random(12);
    for smallness in [1e-2, 1e-3, 1e-5, 1e-6] {
        let mesh = support::stadium(8, smallness);
        let nested = grid(mesh.triangles(), UniformOptions { nested_above: Some(8), ..UniformOptions::DEFAULT });
        assert!(nested.nested_grids() > usize::from(smallness < 1e-4), "{smallness}: {nested:?}");
        let target = |random: &mut Random| (random.point() * smallness + support::BALL_PLACE).as_dvec3();
        let rays: Vec<_> = (0..150)
            .map(|step| {
                // From the room, from near the ball, from inside of it, and from where numbers don't tell its cells apart.
                let origin = match step % 4 {
                    0 => random.point().as_dvec3() * 0.9,
                    1 => target(&mut random) + random.point().as_dvec3() * f64::from(smallness) * 5.0,
                    2 => random.point().as_dvec3() * 1e6,
                    _ => target(&mut random),
                };
                Ray::new(origin, target(&mut random) - origin)
            })
            .collect();
        assert!(check(&mesh, &rays) > 100);
    }
}

#[test]
fn crowds_in_one_cell_take_bounded_memory() {
    let mut random = Random(13);
    let options = UniformOptions { nested_above: Some(8), ..UniformOptions::DEFAULT };
    // Spread through a small box, and all of one size with it, so that no grid tells them apart.
    for size in [0.01, 1.0] {
        let mut mesh = support::stadium(1, 1e-4);
        for _ in 0..100_000 {
            let center = random.point();
            let corners = [0; 3].map(|_| (center + random.point() * size) * 1e-4 + support::BALL_PLACE);
            mesh.push(corners);
        }
        let mut nested = UniformGrid::default();
        nested.set_options(options).expect("possible options");
        nested.build(mesh.triangles());
        assert!(nested.nested_grids() > 0, "{nested:?}");
        let count = mesh.indices.len();
        let most = count as u64 * UniformGrid::MOST_REFERENCES + UniformGrid::LEAST_LIMIT;
        assert!(nested.nested_references() as u64 <= most, "{nested:?}");
        assert!(nested.bytes().triangles < 400 * count, "{} bytes a triangle", nested.bytes().triangles / count);
        // What one cell lists, lists each triangle of it once.
        let ray = Ray::new(support::BALL_PLACE.as_dvec3() + 1e-3, -DVec3::ONE);
        assert_eq!(nested.nearest(mesh.triangles(), &ray, &|_| true), nearest(mesh.triangles(), &ray, |_| true));
    }
}

#[test]
fn grazing_rays_and_shared_edges_hit_what_the_predicate_says() {
    let mut random = Random(4);
    let mesh = scene(&mut random);
    let rays = support::grazing_rays(mesh.triangles(), &mut random, 300);
    assert!(check(&mesh, &rays) > 300);
}

#[test]
fn any_number_of_triangles_is_hit_and_rebuilt() {
    let mut random = Random(5);
    let mut grids = [UniformGrid::default(), UniformGrid::default()];
    let nested = UniformOptions { cells_per_triangle: 0.2, nested_above: Some(2), ..UniformOptions::DEFAULT };
    grids[1].set_options(nested).expect("possible options");
    assert!(
        grids
            .iter()
            .all(|grid| { grid.nearest(Triangles::default(), &Ray::new(DVec3::ZERO, DVec3::X), &|_| true).is_none() })
    );
    for count in (0..40).chain([300, 0, 5, 300, 100, 200]) {
        let mesh = Mesh::soup(&mut random, count, 0.1);
        for grid in &mut grids {
            grid.build(mesh.triangles());
            grid.check(mesh.triangles()).expect("a valid grid");
            for _ in 0..20 {
                let ray = random_ray(&mut random, 3.0);
                let found = grid.nearest(mesh.triangles(), &ray, &|_| true);
                assert_eq!(found, nearest(mesh.triangles(), &ray, |_| true), "{count} triangles, {ray:?}");
            }
        }
        assert!(grids[0].nested_grids() == 0 && (count < 300 || grids[1].nested_grids() > 0), "{grids:?}");
    }
    // Without them again.
    grids[1].set_options(UniformOptions::DEFAULT).expect("possible options");
    let mesh = Mesh::soup(&mut random, 300, 0.1);
    grids.iter_mut().for_each(|grid| grid.build(mesh.triangles()));
    assert!(grids[1].is_same_as(&grids[0]) && grids[1].nested_grids() == 0);
}

#[test]
fn flat_huge_tiny_and_far_scenes_hit_what_the_predicate_says() {
    let mut random = Random(6);
    let mut flat = Mesh::floor(9, 2.0);
    let wall = |place: Vec3| Vec3::new(place.x, 0.0, place.z);
    let mut line = Mesh::default();
    line.push([Vec3::ZERO, Vec3::X, Vec3::X * 2.0]);
    let soup = Mesh::soup(&mut random, 60, 0.05);
    flat.positions.iter_mut().for_each(|position| *position = wall(*position));
    let mut two_sizes = Mesh::soup(&mut random, 200, 0.1).moved(1e-4, Vec3::ZERO);
    two_sizes.append(&Mesh::floor(2, 1000.0));
    for (mesh, must_hit) in [(&flat, true), (&line, false), (&soup, true), (&two_sizes, true)] {
        for (scale, offset) in [
            (1.0, Vec3::ZERO),
            (1e-30, Vec3::ZERO),
            (1e30, Vec3::ZERO),
            (1.0, Vec3::new(148_376.0, 1234.0, -223_423.0)),
            (1.0, Vec3::new(3e8, 0.0, 0.0)),
        ] {
            let mesh = mesh.moved(scale, offset);
            let rays: Vec<_> = (0..80)
                .map(|_| {
                    let Ray { origin, direction, .. } = random_ray(&mut random, 3.0);
                    let scale = f64::from(scale);
                    Ray::new(origin * scale + offset.as_dvec3(), direction * scale)
                })
                .collect();
            let hits = check(&mesh, &rays);
            assert!(hits > 0 || !must_hit || offset.x > 1e8, "{scale} {offset}");
        }
    }
}

#[test]
fn hits_that_do_not_count_are_passed_through() {
    let mut random = Random(7);
    let mesh = scene(&mut random);
    let grid = grid(mesh.triangles(), UniformOptions::DEFAULT);
    let counts = |hit: &Hit| hit.triangle.is_multiple_of(3) && hit.barycentric[0] < 0.7;
    let mut hits = 0;
    for _ in 0..300 {
        let ray = random_ray(&mut random, 3.0);
        let expected = nearest(mesh.triangles(), &ray, counts);
        assert_eq!(grid.nearest(mesh.triangles(), &ray, &counts), expected, "{ray:?}");
        hits += usize::from(expected.is_some());
    }
    assert!(hits > 30, "{hits}");
}

#[test]
fn points_are_shadowed_as_the_predicate_says() {
    let mut random = Random(8);
    let mesh = scene(&mut random);
    let triangles = mesh.triangles();
    let lights = [
        LightSource::Point { position: Vec3::new(3.0, 5.0, 2.0) },
        LightSource::Point { position: Vec3::new(0.1, 0.3, 0.2) },
        LightSource::Directional { direction: Vec3::new(0.3, -0.9, 0.1).normalize() },
        LightSource::Directional { direction: Vec3::NEG_Y },
    ];
    let (mut lit, mut shadowed) = (0, 0);
    for options in options() {
        let grid = grid(triangles, options);
        for step in 0..300 {
            let ray = random_ray(&mut random, 4.0);
            let Some(seen) = nearest(triangles, &ray, |_| true) else { continue };
            let shadow_ray = ShadowRay::new(&lights[step % 4], HitPoint::new(&ray, seen.t));
            let counts = |id: u32, barycentric: [f32; 2]| !id.is_multiple_of(5) || barycentric[1] < 0.5;
            let expected = blocked_by_any(triangles, &shadow_ray, seen.triangle, counts);
            assert_eq!(grid.blocked(triangles, &shadow_ray, seen.triangle, &counts), expected, "{ray:?}");
            if expected { shadowed += 1 } else { lit += 1 }
        }
    }
    assert!(lit > 50 && shadowed > 50, "{lit} {shadowed}");
}

#[test]
fn grids_are_the_same_on_any_number_of_threads() {
    let mut random = Random(9);
    let mut mesh = Mesh::soup(&mut random, 30_000, 0.01);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 60));
    // More than a thread takes at once in one cell, and many cells.
    let ball = Mesh::bumpy_ball(Vec3::ZERO, 1e-3, 80);
    mesh.append(&ball.moved(1.0, Vec3::new(1.7, 0.31, 0.52)));
    for nested_above in [None, Some(8)] {
        let options = UniformOptions { nested_above, ..UniformOptions::DEFAULT };
        let build = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| grid(mesh.triangles(), options))
        };
        let one = build(1);
        assert!(one.references() > 40_000 && one.bytes().triangles > 0);
        assert_eq!(one.nested_grids() > 50, nested_above.is_some(), "{one:?}");
        for threads in [2, 5] {
            assert!(build(threads).is_same_as(&one), "{threads} threads");
        }
        assert!(!one.is_same_as(&grid(mesh.triangles(), UniformOptions { nested_above: Some(20), ..options })));
    }
}

#[test]
fn exact_insertion_has_fewer_references() {
    let mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 60);
    let [boxes, exact] = [Insertion::BoundingBox, Insertion::Exact]
        .map(|insertion| grid(mesh.triangles(), UniformOptions { insertion, ..UniformOptions::DEFAULT }).references());
    // The paper: by more than one third.
    assert!(exact * 4 < boxes * 3, "{exact} {boxes}");
}

#[test]
fn large_triangles_do_not_fill_memory() {
    let mut random = Random(10);
    let mut mesh = Mesh::default();
    (0..5000).for_each(|_| mesh.push([random.point(), random.point(), random.point()]));
    let grid = grid(mesh.triangles(), UniformOptions { cells_per_triangle: 100.0, ..UniformOptions::DEFAULT });
    let limit = 5000 * UniformGrid::MOST_REFERENCES + UniformGrid::LEAST_LIMIT;
    assert!(grid.references() as u64 <= limit && grid.references() as u64 > limit / 8, "{grid:?}");
}

#[test]
fn impossible_options_are_refused() {
    let mut grid = UniformGrid::default();
    for cells_per_triangle in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = UniformOptions { cells_per_triangle, ..UniformOptions::DEFAULT };
        assert!(grid.set_options(options).unwrap_err().to_string().contains("cells a triangle"));
    }
    for macrocell in [0, 65] {
        assert!(grid.set_options(UniformOptions { macrocell, ..UniformOptions::DEFAULT }).is_err());
    }
    let nested = UniformOptions { nested_above: Some(0), ..UniformOptions::DEFAULT };
    assert!(grid.set_options(nested).unwrap_err().to_string().contains("more than 0 triangles"));
}
