//! The perspective grid against the predicate, asked about every pair of a pixel and a triangle.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec2, Vec3};
use umbrage_rays::predicate::crossing;
use umbrage_rays::{
    Camera, Hit, Mask, MaskAnswers, MaskPoints, PerspectiveGrid, PixelWork, Projection, SeenPixels, SimdLevel,
    Triangles, Unmasked, View,
};

use crate::support::{self, Mesh, Random, assert_exact, check, is_same, view};

const MIDDLE: DVec2 = DVec2::splat(0.5);

#[test]
fn work_adds_up_and_changes_nothing() {
    let mut mesh = Mesh::soup(&mut Random(7), 200, 0.1);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 40));
    let (width, height) = (192, 128);
    let view = view(width, height);
    let (mut grid, mut reference, mut seen) =
        (PerspectiveGrid::default(), SeenPixels::default(), SeenPixels::default());
    let mut work = PixelWork::default();
    grid.build(mesh.triangles(), &view, MIDDLE, |_| false).expect("a small image");
    let plain = grid.trace(mesh.triangles(), Unmasked, &mut reference);
    for _ in 0..2 {
        let counts = grid.trace_counting(mesh.triangles(), Unmasked, &mut seen, &mut work);
        assert!(is_same(&seen, &reference));
        assert_eq!(counts, plain);
        assert!(counts.listed > 0 && counts.fragments > 0);
        let pixels = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        assert_eq!(pixels().map(|(x, y)| u64::from(work.at(x, y).undecided)).sum::<u64>(), counts.undecided);
        // Each tile's pixels have its lists in common.
        assert_eq!(pixels().map(|(x, y)| u64::from(work.at(x, y).pairs)).sum::<u64>(), counts.listed * 64 * 64);
        assert!(pixels().all(|(x, y)| work.at(x, y).pairs == work.at(x / 64 * 64, y / 64 * 64).pairs));
    }
}

#[test]
fn soups_of_all_sizes_are_seen_exactly() {
    let mut random = Random(1);
    for (width, height) in [(1, 1), (7, 3), (64, 64), (65, 30), (90, 70)] {
        for smallest in [1.0, 0.1, 0.001] {
            let mesh = Mesh::soup(&mut random, 150, smallest);
            check(&mesh, &view(width, height), MIDDLE);
        }
    }
}

#[test]
fn any_number_of_triangles_is_seen_exactly() {
    let mut random = Random(2);
    for count in 0..40 {
        check(&Mesh::soup(&mut random, count, 0.1), &view(20, 20), DVec2::new(0.1, 0.9));
    }
}

#[test]
fn a_finely_meshed_ball_is_seen_exactly() {
    let mut mesh = Mesh::bumpy_ball(Vec3::new(0.0, 1.0, 0.0), 1.0, 24);
    mesh.append(&Mesh::floor(8, 3.0));
    let (_, counts) = check(&mesh, &view(67, 45), MIDDLE);
    assert!(counts.fragments > 100 && counts.listed > 100, "{counts:?}");
    assert!(counts.referred < 100, "{counts:?}");
}

#[test]
fn a_camera_inside_the_scene_sees_exactly() {
    let mut random = Random(3);
    for look in 0..6 {
        let mesh = Mesh::soup(&mut random, 200, 0.3);
        let camera = Camera::look_at(random.point() * 0.5, random.point(), Vec3::Y, 0.5 + 0.4 * look as f32);
        check(&mesh, &View { camera, width: 70, height: 66 }, MIDDLE);
    }
}

#[test]
fn triangles_that_cover_the_view_or_lie_behind_are_seen_exactly() {
    let camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0);
    let view = View { camera, width: 70, height: 40 };
    for far in [1e2, 1e4, 1e7] {
        let mut mesh = Mesh::default();
        mesh.push([Vec3::new(-far, -far, -5.0), Vec3::new(far, -far, -5.0), Vec3::new(0.0, far, -5.0)]);
        // A floor through the eye plane, another through the eye, and one behind.
        mesh.push([Vec3::new(-far, -1.0, far), Vec3::new(far, -1.0, far), Vec3::new(0.0, -1.0, -far)]);
        mesh.push([Vec3::new(-far, 0.0, far), Vec3::new(far, 0.0, far), Vec3::new(0.0, 0.0, -far)]);
        mesh.push([Vec3::new(-far, -far, 5.0), Vec3::new(far, -far, 5.0), Vec3::new(0.0, far, 5.0)]);
        let (seen, _) = check(&mesh, &view, MIDDLE);
        let order = seen.order();
        let mut inside = (0..order.places()).filter(|&place| order.pixel(place).is_some());
        assert!(inside.all(|place| seen.triangle[place] < 2));
    }
}

#[test]
fn triangles_over_many_tiles_are_seen_exactly() {
    let mut random = Random(11);
    // More columns of tiles than are looked at together; more rows than columns; a tile more in each than is whole.
    for (width, height) in [(1100, 70), (66, 400), (330, 260)] {
        let mut mesh = Mesh::default();
        for step in 0..60 {
            // From needles to triangles that hold the whole view, around the camera and through the eye plane.
            let (length, width) = ([1.0, 2.0, 9.0][step % 3], [0.02, 0.5, 1.0, 40.0][step % 4]);
            let [middle, across, along] = [0; 3].map(|_| random.point());
            let corner = middle * 3.0;
            mesh.push([corner, corner + across * length, corner + across + along * width]);
        }
        let camera = Camera::look_at(random.point() * 0.2, random.point(), Vec3::Y, 1.2);
        let (_, counts) = check(&mesh, &View { camera, width, height }, MIDDLE);
        assert!(counts.listed > 30, "{counts:?}");
    }
}

#[test]
fn culled_back_faces_are_seen_through() {
    let (mesh, views) = support::seen_from_both_sides();
    let mut grid = PerspectiveGrid::default();
    let mut seen = SeenPixels::default();
    for view in &views {
        for culls in [true, false] {
            grid.set_culls_back_faces(culls);
            grid.build(mesh.triangles(), view, MIDDLE, |_| false).unwrap();
            grid.check(mesh.triangles()).unwrap();
            grid.trace(mesh.triangles(), Unmasked, &mut seen);
            for (x, y) in (0..40 * 40).map(|pixel| (pixel % 40, pixel / 40)) {
                let ray = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let is_there = |hit: &Hit| {
                    let crossing = crossing(&ray, mesh.triangles().corners(hit.triangle));
                    !culls || crossing.is_some_and(|crossing| crossing.front)
                };
                let hit = support::nearest(mesh.triangles(), view, MIDDLE, (x, y), is_there);
                let expected = hit.map_or(SeenPixels::NONE, |hit| hit.triangle);
                assert_eq!(seen.triangle_at(x, y), expected, "pixel ({x}, {y}), {culls}");
            }
        }
    }
}

#[test]
fn huge_offsets_and_scales_are_seen_exactly() {
    let mut random = Random(4);
    let mut mesh = Mesh::soup(&mut random, 100, 0.05);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 8));
    for (scale, offset) in [
        (1e-6, Vec3::ZERO),
        (1e-3, Vec3::splat(3e-3)),
        (1.0, Vec3::new(148_376.0, 1234.0, -223_423.0)),
        (1e6, Vec3::ZERO),
        (1e-25, Vec3::ZERO),
        (1e25, Vec3::ZERO),
        (1e-36, Vec3::ZERO),
        (1e35, Vec3::ZERO),
    ] {
        let mut view = view(48, 40);
        view.camera.position = view.camera.position * scale + offset;
        check(&mesh.moved(scale, offset), &view, MIDDLE);
    }
}

#[test]
fn samples_on_edges_and_corners_are_seen_exactly() {
    // Pixels of unit size at distance one: corners of the mesh are on samples.
    let camera = Camera {
        position: Vec3::new(0.5, 0.5, 8.0),
        right: Vec3::X,
        up: Vec3::Y,
        forward: Vec3::NEG_Z,
        projection: Projection::Perspective { tan_half_height: 4.0 },
    };
    let view = View { camera, width: 64, height: 64 };
    let mut mesh = Mesh::default();
    for floor in [Mesh::floor(16, 32.0), Mesh::floor(64, 32.0), Mesh::floor(2, 512.0)] {
        let upright = floor.positions.iter().map(|position| Vec3::new(position.x, position.z, position.y)).collect();
        mesh.append(&Mesh { positions: upright, indices: floor.indices });
    }
    for offset in [DVec2::ZERO, MIDDLE, DVec2::ONE] {
        let mut shuffled = mesh.clone();
        // Mixed winding.
        shuffled.indices.iter_mut().step_by(3).for_each(|triangle| triangle.swap(0, 2));
        let bvh = {
            let mut bvh = umbrage_rays::Bvh::default();
            bvh.build(shuffled.triangles());
            bvh
        };
        let mut grid = PerspectiveGrid::default();
        let mut seen = SeenPixels::default();
        grid.build(shuffled.triangles(), &view, offset, |_| false).unwrap();
        grid.trace(shuffled.triangles(), Unmasked, &mut seen);
        for (place, &id) in seen.triangle.iter().enumerate() {
            let Some((x, y)) = seen.order().pixel(place) else { continue };
            let ray = view.ray(f64::from(x) + offset.x, f64::from(y) + offset.y);
            let hit = bvh.nearest(shuffled.triangles(), &ray, |_| true);
            assert_eq!(hit.map(|hit| hit.triangle), Some(id), "pixel ({x}, {y})");
        }
    }
}

#[test]
fn slivers_needles_and_near_coincident_planes_are_seen_exactly() {
    let mut random = Random(5);
    let mut mesh = Mesh::default();
    for _ in 0..120 {
        let (from, to) = (random.point() * 2.0, random.point() * 2.0);
        let thickness = 1e-7_f32.powf(random.unit());
        mesh.push([from, to, from + (to - from) * random.unit() + random.point() * thickness]);
    }
    for layer in 0..20 {
        // Less than an f32's rounding apart at the camera's distance.
        let depth = 1e-7 * layer as f32;
        mesh.push([Vec3::new(-1.0, -1.0, depth), Vec3::new(1.0, -1.0, -depth), Vec3::new(0.0, 1.0, depth)]);
    }
    check(&mesh, &view(66, 50), MIDDLE);
}

#[test]
fn of_identical_triangles_the_lowest_id_is_seen() {
    let mut mesh = Mesh::default();
    mesh.positions.extend([Vec3::new(-1.0, -1.0, 0.1), Vec3::new(1.0, -1.0, -0.2), Vec3::new(0.0, 1.0, 0.3)]);
    mesh.indices = vec![[0, 1, 2]; 10_000];
    let view = view(12, 9);
    let mut grid = PerspectiveGrid::default();
    let mut seen = SeenPixels::default();
    grid.build(mesh.triangles(), &view, MIDDLE, |_| false).unwrap();
    grid.trace(mesh.triangles(), Unmasked, &mut seen);
    assert!(seen.triangle.contains(&0));
    assert!(seen.triangle.iter().all(|&id| id == 0 || id == SeenPixels::NONE));
}

#[test]
fn triangles_that_cannot_be_hit_are_left_out_and_counted() {
    let mut random = Random(6);
    let mut mesh = Mesh::soup(&mut random, 100, 0.3);
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    for (place, &value) in bad.iter().cycle().take(9).enumerate() {
        mesh.positions[place * 30 + place % 3][place % 3] = value;
    }
    mesh.indices[95] = [0, 4, 900_000];
    mesh.indices[96] = [1, 2, u32::MAX];
    mesh.indices[97] = [4, 4, 5];
    mesh.positions[98 * 3] = mesh.positions[98 * 3 + 1];
    let (_, counts) = check(&mesh, &view(33, 65), MIDDLE);
    assert!(counts.listed > 0);
    let mut grid = PerspectiveGrid::default();
    grid.build(mesh.triangles(), &view(33, 65), MIDDLE, |_| false).unwrap();
    assert_eq!(grid.omitted(), &mesh.triangles().omitted());
    assert!(grid.omitted().total() > 10);
}

#[test]
fn refused_hits_are_seen_through() {
    let mut random = Random(7);
    let mesh = Mesh::soup(&mut random, 200, 0.1);
    let view = view(40, 40);
    let masked = |id: u32| id.is_multiple_of(3);
    let counts = |hit: &Hit| !masked(hit.triangle) || hit.barycentric[0] < 0.4;
    let mut grid = PerspectiveGrid::default();
    let mut seen = SeenPixels::default();
    grid.build(mesh.triangles(), &view, MIDDLE, masked).unwrap();
    grid.check(mesh.triangles()).unwrap();
    grid.trace(mesh.triangles(), counts, &mut seen);
    assert_exact(mesh.triangles(), &view, MIDDLE, &seen, counts);
}

/// Cuts every other one of so many stripes out of each third triangle.
struct Stripes {
    across: usize,
    count: f64,
    /// Points that were asked about, and answers.
    asked: AtomicUsize,
    answered: AtomicUsize,
}

impl Stripes {
    fn masks(id: u32) -> bool {
        id.is_multiple_of(3)
    }

    fn stripe(&self, weight: f64) -> i64 {
        (weight * self.count).floor() as i64
    }
}

impl Mask for &Stripes {
    fn is_solid(&self, hit: &Hit) -> bool {
        !Stripes::masks(hit.triangle) || self.stripe(f64::from(hit.barycentric[self.across])) % 2 == 0
    }

    fn are_solid(&self, triangle: u32, points: &MaskPoints) -> MaskAnswers {
        assert!(Stripes::masks(triangle));
        let mut answers = MaskAnswers::default();
        for point in (0..16).filter(|point| points.asked >> point & 1 == 1) {
            let [weight, error] = [points.barycentric[self.across][point], points.error[point]].map(f64::from);
            assert!(error > 0.0 || error.is_nan());
            let (first, last) = (self.stripe(weight - error), self.stripe(weight + error));
            if first == last && error <= 1.0 {
                let answer = if first % 2 == 0 { &mut answers.solid } else { &mut answers.cut };
                *answer |= 1 << point;
            }
        }
        self.asked.fetch_add(points.asked.count_ones() as usize, Ordering::Relaxed);
        self.answered.fetch_add((answers.solid | answers.cut).count_ones() as usize, Ordering::Relaxed);
        answers
    }
}

#[test]
fn masks_that_answer_early_are_seen_exactly() {
    let mut random = Random(21);
    let mut mesh = Mesh::soup(&mut random, 60, 0.1);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.2, 24));
    mesh.append(&Mesh::floor(3, 500.0));
    let view = view(70, 50);
    for (across, count) in [(0, 3.0), (1, 50.0), (0, 1e3), (1, 3e4)] {
        let stripes = Stripes { across, count, asked: AtomicUsize::new(0), answered: AtomicUsize::new(0) };
        let mut first: Option<SeenPixels> = None;
        for level in SimdLevel::available() {
            let mut grid = PerspectiveGrid::with_level(level);
            let mut seen = SeenPixels::default();
            grid.build(mesh.triangles(), &view, MIDDLE, Stripes::masks).unwrap();
            grid.check(mesh.triangles()).unwrap();
            grid.trace(mesh.triangles(), &stripes, &mut seen);
            match &first {
                Some(first) => assert_eq!(seen.triangle, first.triangle),
                None => assert_exact(mesh.triangles(), &view, MIDDLE, &seen, |hit| (&stripes).is_solid(hit)),
            }
            first.get_or_insert(seen);
        }
        let (asked, answered) = (stripes.asked.into_inner(), stripes.answered.into_inner());
        assert!(asked > 500);
        assert!(count > 100.0 || answered * 20 > asked * 19, "{answered} answers to {asked} questions");
    }
}

#[test]
fn orthographic_views_are_seen_exactly() {
    let mut random = Random(8);
    let mut mesh = Mesh::soup(&mut random, 150, 0.1);
    mesh.append(&Mesh::floor(4, 3.0));
    let mut view = view(50, 66);
    view.camera.projection = Projection::Orthographic { half_height: 2.0 };
    check(&mesh, &view, MIDDLE);
    view.camera.position = Vec3::ZERO;
    check(&mesh, &view, MIDDLE);
}

#[test]
fn cameras_out_of_square_are_seen_through_exactly() {
    let mut random = Random(9);
    let mesh = Mesh::soup(&mut random, 20, 0.3);
    let mut stretched = view(16, 12);
    stretched.camera.right *= 2.0;
    check(&mesh, &stretched, MIDDLE);
    let mut flat = view(16, 12);
    flat.camera.right = flat.camera.up;
    check(&mesh, &flat, MIDDLE);
    for tan_half_height in [0.0, f32::NAN, f32::INFINITY, -0.5, 1e-9, 1e9] {
        let mut view = view(16, 12);
        view.camera.projection = Projection::Perspective { tan_half_height };
        check(&mesh, &view, MIDDLE);
    }
    let mut nowhere = view(16, 12);
    nowhere.camera.position.x = f32::NAN;
    check(&mesh, &nowhere, MIDDLE);
    check(&mesh, &view(16, 12), DVec2::new(1e3, -1e12));
}

#[test]
fn threads_and_instructions_change_no_bit() {
    let mut random = Random(10);
    let mut mesh = Mesh::soup(&mut random, 3000, 0.01);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.5, 60));
    mesh.append(&Mesh::floor(2, 500.0));
    let view = view(300, 200);
    let mut reference: Option<(SeenPixels, _)> = None;
    for level in SimdLevel::available() {
        for threads in [1, 2, 3, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let result = pool.install(|| {
                let mut grid = PerspectiveGrid::with_level(level);
                let mut seen = SeenPixels::default();
                grid.build(mesh.triangles(), &view, MIDDLE, |_| false).unwrap();
                let counts = grid.trace(mesh.triangles(), Unmasked, &mut seen);
                (seen, counts)
            });
            match &reference {
                None => reference = Some(result),
                Some((seen, counts)) => {
                    assert!(is_same(seen, &result.0) && *counts == result.1, "{threads} threads, {level:?}");
                }
            }
        }
    }
}

#[test]
fn a_grid_can_be_used_again_for_anything() {
    let mut random = Random(11);
    let mut grid = PerspectiveGrid::default();
    let mut seen = SeenPixels::default();
    assert_eq!(grid.trace(Triangles::default(), Unmasked, &mut seen).listed, 0);
    for (count, width, height) in [(100, 100, 70), (5000, 10, 10), (0, 30, 30), (50, 0, 5), (50, 5, 0), (80, 130, 3)] {
        let mesh = Mesh::soup(&mut random, count, 0.1);
        let view = view(width, height);
        grid.build(mesh.triangles(), &view, MIDDLE, |_| false).unwrap();
        grid.check(mesh.triangles()).unwrap();
        grid.trace(mesh.triangles(), Unmasked, &mut seen);
        assert_exact(mesh.triangles(), &view, MIDDLE, &seen, |_| true);
    }
    let too_large = View { width: 1 << 17, ..view(1, 1) };
    assert!(grid.build(Triangles::default(), &too_large, MIDDLE, |_| false).is_err());
}

#[test]
fn samples_on_edges_of_triangles_through_the_eye_plane_are_seen_exactly() {
    let mut random = Random(12);
    for _ in 0..60 {
        let (sin, cos) = (random.unit() * 6.0).sin_cos();
        let (forward, right) = (Vec3::new(sin, 0.0, cos), Vec3::new(cos, 0.0, -sin));
        let projection = Projection::Perspective { tan_half_height: 0.3 + random.unit() };
        let camera = Camera { position: Vec3::ZERO, right, up: Vec3::Y, forward, projection };
        // The rays of column 8 are in the plane of the eye, P and Q: they meet the edge PQ to the last bit.
        let view = View { camera, width: 16, height: 16 };
        let (p, q) = (forward * 4.0, Vec3::new(0.0, -2.0, 0.0));
        let mut mesh = Mesh::default();
        mesh.push([p, q, right * 5.0 - forward * 3.0 - Vec3::Y]);
        mesh.push([p, q, right * -5.0 - forward * 3.0 - Vec3::Y]);
        for triangles in [[0, 1], [1, 0]] {
            let indices = triangles.map(|id: usize| mesh.indices[id]).to_vec();
            check(&Mesh { positions: mesh.positions.clone(), indices }, &view, DVec2::new(0.0, 0.5));
        }
    }
}
