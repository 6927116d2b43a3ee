//! The ground and the light of files that have neither.

use glam::Vec3;
use umbrage_files::OpenOptions;
use umbrage_rays::LightSource;
use umbrage_scene::{Ground, GroundChoice, Scene};

use crate::solids::cube_obj;

fn opened(obj: &[u8], ground: GroundChoice) -> Scene {
    let options = OpenOptions { ground, ..OpenOptions::default() };
    umbrage_files::open_files("a.obj", [("a.obj", obj)], &options).unwrap()
}

/// A square of two triangles at a height, seen from above or from below.
fn square(height: f32, faces_up: bool, first: u32) -> String {
    let corners = format!("v -9 {height} -9\nv -9 {height} 9\nv 9 {height} 9\nv 9 {height} -9\n");
    let order = if faces_up { [0, 1, 2, 3] } else { [3, 2, 1, 0] }.map(|corner| (first + corner).to_string());
    format!("{corners}f {}\n", order.join(" "))
}

#[test]
fn files_without_a_floor_get_a_ground_behind_their_own_triangles() {
    let cube = cube_obj();
    let plain = opened(&cube, GroundChoice::None);
    assert_eq!((plain.ground(), OpenOptions::for_pictures().ground), (None, GroundChoice::Auto));
    let scene = opened(&cube, GroundChoice::Auto);
    assert_eq!(scene.ground(), Some(Ground::default()));
    let [own, frame] = [plain.at(0.0).unwrap(), scene.at(0.0).unwrap()];
    let (own, all) = (own.mesh.triangles.as_slice(), frame.mesh.triangles.as_slice());
    assert_eq!((frame.mesh.ground_triangles, &all[..own.len()], all.len()), (2, own, own.len() + 2));
    assert_eq!(frame.framing_camera(1.5), plain.at(0.0).unwrap().framing_camera(1.5));
}

#[test]
fn files_with_a_floor_and_scenes_of_no_file_get_none() {
    let cube = String::from_utf8(cube_obj()).unwrap();
    let of = |floor: String| opened(format!("{cube}{floor}").as_bytes(), GroundChoice::Auto).ground();
    assert_eq!(of(square(-1.0, true, 9)), None);
    // A ceiling, and a floor's other side.
    assert_eq!(of(square(30.0, true, 9)), Some(Ground::default()));
    assert_eq!(of(square(-1.0, false, 9)), Some(Ground::default()));
    // Nothing stands on a plate.
    let plate = square(0.0, true, 1) + &square(-0.1, false, 5);
    assert_eq!(opened(plate.as_bytes(), GroundChoice::Auto).ground(), Some(Ground::default()));
    // A wall stands on nothing.
    assert_eq!(opened(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", GroundChoice::Auto).ground(), Some(Ground::default()));
}

#[test]
fn a_ground_is_at_the_foot_of_the_scene_however_far_that_is_from_the_origin() {
    let far = b"v 500000 4649776 100\nv 500001 4649776 100\nv 500000 4649777 100\nf 1 2 3\n";
    let scene = opened(far, GroundChoice::Auto);
    let frame = scene.at(0.0).unwrap();
    let [ground, _, _] = frame.triangles().corners(1);
    let height = scene.world_from_local(ground).y;
    assert!((height - 4_649_776.0).abs() < 1e-4, "{height}");
}

#[test]
fn a_ground_reaches_thirty_half_diagonals_and_faces_up() {
    // Its diagonal is 3, and its middle (1, 2.5, -1).
    let obj = b"v 0 2 0\nv 2 2 0\nv 0 3 -2\nf 1 2 3\n";
    for (text, height) in [("shadow", 2.0 - 3e-5), ("matte:0.5", 0.5)] {
        let frame = opened(obj, text.parse().unwrap()).at(0.0).unwrap();
        let triangles = frame.triangles();
        let corners = [triangles.corners(1), triangles.corners(2)];
        for [a, b, c] in corners {
            assert!((b - a).cross(c - a).y > 0.0);
            for corner in [a, b, c] {
                let off = corner - Vec3::new(1.0, height, -1.0);
                assert!((off.abs() - Vec3::new(45.0, 0.0, 45.0)).length() < 1e-4, "{text}: {corner}");
            }
        }
        let material = frame.mesh.material_of_triangle[2] as usize;
        let material = &frame.materials.materials[material];
        assert_eq!((&*material.name, material.catches_shadows), ("ground", text == "shadow"));
    }
}

#[test]
fn the_sun_that_is_made_is_above_the_left_of_the_framing_camera_at_any_size() {
    for scale in [1e-20_f32, 1.0, 1e30] {
        let obj = format!("v 0 0 0\nv {scale} 0 0\nv 0 {scale} 0\nv 0 0 {scale}\nf 1 2 3\nf 1 2 4\n");
        let frame = opened(obj.as_bytes(), GroundChoice::None).at(0.0).unwrap();
        let camera = frame.framing_camera(1.0);
        let light = &frame.lights[0];
        let LightSource::Directional { direction } = light.source else { panic!("{light:?}") };
        let towards = -direction;
        assert!(towards.dot(camera.right) < -0.4 && towards.dot(Vec3::Y) > 0.7 && towards.dot(camera.forward) < 0.0);
        assert!(light.casts_shadow && (1.0..4.0).contains(&light.intensity));
    }
}

#[test]
fn grounds_are_chosen_by_their_names() {
    for text in ["none", "auto", "shadow", "matte:0.5"] {
        assert_eq!(text.parse::<GroundChoice>().unwrap().to_string(), text);
    }
    assert!("floor".parse::<GroundChoice>().is_err());
}
