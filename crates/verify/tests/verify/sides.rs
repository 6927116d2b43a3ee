//! One-sided triangles.

use std::sync::Arc;

use glam::{DVec2, Vec3, Vec4};
use umbrage::rays::{self, Camera, View};
use umbrage::scene::{Frame, Light, Material, Materials, Mesh};
use umbrage::{Background, Renderer, Settings, Sides};
use umbrage_papers::structures;
use umbrage_verify::lights::{point, sun};
use umbrage_verify::{Case, TestMesh, referee};

const SIDE: u32 = 40;

/// A ball in an inside-out hull, as models have for their outlines, over a floor. From outside only the hull's far half
/// is visible. Also which triangles have a back: all but the hull's.
fn outlined_ball() -> (TestMesh, u32, rays::Sides<'static>) {
    let mut mesh = TestMesh::bumpy_ball(1.0, 12);
    mesh.append(&TestMesh::plane(3, 4.0).placed(1.0, Vec3::NEG_Y * 1.5));
    let first = mesh.indices.len() as u32;
    let mut hull = TestMesh::bumpy_ball(1.15, 12);
    hull.indices.iter_mut().for_each(|[a, b, _]| std::mem::swap(a, b));
    mesh.append(&hull);
    let mut backs = vec![0_u64; mesh.indices.len().div_ceil(64)];
    (0..first).for_each(|id| backs[id as usize / 64] |= 1 << (id % 64));
    (mesh, first, rays::Sides::Each(backs.leak()))
}

fn case(mesh: TestMesh, sides: rays::Sides<'static>) -> Case {
    let camera = Camera::look_at(Vec3::new(0.5, 1.0, 4.0), Vec3::ZERO, Vec3::Y, 0.8);
    let view = View { camera, width: SIDE, height: SIDE };
    let lights = [point(Vec3::new(1.0, 2.5, 5.0)), sun(0.2, -1.0, -0.4), point(Vec3::new(0.0, 1.08, 0.0))];
    Case { sides, offset_pixels: DVec2::splat(0.5), ..Case::new("an outlined ball", mesh, view, &lights) }
}

/// The case's triangles, white except for the hull's, which are black.
fn frame(case: &Case) -> Frame {
    let mut frame = Frame::from_triangles(case.mesh.positions.clone(), case.mesh.indices.clone());
    let black = Material { base_color: Vec4::W, unlit: true, ..Material::default() };
    let white = Material { base_color: Vec4::ONE, ..Material::clay() };
    let material_of_triangle = (0..case.mesh.indices.len() as u32).map(|id| case.sides.has_back(id).into());
    frame.mesh = Arc::new(Mesh { material_of_triangle: material_of_triangle.collect(), ..(*frame.mesh).clone() });
    frame.materials = Arc::new(Materials { materials: vec![black, white], ..Materials::default() });
    let light = |&source| Light::new(source, 9.0);
    frame.lights = case.lights.iter().map(light).collect();
    frame
}

fn settings(case: &Case) -> Settings {
    let camera = case.view.camera.into();
    Settings { width: SIDE, height: SIDE, camera, background: Background::Color(Vec3::ZERO), ..Settings::default() }
}

#[test]
fn what_is_in_an_inverted_hull_is_seen_and_lit() {
    let (mesh, hull, backs) = outlined_ball();
    for (sides, of_case) in [(Sides::File, backs), (Sides::Front, rays::Sides::Front), (Sides::Both, rays::Sides::Both)]
    {
        let mut case = case(mesh.clone(), backs);
        let frame = frame(&case);
        case.sides = of_case;
        let truth = referee::truth(&case);
        assert_eq!(truth, case.truth(), "{sides}");
        for structure in structures().iter() {
            let name = structure.name();
            let mut renderer = Renderer::default();
            let settings = Settings { structure: structure.clone(), sides, ..settings(&case) };
            let film = renderer.render_frame(&frame, &settings).expect("a picture").clone();
            let compared = referee::compare(&case, &truth, renderer.seen(), renderer.light_masks());
            assert_eq!(compared, Ok(()), "{sides}, {name}");
            // At the ball's middle its hull is seen from outside.
            let [x, y] = [SIDE / 2; 2];
            let is_lit = renderer.light_masks()[0].is_lit(x, y);
            let brightness = film.color[(y * SIDE + x) as usize].truncate().max_element();
            let found = (renderer.seen().triangle_at(x, y) >= hull, is_lit, brightness > 0.1);
            let of_hull = truth.triangle.iter().filter(|&&id| (hull..u32::MAX).contains(&id)).count();
            if sides == Sides::Both {
                assert_eq!(found, (true, true, false), "{name}: all is black");
            } else {
                assert_eq!(found, (false, true, true), "{sides}, {name}");
                assert!((20..400).contains(&of_hull), "{sides}, {name}: an outline of {of_hull} pixels");
            }
            // The light between ball and hull can't leave the hull, whose front is inside.
            let beyond = (0..SIDE).filter(|&x| renderer.light_masks()[2].is_lit(x, SIDE - 1)).count();
            assert_eq!(beyond, 0, "{sides}, {name}");
        }
    }
}

#[test]
fn rays_behind_glass_and_from_mirrors_go_through_backs_as_well() {
    let (mesh, _, backs) = outlined_ball();
    let mut case = case(mesh, backs);
    let camera = case.view.camera;
    let pane = |mesh: &mut TestMesh, middle: Vec3| {
        let corner = |x: f32, y: f32| middle + camera.right * x + camera.up * y;
        mesh.quad([corner(-2.0, -2.0), corner(2.0, -2.0), corner(2.0, 2.0), corner(-2.0, 2.0)]);
    };
    // A pane of glass before the camera; and a mirror there, in which a camera that is turned around sees the same.
    pane(&mut case.mesh, camera.position + camera.forward * 0.5);
    let triangles = case.mesh.indices.len();
    let plain = frame(&case);
    let with = |material: Material| {
        let mut frame = plain.clone();
        Arc::make_mut(&mut frame.materials).materials.push(Material { double_sided: true, ..material });
        Arc::make_mut(&mut frame.mesh).material_of_triangle[triangles - 2..].fill(2);
        frame
    };
    let glass = with(Material { transmission: 1.0, roughness: 0.0, ..Material::clay() });
    let mirror = with(Material { metallic: 1.0, roughness: 0.0, base_color: Vec4::ONE, ..Material::clay() });
    let turned =
        Camera { position: camera.position + camera.forward, forward: -camera.forward, right: -camera.right, ..camera };
    let of_mirror = Settings { camera: turned.into(), bounces: 2, ..settings(&case) };
    for (what, frame, settings) in [("glass", glass, settings(&case)), ("a mirror", mirror, of_mirror)] {
        let bright = [Sides::File, Sides::Both].map(|sides| {
            let mut renderer = Renderer::default();
            let film = renderer.render_frame(&frame, &Settings { sides, ..settings.clone() }).expect("a picture");
            film.color[(SIDE / 2 * SIDE + SIDE / 2) as usize].truncate().max_element()
        });
        assert!(bright[0] > 0.1 && bright[1] < 0.1, "{what}: {bright:?}");
    }
}
