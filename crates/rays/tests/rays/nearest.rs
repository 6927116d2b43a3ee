//! Nearest points, against the distance from every triangle in big numbers.

use std::cmp::Ordering;

use glam::{DVec3, Vec3};
use umbrage_rays::{Closest, ClosestPoints, Nearest, SimdLevel, Triangles, Within};

use crate::exact::{Fraction, closest, side, squared_distance};
use crate::support::{Mesh, Random, blocks, is_usable, scene};

/// Points anywhere around a mesh, on its corners, edges and faces and just beside them, between its triangles, and far away.
fn points(random: &mut Random, triangles: Triangles<'_>, reach: f32, count: usize) -> Vec<Vec3> {
    let mut points = Vec::new();
    let usable: Vec<u32> = (0..triangles.len() as u32).filter(|&id| is_usable(triangles, id)).collect();
    for step in 0..count {
        let anywhere = random.point() * (1.5 * reach);
        let Some(&id) = usable.get(random.bits() as usize % usable.len().max(1)) else {
            points.push(anywhere);
            continue;
        };
        let [a, b, c] = triangles.corners(id);
        let on_edge = a.lerp(b, random.unit());
        let inside = on_edge.lerp(c, random.unit());
        let beside =
            |at: Vec3, random: &mut Random| at + random.point() * reach * 10.0_f32.powi(-(step as i32 / 12 % 8));
        points.push(match step % 12 {
            0 => a,
            1 => on_edge,
            2 => inside,
            3 => beside(a, random),
            4 => beside(inside, random),
            // Right angles.
            5 => (anywhere / reach * 8.0).round() / 8.0 * reach,
            6 => a.midpoint(b),
            7 => a.midpoint(b) + (b - a).cross(c - a).normalize_or_zero() * reach,
            8 => anywhere * 1e3,
            9 => a + Vec3::Y * reach * 0.25,
            10 => (a + b + c) / 3.0,
            _ => anywhere,
        });
    }
    points.retain(|point| point.is_finite());
    points
}

/// Finds nearest points by every level, on one thread and on two: the same.
fn found(nearest: &mut [Nearest], query: &Closest<'_>) -> ClosestPoints {
    let mut all = Vec::new();
    for nearest in nearest {
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let mut found = ClosestPoints::default();
            pool.install(|| {
                nearest.build(query.triangles);
                nearest.closest_points(query, &mut found);
            });
            all.push(found);
        }
    }
    let same = |one: &ClosestPoints, other: &ClosestPoints| {
        let bits = |found: &ClosestPoints| {
            let numbers = found.position.iter().flat_map(DVec3::to_array).chain(found.distance.iter().copied());
            let weights = found.barycentric.as_flattened().iter().map(|weight| weight.to_bits());
            (numbers.map(f64::to_bits).collect::<Vec<_>>(), weights.collect::<Vec<_>>())
        };
        one.triangle == other.triangle && bits(one) == bits(other) && one.nowhere == other.nowhere
    };
    let first = all.swap_remove(0);
    assert!(all.iter().all(|other| same(&first, other)), "levels and threads differ");
    first
}

fn every_level() -> Vec<Nearest> {
    SimdLevel::available().into_iter().map(Nearest::with_level).collect()
}

/// The answers that differ from the truth, in words. `tolerance` is of the distance, in that of the triangle's second nearest
/// corner.
fn faults(query: &Closest<'_>, found: &ClosestPoints, tolerance: f64) -> Vec<String> {
    let Closest { triangles, points, max } = *query;
    let mut faults = Vec::new();
    assert_eq!(found.len(), points.len());
    for (index, &point) in points.iter().enumerate() {
        let truth = closest(triangles, point).filter(|(_, square)| {
            max > 0.0 && (max == f64::INFINITY || square.compare(&Fraction::square_of(max)) == Ordering::Less)
        });
        let (id, distance) = (found.triangle[index], found.distance[index]);
        let expected = truth.as_ref().map_or(ClosestPoints::NONE, |(id, _)| *id);
        if id != expected {
            let distances = [id, expected].map(|id| {
                if id == ClosestPoints::NONE { f64::NAN } else { squared_distance(point, triangles.corners(id)).root() }
            });
            faults.push(format!("{point}: {id} instead of {expected}, at {distances:?} within {max}"));
        }
        let Some((_, square)) = truth.filter(|_| id == expected) else {
            if id == ClosestPoints::NONE && !(distance == f64::INFINITY && found.position[index].is_nan()) {
                faults.push(format!("{point}: a miss at {distance}"));
            }
            continue;
        };
        let corners = triangles.corners(id).map(Vec3::as_dvec3);
        // The second nearest: one far away doesn't make it less exact.
        let mut of_corners = corners.map(|corner| corner.distance(point.as_dvec3()));
        of_corners.sort_unstable_by(f64::total_cmp);
        let of_corners = of_corners[1];
        let largest = corners.iter().chain([&point.as_dvec3()]).map(|at| at.abs().max_element()).fold(0.0, f64::max);
        let error = (distance - square.root()).abs();
        if error > tolerance * of_corners {
            faults.push(format!("{point}: {distance}, wrong by {error:e} of {of_corners}"));
        }
        let of_position = (found.position[index].distance(point.as_dvec3()) - distance).abs();
        if of_position > 1e-14 * largest {
            faults.push(format!("{point}: at {}, wrong by {of_position:e} of {largest}", found.position[index]));
        }
        let [v, w] = found.barycentric[index].map(f64::from);
        let at = corners[0] * (1.0 - v - w) + corners[1] * v + corners[2] * w;
        if !(v >= 0.0 && w >= 0.0 && v + w <= 1.0 + 1e-7 && at.distance(found.position[index]) <= 1e-6 * largest) {
            faults.push(format!("{point}: weights {v} and {w}"));
        }
    }
    faults
}

fn check(name: &str, nearest: &mut [Nearest], query: &Closest<'_>, tolerance: f64) {
    let found = found(nearest, query);
    let faults = faults(query, &found, tolerance);
    assert!(
        faults.is_empty(),
        "{name}: {} of {}\n{}",
        faults.len(),
        query.points.len(),
        faults[..faults.len().min(20)].join("\n")
    );
}

/// Triangles with shared corners, in one plane, of small whole numbers, without area, without finite corners, and slivers.
fn meshes(random: &mut Random) -> Vec<(&'static str, Mesh, f64)> {
    let mut slivers = Mesh::default();
    for number in 0..40 {
        let [a, b] = [random.point(), random.point()];
        let thin = random.point() * 10.0_f32.powi(-(number % 9));
        slivers.push([a, b, a.lerp(b, random.unit()) + thin]);
        slivers.push([a, b, a.lerp(b, 0.5)]);
        slivers.push([a, b, b]);
    }
    slivers.push([Vec3::splat(0.1); 3]);
    let mut plane = Mesh::floor(6, 1.0);
    plane.append(&Mesh::floor(4, 1.0));
    vec![
        ("a scene", scene(random), 1e-14),
        ("blocks", blocks(random, 24).moved(0.25, Vec3::ZERO), 1e-14),
        ("a ball", Mesh::bumpy_ball(Vec3::ZERO, 1.0, 8), 1e-14),
        ("a plane", plane, 1e-14),
        ("slivers", slivers, 1e-13),
        ("one triangle", Mesh { indices: vec![[2, 0, 1]], ..Mesh::soup(random, 1, 1.0) }, 1e-14),
    ]
}

#[test]
fn nearest_triangles_are_those_of_big_numbers() {
    let mut random = Random(71);
    let mut nearest = every_level();
    for round in 0..3 {
        for (name, mesh, tolerance) in meshes(&mut random) {
            let points = points(&mut random, mesh.triangles(), 1.0, 120);
            for max in [f64::INFINITY, 0.3, 0.0] {
                let query = Closest { max, ..Closest::new(mesh.triangles(), &points) };
                check(&format!("{name}, round {round}"), &mut nearest, &query, tolerance);
            }
        }
    }
}

#[test]
fn nearest_triangles_of_every_scale_are_those_of_big_numbers() {
    let mut random = Random(72);
    let mut nearest = every_level();
    for scale in [1e-37, 1e-30, 1e-18, 1e-6, 1e-3, 1e3, 1e6, 1e18, 1e30, 1e37] {
        for (name, mesh, tolerance) in meshes(&mut random) {
            let mesh = mesh.moved(scale, Vec3::ZERO);
            let points = points(&mut random, mesh.triangles(), scale, 36);
            let query = Closest::new(mesh.triangles(), &points);
            check(&format!("{name} of {scale:e}"), &mut nearest, &query, tolerance);
        }
    }
}

#[test]
fn far_corners_and_points_change_nothing() {
    let mut random = Random(73);
    let mut nearest = every_level();
    for reach in [1e4, 1e9, 1e20, 1e36, 3e38] {
        let mut mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 6);
        mesh.positions[30] = random.point() * reach;
        mesh.positions[50] = random.point() * reach;
        let mut points = points(&mut random, mesh.triangles(), 1.0, 60);
        points.extend((0..6).map(|_| random.point() * reach));
        check(&format!("corners at {reach:e}"), &mut nearest, &Closest::new(mesh.triangles(), &points), 1e-14);
        // Far from everything, and far above a plane and boxes.
        let mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 6);
        for mesh in [&mesh, &Mesh::floor(7, 1.0), &blocks(&mut random, 9)] {
            let mut points: Vec<Vec3> = (0..12).map(|_| random.point() * reach).collect();
            points.extend((0..12).map(|_| random.point().with_y(reach)));
            points.extend((0..6).map(|_| random.point().round().with_x(-reach)));
            points.extend((0..6).map(|_| random.point()));
            check(&format!("points at {reach:e}"), &mut nearest, &Closest::new(mesh.triangles(), &points), 1e-14);
        }
        // All of it far from the origin.
        let mesh = mesh.moved(reach * 1e-6, Vec3::new(0.3, -0.5, 0.7) * reach);
        let points: Vec<Vec3> = mesh.positions.iter().map(|at| at + random.point() * reach * 1e-6).collect();
        check(&format!("a ball at {reach:e}"), &mut nearest, &Closest::new(mesh.triangles(), &points[..60]), 1e-14);
    }
}

#[test]
fn limits_are_exact() {
    let mut random = Random(74);
    let mut nearest = every_level();
    let mesh = scene(&mut random);
    for point in points(&mut random, mesh.triangles(), 1.0, 40) {
        let (_, square) = closest(mesh.triangles(), point).expect("a triangle");
        let distance = square.root();
        for max in [distance, distance.next_up(), distance.next_down(), 1e-160, 5e-324, -1.0, f64::NAN] {
            let points = [point];
            check("a limit", &mut nearest, &Closest { max, ..Closest::new(mesh.triangles(), &points) }, 1e-14);
        }
    }
    // 3, 4 and 5.
    let mesh = Mesh { positions: vec![Vec3::new(3.0, 4.0, 0.0); 3], indices: vec![[0, 1, 2]] };
    for (max, expected) in [(5.0, ClosestPoints::NONE), (5.0_f64.next_up(), 0)] {
        let points = [Vec3::ZERO];
        let found = found(&mut nearest, &Closest { max, ..Closest::new(mesh.triangles(), &points) });
        assert_eq!(found.triangle, [expected], "{max}");
    }
}

#[test]
fn bad_numbers_have_no_nearest_point_and_are_counted() {
    let mut random = Random(75);
    let mut nearest = every_level();
    let mesh = scene(&mut random);
    let mut points = points(&mut random, mesh.triangles(), 1.0, 200);
    for (step, point) in points.iter_mut().enumerate() {
        let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][step % 3];
        if step % 5 < 2 {
            point[step / 3 % 3] = bad;
        }
    }
    let finite: Vec<Vec3> = points.iter().copied().filter(|point| point.is_finite()).collect();
    let of_all = found(&mut nearest, &Closest::new(mesh.triangles(), &points));
    let of_finite = found(&mut nearest, &Closest::new(mesh.triangles(), &finite));
    assert_eq!((of_all.nowhere, of_finite.nowhere), (points.len() - finite.len(), 0));
    let mut answers = of_finite.triangle.iter();
    for (index, point) in points.iter().enumerate() {
        let expected = if point.is_finite() { *answers.next().expect("an answer") } else { ClosestPoints::NONE };
        assert_eq!(of_all.triangle[index], expected, "{point}");
    }
    for indices in [vec![], vec![[0, 1, 9999]]] {
        let empty = Mesh { positions: vec![Vec3::ZERO; 3], indices };
        let found = found(&mut nearest, &Closest::new(empty.triangles(), &points));
        assert!(found.triangle.iter().all(|&id| id == ClosestPoints::NONE));
        assert_eq!(found.nowhere, of_all.nowhere);
    }
    assert!(found(&mut nearest, &Closest::new(mesh.triangles(), &[])).is_empty());
    for count in [200, 20] {
        let query = Closest { max: 0.0, ..Closest::new(mesh.triangles(), &points[..count]) };
        assert_eq!(found(&mut nearest, &query).triangle, vec![ClosestPoints::NONE; count]);
        found(&mut nearest, &Closest::new(mesh.triangles(), &points));
    }
}

#[test]
fn triangles_without_finite_corners_are_near_to_nothing() {
    let mut nearest = every_level();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            // Their other corners are nearer than the triangle that counts.
            let mut mesh = Mesh::default();
            for number in 0..3 {
                let mut corners = [Vec3::X, Vec3::Y, Vec3::Z];
                corners[1 + number % 2][axis] = bad;
                mesh.push(corners);
            }
            mesh.push([Vec3::splat(3.0), Vec3::new(3.0, 4.0, 3.0), Vec3::new(4.0, 3.0, 3.0)]);
            let points = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::splat(1e9)];
            check(&format!("{bad} on axis {axis}"), &mut nearest, &Closest::new(mesh.triangles(), &points), 1e-14);
        }
    }
}

#[test]
fn frames_of_moving_and_changing_triangles_are_right() {
    let mut random = Random(76);
    let mut nearest = every_level();
    let mut mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 20);
    for frame in 0..6 {
        if frame == 4 {
            mesh = scene(&mut random);
        }
        for position in &mut mesh.positions {
            *position += random.point() * 0.05;
        }
        let points = points(&mut random, mesh.triangles(), 1.0, 90 - frame * 7);
        check(&format!("frame {frame}"), &mut nearest, &Closest::new(mesh.triangles(), &points), 1e-13);
    }
}

#[test]
fn many_points_of_a_mesh_have_the_answers_of_each_alone() {
    let mut random = Random(77);
    let mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 60);
    let points: Vec<Vec3> = (0..5000).map(|_| random.point() * 1.5).collect();
    let (mut nearest, mut all, mut one) = (Nearest::default(), ClosestPoints::default(), ClosestPoints::default());
    nearest.build(mesh.triangles());
    nearest.closest_points(&Closest::new(mesh.triangles(), &points), &mut all);
    for (index, point) in points.iter().enumerate() {
        nearest.closest_points(&Closest::new(mesh.triangles(), &[*point]), &mut one);
        assert_eq!((all.triangle[index], all.distance[index]), (one.triangle[0], one.distance[0]), "{point}");
    }
}

#[test]
fn copies_of_a_triangle_in_one_spot_are_told_apart_by_their_ids() {
    let mut mesh = Mesh::default();
    let mut corners = [Vec3::new(0.1, 0.2, 0.3), Vec3::new(1.7, 0.1, 0.4), Vec3::new(0.3, 1.9, -0.2)];
    for number in 0..100_000 {
        corners.rotate_left(number % 3);
        mesh.push(corners);
    }
    let points = [Vec3::new(0.5, 0.5, 2.0), Vec3::new(-1.0, -2.0, 0.0), Vec3::new(5.0, 5.0, 5.0), corners[0]];
    let found = found(&mut every_level(), &Closest::new(mesh.triangles(), &points));
    assert_eq!(found.triangle, [0; 4]);
}

#[test]
fn steady_queries_take_nothing_from_the_heap() {
    let mut random = Random(78);
    let mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 30);
    let points: Vec<Vec3> = (0..3000).map(|_| random.point() * 1.5).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    pool.install(|| {
        let (mut nearest, mut found) = (Nearest::default(), ClosestPoints::default());
        let counted = [(); 4].map(|()| {
            let before = allocations::on_this_thread();
            nearest.build(mesh.triangles());
            nearest.signed_distances(&Closest::new(mesh.triangles(), &points), &mut found);
            allocations::on_this_thread() - before
        });
        assert!(counted[0] > 0 && counted[3] == 0, "{counted:?}");
    });
}

/// Points found inside by every level, on one thread and on two: the same.
fn inside(triangles: Triangles<'_>, points: &[Vec3]) -> Vec<bool> {
    let mut all = Vec::new();
    for mut nearest in every_level() {
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let mut inside = vec![true];
            pool.install(|| {
                nearest.build(triangles);
                nearest.inside(triangles, points, &mut inside);
            });
            all.push(inside);
        }
    }
    assert!(all.iter().all(|other| *other == all[0]), "levels and threads differ");
    all.swap_remove(0)
}

#[test]
fn points_on_the_sides_of_boxes_are_inside_of_one_of_two_neighbours() {
    let mut random = Random(80);
    for scale in [1.0, 1e-37, 1e-20, 0.3, 1e30, 1e37] {
        let mut mesh = Mesh::default();
        let mut boxes = Vec::new();
        for _ in 0..12 {
            let low = (random.point() * 4.0).round();
            let size = (random.point() * 2.0).round().abs() + 1.0;
            let [x, y, z] = [Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z];
            for [along, across, to] in [[x, y, z], [y, z, x], [z, x, y]] {
                for start in [low, low + to] {
                    mesh.quad([start, start + along, start + along + across, start + across]);
                }
            }
            boxes.push([low * scale, (low + size) * scale]);
        }
        // Triangles without area or finite corners aren't crossed.
        mesh.push([Vec3::ZERO, Vec3::ZERO, Vec3::X * 9.0]);
        mesh.push([Vec3::new(-9.0, -9.0, -9.0), Vec3::new(0.0, 9.0, -9.0), Vec3::new(0.0, f32::NAN, 9.0)]);
        let mesh = mesh.moved(scale, Vec3::ZERO);
        let mut points: Vec<Vec3> = (0..300).map(|_| (random.point() * 6.0).round() * scale).collect();
        points.extend((0..300).map(|_| (random.point() * 12.0).round() * (0.5 * scale)));
        points.extend((0..300).map(|_| random.point() * (6.0 * scale)));
        points.extend([Vec3::NAN, Vec3::INFINITY, Vec3::splat(1e38), Vec3::splat(-1e38)]);
        let found = inside(mesh.triangles(), &points);
        for (point, found) in points.iter().zip(found) {
            let is_in = |[low, high]: &&[Vec3; 2]| point.cmpge(*low).all() && point.cmplt(*high).all();
            let count = boxes.iter().filter(is_in).count();
            assert_eq!(found, count % 2 == 1, "{point} of {scale:e}, in {count} boxes");
        }
    }
}

#[test]
fn points_inside_of_tetrahedra_are_on_the_inner_sides_of_all_faces() {
    let mut random = Random(81);
    for round in 0..40 {
        let scale = [1.0, 1e-6, 1e6, 1e-30, 1e30][round % 5];
        let (mut mesh, mut all) = (Mesh::default(), Vec::new());
        for _ in 0..10 {
            // Of any shape, or of small whole numbers.
            let corner =
                |random: &mut Random| if round % 2 == 0 { random.point() } else { (random.point() * 3.0).round() };
            let corners = [0; 4].map(|_| corner(&mut random) * scale);
            let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [3, 2, 1]].map(|face| face.map(|index| corners[index]));
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners);
            mesh.indices
                .extend([[0, 1, 2], [0, 2, 3], [0, 3, 1], [3, 2, 1]].map(|face| face.map(|index: u32| index + first)));
            all.push(faces);
        }
        let mut points: Vec<Vec3> = (0..60).map(|_| random.point() * scale).collect();
        points.extend((0..60).map(|_| (random.point() * 3.0).round() * (0.5 * scale)));
        points.extend(mesh.positions.iter().map(|at| at.lerp(random.point() * scale, 1e-6)));
        // Ahead of and behind edges, as far beside them as rounding takes them.
        for &[a, b, _] in &mesh.indices {
            let [a, b] = [a, b].map(|vertex| mesh.positions[vertex as usize]);
            points.extend([0; 4].map(|_| a.lerp(b, random.unit()) + Vec3::X * (random.point().x * 0.5 * scale)));
        }
        let found = inside(mesh.triangles(), &points);
        let (mut nearest, mut signed) = (Nearest::default(), ClosestPoints::default());
        nearest.build(mesh.triangles());
        nearest.signed_distances(&Closest::new(mesh.triangles(), &points), &mut signed);
        for (index, &point) in points.iter().enumerate() {
            assert_eq!(signed.distance[index] <= 0.0 && signed.distance[index].is_sign_negative(), found[index]);
            let sides: Vec<_> = all.iter().map(|faces| faces.map(|face| side(point, face))).collect();
            if sides.iter().flatten().any(|side| *side == Ordering::Equal) {
                continue;
            }
            let is_in = |sides: &&[Ordering; 4]| sides.iter().all(|side| *side == sides[0]);
            let count = sides.iter().filter(is_in).count();
            assert_eq!(found[index], count % 2 == 1, "{point} in round {round}, in {count}");
        }
    }
}

#[test]
fn points_on_inner_faces_and_edges_are_inside_of_one_part() {
    let mut random = Random(83);
    let (mut nearest, mut inside) = (Nearest::default(), Vec::new());
    for round in 0..200 {
        // Four tetrahedra around an axis.
        let [u, v, mut w] = [0; 3].map(|_| (random.point() * 3.5).round() * 8.0);
        if round % 3 == 0 {
            w = Vec3::Y * 16.0;
        }
        if u.dot(v.cross(w)) == 0.0 {
            continue;
        }
        let weights = [0.0, 0.25, -0.25, 0.375, -0.125];
        let points: Vec<Vec3> = weights
            .iter()
            .flat_map(|a| weights.map(|b| u * *a + w * b).into_iter().chain(weights.map(|b| v * *a + w * b)))
            .collect();
        let mut counts = vec![0; points.len()];
        for [side, next] in [[u, v], [v, -u], [-u, -v], [-v, u]] {
            let indices = vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [3, 2, 1]];
            let mesh = Mesh { positions: vec![w, -w, side, next], indices };
            nearest.build(mesh.triangles());
            nearest.inside(mesh.triangles(), &points, &mut inside);
            counts.iter_mut().zip(&inside).for_each(|(count, inside)| *count += usize::from(*inside));
        }
        assert_eq!(counts, vec![1; points.len()], "round {round}: {u}, {v}, {w}");
    }
}

#[test]
fn triangles_within_a_distance_are_those_of_big_numbers() {
    let mut random = Random(82);
    let (mut nearest, mut within) = (every_level(), Within::default());
    for (name, mesh, _) in meshes(&mut random) {
        let triangles = mesh.triangles();
        let mut points = points(&mut random, triangles, 1.0, 30);
        points.push(Vec3::NAN);
        // Distances from corners of small whole numbers among them.
        for max in [0.5, 0.25, 1.25, 0.0, f64::INFINITY] {
            let is_near = |point: Vec3, id: u32| {
                is_usable(triangles, id)
                    && (max == f64::INFINITY
                        || max > 0.0
                            && squared_distance(point, triangles.corners(id)).compare(&Fraction::square_of(max))
                                == Ordering::Less)
            };
            let truth: Vec<Vec<u32>> = points
                .iter()
                .map(|&point| {
                    (0..triangles.len() as u32).filter(|&id| point.is_finite() && is_near(point, id)).collect()
                })
                .collect();
            for nearest in &mut nearest {
                nearest.build(triangles);
                nearest.within(&Closest { max, ..Closest::new(triangles, &points) }, &mut within);
                assert_eq!(within.starts.len(), points.len() + 1);
                for (index, truth) in truth.iter().enumerate() {
                    assert_eq!(within.of(index), truth, "{name}, {} within {max}", points[index]);
                }
            }
        }
    }
}
