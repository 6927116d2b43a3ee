//! The uniform grid, ray by ray, against the hierarchy and the predicate asked about every triangle.

use glam::{DVec3, Vec3};
use umbrage_papers::{Insertion, PacketSide, UniformGrid, UniformOptions};
use umbrage_rays::{Bvh, Choice as _, Hit, Ray, SimdLevel, SingleRays as _, Structure, Triangles};

use crate::support::{self, CORNER_CELLS, Mesh, Random, far, nearest_of_all as nearest, pairs, random_ray, scales};

/// World position of the first corner of a cell, which may be one beyond the last.
fn corner_of(grid: &UniformGrid, cell: [u32; 3]) -> DVec3 {
    let lattice = grid.lattice().expect("a grid that was built");
    lattice.corner + glam::UVec3::from(cell).as_dvec3() * lattice.side
}

/// Options for [`corners_of_cells_in_a_room`](support::corners_of_cells_in_a_room).
pub(crate) fn corner_options() -> UniformOptions {
    UniformOptions { cells_per_triangle: CORNER_CELLS, nested_above: Some(64), ..UniformOptions::DEFAULT }
}

/// Grids of every kind.
fn options() -> [UniformOptions; 8] {
    let plain = UniformOptions::DEFAULT;
    let nested = UniformOptions { nested_above: Some(8), ..plain };
    [
        plain,
        UniformOptions { cells_per_triangle: 0.3, macrocell: 1, ..plain },
        UniformOptions { cells_per_triangle: 60.0, macrocell: 4, ..plain },
        // Coarse, so that many cells are crowded and grids are nested.
        UniformOptions { cells_per_triangle: 0.1, ..nested },
        UniformOptions { cells_per_triangle: 0.5, macrocell: 2, ..nested },
        UniformOptions { nested_above: Some(1), ..plain },
        UniformOptions { insertion: Insertion::Exact, ..plain },
        UniformOptions { insertion: Insertion::Exact, ..nested },
    ]
}

fn grid(triangles: Triangles<'_>, options: UniformOptions) -> UniformGrid {
    let mut grid = UniformGrid::default();
    grid.set_options(options).expect("possible options");
    grid.build(triangles);
    grid.check(triangles).unwrap_or_else(|broken| panic!("{options:?}: {broken}"));
    grid
}

/// Compares all grids, and the hierarchy, with the predicate for each ray. Returns the number of hits.
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
fn rays_along_axes_and_in_planes_of_cells_hit_what_the_predicate_says() {
    let mut random = Random(3);
    let mut mesh = scene(&mut random);
    // Cubes whose sides are likely to be planes between cells.
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
        let [low, high] = [corner_of(&lattice, [0; 3]), corner_of(&lattice, lattice.cells())];
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
        let corner = corner_of(&before, cell);
        cell[axis] += 1;
        let sides = corner_of(&before, cell.map(|at| at + 1)) - corner;
        let normal = [DVec3::X, DVec3::Y, DVec3::Z][axis] * sides;
        let across = [DVec3::Y, DVec3::Z, DVec3::X][axis] * sides;
        let along = [DVec3::Z, DVec3::X, DVec3::Y][axis] * sides;
        let positions = match triangle % 4 {
            // In the plane of the corner up to an ulp, and around the corner.
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
    for macrocell in [1, 2, 6] {
        let cells_per_triangle = CORNER_CELLS;
        let grid = grid(triangles, UniformOptions { cells_per_triangle, macrocell, ..UniformOptions::DEFAULT });
        assert_eq!((grid.cells(), corner_of(&grid, [2, 4, 6])), ([17; 3], DVec3::new(1.0, 2.0, 3.0)));
        for (ray, expected) in rays.iter().zip(&expected) {
            assert_eq!(grid.nearest(triangles, ray, &|_| true), *expected, "{ray:?}");
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
    for macrocell in [1, 2, 6] {
        let grid = grid(triangles, UniformOptions { macrocell, ..corner_options() });
        assert_eq!(grid.nested_grids(), 1, "{grid:?}");
        for (ray, expected) in rays.iter().zip(&expected) {
            assert_eq!(grid.nearest(triangles, ray, &|_| true), *expected, "{ray:?}");
        }
    }
    assert!(expected.iter().flatten().count() > rays.len() / 2);
}

#[test]
fn crowds_in_one_cell_take_bounded_memory() {
    let mut random = Random(13);
    let options = UniformOptions { nested_above: Some(8), ..UniformOptions::DEFAULT };
    // Spread through a small box, then all as large as that box, so that no grid tells them apart.
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
        // A cell's list holds each of its triangles once.
        let ray = Ray::new(support::BALL_PLACE.as_dvec3() + 1e-3, -DVec3::ONE);
        assert_eq!(nested.nearest(mesh.triangles(), &ray, &|_| true), nearest(mesh.triangles(), &ray, |_| true));
    }
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
    // Without nested grids again.
    grids[1].set_options(UniformOptions::DEFAULT).expect("possible options");
    let mesh = Mesh::soup(&mut random, 300, 0.1);
    grids.iter_mut().for_each(|grid| grid.build(mesh.triangles()));
    assert!(grids[1].is_same_as(&grids[0]) && grids[1].nested_grids() == 0);
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
fn large_triangles_do_not_fill_memory() {
    let mut random = Random(10);
    let mut mesh = Mesh::default();
    (0..5000).for_each(|_| mesh.push([random.point(), random.point(), random.point()]));
    let grid = grid(mesh.triangles(), UniformOptions { cells_per_triangle: 100.0, ..UniformOptions::DEFAULT });
    let limit = 5000 * UniformGrid::MOST_REFERENCES + UniformGrid::LEAST_LIMIT;
    assert!(grid.references() as u64 <= limit && grid.references() as u64 > limit / 8, "{grid:?}");
}

#[test]
fn exact_insertion_makes_fewer_references() {
    let mesh = Mesh::soup(&mut Random(3), 2000, 0.3);
    let references = [Insertion::Boxes, Insertion::Exact].map(|insertion| {
        let grid = grid(mesh.triangles(), UniformOptions { insertion, ..UniformOptions::DEFAULT });
        assert!(insertion.to_string().parse() == Ok(insertion));
        grid.references()
    });
    assert!(3 * references[1] < 2 * references[0], "{references:?}");
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
    for shadow_spread in [0.0, -0.1, f32::NAN, f32::INFINITY] {
        assert!(grid.set_options(UniformOptions { shadow_spread, ..UniformOptions::DEFAULT }).is_err());
    }
    let nested = UniformOptions { nested_above: Some(0), ..UniformOptions::DEFAULT };
    assert!(grid.set_options(nested).unwrap_err().to_string().contains("more than 0 triangles"));
}

#[test]
fn packets_are_named_by_their_side() {
    for side in PacketSide::all() {
        assert_eq!((side.name(), side.name().parse()), (side.pixels().to_string().as_str(), Ok(side)));
    }
}

fn of_row(row: &mut pairs::Row<'_>, level: SimdLevel) -> Box<dyn Structure> {
    let packets: Vec<PacketSide> = PacketSide::all().collect();
    let options = UniformOptions {
        cells_per_triangle: row.pick("cells", &[0.3, 6.0, 60.0]),
        macrocell: row.pick("macrocell", &[1, 4, 6]),
        insertion: row.pick("insertion", &[Insertion::Boxes, Insertion::Exact]),
        packet: row.pick("packet", &packets),
        nested_above: row.pick("nested above", &[None, Some(1), Some(8)]),
        shadow_spread: row.pick("spread", &[1e-4, 0.05, 10.0]),
    };
    let mut grid = UniformGrid::with_level(level);
    grid.set_options(options).expect("possible options");
    Box::new(grid)
}

fn structures() -> scales::Structures {
    let mut nested = UniformGrid::default();
    let options = UniformOptions { cells_per_triangle: 0.3, nested_above: Some(4), ..UniformOptions::DEFAULT };
    nested.set_options(options).expect("possible options");
    vec![("uniform grid", Box::new(UniformGrid::default())), ("nested grid", Box::new(nested))]
}

#[test]
fn grids_of_all_pairs_of_options_answer_as_the_predicate_does() {
    pairs::check(of_row);
}

#[test]
fn scenes_of_every_scale_are_seen_and_lit_as_the_predicate_says() {
    scales::check_every_scale(structures());
}

#[test]
fn scenes_some_of_which_is_far_away_are_seen_and_lit_as_the_predicate_says() {
    scales::check_far_parts(structures());
}

#[test]
fn scenes_with_one_far_vertex_or_one_huge_triangle_are_answered_as_the_predicate_does() {
    far::check_answers(UniformGrid::default());
}
