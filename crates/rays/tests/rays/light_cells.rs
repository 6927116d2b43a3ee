//! In which cell of a light's grid points are.

use std::collections::HashMap;

use glam::{DMat3, DVec2, DVec3, Vec3};
use umbrage_rays::{
    LightCell, LightCells, LightFace, LightGrid, LightSource, ListedLightGrid, ListedLightOptions, PerspectiveGrid,
    SeenImage, SeenPixels, Triangles, Unmasked, View,
};

use crate::support::{Mesh, view};

const OFFSET: DVec2 = DVec2::new(0.5, 0.25);

fn mesh() -> Mesh {
    let mut mesh = Mesh::bumpy_ball(Vec3::new(0.2, 0.8, 0.0), 0.7, 12);
    mesh.append(&Mesh::floor(4, 3.0));
    mesh
}

/// One that sees everything through one face, one that needs a cube, parallel light, and a cone.
fn lights() -> [LightSource; 4] {
    let position = Vec3::new(2.0, 5.0, 1.0);
    let direction = Vec3::new(-2.0, -5.0, -1.0).normalize();
    [
        LightSource::Point { position },
        LightSource::Point { position: Vec3::new(-0.9, 0.6, 0.4) },
        LightSource::Directional { direction },
        LightSource::Spot { position, direction, inner_radians: 0.1, outer_radians: 0.2 },
    ]
}

fn see(triangles: Triangles<'_>, view: &View) -> SeenPixels {
    let (mut grid, mut seen) = (PerspectiveGrid::default(), SeenPixels::default());
    grid.build(triangles, view, OFFSET, |_| false).expect("a small image");
    grid.trace(triangles, Unmasked, &mut seen);
    seen
}

/// Each light's cells, of the direct grid and of the listed one with some options; which of the two, and how many
/// columns it has where that is chosen.
fn for_each_grid(image: &SeenImage<'_>, mut check: impl FnMut(&LightSource, Option<u32>, &LightCells)) {
    let mut cells = LightCells::default();
    let (mut direct, mut listed) = (LightGrid::default(), ListedLightGrid::default());
    direct.survey(image);
    listed.survey(image);
    let mut lit = vec![0; image.seen.triangle.len() / 16];
    for light in &lights() {
        direct.shadow(image, light, |_| true, &Unmasked, &mut lit);
        assert_eq!(direct.counts().outliers, 0);
        direct.locate(image, light, &mut cells);
        check(light, None, &cells);
        for columns in [1, 7, 192] {
            listed.set_options(ListedLightOptions::new(columns, 16, 16).expect("possible cells"));
            listed.locate(image, light, &mut cells);
            check(light, Some(columns), &cells);
        }
    }
}

#[test]
fn each_cell_counts_exactly_its_own_points() {
    let (mesh, view) = (mesh(), view(150, 100));
    let seen = see(mesh.triangles(), &view);
    let image = SeenImage { triangles: mesh.triangles(), view, offset_pixels: OFFSET, seen: &seen };
    let mut checked = 0;
    for_each_grid(&image, |light, columns, cells| {
        let mut pixels: HashMap<LightCell, u32> = HashMap::new();
        for (x, y) in (0..100).flat_map(|y| (0..150).map(move |x| (x, y))) {
            let cell = cells.at(x, y);
            assert_eq!(cell.is_some(), seen.triangle_at(x, y) != SeenPixels::NONE, "{light:?}, pixel ({x}, {y})");
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
        for (x, y) in (0..100).flat_map(|y| (0..150).map(move |x| (x, y))) {
            let count = cells.at(x, y).map_or(0, |cell| pixels[&cell]);
            assert_eq!(cells.points_at(x, y), count);
        }
        let faces = cells.faces().iter().enumerate();
        let all: u64 = faces
            .flat_map(|(face, LightFace { columns, rows, .. })| {
                (0..*rows as u16).flat_map(move |row| {
                    (0..*columns as u16).map(move |column| LightCell { face: face as u16, column, row })
                })
            })
            .map(|cell| u64::from(cells.points_of(cell)))
            .sum();
        assert_eq!(all, pixels.values().map(|&count| u64::from(count)).sum::<u64>(), "cells without pixels are empty");
        checked += 1;
    });
    assert_eq!(checked, 16);
}

/// Where a light has a point on a face, from 0 to 1 along its first and its last side, and how far the point is from
/// the rectangle at the nearest one towards that at the farthest.
fn place(light: &LightSource, face: &LightFace, point: DVec3) -> [f64; 3] {
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
    let (mesh, view) = (mesh(), view(150, 100));
    let seen = see(mesh.triangles(), &view);
    let image = SeenImage { triangles: mesh.triangles(), view, offset_pixels: OFFSET, seen: &seen };
    let mut faces = [0; 4];
    for_each_grid(&image, |light, columns, cells| {
        let which = lights().iter().position(|other| other == light).expect("one of them");
        faces[which] = cells.faces().len();
        // The lowest and the highest X of each column, and Y of each row.
        let mut ranges: HashMap<(u16, usize, u16), [f64; 2]> = HashMap::new();
        for (x, y) in (0..100).flat_map(|y| (0..150).map(move |x| (x, y))) {
            let Some(cell) = cells.at(x, y) else { continue };
            let ray = view.ray(f64::from(x) + OFFSET.x, f64::from(y) + OFFSET.y);
            let t = 1.0 / f64::from(seen.inverse_depth[seen.order().place(x, y)]);
            let face = &cells.faces()[usize::from(cell.face)];
            let found = place(light, face, ray.origin + ray.direction * t);
            assert!(found.iter().all(|at| (-1e-3..=1.001).contains(at)), "{light:?}: {found:?} of {face:?}");
            for (axis, cell_of_axis, count) in [(0, cell.column, face.columns), (1, cell.row, face.rows)] {
                let range = ranges.entry((cell.face, axis, cell_of_axis)).or_insert([f64::INFINITY, f64::NEG_INFINITY]);
                *range = [range[0].min(found[axis]), range[1].max(found[axis])];
                if columns.is_some() {
                    // The listed grid's cells are all of the same size, but for 8192 strips.
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
    let (mesh, view) = (mesh(), view(70, 20));
    let seen = see(mesh.triangles(), &view);
    let image = SeenImage { triangles: mesh.triangles(), view, offset_pixels: OFFSET, seen: &seen };
    let (mut grid, mut cells) = (LightGrid::default(), LightCells::default());
    grid.survey(&image);
    grid.locate(&image, &lights()[0], &mut cells);
    assert!(!cells.faces().is_empty());
    grid.locate(&image, &LightSource::Directional { direction: Vec3::ZERO }, &mut cells);
    assert!(cells.faces().is_empty());
    assert_eq!((cells.at(35, 10), cells.points_at(35, 10)), (None, 0));
}
