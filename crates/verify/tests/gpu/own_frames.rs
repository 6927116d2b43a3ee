//! Frames that a program makes without a scene: rendered as a scene's, or refused.

use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};
use umbrage::rays::{Camera, LightSource, Projection, View};
use umbrage::scene::{Alpha, BadFrame, Frame, Light, Material, NamedCamera, Scene, TextureUse};
use umbrage::{Background, CameraChoice, Error, Film, LightMask, Renderer, Seen, Settings, Settled, Stats, Structure};
use umbrage_papers::{KdTrees, Listed, Uniform};
use umbrage_verify::real_scene;

use crate::common;

const SIZE: [u32; 2] = [70, 50];

fn settings() -> Settings {
    Settings { width: SIZE[0], height: SIZE[1], ..Settings::default() }
}

/// All results of a render, as bits, so that NaN equals itself.
#[derive(Clone, Debug, PartialEq)]
struct Shown {
    film: Vec<[u32; 9]>,
    seen: Vec<u32>,
    lit: Vec<LightMask>,
}

fn shown(renderer: &Renderer) -> Shown {
    let Film { color, depth, normal, triangle, .. } = renderer.film();
    let pixels = color.iter().zip(depth).zip(normal.iter().zip(triangle));
    let film = pixels.map(|((color, depth), (normal, &triangle))| {
        let [x, y, z] = normal.to_array().map(f32::to_bits);
        let [red, green, blue, coverage] = color.to_array().map(f32::to_bits);
        [red, green, blue, coverage, depth.to_bits(), x, y, z, triangle]
    });
    let places = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
    Shown {
        film: film.collect(),
        seen: places.map(|(x, y)| renderer.seen().triangle_at(x, y)).collect(),
        lit: renderer.light_masks().to_vec(),
    }
}

/// Renders moments of a scene both ways and expects the same bytes.
fn compare(name: &str, renderer: &mut Renderer, scene: &Scene, settings: &Settings) {
    for moment in [0.0, 0.4] {
        let seconds = moment * scene.duration_seconds();
        renderer.render(scene, seconds, settings).unwrap_or_else(|error| panic!("{name}: {error}"));
        let of_scene = shown(renderer);
        let counts = |renderer: &Renderer| {
            let stats = renderer.stats();
            [stats.triangles, stats.vertices, stats.lights, stats.camera_rays as usize, stats.shadow_rays as usize]
        };
        let counts_of_scene = counts(renderer);
        // The renderer's last picture must not help it.
        renderer.render_frame(&Frame::default(), settings).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(shown(renderer) != of_scene, "{name}: shows nothing");
        let posed = scene.at(seconds).unwrap_or_else(|error| panic!("{error}"));
        renderer.render_frame(&posed, settings).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(shown(renderer) == of_scene, "{name} at {seconds}: another picture");
        assert_eq!(counts(renderer), counts_of_scene, "{name}");
    }
}

#[test]
fn posed_frames_are_rendered_as_their_scenes_are() {
    let lamp = light(LightSource::Point { position: Vec3::new(0.5, 4.0, 3.0) });
    let variants = [
        ("as it is", settings()),
        ("two samples", Settings { samples: 2, sides: umbrage::Sides::Front, ..settings() }),
        ("another light", Settings { lights: Some(vec![lamp.clone(), lamp]), ..settings() }),
        ("the paper's form", Settings { structure: Structure::of::<Listed>(), ..settings() }),
        ("the uniform grid", Settings { structure: Structure::of::<Uniform>(), ..settings() }),
        ("the kd-tree", Settings { structure: Structure::of::<KdTrees>(), ..settings() }),
        ("the hierarchy", Settings { structure: Structure::bvh(), ..settings() }),
    ];
    for demo in ["shatter", "glass", "forest"] {
        let scene = umbrage::open(format!("demo:{demo}?triangles=2000")).expect("a scene of the gallery");
        for (name, settings) in &variants {
            compare(&format!("{demo}, {name}"), &mut Renderer::default(), &scene, settings);
        }
        // A GPU has one structure.
        for (name, settings) in &variants[..3] {
            let Some(mut gpu) = common::renderer() else { break };
            compare(&format!("{demo}, {name}, on the GPU"), &mut gpu, &scene, settings);
        }
    }
}

#[test]
fn frames_of_real_scenes_pass() {
    for name in ["robot_expressive.glb", "tree_alphamask.glb", "elephant_gallop.glb", "sibenik.obj", "chess_board.glb"]
    {
        if let Some(path) = real_scene(name) {
            let scene = umbrage::open(&path).unwrap_or_else(|error| panic!("{error}"));
            compare(name, &mut Renderer::default(), &scene, &settings());
        }
    }
    let Some(folder) = real_scene("conformance") else { return };
    let mut checked = 0;
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|extension| extension == "glb" || extension == "gltf") {
            let scene = umbrage::open(&path).unwrap_or_else(|error| panic!("{error}"));
            for moment in [0.0, 0.35, 0.7] {
                let frame = scene.at(moment * scene.duration_seconds()).unwrap_or_else(|error| panic!("{error}"));
                assert_eq!(frame.check(), Ok(()), "{}", path.display());
            }
            checked += 1;
        }
    }
    assert!(checked > 0, "no scenes in the folder");
}

fn light(source: LightSource) -> Light {
    Light::new(source, 20.0)
}

/// A floor of two triangles and a triangle above it.
fn frame() -> Frame {
    let corner = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let floor = [corner(-2.0, 0.0, -2.0), corner(2.0, 0.0, -2.0), corner(2.0, 0.0, 2.0), corner(-2.0, 0.0, 2.0)];
    let above = [corner(-0.5, 0.5, 0.0), corner(0.5, 0.5, 0.0), corner(0.0, 1.2, -0.2)];
    let mut frame = Frame::from_triangles([&floor[..], &above].concat(), vec![[0, 2, 1], [0, 3, 2], [4, 5, 6]]);
    frame.lights = vec![light(LightSource::Point { position: corner(0.5, 4.0, 1.0) })];
    frame
}

fn camera() -> Camera {
    Camera::look_at(Vec3::new(0.0, 2.0, 4.0), Vec3::ZERO, Vec3::Y, 0.8)
}

/// Broken frames of all kinds, and parts of their error messages.
fn broken_frames() -> Vec<(Frame, &'static str)> {
    type Change = fn(&mut Frame);
    let with_texture = |material: &mut Material| material.base_color_texture = Some(TextureUse::new(3));
    let changes: [(Change, &str); 24] = [
        (|frame| Arc::make_mut(&mut frame.mesh).triangles[1][2] = 7, "triangle 1 has vertex 7 of 7"),
        (|frame| Arc::make_mut(&mut frame.mesh).triangles[2][0] = u32::MAX, "triangle 2 has vertex 4294967295 of 7"),
        (|frame| frame.positions.clear(), "triangle 0 has vertex 0 of 0"),
        (|frame| Arc::make_mut(&mut frame.mesh).material_of_triangle[2] = 1, "triangle 2 has material 1 of 1"),
        (|frame| frame.materials = Arc::default(), "triangle 0 has material 0 of 0"),
        (|frame| Arc::make_mut(&mut frame.mesh).material_of_triangle.truncate(2), "2 materials for 3 triangles"),
        (|frame| Arc::make_mut(&mut frame.mesh).material_of_triangle.push(0), "4 materials for 3 triangles"),
        (|frame| frame.normals = vec![Vec3::Y; 6], "6 normals for 7 vertices"),
        (|frame| frame.tangents = vec![Vec4::X; 8], "8 tangents for 7 vertices"),
        (
            |frame| Arc::make_mut(&mut frame.mesh).tex_coords[0] = vec![Vec2::X],
            "1 texture coordinates of set 0 for 7 vertices",
        ),
        (
            |frame| Arc::make_mut(&mut frame.mesh).tex_coords[1] = vec![Vec2::X; 2],
            "2 texture coordinates of set 1 for 7 vertices",
        ),
        (|frame| Arc::make_mut(&mut frame.mesh).colors = vec![Vec4::ONE; 3], "3 colours for 7 vertices"),
        (|frame| point(frame).x = f32::NAN, "light 0: its position is not finite"),
        (
            |frame| frame.lights.push(light(LightSource::Directional { direction: Vec3::ZERO })),
            "light 1: its direction is not finite, or too short to be one",
        ),
        (
            |frame| frame.lights.push(spot(Vec3::NAN, 0.3)),
            "light 1: its direction is not finite, or too short to be one",
        ),
        (
            |frame| frame.lights.push(spot(Vec3::X, f32::NAN)),
            "light 1: its cone's angles are not 0 ≤ inner ≤ outer ≤ π/2",
        ),
        (|frame| frame.lights.push(spot(Vec3::X, 1.6)), "light 1: its cone's angles are not 0 ≤ inner ≤ outer ≤ π/2"),
        (|frame| frame.lights[0].intensity = f32::INFINITY, "light 0: its colour or intensity is not finite"),
        (|frame| frame.lights[0].range = Some(f32::NAN), "light 0: its range is not above zero"),
        (
            |frame| see(frame, Camera { forward: Vec3::NAN, ..camera() }),
            "camera 0: its position or an axis is not finite",
        ),
        (
            |frame| see(frame, Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 0.0)),
            "camera 0: its view's height is not above zero",
        ),
        (
            |frame| see(frame, Camera { up: camera().right, ..camera() }),
            "camera 0: its axes are not of unit length and at right angles",
        ),
        (
            |frame| Arc::make_mut(&mut frame.materials).materials[0].roughness = f32::NAN,
            "material 0: one of its numbers is not finite",
        ),
        (
            |frame| see(frame, Camera { position: Vec3::INFINITY, ..camera() }),
            "camera 0: its position or an axis is not finite",
        ),
    ];
    let mut frames: Vec<_> = changes
        .into_iter()
        .map(|(change, words)| {
            let mut frame = frame();
            change(&mut frame);
            (frame, words)
        })
        .collect();
    let mut painted = frame();
    with_texture(&mut Arc::make_mut(&mut painted.materials).materials[0]);
    frames.push((painted, "material 0 has texture 3 of 0"));
    frames
}

fn point(frame: &mut Frame) -> &mut Vec3 {
    match &mut frame.lights[0].source {
        LightSource::Point { position } => position,
        other => panic!("{other:?}"),
    }
}

fn spot(direction: Vec3, outer_radians: f32) -> Light {
    light(LightSource::Spot { position: Vec3::Y, direction, inner_radians: 0.1, outer_radians })
}

fn see(frame: &mut Frame, camera: Camera) {
    frame.cameras = vec![NamedCamera { name: "".into(), camera }];
}

fn check_refusals(renderer: &mut Renderer) {
    renderer.render_frame(&frame(), &settings()).expect("a good frame");
    let last = shown(renderer);
    for (bad, words) in broken_frames() {
        let error = renderer.render_frame(&bad, &settings()).expect_err(words);
        assert!(matches!(&error, Error::Frame(_)) && error.to_string() == words, "{error} is not {words}");
        // The last frame is still there.
        assert!(shown(renderer) == last, "{words}");
    }
    // Settings that replace the broken part mend the frame.
    let mut dark = frame();
    dark.lights[0].intensity = f32::NAN;
    let lit = Settings { lights: Some(frame().lights), ..settings() };
    renderer.render_frame(&dark, &lit).expect("a frame with other lights");
    assert!(shown(renderer) == last);
    for (bad, words) in broken_settings() {
        let error = renderer.render_frame(&frame(), &bad).expect_err(words);
        assert_eq!(error.to_string(), words);
        assert!(shown(renderer) == last, "{words}");
    }
    let other = Settings { lights: Some(vec![spot(Vec3::ZERO, 0.3)]), ..settings() };
    let error = renderer.render_frame(&frame(), &other).expect_err("a light without a direction");
    assert!(matches!(error, Error::Frame(BadFrame::Light { light: 0, .. })), "{error}");
}

/// Settings of NaN and of size zero, and parts of their error messages.
fn broken_settings() -> [(Settings, &'static str); 6] {
    let seen_by = |camera: Camera| Settings { camera: camera.into(), ..settings() };
    let Camera { right, .. } = camera();
    [
        (seen_by(Camera { position: Vec3::NAN, ..camera() }), "the camera: its position or an axis is not finite"),
        (
            seen_by(Camera { forward: Vec3::ZERO, ..camera() }),
            "the camera: its axes are not of unit length and at right angles",
        ),
        (seen_by(Camera { up: right, ..camera() }), "the camera: its axes are not of unit length and at right angles"),
        (
            seen_by(Camera { projection: Projection::Perspective { tan_half_height: 0.0 }, ..camera() }),
            "the camera: its view's height is not above zero",
        ),
        (Settings { exposure_stops: f32::NAN, ..settings() }, "the exposure is not a finite number"),
        (
            Settings { background: Background::Color(Vec3::new(0.0, f32::INFINITY, 0.0)), ..settings() },
            "the background's colour is not a finite number",
        ),
    ]
}

#[test]
fn moments_that_are_none_are_refused() {
    let scene = umbrage::open("demo:cloth?triangles=500").expect("a scene of the gallery");
    for seconds in [f64::NAN, f64::INFINITY] {
        let error = Renderer::default().render(&scene, seconds, &settings()).expect_err("no moment");
        assert!(error.to_string().ends_with("seconds: it must be a finite number"), "{error}");
    }
}

#[test]
fn broken_frames_are_refused() {
    check_refusals(&mut Renderer::default());
    if let Some(mut gpu) = common::renderer() {
        check_refusals(&mut gpu);
    }
}

#[test]
fn cameras_of_a_frame_are_chosen_by_number() {
    let mut filmed = frame();
    let other = Camera::look_at(Vec3::new(3.0, 1.0, 1.0), Vec3::ZERO, Vec3::Y, 0.6);
    filmed.cameras = [camera(), other].map(|camera| NamedCamera { name: "".into(), camera }).into();
    let with = |camera: CameraChoice| Settings { camera, ..settings() };
    let check = |renderer: &mut Renderer| {
        let [own, default, first, second] =
            [other.into(), CameraChoice::Default, CameraChoice::Scene(0), CameraChoice::Scene(1)].map(|choice| {
                renderer.render_frame(&filmed, &with(choice)).expect("a frame");
                shown(renderer)
            });
        assert!(own == second && first == default && first != second);
        let error = renderer.render_frame(&filmed, &with(CameraChoice::Scene(2))).expect_err("two cameras");
        assert!(matches!(error, Error::NoSuchCamera { camera: 2, cameras: 2 }), "{error}");
        assert!(shown(renderer) == second);
    };
    check(&mut Renderer::default());
    if let Some(mut gpu) = common::renderer() {
        check(&mut gpu);
    }
}

#[test]
fn answers_are_those_of_the_picture() {
    let mut misses = 0;
    for demo in ["forest", "glass", "shatter"] {
        let scene = umbrage::open(format!("demo:{demo}?triangles=2000")).expect("a scene of the gallery");
        let mut renderer = Renderer::default();
        renderer.render(&scene, 0.3, &settings()).expect("a frame");
        let (of_picture, frame) = (shown(&renderer), renderer.frame().clone());
        let view = settings().view(&frame).expect("a view");
        let seen = renderer.see(&frame, &view).expect("an answer");
        assert!(seen.triangle == of_picture.seen, "{demo}");
        for (pixel, (&triangle, depth)) in seen.triangle.iter().zip(&seen.depth).enumerate() {
            let ([v, w], position) = (seen.barycentric[pixel], seen.position[pixel]);
            if triangle == Seen::NO_TRIANGLE {
                assert!(depth.is_infinite() && v.is_nan() && w.is_nan() && position.is_nan());
                misses += 1;
                continue;
            }
            let [a, b, c] = frame.triangles().corners(triangle).map(Vec3::as_dvec3);
            let weighed = a + (b - a) * f64::from(v) + (c - a) * f64::from(w);
            assert!(weighed.distance(position) < 1e-5 * depth, "{demo}, pixel {pixel}");
            let along = (position - view.camera.position.as_dvec3()).dot(view.camera.forward.as_dvec3());
            assert!((along - depth).abs() < 1e-6 * depth, "{demo}, pixel {pixel}");
        }
        let lit = renderer.shadow(&seen, &frame.lights).expect("an answer");
        assert!(lit == of_picture.lit, "{demo}");
        assert!(lit.iter().any(|mask| seen_and(&seen, |x, y| mask.is_lit(x, y))), "{demo}");
        assert!(lit.iter().any(|mask| seen_and(&seen, |x, y| !mask.is_lit(x, y))), "{demo}");
        // The last picture is still there.
        assert!(shown(&renderer) == of_picture, "{demo}");
    }
    assert!(misses > 0);
}

/// Whether `is_so` holds for any pixel that shows a triangle.
fn seen_and(seen: &Seen<'_>, is_so: impl Fn(u32, u32) -> bool) -> bool {
    let mut pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))).zip(&seen.triangle);
    pixels.any(|((x, y), &triangle)| triangle != Seen::NO_TRIANGLE && is_so(x, y))
}

#[test]
fn answers_without_a_frame_or_an_image_are_refused() {
    let (mut renderer, camera) = (Renderer::default(), camera());
    let frame = frame();
    let view = View { camera, width: 0, height: 8 };
    assert!(matches!(renderer.see(&frame, &view), Err(Error::ImageSize { width: 0, height: 8 })));
    for (bad, words) in broken_frames() {
        let error = renderer.see(&bad, &View { width: 8, ..view }).expect_err(words);
        assert_eq!(error.to_string(), words);
    }
    let seen = renderer.see(&frame, &View { width: 8, ..view }).expect("an answer");
    let error = renderer.shadow(&seen, &[spot(Vec3::ZERO, 0.3)]).expect_err("a light without a direction");
    assert!(matches!(error, Error::Frame(BadFrame::Light { light: 0, .. })), "{error}");
    if let Some(mut gpu) = common::renderer() {
        assert!(matches!(gpu.see(&frame, &View { width: 8, ..view }), Err(Error::AnswersOnGpu)));
        assert!(matches!(gpu.shadow(&seen, &[]), Err(Error::AnswersOnGpu)));
    }
}

#[test]
fn many_panes_are_seen_through_without_points_which_are_counted() {
    const PANES: u32 = 40;
    const OPACITY: f32 = 0.01;
    let corners = |pane: u32| {
        let z = if pane == 0 { -1.0 } else { pane as f32 * 0.01 };
        [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]].map(|[x, y]| Vec3::new(x, y, z))
    };
    let triangles = (0..=PANES).flat_map(|pane| [[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|of| 4 * pane + of)));
    let mut frame = Frame::from_triangles((0..=PANES).flat_map(corners).collect(), triangles.collect());
    let unlit = |color: Vec4| Material { base_color: color, unlit: true, ..Material::clay() };
    let materials = &mut Arc::make_mut(&mut frame.materials).materials;
    *materials = vec![unlit(Vec4::ONE), Material { alpha: Alpha::Blend, ..unlit(Vec4::W * OPACITY) }];
    let mesh = Arc::make_mut(&mut frame.mesh);
    mesh.material_of_triangle[2..].fill(1);
    mesh.marks.add([0, 1], [[2, 3]], 0);
    let projection = Projection::Orthographic { half_height: 1.0 };
    let camera = Camera { projection, ..Camera::look_at(Vec3::Z * 5.0, Vec3::ZERO, Vec3::Y, 1.0) };
    for bounces in [0, 1] {
        let background = Background::Color(Vec3::ZERO);
        let settings = Settings { camera: camera.into(), width: 8, height: 8, background, bounces, ..settings() };
        let check = |renderer: &mut Renderer, omitted: usize| {
            let seen = renderer.render_frame(&frame, &settings).expect("a frame").color[27].truncate();
            let expected = Vec3::splat((1.0 - OPACITY).powi(PANES as i32));
            assert!(seen.abs_diff_eq(expected, 1e-4), "{seen} rather than {expected} with {bounces} bounces");
            let Stats { marks, omitted_marks, .. } = *renderer.stats();
            assert_eq!([marks, omitted_marks], [3, omitted]);
        };
        check(&mut Renderer::default(), 0);
        if let Some(mut gpu) = common::renderer() {
            check(&mut gpu, 3);
        }
    }
}

#[test]
fn triangles_that_are_nowhere_are_left_out() {
    let mut partly = frame();
    partly.positions[4].y = f32::NAN;
    partly.normals = vec![Vec3::NAN; 7];
    let check = |renderer: &mut Renderer| {
        let settings = Settings { camera: camera().into(), ..settings() };
        let film = renderer.render_frame(&partly, &settings).expect("a frame");
        assert!(!film.triangle.contains(&2) && film.triangle.contains(&0) && film.triangle.contains(&1));
        assert!(film.color.iter().all(|color| color.is_finite()));
        let [omitted] = &renderer.stats().omitted[..] else { panic!("{:?}", renderer.stats().omitted) };
        assert_eq!((omitted.reason, omitted.count, &omitted.first_ids), ("a coordinate is not finite", 1, &vec![2]));
    };
    check(&mut Renderer::default());
    if let Some(mut gpu) = common::renderer() {
        check(&mut gpu);
    }
}

#[test]
fn films_without_first_hits_have_the_same_colors() {
    let check = |renderer: &mut Renderer| {
        let settings = Settings { camera: camera().into(), samples: 2, ..settings() };
        let without = Settings { first_hits: false, ..settings.clone() };
        let whole = renderer.render_frame(&frame(), &settings).expect("a frame").clone();
        let bare = renderer.render_frame(&frame(), &without).expect("a frame");
        assert!(bare.color == whole.color && whole.triangle.contains(&2));
        assert!(bare.triangle.is_empty() && bare.depth.is_empty() && bare.normal.is_empty());
        let again = renderer.render_frame(&frame(), &settings).expect("a frame");
        assert!(again.triangle == whole.triangle && again.depth == whole.depth && again.normal == whole.normal);
    };
    check(&mut Renderer::default());
    if let Some(mut gpu) = common::renderer() {
        check(&mut gpu);
    }
}

#[test]
fn frames_without_cameras_are_framed_as_they_are() {
    let mut renderer = Renderer::default();
    for offset in [Vec3::ZERO, Vec3::new(40.0, -7.0, 3.0)] {
        let mut moved = frame();
        moved.positions.iter_mut().for_each(|position| *position += offset);
        let film = renderer.render_frame(&moved, &settings()).expect("a frame");
        let seen = film.triangle.iter().filter(|&&triangle| triangle != Film::NO_TRIANGLE).count();
        assert!(seen > film.triangle.len() / 8, "{seen} pixels show something");
    }
    // And without triangles, a picture shows its surroundings.
    let film = renderer.render_frame(&Frame::default(), &settings()).expect("a frame");
    assert!(film.triangle.iter().all(|&triangle| triangle == Film::NO_TRIANGLE));
}

/// A square whose diagonal ten rays go through, for each sample on the pixels' own diagonal; and, behind the camera, a
/// triangle whose shadow ends there.
fn diagonal() -> (Frame, Settings) {
    let at = Vec3::new;
    let square = [at(-20.0, 20.0, 0.0), at(20.0, -20.0, 0.0), at(20.0, 20.0, 0.0), at(-20.0, -20.0, 0.0)];
    let behind = [at(-30.0, 30.0, 20.0), at(30.0, -30.0, 20.0), at(30.0, 30.0, 20.0)];
    let mut frame = Frame::from_triangles([&square[..], &behind].concat(), vec![[0, 1, 2], [1, 0, 3], [4, 5, 6]]);
    frame.lights = vec![light(LightSource::Directional { direction: Vec3::NEG_Z })];
    let projection = Projection::Orthographic { half_height: 5.0 };
    let camera = Camera { position: Vec3::Z * 5.0, right: Vec3::X, up: Vec3::Y, forward: Vec3::NEG_Z, projection };
    (frame, Settings { width: 10, height: 10, camera: camera.into(), ..Settings::default() })
}

fn settled(renderer: &mut Renderer, structure: &Structure, samples: u32) -> [Option<Settled>; 2] {
    let (frame, settings) = diagonal();
    renderer.render_frame(&frame, &Settings { samples, structure: structure.clone(), ..settings }).expect("a frame");
    let Stats { settled_camera_rays, settled_shadow_rays, .. } = renderer.stats();
    [*settled_camera_rays, *settled_shadow_rays]
}

#[test]
fn rays_through_edges_are_settled_by_the_predicate() {
    let check = |renderer: &mut Renderer, structure: Structure, knows_rays: bool| {
        let mut settled = |samples| settled(renderer, &structure, samples).map(|settled| settled.expect("counted"));
        let [of_camera, of_light] = settled(1);
        // Camera rays meet both triangles of the square; shadow rays the other one of them and the one behind the camera.
        for settled in [of_camera, of_light] {
            assert!((10..=20).contains(&settled.tests) && settled.of_rays == 100, "{structure:?}: {settled:?}");
        }
        assert_eq!((of_camera.rays, of_light.rays), (knows_rays.then_some(10), None));
        // The first and the last of four samples are on the diagonal.
        let twice = |once: Settled| Settled {
            tests: 2 * once.tests,
            rays: once.rays.map(|rays| 2 * rays),
            of_rays: 4 * once.of_rays,
        };
        assert_eq!(settled(4), [of_camera, of_light].map(twice));
        assert_eq!(settled(1), [of_camera, of_light]);
    };
    for structure in [Structure::default(), Structure::of::<Listed>()] {
        check(&mut Renderer::default(), structure, false);
    }
    if let Some(mut gpu) = common::renderer() {
        check(&mut gpu, Structure::default(), true);
    }
    for structure in [Structure::of::<Uniform>(), Structure::of::<KdTrees>(), Structure::bvh()] {
        assert_eq!(settled(&mut Renderer::default(), &structure, 1), [None, None], "{structure:?}");
    }
}
