use glam::{Quat, Vec3};
use serde_json::json;
use umbrage_files::Clip;
use umbrage_scene::Frame;

use crate::builder::{Builder, I16, U8};

/// A triangle on node 0 with one animation.
fn animated<const N: usize>(path: &str, interpolation: &str, times: &[f32], values: &[[f32; N]]) -> Builder {
    let mut file = Builder::new();
    let mesh = file.triangle();
    let node = file.push("nodes", json!({ "mesh": mesh }));
    file.animate(node, path, interpolation, times, values);
    file
}

#[track_caller]
fn assert_close(actual: Vec3, expected: Vec3) {
    assert!((actual - expected).length() < 1e-5, "{actual}, not {expected}");
}

/// The world positions of the triangle's three corners.
fn corners(frame: &Frame) -> [Vec3; 3] {
    frame.positions[..].try_into().unwrap()
}

#[test]
fn step_keeps_the_keyframe_before() {
    let file = animated("translation", "STEP", &[1.0, 2.0, 4.0], &[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [4.0, 0.0, 0.0]]);
    let scene = file.open().unwrap();
    assert_eq!(scene.duration_seconds(), 4.0);
    for (seconds, x) in [(0.0, 1.0), (1.0, 1.0), (1.999, 1.0), (2.0, 2.0), (3.999, 2.0), (4.0, 4.0)] {
        assert_eq!(scene.at(seconds).unwrap().positions[0].x, x, "{seconds}");
    }
}

#[test]
fn linear_mixes_and_holds_outside_its_range() {
    let file =
        animated("translation", "LINEAR", &[1.0, 3.0, 4.0], &[[0.0, 1.0, 0.0], [4.0, 3.0, 0.0], [4.0, 3.0, 8.0]]);
    let scene = file.open().unwrap();
    for (seconds, expected) in
        [(0.5, [0.0, 1.0, 0.0]), (1.5, [1.0, 1.5, 0.0]), (3.0, [4.0, 3.0, 0.0]), (3.25, [4.0, 3.0, 2.0])]
    {
        assert_close(scene.at(seconds).unwrap().positions[0], Vec3::from_array(expected));
    }
}

#[test]
fn time_starts_again_after_the_end() {
    let file = animated("translation", "LINEAR", &[0.0, 2.0], &[[0.0; 3], [2.0, 0.0, 0.0]]);
    let scene = file.open().unwrap();
    assert_close(scene.at(4.5).unwrap().positions[0], Vec3::new(0.5, 0.0, 0.0));
    assert_close(scene.at(2.0).unwrap().positions[0], Vec3::new(2.0, 0.0, 0.0));
    assert_close(scene.at(-1.0).unwrap().positions[0], Vec3::ZERO);
}

#[test]
fn scale_is_animated() {
    let file = animated("scale", "LINEAR", &[0.0, 1.0], &[[1.0; 3], [3.0, 5.0, 1.0]]);
    let [_, x, y] = corners(&file.at(0.5));
    assert_close(x, Vec3::new(2.0, 0.0, 0.0));
    assert_close(y, Vec3::new(0.0, 3.0, 0.0));
}

#[test]
fn rotations_turn_at_constant_speed() {
    let quarter = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    let file = animated("rotation", "LINEAR", &[0.0, 1.0], &[Quat::IDENTITY.to_array(), quarter.to_array()]);
    for part in [0.0, 0.1, 0.25, 0.5, 0.9, 1.0_f32] {
        let angle = part * std::f32::consts::FRAC_PI_2;
        let [_, x, _] = corners(&file.at(f64::from(part)));
        assert_close(x, Vec3::new(angle.cos(), angle.sin(), 0.0));
    }
}

#[test]
fn rotations_take_the_shorter_way() {
    let quarter = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    // The same rotation with all signs flipped: component by component it is further away.
    let file = animated("rotation", "LINEAR", &[0.0, 1.0], &[Quat::IDENTITY.to_array(), (-quarter).to_array()]);
    let [_, x, _] = corners(&file.at(0.5));
    let half = std::f32::consts::FRAC_1_SQRT_2;
    assert_close(x, Vec3::new(half, half, 0.0));
}

#[test]
fn almost_equal_rotations_are_mixed() {
    let small = Quat::from_rotation_z(1e-3);
    let file = animated("rotation", "LINEAR", &[0.0, 1.0], &[Quat::IDENTITY.to_array(), small.to_array()]);
    let [_, x, _] = corners(&file.at(0.25));
    assert!((x.y - 0.25e-3).abs() < 1e-8, "{x}");
}

#[test]
fn cubic_splines_follow_their_tangents() {
    // In-tangent, value and out-tangent of each of two keyframes that are two seconds apart.
    let keys = [[9.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [9.0; 3]];
    let scene = animated("translation", "CUBICSPLINE", &[1.0, 3.0], &keys).open().unwrap();
    // At a quarter: h = (27/32, 9/64, 5/32, −3/64), and tangents count twice over two seconds.
    let quarter = 27.0 / 32.0 * 1.0 + 9.0 / 64.0 * 6.0 + 5.0 / 32.0 * 2.0 - 3.0 / 64.0 * -2.0;
    // In the middle: h = (1/2, 1/8, 1/2, −1/8).
    let middle = 0.5 * 1.0 + 0.125 * 6.0 + 0.5 * 2.0 - 0.125 * -2.0;
    for (seconds, x) in [(0.0, 1.0), (1.0, 1.0), (1.5, quarter), (2.0, middle), (3.0, 2.0)] {
        assert_close(scene.at(seconds).unwrap().positions[0], Vec3::new(x, 0.0, 0.0));
    }
}

#[test]
fn cubic_rotations_are_normalised() {
    let zero = [0.0; 4];
    let half = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2).to_array();
    let keys = [zero, Quat::IDENTITY.to_array(), zero, zero, half, zero];
    let [_, x, _] = corners(&animated("rotation", "CUBICSPLINE", &[0.0, 1.0], &keys).at(0.5));
    // Halfway, the components are the mean of both, which isn't of unit length.
    let angle = std::f32::consts::FRAC_PI_4;
    assert_close(x, Vec3::new(angle.cos(), angle.sin(), 0.0));
}

#[test]
fn normalized_integers_are_rotations_and_weights() {
    let mut file = Builder::new();
    let mesh = file.triangle();
    let node = file.push("nodes", json!({ "mesh": mesh }));
    file.animate(node, "rotation", "LINEAR", &[0.0], &[[0.0; 4]]);
    let quarter = (std::f32::consts::FRAC_1_SQRT_2 * 32_767.0).round() as i16;
    let bytes: Vec<u8> = [0, 0, quarter, quarter].iter().flat_map(|value: &i16| value.to_le_bytes()).collect();
    let output = file.accessor(I16, "VEC4", 1, &bytes);
    file.json["accessors"][output]["normalized"] = json!(true);
    file.json["animations"][0]["samplers"][0]["output"] = json!(output);
    let [_, x, _] = corners(&file.at(0.0));
    assert_close(x, Vec3::Y);
}

#[test]
fn morph_weights_are_animated() {
    let mut file = morphing();
    file.animate(0, "weights", "LINEAR", &[0.0, 1.0], &[[0.0], [1.0], [1.0], [0.0]]);
    let frame = file.at(0.25);
    // Weights 0.25 and 0.75.
    assert_close(frame.positions[0], Vec3::new(0.0, 0.75, 0.25));
}

#[test]
fn cubic_morph_weights_have_tangents_for_each_target() {
    let mut file = morphing();
    // For each keyframe two in-tangents, two values and two out-tangents.
    let keys = [9.0, 9.0, 0.0, 1.0, 4.0, 0.0, 0.0, -8.0, 1.0, 0.0, 9.0, 9.0].map(|number| [number]);
    file.animate(0, "weights", "CUBICSPLINE", &[0.0, 1.0], &keys);
    let frame = file.at(0.5);
    // 0.125 · 4 + 0.5 · 1, and 0.5 · 1 − 0.125 · (−8).
    assert_close(frame.positions[0], Vec3::new(0.0, 1.5, 1.0));
}

/// A triangle with two targets: the first moves corner 0 by one along z, the second along y.
fn morphing() -> Builder {
    let mut file = Builder::new();
    let positions = file.floats(&crate::builder::TRIANGLE);
    let along_z = file.floats(&[[0.0, 0.0, 1.0], [0.0; 3], [0.0; 3]]);
    let along_y = file.floats(&[[0.0, 1.0, 0.0], [0.0; 3], [0.0; 3]]);
    let targets = json!([{ "POSITION": along_z }, { "POSITION": along_y }]);
    let mesh = file.mesh(json!({ "POSITION": positions }), json!({ "targets": targets }));
    file.push("nodes", json!({ "mesh": mesh }));
    file
}

#[test]
fn a_matrix_is_taken_apart_where_it_is_animated() {
    let mut file = animated("translation", "LINEAR", &[0.0, 1.0], &[[0.0; 3], [0.0, 0.0, 4.0]]);
    let quarter = glam::Mat4::from_rotation_z(std::f32::consts::FRAC_PI_2) * glam::Mat4::from_scale(Vec3::splat(2.0));
    file.json["nodes"][0]["matrix"] = json!(quarter.to_cols_array());
    let [origin, x, _] = corners(&file.at(0.5));
    assert_close(origin, Vec3::new(0.0, 0.0, 2.0));
    assert_close(x, Vec3::new(0.0, 2.0, 2.0));
}

/// Two nodes, two animations: `Rise` moves node 0 up, `Slide` moves node `other` aside.
fn two_clips(other: usize) -> Builder {
    let mut file = Builder::new();
    let mesh = file.triangle();
    file.push("nodes", json!({ "mesh": mesh }));
    file.push("nodes", json!({ "mesh": mesh }));
    let rise = file.animate(0, "translation", "LINEAR", &[0.0, 2.0], &[[0.0; 3], [0.0, 2.0, 0.0]]);
    let slide = file.animate(other, "translation", "LINEAR", &[0.0, 1.0], &[[0.0; 3], [1.0, 0.0, 0.0]]);
    file.json["animations"][rise]["name"] = json!("Rise");
    file.json["animations"][slide]["name"] = json!("Slide");
    file
}

#[test]
fn clips_play_as_asked() {
    let up = Vec3::new(0.0, 1.0, 0.0);
    let aside = Vec3::new(1.0, 0.0, 0.0);
    for (other, clip, first, second, duration) in [
        (1, Clip::Auto, up, aside, 2.0),
        (0, Clip::Auto, up, Vec3::ZERO, 2.0),
        (0, Clip::All, aside, Vec3::ZERO, 2.0),
        (1, Clip::Rest, Vec3::ZERO, Vec3::ZERO, 0.0),
        (1, Clip::Named("Rise".into()), up, Vec3::ZERO, 2.0),
        (1, Clip::Named("1".into()), Vec3::ZERO, aside, 1.0),
    ] {
        let scene = two_clips(other).open_clip(clip.clone()).unwrap();
        let frame = scene.at(1.0).unwrap();
        assert_eq!([frame.positions[0], frame.positions[3]], [first, second], "{clip:?} {other}");
        assert_eq!(scene.duration_seconds(), duration, "{clip:?} {other}");
        let names: Vec<_> = scene.animations().iter().map(|animation| animation.name.as_str()).collect();
        assert_eq!(names, ["Rise", "Slide"]);
        assert_eq!(scene.animations()[0].seconds, 2.0);
    }
    let plays =
        |clip| two_clips(0).open_clip(clip).unwrap().animations().iter().map(|clip| clip.plays).collect::<Vec<_>>();
    assert_eq!(plays(Clip::Auto), [true, false]);
    assert_eq!(plays(Clip::All), [true, true]);
}

#[test]
fn an_unknown_clip_is_refused_with_the_known_ones() {
    let error = two_clips(0).open_clip(Clip::Named("Fall".into())).unwrap_err().to_string();
    assert!(error.contains("`Fall`") && error.contains("`Rise`, `Slide`"), "{error}");
}

#[test]
fn channels_without_a_node_are_left_out_with_a_warning() {
    let mut file = two_clips(1);
    let pointer =
        json!({ "sampler": 0, "target": { "path": "pointer", "extensions": { "KHR_animation_pointer": {} } } });
    file.json["animations"][1]["channels"].as_array_mut().unwrap().push(pointer);
    let scene = file.open().unwrap();
    assert!(scene.warnings()[0].contains("1 animation channels"), "{:?}", scene.warnings());
    assert_eq!(scene.at(1.0).unwrap().positions[3], Vec3::X);
}

#[test]
fn broken_curves_are_refused() {
    let falling = animated("translation", "LINEAR", &[1.0, 0.5], &[[0.0; 3]; 2]);
    assert!(falling.error().contains("never fall"));
    let nan = animated("translation", "LINEAR", &[0.0, 1.0], &[[0.0; 3], [f32::NAN, 0.0, 0.0]]);
    assert!(nan.error().contains("number 3 is not finite"), "{}", nan.error());
    let few = animated("translation", "CUBICSPLINE", &[0.0, 1.0], &[[0.0; 3]; 5]);
    assert!(few.error().contains("15 numbers where 2 keyframes with 3 values"), "{}", few.error());
    let mut unknown = animated("translation", "BEZIER", &[0.0], &[[0.0; 3]]);
    assert!(unknown.error().contains("animations[0].samplers[0].interpolation"));
    unknown.json["animations"][0]["channels"][0]["sampler"] = json!(7);
    assert!(unknown.error().contains("animations[0].channels[0].sampler: index 7 is out of range"));
    let mut bytes = animated("translation", "LINEAR", &[0.0], &[[0.0; 3]]);
    let whole = bytes.accessor(U8, "SCALAR", 1, &[0]);
    bytes.json["animations"][0]["samplers"][0]["output"] = json!(whole);
    assert!(bytes.error().contains("3 components"), "{}", bytes.error());
}

#[test]
fn equal_times_jump() {
    let file = animated("translation", "LINEAR", &[0.0, 1.0, 1.0, 2.0], &[[0.0; 3], [1.0; 3], [5.0; 3], [6.0; 3]]);
    let scene = file.open().unwrap();
    assert_close(scene.at(0.5).unwrap().positions[0], Vec3::splat(0.5));
    assert_close(scene.at(1.0).unwrap().positions[0], Vec3::splat(5.0));
    assert_close(scene.at(1.5).unwrap().positions[0], Vec3::splat(5.5));
}
