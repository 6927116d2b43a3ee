//! The listed form of the perspective grid against the predicate, asked about every pair of a pixel and a triangle.

use glam::{DVec2, Vec3};
use umbrage_rays::predicate::crossing;
use umbrage_rays::{
    Camera, Cells, Hit, ImageTooLarge, ListedCounts, ListedGrid, ListedOptions, PixelWork, Projection, SeenPixels,
    SimdLevel, Triangles, Unmasked, View,
};

use crate::support::{self, Mesh, Random, assert_exact, is_same, view};

const MIDDLE: DVec2 = DVec2::splat(0.5);

fn options(sorting_tile: u32, tracing_tiles: u32, slices: u32) -> ListedOptions {
    let cells = Cells::new(sorting_tile, tracing_tiles, slices).expect("possible cells");
    ListedOptions { cells, ..ListedOptions::DEFAULT }
}

/// Some of each parameter, the default first.
fn many_options() -> Vec<ListedOptions> {
    let mut many = vec![ListedOptions::DEFAULT];
    for (place, (tile, tiles, slices)) in
        [(8, 1, 1), (8, 8, 7), (16, 2, 64), (16, 4, 2), (32, 2, 16), (64, 1, 3), (8, 2, 16)].into_iter().enumerate()
    {
        many.push(ListedOptions { skips_blocks: place % 2 == 0, ..options(tile, tiles, slices) });
    }
    many
}

/// Builds, validates and traces with `options`.
fn trace(mesh: &Mesh, view: &View, offset: DVec2, options: ListedOptions) -> (SeenPixels, ListedCounts) {
    let mut grid = ListedGrid::default();
    let mut seen = SeenPixels::default();
    grid.build(mesh.triangles(), view, offset, options, |_| false).expect("a small image");
    grid.check(mesh.triangles()).unwrap_or_else(|wrong| panic!("{options:?}: {wrong}"));
    let counts = grid.trace(mesh.triangles(), Unmasked, &mut seen);
    (seen, counts)
}

/// Compares what many options find with the predicate; returns the default's counts.
fn check(mesh: &Mesh, view: &View, offset: DVec2) -> ListedCounts {
    let (reference, counts) = trace(mesh, view, offset, ListedOptions::DEFAULT);
    assert_exact(mesh.triangles(), view, offset, &reference, |_| true);
    for options in many_options().into_iter().skip(1) {
        let (seen, _) = trace(mesh, view, offset, options);
        assert!(seen.triangle == reference.triangle, "{options:?}");
        for (a, b) in seen.inverse_depth.iter().zip(&reference.inverse_depth) {
            let near = (a - b).abs() <= 2.0 * SeenPixels::RELATIVE_ERROR * b.abs();
            assert!(near || (a.is_nan() && b.is_nan()), "{options:?}: {a} {b}");
        }
    }
    counts
}

/// The sums of tested triangles, cells, undecided ones and pairs over the pixels of an image.
fn sums(work: &PixelWork, view: &View) -> [u64; 4] {
    let mut sums = [0; 4];
    for (x, y) in (0..view.height).flat_map(|y| (0..view.width).map(move |x| (x, y))) {
        let work = work.at(x, y);
        for (sum, count) in sums.iter_mut().zip([work.tested, work.cells, work.undecided, work.pairs]) {
            *sum += u64::from(count);
        }
    }
    sums
}

#[test]
fn work_adds_up_and_changes_nothing() {
    let mesh = Mesh::soup(&mut Random(7), 200, 0.1);
    let view = view(128, 64);
    let (reference, _) = trace(&mesh, &view, MIDDLE, ListedOptions::DEFAULT);
    let mut work = PixelWork::default();
    for options in many_options() {
        let mut grid = ListedGrid::default();
        let mut seen = SeenPixels::default();
        grid.build(mesh.triangles(), &view, MIDDLE, options, |_| false).expect("a small image");
        for _ in 0..2 {
            let counts = grid.trace_counting(mesh.triangles(), Unmasked, &mut seen, &mut work);
            assert_eq!(seen.triangle, reference.triangle);
            // All samples of a block are tested together, and all of a sorting tile visit a cell together and have its
            // lists in common.
            let samples = u64::from(options.cells.sorting_tile()).pow(2);
            let expected = [counts.tests * 16, counts.cells * samples, counts.undecided, counts.pairs * samples];
            assert_eq!(sums(&work, &view), expected);
            assert!(counts.pairs > 0);
        }
    }
}

#[test]
fn soups_of_all_sizes_are_seen_exactly() {
    let mut random = Random(1);
    for (width, height) in [(1, 1), (7, 3), (64, 64), (65, 30), (90, 70)] {
        for smallest in [1.0, 0.1, 0.001] {
            let mesh = Mesh::soup(&mut random, 100, smallest);
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
    let counts = check(&mesh, &view(67, 45), MIDDLE);
    assert!(counts.pairs > 1000 && counts.tests > 1000 && counts.cells > 15, "{counts:?}");
    assert!(counts.referred < 100, "{counts:?}");
}

#[test]
fn a_camera_inside_the_scene_sees_exactly() {
    let mut random = Random(3);
    for look in 0..6 {
        let mesh = Mesh::soup(&mut random, 120, 0.3);
        let camera = Camera::look_at(random.point() * 0.5, random.point(), Vec3::Y, 0.5 + 0.4 * look as f32);
        check(&mesh, &View { camera, width: 70, height: 40 }, MIDDLE);
    }
}

#[test]
fn triangles_that_cover_the_view_or_lie_behind_are_seen_exactly() {
    let camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0);
    let view = View { camera, width: 140, height: 70 };
    for far in [1e2, 1e4, 1e7] {
        let mut mesh = Mesh::default();
        mesh.push([Vec3::new(-far, -far, -5.0), Vec3::new(far, -far, -5.0), Vec3::new(0.0, far, -5.0)]);
        // A floor through the eye plane, another through the eye, and one behind.
        mesh.push([Vec3::new(-far, -1.0, far), Vec3::new(far, -1.0, far), Vec3::new(0.0, -1.0, -far)]);
        mesh.push([Vec3::new(-far, 0.0, far), Vec3::new(far, 0.0, far), Vec3::new(0.0, 0.0, -far)]);
        mesh.push([Vec3::new(-far, -far, 5.0), Vec3::new(far, -far, 5.0), Vec3::new(0.0, far, 5.0)]);
        check(&mesh, &view, MIDDLE);
    }
}

#[test]
fn what_is_hidden_is_not_tested() {
    // Walls one behind the other, each of them a slice.
    let mut mesh = Mesh::default();
    for wall in 0..32 {
        let (depth, half) = (-2.0_f32.powi(wall), 2.0_f32.powi(wall + 1));
        mesh.quad([(-half, -half), (half, -half), (half, half), (-half, half)].map(|(x, y)| Vec3::new(x, y, depth)));
    }
    let camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0);
    let view = View { camera, width: 128, height: 128 };
    let tests = |slices: u32| {
        let options = ListedOptions { skips_blocks: false, ..options(16, 1, slices) };
        let (seen, counts) = trace(&mesh, &view, MIDDLE, options);
        assert!(seen.triangle.iter().all(|&id| id < 2));
        assert!(counts.pairs >= 64 * 32, "{counts:?}");
        counts.tests
    };
    assert!(tests(1) > 20 * tests(32), "{} {}", tests(1), tests(32));
}

#[test]
fn huge_offsets_and_scales_are_seen_exactly() {
    let mut random = Random(4);
    let mut mesh = Mesh::soup(&mut random, 60, 0.05);
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
        let mut view = view(36, 30);
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
    let view = View { camera, width: 32, height: 32 };
    let mut mesh = Mesh::default();
    for floor in [Mesh::floor(8, 16.0), Mesh::floor(12, 16.0), Mesh::floor(2, 256.0)] {
        let upright = floor.positions.iter().map(|position| Vec3::new(position.x, position.z, position.y)).collect();
        mesh.append(&Mesh { positions: upright, indices: floor.indices });
    }
    // Mixed winding.
    mesh.indices.iter_mut().step_by(3).for_each(|triangle| triangle.swap(0, 2));
    for offset in [DVec2::ZERO, MIDDLE, DVec2::ONE] {
        check(&mesh, &view, offset);
    }
}

#[test]
fn slivers_needles_and_near_coincident_planes_are_seen_exactly() {
    let mut random = Random(5);
    let mut mesh = Mesh::default();
    for _ in 0..100 {
        let (from, to) = (random.point() * 2.0, random.point() * 2.0);
        let thickness = 1e-7_f32.powf(random.unit());
        mesh.push([from, to, from + (to - from) * random.unit() + random.point() * thickness]);
    }
    for layer in 0..20 {
        // Less than an f32's rounding apart at the camera's distance.
        let depth = 1e-7 * layer as f32;
        mesh.push([Vec3::new(-1.0, -1.0, depth), Vec3::new(1.0, -1.0, -depth), Vec3::new(0.0, 1.0, depth)]);
    }
    check(&mesh, &view(66, 40), MIDDLE);
}

#[test]
fn of_identical_triangles_the_lowest_id_is_seen() {
    let mut mesh = Mesh::default();
    mesh.positions.extend([Vec3::new(-1.0, -1.0, 0.1), Vec3::new(1.0, -1.0, -0.2), Vec3::new(0.0, 1.0, 0.3)]);
    mesh.indices = vec![[0, 1, 2]; 10_000];
    let mut grid = ListedGrid::default();
    let mut seen = SeenPixels::default();
    grid.build(mesh.triangles(), &view(12, 9), MIDDLE, ListedOptions::DEFAULT, |_| false).unwrap();
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
    check(&mesh, &view(33, 65), MIDDLE);
    let mut grid = ListedGrid::default();
    grid.build(mesh.triangles(), &view(33, 65), MIDDLE, ListedOptions::DEFAULT, |_| false).unwrap();
    assert_eq!(grid.omitted(), &mesh.triangles().omitted());
    assert!(grid.omitted().total() > 10);
}

#[test]
fn refused_hits_are_seen_through() {
    let mut random = Random(7);
    let mut mesh = Mesh::soup(&mut random, 200, 0.1);
    mesh.append(&Mesh::floor(2, 500.0));
    let view = view(40, 40);
    let masked = |id: u32| id.is_multiple_of(3);
    let counts = |hit: &Hit| !masked(hit.triangle) || hit.barycentric[0] < 0.4;
    for options in many_options() {
        let mut grid = ListedGrid::default();
        let mut seen = SeenPixels::default();
        grid.build(mesh.triangles(), &view, MIDDLE, options, masked).unwrap();
        grid.check(mesh.triangles()).unwrap();
        grid.trace(mesh.triangles(), counts, &mut seen);
        assert_exact(mesh.triangles(), &view, MIDDLE, &seen, counts);
    }
}

#[test]
fn culled_back_faces_are_seen_through() {
    let (mesh, views) = support::seen_from_both_sides();
    for view in &views {
        let expected = |x: u32, y: u32| {
            let ray = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let is_front = |hit: &Hit| {
                crossing(&ray, mesh.triangles().corners(hit.triangle)).is_some_and(|crossing| crossing.front)
            };
            let hit = support::nearest(mesh.triangles(), view, MIDDLE, (x, y), is_front);
            hit.map_or(SeenPixels::NONE, |hit| hit.triangle)
        };
        let expected: Vec<u32> = (0..40 * 40).map(|pixel| expected(pixel % 40, pixel / 40)).collect();
        for options in many_options() {
            let options = ListedOptions { culls_back_faces: true, ..options };
            let (seen, counts) = trace(&mesh, view, MIDDLE, options);
            let seen: Vec<u32> = (0..40 * 40).map(|pixel| seen.triangle_at(pixel % 40, pixel / 40)).collect();
            assert!(seen == expected, "{options:?}");
            let is_perspective = matches!(view.camera.projection, Projection::Perspective { .. });
            assert!(counts.dropped > 100 || !is_perspective, "{counts:?}");
        }
    }
}

#[test]
fn orthographic_views_are_seen_exactly() {
    let mut random = Random(8);
    let mut mesh = Mesh::soup(&mut random, 120, 0.1);
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
    let turned = ListedOptions { culls_back_faces: true, skips_blocks: false, ..options(8, 4, 16) };
    for options in [ListedOptions::DEFAULT, turned] {
        let mut reference: Option<(SeenPixels, _)> = None;
        for (level, threads) in SimdLevel::available().into_iter().flat_map(|level| [1, 2, 3, 7].map(|n| (level, n))) {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let result = pool.install(|| {
                let mut grid = ListedGrid::with_level(level);
                let mut seen = SeenPixels::default();
                grid.build(mesh.triangles(), &view, MIDDLE, options, |_| false).unwrap();
                let counts = grid.trace(mesh.triangles(), Unmasked, &mut seen);
                (seen, counts)
            });
            let (seen, counts) = reference.get_or_insert_with(|| result.clone());
            assert!(is_same(seen, &result.0) && *counts == result.1, "{threads} threads, {level:?}, {options:?}");
        }
    }
}

#[test]
fn a_grid_can_be_used_again_for_anything() {
    let mut random = Random(11);
    let mut grid = ListedGrid::default();
    let mut seen = SeenPixels::default();
    assert_eq!(grid.trace(Triangles::default(), Unmasked, &mut seen), ListedCounts::default());
    for (count, width, height) in [(100, 100, 70), (5000, 10, 10), (0, 30, 30), (50, 0, 5), (50, 5, 0), (80, 130, 3)] {
        let mesh = Mesh::soup(&mut random, count, 0.1);
        let view = view(width, height);
        grid.build(mesh.triangles(), &view, MIDDLE, ListedOptions::DEFAULT, |_| false).unwrap();
        grid.check(mesh.triangles()).unwrap();
        grid.trace(mesh.triangles(), Unmasked, &mut seen);
        assert_exact(mesh.triangles(), &view, MIDDLE, &seen, |_| true);
    }
    let too_large = View { width: ImageTooLarge::LARGEST_SIDE + 1, ..view(1, 1) };
    assert!(grid.build(Triangles::default(), &too_large, MIDDLE, ListedOptions::DEFAULT, |_| false).is_err());
}
