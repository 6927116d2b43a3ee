//! Rays exactly through vertices and edges: none slips between triangles, and each has the lowest id of the triangles
//! that it meets.

use glam::Vec3;
use umbrage_verify::lights::point;
use umbrage_verify::{Case, Random, Sheet, SheetShape};

use super::grids::grids;

#[test]
fn sheets_hold_every_ray() {
    let Some(mut grids) = grids() else { return };
    let mut random = Random::new(53);
    for (position, scale) in SheetShape::PLACES {
        for is_orthographic in [false, true] {
            for (side, step, has_shell) in [(16, 1, false), (32, 2, true), (32, 8, false)] {
                // Positions away from zero have no bits left for a second sheet so close.
                let has_shell = has_shell && position == Vec3::ZERO;
                let shape = SheetShape { side, step, position, scale, is_orthographic, has_shell };
                let sheet = Sheet::new(shape, &mut random);
                // One light at the camera, and one at a vertex.
                let lights = [sheet.light, point(sheet.mesh.positions[sheet.mesh.positions.len() / 3])];
                let case = Case::new("", sheet.mesh, sheet.view, &lights);
                let case = Case { offset_pixels: sheet.offset_pixels, ..case };
                let truth = case.truth();
                assert!(truth.triangle.iter().all(|&id| id < sheet.front), "{shape:?}: the oracle sees through");
                assert!(truth.lit[0].iter().all(|&lit| lit), "{shape:?}: the oracle has shadows");
                grids.check_against(&format!("{shape:?}"), &case, &truth);
            }
        }
    }
}
