//! Cases for structures. Each group, and its truth, is made when a first structure needs it.

mod aimed;
mod cameras;
mod crowds;
mod lights;
mod moving;
mod opacity;
mod patches;
mod samples;
mod seams;
mod triangles;

pub(crate) use cameras::{BALL, stadium};
pub(crate) use opacity::Squares;
use std::sync::LazyLock;

use glam::Vec3;
use umbrage_verify::{Case, Random, TestMesh};

use crate::check::{Known, known};

pub(crate) static FEW_TRIANGLES: LazyLock<Vec<Known>> = LazyLock::new(|| known(triangles::few()));
pub(crate) static BAD_PLACES: LazyLock<Vec<Known>> = LazyLock::new(|| known(triangles::in_bad_places()));
pub(crate) static BAD_SHAPES: LazyLock<Vec<Known>> = LazyLock::new(|| known(triangles::of_bad_shapes()));
pub(crate) static BROKEN: LazyLock<Vec<Known>> = LazyLock::new(|| known(triangles::that_are_none()));
pub(crate) static CAMERAS: LazyLock<Vec<Known>> = LazyLock::new(|| known(cameras::of_all_kinds()));
pub(crate) static IMAGE_SIZES: LazyLock<Vec<Known>> = LazyLock::new(|| known(cameras::image_sizes()));
pub(crate) static WORLDS: LazyLock<Vec<Known>> = LazyLock::new(|| known(cameras::worlds()));
pub(crate) static LIGHTS: LazyLock<Vec<Known>> = LazyLock::new(|| known(lights::of_all_kinds()));
pub(crate) static OUTLIERS: LazyLock<Vec<Known>> = LazyLock::new(lights::that_no_face_holds);
pub(crate) static SEAMS: LazyLock<Vec<Known>> = LazyLock::new(seams::all);
pub(crate) static LATTICES: LazyLock<Vec<Known>> = LazyLock::new(|| known(seams::lattices()));
pub(crate) static OPACITY: LazyLock<Vec<Known>> = LazyLock::new(|| known(opacity::of_masks()));
pub(crate) static SIDES: LazyLock<Vec<Known>> = LazyLock::new(|| known(opacity::of_sides()));
pub(crate) static PATCHES: LazyLock<Vec<Known>> = LazyLock::new(|| known(patches::of_bad_shapes()));
pub(crate) static SAMPLES: LazyLock<Vec<Known>> = LazyLock::new(|| known(samples::all()));
pub(crate) static AIMED: LazyLock<Vec<Known>> = LazyLock::new(|| known(aimed::all()));
pub(crate) static MOVING: LazyLock<Vec<Known>> = LazyLock::new(moving::frames);
pub(crate) static CROWDS: LazyLock<Vec<Known>> = LazyLock::new(crowds::all);

/// Coordinates with few bits left.
pub(crate) const FAR: Vec3 = Vec3::new(148_376.0, 1_234.0, -223_423.0);

/// A bumpy ball above a floor.
pub(crate) fn room(rings: u32) -> TestMesh {
    let mut mesh = TestMesh::bumpy_ball(0.8, rings).placed(1.0, Vec3::Y * 0.1);
    mesh.append(&TestMesh::plane(1, 4.0).placed(1.0, Vec3::NEG_Y));
    mesh
}

/// Triangles of all sizes, a ball and a floor, and some that can't be hit.
pub(crate) fn scene(random: &mut Random) -> TestMesh {
    let mut mesh = TestMesh::soup(random, 60, 0.02);
    mesh.append(&TestMesh::bumpy_ball(1.0, 8));
    mesh.append(&TestMesh::plane(5, 3.0));
    mesh.positions[5].x = f32::NAN;
    mesh.indices.push([0, 1, u32::MAX]);
    mesh.indices.push([7, 7, 8]);
    mesh
}

/// The same case with rays through other parts of pixels.
fn through(case: Case, x: f64, y: f64) -> Case {
    Case { offset_pixels: glam::DVec2::new(x, y), ..case }
}
