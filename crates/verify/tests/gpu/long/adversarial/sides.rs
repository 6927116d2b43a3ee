//! Triangles that have only a front.

use glam::Vec3;
use umbrage_rays::{Camera, Projection, Sides};
use umbrage_verify::lights::around;
use umbrage_verify::views::view;
use umbrage_verify::{Case, MIXED_SIDES, TestMesh};

use super::grids::{case, grids};

#[test]
fn fronts_and_some_backs() {
    let Some(mut grids) = grids() else { return };
    let look = Camera::look_at(Vec3::new(2.5, 1.5, 3.5), Vec3::ZERO, Vec3::Y, 0.9);
    let mesh = TestMesh::fronts_and_backs([look.position, Vec3::new(3.0, 5.0, 2.0)]);
    let mirrored = Camera { right: -look.right, ..look };
    let parallel = Camera { projection: Projection::Orthographic { half_height: 1.5 }, ..look };
    for (number, camera) in [look, mirrored, parallel].into_iter().enumerate() {
        for sides in [Sides::Front, MIXED_SIDES] {
            let case = Case { sides, ..case(&mesh, view(camera, 33, 30), &around(1.0, Vec3::ZERO)) };
            grids.check(&format!("camera {number}, {sides:?}"), &case);
        }
    }
}
