//! Several samples of a pixel as one image, whose rays are shifted by even and odd columns and rows.

use glam::{DVec2, Vec3};
use umbrage_rays::{Camera, Projection, Shifts, View};
use umbrage_verify::lights::around;
use umbrage_verify::views::{camera, placed, view};
use umbrage_verify::{Case, MIXED_SIDES, Random, TestMesh};

use super::opacity::Squares;
use super::{FAR, room};

/// Offsets and shifts: four samples of a Hammersley set, two of eight, the largest ones in both directions, and some
/// with unrelated columns and rows.
fn patterns() -> Vec<(DVec2, Shifts)> {
    let hammersley = [(0.125, 0.125), (0.625, 0.375), (0.375, 0.625), (0.875, 0.875)];
    let of_eight = [(0.1875, 0.3125), (0.6875, 0.1875), (0.3125, 0.8125), (0.8125, 0.6875)];
    let quarters = [hammersley, of_eight].map(|offsets| Shifts::of_quarters(offsets.map(DVec2::from)));
    let mut patterns: Vec<_> = quarters.into_iter().map(|pattern| pattern.expect("one in each quarter")).collect();
    let step = Shifts::STEP_PIXELS;
    for shifts in [
        [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)],
        [(0.5, 0.5), (-0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)],
        [(0.5, step), (0.25, -0.125), (-3.0 * step, 0.5), (-0.5, 0.375)],
    ] {
        let shifts = Shifts::new(shifts.map(DVec2::from)).expect("possible shifts");
        patterns.push((DVec2::new(0.5, 0.375), shifts));
    }
    patterns
}

pub(super) fn all() -> Vec<Case> {
    let mut random = Random::new(17);
    let look = Camera::look_at(Vec3::new(2.5, 1.5, 3.5), Vec3::ZERO, Vec3::Y, 0.9);
    let parallel = Camera { projection: Projection::Orthographic { half_height: 1.5 }, ..look };
    let lights = around(1.0, Vec3::ZERO);
    let mut soup = TestMesh::soup(&mut random, 80, 0.1);
    soup.append(&TestMesh::bumpy_ball(1.2, 8));
    soup.append(&TestMesh::plane(3, 500.0));
    // Triangles of the size of pixels and smaller, which are tested where they are set up, and their neighbours.
    let mut fine = TestMesh::bumpy_ball(1.0, 22).placed(1.0, Vec3::Y * 0.3);
    fine.append(&TestMesh::plane(9, 3.0));
    let inside = Camera::look_at(random.point() * 0.5, random.point(), Vec3::Y, 1.4);
    let mut cases = Vec::new();
    for (number, (offset_pixels, shifts)) in patterns().into_iter().enumerate() {
        let mut ask = |name: &str, mesh: &TestMesh, view: View| {
            let case = Case::new(format!("{name}, {shifts:?}"), mesh.clone(), view, &lights[..2]);
            cases.push(Case { offset_pixels, shifts, ..case });
        };
        ask("a soup", &soup, view(look, 31, 22));
        ask("a soup, parallel", &soup, view(parallel, 18, 21));
        ask("small triangles", &fine, view(look, 33, 29));
        ask("small triangles, parallel", &fine, view(parallel, 17, 19));
        ask("inside", &soup, view(inside, 24, 17));
        ask("one pixel", &soup, view(look, 1, 1));
        if number == 0 {
            ask("several tiles", &soup, view(look, 140, 68));
        }
        // A spot and a sun.
        let lights = [lights[6], lights[7]];
        for (scale, offset) in [(1e-3, Vec3::splat(3e-3)), (300.0, FAR)] {
            let (mesh, view) = (room(7).placed(scale, offset), view(placed(camera(), scale, offset), 19, 15));
            let case = Case::new("a room elsewhere", mesh, view, &around(scale, offset)[..2]);
            cases.push(Case { offset_pixels, shifts, ..case });
        }
        let case = || Case { offset_pixels, shifts, ..Case::new("", soup.clone(), view(look, 27, 22), &lights) };
        let masks = || Box::new(Squares(7.0));
        cases.push(Case { name: "masks".into(), opacity: masks(), shadow_opacity: masks(), ..case() });
        cases.push(Case { name: "sides".into(), sides: MIXED_SIDES, ..case() });
    }
    cases
}
