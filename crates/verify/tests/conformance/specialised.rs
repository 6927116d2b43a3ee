//! Promises of structures that are made for the rays of one camera and each light: cells, and counts of work.

use std::collections::HashMap;
use std::num::NonZeroU32;

use glam::{DMat3, DVec2, DVec3, Vec3};
use umbrage_papers::{Cells, ListedGrids, ListedLightOptions, ListedOptions};
use umbrage_rays::predicate::ShadowRay;
use umbrage_rays::{
    Cone, DirectGrids, ImageTooLarge, LightCell, LightCells, LightFace, LightMask, LightSource, PixelCounts, PixelWork,
    SeenPixels, Shot, Sides, SimdLevel, Specialised, Structure, Triangles, Work,
};
use umbrage_verify::lights::{point, sun};
use umbrage_verify::structures::Make;
use umbrage_verify::views::{camera, view};
use umbrage_verify::{Case, Plates, Random, TestMesh};

use crate::cases;
use crate::check::check_frames;

fn listed_grids(camera: ListedOptions, cells: u32) -> ListedGrids {
    let light = ListedLightOptions::new(cells, 16, 16).expect("possible cells");
    ListedGrids::with_options(SimdLevel::default(), camera, light)
}

fn see(structure: &mut dyn Structure, shot: &Shot<'_>) -> (SeenPixels, Work) {
    let mut seen = SeenPixels::default();
    structure.build(shot.triangles);
    let work = structure.see(shot, &mut seen).expect("a small image");
    (seen, work)
}

fn shadow(structure: &mut dyn Structure, shot: &Shot<'_>, seen: &SeenPixels, light: LightSource) -> Work {
    structure.shadow(shot, seen, &[light], &mut [LightMask::default()])
}

fn as_specialised(structure: &mut dyn Structure) -> &mut dyn Specialised {
    structure.specialised().expect("made for a shot")
}

/// The sums of each count over all pixels.
fn sums(case: &Case, work: &PixelWork) -> [u64; 4] {
    case.pixels().fold([0; 4], |[tests, cells, asked, listed], (x, y)| {
        let PixelCounts { tested, cells: more, undecided, pairs } = work.at(x, y);
        [tests + u64::from(tested), cells + u64::from(more), asked + u64::from(undecided), listed + u64::from(pairs)]
    })
}

fn soup_and_ball() -> Case {
    let mut mesh = TestMesh::soup(&mut Random::new(7), 200, 0.1);
    mesh.append(&TestMesh::bumpy_ball(1.0, 24));
    Case::new("a soup and a ball", mesh, view(camera(), 128, 64), &[])
}

#[test]
fn patches_are_right_in_every_frame() {
    let make: Make = |level| Box::new(DirectGrids::with_level(level));
    check_frames(make, &cases::PATCHES);
    check_frames(make, &cases::AIMED);
}

#[test]
fn work_of_pixels_adds_up() {
    let (case, mut work, mut seen) = (soup_and_ball(), PixelWork::default(), SeenPixels::default());
    let mut direct = DirectGrids::default();
    // Patches are grown in the second frame of the same triangles.
    (0..2).for_each(|_| direct.build(case.shot().triangles));
    for _ in 0..2 {
        let Work { counts, .. } = direct.see_counting(&case.shot(), &mut seen, &mut work).expect("a small image");
        assert_eq!(counts, see(&mut direct, &case.shot()).1.counts);
        assert!(counts.pairs > 100 && counts.fragments > 100 && counts.undecided < 100, "{counts:?}");
        let [_, _, undecided, pairs] = sums(&case, &work);
        // All pixels of a tile share its lists.
        assert_eq!([undecided, pairs], [counts.undecided, counts.pairs * 64 * 64]);
        assert!(case.pixels().all(|(x, y)| work.at(x, y).pairs == work.at(x / 64 * 64, y / 64 * 64).pairs));
    }
    for (tile, tiles, slices, skips_blocks, most) in
        [(16, 4, 8, true, 0), (8, 8, 7, false, 0), (64, 1, 3, true, 0), (16, 4, 8, true, 40)]
    {
        let cells = Cells::new(tile, tiles, slices).expect("possible cells");
        let mut listed =
            listed_grids(ListedOptions { cells, skips_blocks, most_triangles: NonZeroU32::new(most) }, 192);
        for _ in 0..2 {
            let Work { counts, .. } = listed.see_counting(&case.shot(), &mut seen, &mut work).expect("a small image");
            assert!(counts.pairs > 100 && counts.undecided < 100, "{counts:?}");
            // All samples of a block are tested together, and all of a sorting tile visit a cell together and share its
            // lists.
            let samples = u64::from(tile).pow(2);
            let expected = [counts.tests * 16, counts.cells * samples, counts.undecided, counts.pairs * samples];
            assert_eq!(sums(&case, &work), expected);
        }
    }
}

#[test]
fn what_is_hidden_is_not_tested() {
    // Walls one behind the other, each in a slice of its own.
    let mut mesh = TestMesh::default();
    for wall in 0..32 {
        let (depth, half) = (-2.0_f32.powi(wall), 2.0_f32.powi(wall + 1));
        mesh.quad([(-half, -half), (half, -half), (half, half), (-half, half)].map(|(x, y)| Vec3::new(x, y, depth)));
    }
    let look = umbrage_rays::Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0);
    let case = Case::new("walls", mesh, view(look, 128, 128), &[]);
    let tests = |slices: u32| {
        let cells = Cells::new(16, 1, slices).expect("possible cells");
        let (seen, Work { counts, .. }) = see(
            &mut listed_grids(ListedOptions { cells, skips_blocks: false, most_triangles: None }, 192),
            &case.shot(),
        );
        assert!(seen.triangle.iter().all(|&id| id < 2) && counts.pairs >= 64 * 32, "{counts:?}");
        counts.tests
    };
    assert!(tests(1) > 20 * tests(32), "{} {}", tests(1), tests(32));
}

#[test]
fn back_faces_that_stop_nothing_are_dropped() {
    let case = Case { sides: Sides::Front, ..soup_and_ball() };
    let [all, front] = [Sides::Both, Sides::Front].map(|sides| {
        let shot = Shot { sides, ..case.shot() };
        see(&mut ListedGrids::default(), &shot).1.counts
    });
    assert!(front.dropped > all.dropped + 100 && front.pairs < all.pairs, "{front:?} {all:?}");
}

#[test]
fn images_with_too_long_sides_are_refused() {
    let too_large = view(camera(), ImageTooLarge::LARGEST_SIDE + 1, 1);
    let shot = Shot::new(Triangles::default(), too_large);
    let structures: [&mut dyn Structure; 2] = [&mut DirectGrids::default(), &mut ListedGrids::default()];
    for structure in structures {
        assert!(structure.see(&shot, &mut SeenPixels::default()).is_err());
        assert!(
            as_specialised(structure)
                .see_counting(&shot, &mut SeenPixels::default(), &mut PixelWork::default())
                .is_err()
        );
    }
}

#[test]
fn masks_that_know_their_squares_leave_little_undecided() {
    let (mut masked, mut settled, mut settled_without) = (0, 0, 0);
    let case = floor_and_ball(150, 120);
    let mut direct = DirectGrids::default();
    let (seen, _) = see(&mut direct, &case.shot());
    for &light in &case.lights {
        let shot = Shot { shadow_opacity: &cases::Squares(7.0), ..case.shot() };
        let counts = shadow(&mut direct, &shot, &seen, light).counts;
        // The filter tests masks itself if it knows enough, else f64 does.
        (masked, settled) = (masked + counts.masked + counts.undecided, settled + counts.settled);
        settled_without += shadow(&mut direct, &case.shot(), &seen, light).counts.settled;
    }
    let for_masks = settled.saturating_sub(settled_without);
    assert!(masked > 1000 && for_masks * 20 < masked, "{masked} masked pairs, {for_masks} for the predicate");
}

/// Only here: the suite's other structures take too long for this many.
#[test]
fn hundreds_of_thousands_of_triangles_in_one_light_cell() {
    let mut plates = Plates::one();
    let truth = plates.truth();
    plates.pile(300_000, 3e-6);
    let case = plates.case();
    let structures: [&mut dyn Structure; 2] = [&mut DirectGrids::default(), &mut ListedGrids::default()];
    for structure in structures {
        let (seen, _) = see(structure, &case.shot());
        let mut masks = [LightMask::default(), LightMask::default()];
        structure.shadow(&case.shot(), &seen, &case.lights, &mut masks);
        for (mask, lit) in masks.iter().zip(&truth.lit) {
            assert!(case.pixels().zip(lit).all(|((x, y), &lit)| mask.is_lit(x, y) == lit), "{structure:?}");
        }
    }
}

/// The middle of a floor and a ball, from above, with rays through a quarter of each pixel.
fn floor_and_ball(width: u32, height: u32) -> Case {
    let mut mesh = TestMesh::bumpy_ball(0.7, 12).placed(1.0, Vec3::new(0.2, 0.8, 0.0));
    mesh.append(&TestMesh::plane(4, 3.0));
    let look = umbrage_rays::Camera::look_at(Vec3::new(2.5, 1.5, 3.5), Vec3::ZERO, Vec3::Y, 0.9);
    let case = Case::new("a floor and a ball", mesh, view(look, width, height), &lights());
    Case { offset_pixels: DVec2::new(0.5, 0.25), ..case }
}

/// A light that needs one face, one that needs a cube, parallel light, and a cone.
fn lights() -> [LightSource; 4] {
    let position = Vec3::new(2.0, 5.0, 1.0);
    let direction = Vec3::new(-2.0, -5.0, -1.0).normalize();
    let spot = LightSource::Spot { position, direction, inner_radians: 0.1, outer_radians: 0.2 };
    [point(position), point(Vec3::new(-0.9, 0.6, 0.4)), sun(-2.0, -5.0, -1.0), spot]
}

/// Calls `check` with each light's cells, of the direct grid and of the listed one with some options, and the chosen
/// number of columns, if there is one.
fn for_each_grid(case: &Case, seen: &SeenPixels, mut check: impl FnMut(&LightSource, Option<u32>, &LightCells)) {
    let (shot, mut cells) = (case.shot(), LightCells::default());
    for light in &case.lights {
        let mut direct = DirectGrids::default();
        direct.build(shot.triangles);
        assert_eq!(shadow(&mut direct, &shot, seen, *light).counts.outliers, 0);
        direct.locate(&shot, seen, light, &mut cells);
        check(light, None, &cells);
        for columns in [1, 7, 192] {
            listed_grids(ListedOptions::DEFAULT, columns).locate(&shot, seen, light, &mut cells);
            check(light, Some(columns), &cells);
        }
    }
}

#[test]
fn each_light_cell_counts_exactly_its_own_points() {
    let case = floor_and_ball(150, 100);
    let (seen, _) = see(&mut DirectGrids::default(), &case.shot());
    let mut checked = 0;
    for_each_grid(&case, &seen, |light, columns, cells| {
        let mut pixels: HashMap<LightCell, u32> = HashMap::new();
        for (x, y) in case.pixels() {
            let cell = cells.at(x, y);
            let ray = case.shot().shadow_ray(&seen, seen.order().index(x, y), light);
            let is_in_cone = |ray: ShadowRay| Cone::of(light).is_none_or(|cone| cone.contains(ray.point()));
            assert!(cell.is_some() || !ray.is_some_and(is_in_cone), "{light:?}, pixel ({x}, {y})");
            assert!(ray.is_some() || cell.is_none(), "{light:?}, pixel ({x}, {y})");
            let Some(cell) = cell else {
                assert_eq!(cells.points_at(x, y), 0);
                continue;
            };
            let face = cells.faces()[usize::from(cell.face)];
            assert!(u32::from(cell.column) < face.columns && u32::from(cell.row) < face.rows, "{cell:?} of {face:?}");
            assert!(columns.is_none_or(|columns| (face.columns, face.rows) == (columns, columns)));
            *pixels.entry(cell).or_default() += 1;
        }
        for (&cell, &count) in &pixels {
            assert_eq!(cells.points_of(cell), count, "{light:?}, {cell:?}");
        }
        assert!(case.pixels().all(|(x, y)| cells.points_at(x, y) == cells.at(x, y).map_or(0, |cell| pixels[&cell])));
        let faces = cells.faces().iter().enumerate();
        let all = faces.flat_map(|(face, LightFace { columns, rows, .. })| {
            (0..*rows as u16).flat_map(move |row| {
                (0..*columns as u16).map(move |column| LightCell { face: face as u16, column, row })
            })
        });
        let all: u64 = all.map(|cell| u64::from(cells.points_of(cell))).sum();
        assert_eq!(all, pixels.values().map(|&count| u64::from(count)).sum::<u64>(), "cells without pixels are empty");
        checked += 1;
    });
    assert_eq!(checked, 16);
}

/// Position of a point on a light's face, from 0 to 1 along its first and its last side, and from 0 to 1 from the near
/// rectangle to the far one.
fn on_face(light: &LightSource, face: &LightFace, point: DVec3) -> [f64; 3] {
    let [near, far] = [face.near, face.far].map(|corners| corners.map(Vec3::as_dvec3));
    match *light {
        LightSource::Directional { .. } => {
            let axes = DMat3::from_cols(near[1] - near[0], near[3] - near[0], far[0] - near[0]);
            (axes.inverse() * (point - near[0])).to_array()
        }
        LightSource::Point { position } | LightSource::Spot { position, .. } => {
            let origin = position.as_dvec3();
            let axes = DMat3::from_cols(far[1] - far[0], far[3] - far[0], far[0] - origin);
            let [x, y, depth] = (axes.inverse() * (point - origin)).to_array();
            let nearest = (near[0] - origin).length() / (far[0] - origin).length();
            [x / depth, y / depth, (depth - nearest) / (1.0 - nearest)]
        }
    }
}

#[test]
fn faces_hold_their_points_in_the_order_of_their_cells() {
    let case = floor_and_ball(150, 100);
    let (shot, (seen, _)) = (case.shot(), see(&mut DirectGrids::default(), &case.shot()));
    let mut faces = [0; 4];
    for_each_grid(&case, &seen, |light, columns, cells| {
        let which = case.lights.iter().position(|other| other == light).expect("one of them");
        faces[which] = cells.faces().len();
        // The lowest and the highest x of each column, and y of each row.
        let mut ranges: HashMap<(u16, usize, u16), [f64; 2]> = HashMap::new();
        for (x, y) in case.pixels() {
            let Some(cell) = cells.at(x, y) else { continue };
            let ray = shot.ray(x, y);
            let t = 1.0 / f64::from(seen.inverse_depth[seen.order().index(x, y)]);
            let face = &cells.faces()[usize::from(cell.face)];
            let found = on_face(light, face, ray.origin + ray.direction * t);
            assert!(found.iter().all(|at| (-1e-3..=1.001).contains(at)), "{light:?}: {found:?} of {face:?}");
            for (axis, cell_of_axis, count) in [(0, cell.column, face.columns), (1, cell.row, face.rows)] {
                let range = ranges.entry((cell.face, axis, cell_of_axis)).or_insert([f64::INFINITY, f64::NEG_INFINITY]);
                *range = [range[0].min(found[axis]), range[1].max(found[axis])];
                if columns.is_some() {
                    // The listed grid's cells are all of the same size, up to 8192 strips.
                    let expected = found[axis] * f64::from(count) - f64::from(cell_of_axis);
                    assert!((-0.1..1.1).contains(&expected), "{light:?}: {found:?} in {cell:?} of {face:?}");
                }
            }
        }
        for (&(face, axis, cell), &[low, _]) in &ranges {
            let before = ranges.iter().filter(|((f, a, c), _)| (*f, *a) == (face, axis) && *c < cell);
            assert!(before.into_iter().all(|(_, [_, high])| *high < low + 1e-4), "{light:?}: face {face}, cell {cell}");
        }
    });
    assert_eq!((faces[0], faces[2], faces[3]), (1, 1, 1));
    assert!(faces[1] > 1, "a light in the middle needs a cube");
}

#[test]
fn a_light_that_is_none_has_no_cells() {
    let case = floor_and_ball(70, 20);
    let (shot, mut grids, mut cells) = (case.shot(), DirectGrids::default(), LightCells::default());
    let (seen, _) = see(&mut grids, &shot);
    grids.locate(&shot, &seen, &lights()[0], &mut cells);
    assert!(!cells.faces().is_empty());
    grids.locate(&shot, &seen, &LightSource::Directional { direction: Vec3::ZERO }, &mut cells);
    assert!(cells.faces().is_empty());
    assert_eq!((cells.at(35, 10), cells.points_at(35, 10)), (None, 0));
}
