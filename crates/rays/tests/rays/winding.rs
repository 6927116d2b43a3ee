//! Generalised winding numbers, against known answers and the sum over all triangles.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use umbrage_rays::{Nearest, SimdLevel, Triangles};

use crate::support::{Mesh, Random, is_usable, scene};

/// The solid angle of a triangle, of its own formula with an arc tangent, in whole spheres.
fn of_triangle(point: Vec3, corners: [Vec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3() - point.as_dvec3());
    let (of_a, of_b, of_c) = (a.length(), b.length(), c.length());
    let real = of_a * of_b * of_c + a.dot(b) * of_c + b.dot(c) * of_a + c.dot(a) * of_b;
    a.dot(b.cross(c)).atan2(real) / (2.0 * PI)
}

fn full_sum(triangles: Triangles<'_>, point: Vec3) -> f64 {
    let usable = (0..triangles.len() as u32).filter(|&id| is_usable(triangles, id));
    usable.map(|id| of_triangle(point, triangles.corners(id))).sum()
}

/// Winding numbers by every level, on one thread and on two: the same bits.
fn numbers(triangles: Triangles<'_>, points: &[Vec3]) -> Vec<f64> {
    let mut all = Vec::new();
    for level in SimdLevel::available() {
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let (mut nearest, mut found) = (Nearest::with_level(level), Vec::new());
            pool.install(|| {
                nearest.build(triangles);
                nearest.winding_numbers(triangles, points, &mut found);
            });
            all.push(found);
        }
    }
    let bits = |numbers: &[f64]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>();
    let first = all.swap_remove(0);
    assert!(all.iter().all(|other| bits(other) == bits(&first)), "levels and threads differ");
    first
}

fn assert_near(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (index, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() <= tolerance, "point {index}: {found} instead of {expected}");
    }
}

/// A ball whose fronts are outside.
fn ball(rings: u32, bump: f32) -> Mesh {
    let mut mesh = Mesh::default();
    mesh.ball(Vec3::ZERO, 1.0, rings, bump);
    mesh
}

/// A cube from 0 to 1 whose fronts are outside.
fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        let [x, y] = [1, 2].map(|step| Vec3::AXES[(axis + step) % 3]);
        let high = Vec3::AXES[axis];
        mesh.quad([high, high + x, high + x + y, high + y]);
        mesh.quad([Vec3::ZERO, y, x + y, x]);
    }
    mesh
}

/// The largest difference from the full sum.
fn error(triangles: Triangles<'_>, points: &[Vec3]) -> f64 {
    let found = numbers(triangles, points);
    found.iter().zip(points).map(|(found, &point)| (found - full_sum(triangles, point)).abs()).fold(0.0, f64::max)
}

#[test]
fn closed_meshes_have_whole_numbers() {
    let mut random = Random(81);
    let points: Vec<Vec3> = (0..1000).map(|_| random.point() * 1.5).collect();
    for bump in [0.0, 0.1] {
        let mesh = ball(40, bump);
        let (mut nearest, mut inside) = (Nearest::default(), Vec::new());
        nearest.build(mesh.triangles());
        nearest.inside(mesh.triangles(), &points, &mut inside);
        let expected: Vec<f64> = inside.iter().map(|&is_inside| f64::from(u8::from(is_inside))).collect();
        assert_near(&numbers(mesh.triangles(), &points), &expected, 1e-2);
        let mut turned = mesh.clone();
        turned.indices.iter_mut().for_each(|corners| corners.swap(1, 2));
        let expected: Vec<f64> = expected.iter().map(|number| -number).collect();
        assert_near(&numbers(turned.triangles(), &points), &expected, 1e-2);
    }
    // Shells inside of one another, and both sides of a surface, near it and far away.
    let mut shells = ball(24, 0.0);
    shells.append(&ball(24, 0.0).moved(0.5, Vec3::ZERO));
    let points = [0.0, 0.45, 0.55, 0.98, 1.01, 3.0, 1e6, 1e30].map(|x| Vec3::new(x, 0.0, 0.1 * x));
    assert_near(&numbers(shells.triangles(), &points), &[2.0, 2.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0], 1e-2);
}

#[test]
fn one_triangle_has_its_solid_angle() {
    let octant = Mesh { positions: vec![Vec3::X, Vec3::Y, Vec3::Z], indices: vec![[0, 1, 2]] };
    let found = numbers(octant.triangles(), &[Vec3::ZERO, Vec3::splat(1.0 / 3.0)]);
    assert_near(&found[..1], &[0.125], 1e-16);
    let mut random = Random(82);
    for _ in 0..50 {
        let corners = [(); 3].map(|()| random.point());
        let mesh = Mesh { positions: corners.into(), indices: vec![[0, 1, 2]] };
        // Near it, where it isn't expanded.
        let points: Vec<Vec3> =
            (0..20).map(|_| (corners[0] + corners[1] + corners[2]) / 3.0 + random.point() * 0.1).collect();
        let expected: Vec<f64> = points.iter().map(|&point| of_triangle(point, corners)).collect();
        assert_near(&numbers(mesh.triangles(), &points), &expected, 1e-14);
    }
}

#[test]
fn open_meshes_have_the_part_of_directions_that_they_cover() {
    let whole = ball(64, 0.0);
    let is_above = |corners: &&[u32; 3]| corners.iter().all(|&vertex| whole.positions[vertex as usize].y > -1e-6);
    let half = Mesh { indices: whole.indices.iter().filter(is_above).copied().collect(), ..whole.clone() };
    let found = numbers(half.triangles(), &[Vec3::ZERO, Vec3::Y * 0.9, Vec3::Y * -0.9, Vec3::Y * 5.0]);
    assert_near(&found[..1], &[0.5], 1e-2);
    assert!(found[1] > 0.8 && found[2] < 0.3 && found[2] > 0.0 && found[3] < 0.0, "{found:?}");
    // A ball with holes: as the full sum has it, and still inside.
    let mut random = Random(83);
    let left = ball(40, 0.1).indices.into_iter().filter(|_| random.unit() < 0.9).collect();
    let holes = Mesh { indices: left, ..ball(40, 0.1) };
    let points: Vec<Vec3> = (0..400).map(|_| random.point() * 1.5).collect();
    assert!(error(holes.triangles(), &points) < 1e-2);
    assert!(numbers(holes.triangles(), &[Vec3::splat(0.1)])[0] > 0.8);
}

#[test]
fn sums_are_near_the_full_sum() {
    let mut random = Random(84);
    let mut largest = 0.0_f64;
    for round in 0..4 {
        let soup = Mesh::soup(&mut random, 600, 1e-3);
        let reach = Mesh::soup(&mut random, 200, 1e-1);
        for mesh in [soup, reach, scene(&mut random), Mesh::floor(40, 1.0), ball(60, 0.1)] {
            let points: Vec<Vec3> = (0..150).map(|step| random.point() * [0.5, 1.5, 4.0][step % 3]).collect();
            let error = error(mesh.triangles(), &points);
            println!("round {round}, {} triangles: {error:e}", mesh.indices.len());
            largest = largest.max(error);
        }
    }
    assert!(largest < 1e-2, "{largest:e}");
}

#[test]
fn every_scale_has_the_same_numbers() {
    let mut random = Random(85);
    let mesh = Mesh::soup(&mut random, 200, 1e-2);
    let points: Vec<Vec3> = (0..100).map(|_| random.point() * 3.0).collect();
    let expected = numbers(mesh.triangles(), &points);
    for exponent in [-100, -30, 30, 100] {
        let scale = 2.0_f32.powi(exponent);
        let scaled: Vec<Vec3> = points.iter().map(|&point| point * scale).collect();
        assert_near(&numbers(mesh.moved(scale, Vec3::ZERO).triangles(), &scaled), &expected, 1e-9);
    }
}

#[test]
fn points_on_a_surface_are_between_its_sides() {
    let cube = cube();
    let points = [
        Vec3::new(0.5, 0.25, 0.0),
        // On a diagonal, an edge and a corner.
        Vec3::new(0.5, 0.5, 1.0),
        Vec3::new(0.5, 0.0, 0.0),
        Vec3::ZERO,
        Vec3::new(1.0, 1.0, 1.0),
        // Beside them.
        Vec3::new(0.5, 0.25, 1e-30),
        Vec3::new(0.5, 0.25, -1e-30),
        // In planes of faces.
        Vec3::new(2.0, 0.5, 0.0),
    ];
    let expected = [0.5, 0.5, 0.25, 0.125, 0.125, 1.0, 0.0, 0.0];
    assert_near(&numbers(cube.triangles(), &points), &expected, 1e-12);
}

#[test]
fn answers_dont_depend_on_other_points_or_earlier_frames() {
    let mut random = Random(86);
    let (mesh, other) = (ball(30, 0.1), Mesh::soup(&mut random, 500, 1e-2));
    let points: Vec<Vec3> = (0..300).map(|_| random.point() * 1.5).collect();
    let expected = numbers(mesh.triangles(), &points);
    let (mut nearest, mut found) = (Nearest::default(), Vec::new());
    for mesh in [&mesh, &mesh, &other, &mesh] {
        nearest.build(mesh.triangles());
        nearest.winding_numbers(mesh.triangles(), &points, &mut found);
    }
    assert_eq!(found, expected);
    for (point, expected) in points.iter().zip(&expected) {
        nearest.winding_numbers(mesh.triangles(), &[*point], &mut found);
        assert_eq!(found, [*expected]);
    }
    // Steady frames take no memory.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let taken = pool.install(|| {
        nearest.build(mesh.triangles());
        nearest.winding_numbers(mesh.triangles(), &points, &mut found);
        let before = allocations::on_this_thread();
        nearest.build(mesh.triangles());
        nearest.winding_numbers(mesh.triangles(), &points, &mut found);
        allocations::on_this_thread() - before
    });
    assert_eq!(taken, 0);
}

#[test]
fn bad_numbers_and_nothing() {
    let mut mesh = ball(10, 0.0);
    let points = [Vec3::ZERO, Vec3::NAN, Vec3::new(0.0, f32::INFINITY, 0.0), Vec3::splat(5.0)];
    let expected = numbers(mesh.triangles(), &points);
    assert!(expected[1].is_nan() && expected[2].is_nan());
    mesh.push([Vec3::NAN, Vec3::X, Vec3::Y]);
    mesh.push([Vec3::X, Vec3::new(f32::INFINITY, 0.0, 0.0), Vec3::Y]);
    mesh.push([Vec3::X * 2.0, Vec3::X * 2.0, Vec3::Y]);
    mesh.indices.push([0, 1, 99_999]);
    let found = numbers(mesh.triangles(), &points);
    assert_near(&[found[0], found[3]], &[1.0, 0.0], 1e-2);
    for indices in [vec![], vec![[0, 1, 99_999]]] {
        let empty = Mesh { positions: vec![Vec3::ZERO; 3], indices };
        let found = numbers(empty.triangles(), &points);
        assert_eq!([found[0], found[3]], [0.0, 0.0]);
        assert!(found[1].is_nan() && found[2].is_nan());
    }
    assert!(numbers(mesh.triangles(), &[]).is_empty());
    // Largest and smallest numbers stay numbers.
    let far = [DVec3::splat(3e38).as_vec3(), Vec3::splat(1e-38), Vec3::splat(-3e38)];
    assert!(numbers(mesh.triangles(), &far).iter().all(|number| number.is_finite()));
}
