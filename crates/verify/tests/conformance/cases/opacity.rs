//! Triangles with holes, and one-sided triangles.

use glam::Vec3;
use umbrage_rays::{Camera, MaskAnswers, MaskPoints, Opacity, Projection, Sides};
use umbrage_verify::lights::{around, point};
use umbrage_verify::views::{camera, placed, view};
use umbrage_verify::{Case, MIXED_SIDES, Random, TestMesh};

use super::{FAR, room};

/// Squares cut out of every third triangle; its intervals are certain away from the squares' borders.
pub(crate) struct Squares(pub(crate) f64);

impl Squares {
    fn square(&self, [b, c]: [f64; 2]) -> [i64; 2] {
        [b, c].map(|weight| (weight * self.0).floor() as i64)
    }
}

impl Opacity for Squares {
    fn is_opaque(&self, triangle: u32) -> bool {
        !triangle.is_multiple_of(3)
    }

    fn stops(&self, triangle: u32, barycentric: [f32; 2]) -> bool {
        assert!(!self.is_opaque(triangle), "nobody needs to ask");
        let [b, c] = self.square(barycentric.map(f64::from));
        b % 2 == c % 2
    }

    fn which_stop(&self, triangle: u32, points: &MaskPoints) -> MaskAnswers {
        assert!(!self.is_opaque(triangle), "nobody needs to ask");
        let MaskPoints { barycentric: [b, c], error, lanes } = points;
        let mut answers = MaskAnswers::default();
        for lane in (0..16).filter(|lane| lanes >> lane & 1 == 1) {
            let at = |error: f64| self.square([b[lane], c[lane]].map(|weight| f64::from(weight) + error));
            let error = f64::from(error[lane]);
            if (0.0..=1.0).contains(&error) && at(-error) == at(error) {
                let is_opaque = self.stops(triangle, [b[lane], c[lane]]);
                *if is_opaque { &mut answers.opaque } else { &mut answers.cut } |= 1 << lane;
            }
        }
        answers
    }
}

pub(super) fn of_masks() -> Vec<Case> {
    let mut random = Random::new(7);
    let mut soup = TestMesh::soup(&mut random, 80, 0.1);
    soup.append(&TestMesh::bumpy_ball(1.2, 8));
    soup.append(&TestMesh::plane(3, 500.0));
    let look = Camera::look_at(Vec3::new(2.5, 1.5, 3.5), Vec3::ZERO, Vec3::Y, 0.9);
    let lights = around(1.0, Vec3::ZERO);
    let case = |lights| Case::new("", soup.clone(), view(look, 40, 30), lights);
    let mut cases = Vec::new();
    // From squares with nearly all points certain to squares with hardly any.
    for count in [3.0, 50.0, 3e4] {
        let (name, opacity) = (format!("{count}² squares"), Box::new(Squares(count)));
        let shadow_opacity = Box::new(Squares(count * 0.7));
        cases.push(Case { name, opacity, shadow_opacity, ..case(&lights[..3]) });
    }
    // Functions know nothing about neighbouring points; camera and shadow rays have different ones.
    let some = |id: u32, [b, _]: [f32; 2]| !id.is_multiple_of(3) || b < 0.4;
    let none = |_: u32, _: [f32; 2]| false;
    cases.push(Case { name: "a function".into(), opacity: Box::new(some), ..case(&lights[5..8]) });
    cases.push(Case { name: "a function of shadows".into(), shadow_opacity: Box::new(some), ..case(&lights[..2]) });
    cases.push(Case { name: "no shadows".into(), shadow_opacity: Box::new(none), ..case(&lights[..2]) });
    cases.push(Case { name: "nothing to see".into(), opacity: Box::new(none), ..case(&lights[..1]) });

    for (scale, offset) in [(1.0, Vec3::ZERO), (1e-6, Vec3::ZERO), (300.0, FAR)] {
        let mesh = room(9).placed(scale, offset);
        let view = view(placed(camera(), scale, offset), 29, 23);
        let case = Case::new("squares in a room", mesh, view, &around(scale, offset));
        cases.push(Case { opacity: Box::new(Squares(7.0)), shadow_opacity: Box::new(Squares(7.0)), ..case });
    }
    cases
}

/// Triangles that show their front, their back or, up to rounding, neither, to the camera and to lights; and views of
/// them, one of them mirrored and one with parallel rays.
pub(super) fn of_sides() -> Vec<Case> {
    let look = Camera::look_at(Vec3::new(2.5, 1.5, 3.5), Vec3::ZERO, Vec3::Y, 0.9);
    let at_first_light = Vec3::new(3.0, 5.0, 2.0);
    let mesh = TestMesh::fronts_and_backs([look.position, at_first_light]);
    let lights = around(1.0, Vec3::ZERO);
    assert_eq!(lights[0], point(at_first_light));
    let mirrored = Camera { right: -look.right, ..look };
    let parallel = Camera { projection: Projection::Orthographic { half_height: 1.5 }, ..look };
    let mut cases = Vec::new();
    for camera in [look, mirrored, parallel] {
        for (name, sides) in [("both sides", Sides::Both), ("fronts", Sides::Front), ("some backs", MIXED_SIDES)] {
            let case = || Case { sides, ..Case::new(name, mesh.clone(), view(camera, 33, 30), &lights) };
            cases.push(case());
            cases.push(Case { opacity: Box::new(Squares(5.0)), shadow_opacity: Box::new(Squares(3.0)), ..case() });
        }
    }
    cases
}
