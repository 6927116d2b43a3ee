//! Many triangles in one place: left out if no ray can tell them from the first.

use glam::{Vec3, Vec4};
use std::sync::Arc;
use umbrage::rays::{self, Camera, LightSource};
use umbrage::scene::{Alpha, Frame, Light, Material, Materials, Mesh};
use umbrage::{Renderer, Settings, Sides};
use umbrage_papers::structures;
use umbrage_verify::{Case, TestMesh, Truth};

const SIDE: u32 = 24;

/// The room, copies of the first two triangles of the ball in front of it, and some near-copies: reversed, with another
/// material, and with a corner moved by a bit.
fn mesh(copies: u32) -> TestMesh {
    let mut mesh = TestMesh::room();
    let [a, b, c] = TestMesh::COPY;
    mesh.push([a, b, c]);
    mesh.push([b.with_z(2.0), a, c]);
    for number in 0..copies {
        mesh.push(if number % 3 == 0 { [b, c, a] } else { [a, b, c] });
    }
    mesh.push([a, c, b]);
    mesh.push([a.with_x(a.x.next_up()), b, c]);
    mesh.push([a, a, b]);
    mesh
}

fn frame(mesh: &TestMesh, lights: &[LightSource]) -> Frame {
    let mut frame = Frame::from_triangles(mesh.positions.clone(), mesh.indices.clone());
    let light = |&source| Light::new(source, 9.0);
    frame.lights = lights.iter().map(light).collect();
    frame
}

fn case(mesh: TestMesh, sides: rays::Sides<'static>) -> Case {
    let camera = Camera::look_at(Vec3::new(-0.5, 0.6, 4.0), Vec3::new(-0.6, -0.2, 0.0), Vec3::Y, 0.8);
    let view = rays::View { camera, width: SIDE, height: SIDE };
    let lights =
        [umbrage_verify::lights::point(Vec3::new(-1.0, 2.5, 3.0)), umbrage_verify::lights::sun(0.3, -1.0, -0.2)];
    Case { sides, offset_pixels: glam::DVec2::splat(0.5), ..Case::new("copies", mesh, view, &lights) }
}

fn compare(renderer: &Renderer, case: &Case, truth: &Truth, what: &str) {
    let compared = umbrage_verify::referee::compare(case, truth, renderer.seen(), renderer.light_masks());
    assert_eq!(compared, Ok(()), "{what}");
}

#[test]
fn copies_change_nothing_but_the_count() {
    const COPIES: u32 = 500;
    for (sides, of_case) in [(Sides::Both, rays::Sides::Both), (Sides::Front, rays::Sides::Front)] {
        let case = case(mesh(COPIES), of_case);
        let (truth, frame) = (case.truth(), frame(&case.mesh, &case.lights));
        let mut bytes = Vec::new();
        for structure in structures().iter() {
            let name = structure.name();
            let settings = Settings {
                width: SIDE,
                height: SIDE,
                camera: case.view.camera.into(),
                structure: structure.clone(),
                sides,
                ..Settings::default()
            };
            let mut renderer = Renderer::default();
            renderer.render_frame(&frame, &settings).expect("a picture");
            compare(&renderer, &case, &truth, name);
            let omitted: Vec<_> = renderer.stats().omitted.iter().map(|kind| (kind.reason, kind.count)).collect();
            assert_eq!(
                omitted,
                [("two corners are in the same place", 1), ("a copy of an earlier triangle", COPIES)],
                "{name}"
            );
            bytes.push((name, renderer.stats().structure_bytes));
            // Few copies aren't searched for.
            let few = self::frame(&mesh(3), &case.lights);
            renderer.render_frame(&few, &settings).expect("a picture");
            assert!(renderer.stats().omitted.len() == 1, "{name}: {:?}", renderer.stats().omitted);
        }
        assert!(bytes.iter().all(|&(_, bytes)| bytes < 3_000_000), "{bytes:?}");
    }
}

/// A masked triangle hides no copy: light passes through the holes of the lattice's first triangle.
#[test]
fn copies_of_what_has_holes_stay() {
    let case = case(mesh(100), rays::Sides::Both);
    let original = TestMesh::room().indices.len() as u32;
    let mut frame = frame(&case.mesh, &case.lights);
    let mut of_triangles = vec![0; case.mesh.indices.len()];
    of_triangles[original as usize] = 1;
    let holes = Material { alpha: Alpha::Mask { cutoff: 0.5 }, base_color: Vec4::ZERO, ..Material::clay() };
    frame.materials = Arc::new(Materials { materials: vec![Material::clay(), holes], ..Materials::default() });
    frame.mesh = Arc::new(Mesh { material_of_triangle: of_triangles, ..(*frame.mesh).clone() });
    let is_hole = move |id: u32, _: [f32; 2]| id != original;
    let case = Case { opacity: Box::new(is_hole), shadow_opacity: Box::new(is_hole), ..case };
    let truth = case.truth();
    assert!(truth.triangle.contains(&(original + 2)), "the first copy is seen");
    let settings = Settings { width: SIDE, height: SIDE, camera: case.view.camera.into(), ..Settings::default() };
    let mut renderer = Renderer::default();
    renderer.render_frame(&frame, &settings).expect("a picture");
    compare(&renderer, &case, &truth, "holes");
    assert_eq!(renderer.stats().omitted[1].count, 99);
}
