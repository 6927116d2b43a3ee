//! Layers compared with brute force, without structures, blocks of pixels and masks.

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec2, Vec3};
use umbrage_rays::{Camera, Hit, LightSource, Projection, Ray, View, predicate};
use umbrage_scene::{Animated, Error, Frame, Light, NamedCamera, Objects, Scene};

use crate::{Film, Layer, Layers, Renderer, Sample, Settings};

const FPS: f64 = 24.0;

/// A floor, and a triangle over it that flies and turns, before a camera that moves as well.
#[derive(Debug)]
struct Flight;

/// The flying triangle's corners, and the camera, at a moment.
fn flying(seconds: f64) -> ([Vec3; 3], Camera) {
    let t = seconds as f32;
    let corner = |x: f32, y: f32, z: f32| Vec3::new(x + 0.9 * t, y + 0.4 * t * x, z - 0.5 * t);
    let eye = Vec3::new(0.3 + 0.2 * t, 2.5, 5.0 - 0.3 * t);
    let camera = Camera::look_at(eye, Vec3::new(0.1, 0.3, 0.0), Vec3::Y, 0.8);
    ([corner(-0.9, 0.8, 0.3), corner(0.8, 0.7, 0.5), corner(0.1, 1.4, -0.4)], camera)
}

fn lamp(name: &str, source: LightSource) -> Light {
    Light { name: name.into(), ..Light::new(source, 30.0) }
}

impl Animated for Flight {
    fn duration_seconds(&self) -> f64 {
        1.0
    }

    fn pose(&self, seconds: f64, frame: &mut Frame) -> Result<(), Error> {
        let (flying, camera) = flying(seconds);
        let floor = [[-2.1, 0.0, -2.0], [2.0, 0.0, -2.0], [2.0, 0.0, 2.2], [-2.0, 0.0, 2.0]].map(Vec3::from);
        let positions = flying.into_iter().chain(floor).collect();
        let mut made = Frame::from_triangles(positions, vec![[0, 1, 2], [3, 5, 4], [3, 6, 5]]);
        let mut objects = Objects::default();
        objects.begin(0, "kite");
        objects.begin(1, "floor");
        Arc::make_mut(&mut made.mesh).objects = objects;
        frame.copy_surfaces(&made);
        frame.cameras.push(NamedCamera { name: "eye".into(), camera });
        frame.lights.push(lamp("above", LightSource::Point { position: Vec3::new(0.4, 3.0, 1.0) }));
        frame.lights.push(lamp("sun", LightSource::Directional { direction: Vec3::new(-0.6, -1.0, -0.2) }));
        // Under the floor, whose upper side the camera sees.
        frame.lights.push(lamp("below", LightSource::Point { position: Vec3::new(0.2, -1.5, 0.3) }));
        Ok(())
    }
}

fn settings(samples: u32) -> Settings {
    // Sides that no block divides.
    let (layers, motion_seconds) = (Layers::all(), 1.0 / FPS);
    let sides = crate::Sides::Both;
    Settings { width: 61, height: 43, samples, layers, motion_seconds, sides, ..Settings::default() }
}

fn nearest(frame: &Frame, ray: &Ray) -> Option<Hit> {
    let hits = (0..frame.mesh.triangles.len() as u32).filter_map(|id| predicate::hit(ray, frame.triangles(), id));
    hits.min_by(|a, b| a.t.total_cmp(&b.t))
}

/// Whether a light reaches a hit, on the side from which the ray comes.
fn is_lit(frame: &Frame, light: &Light, ray: &Ray, hit: &Hit) -> bool {
    let point = ray.origin + ray.direction * hit.t;
    // From the point towards the light, which is at t = 1 or endlessly far.
    let (towards, end) = match light.source {
        LightSource::Directional { direction } => (-direction.as_dvec3(), f64::INFINITY),
        LightSource::Point { position } | LightSource::Spot { position, .. } => (position.as_dvec3() - point, 1.0),
    };
    let [a, b, c] = frame.triangles().corners(hit.triangle).map(Vec3::as_dvec3);
    let normal = (b - a).cross(c - a);
    let others = (0..frame.mesh.triangles.len() as u32).filter(|&other| other != hit.triangle);
    let shadow_ray = Ray::new(point, towards);
    let is_blocked = others
        .filter_map(|other| predicate::hit(&shadow_ray, frame.triangles(), other))
        .any(|blocker| 1e-9 < blocker.t && blocker.t < end);
    !is_blocked && normal.dot(towards).signum() == normal.dot(-ray.direction).signum()
}

fn pixels(film: &Film) -> impl Iterator<Item = (usize, u32, u32)> {
    let width = film.width;
    (0..width * film.height).map(move |pixel| (pixel as usize, pixel % width, pixel / width))
}

#[test]
fn lights_are_where_nothing_is_between() {
    let scene = Scene::new(Box::new(Flight)).unwrap();
    for (samples, moment) in [(1, 0.0), (3, 0.2), (4, 0.5), (8, 0.7)] {
        let settings = settings(samples);
        let mut renderer = Renderer::default();
        let film = renderer.render(&scene, moment, &settings).unwrap();
        let frame = scene.at(moment).unwrap();
        let view = settings.view(&frame).unwrap();
        assert_eq!(film.view, Some(view));
        assert_eq!(film.layers.shadow.iter().map(|layer| &*layer.name).collect::<Vec<_>>(), ["above", "sun", "below"]);
        let mut shades = [0; 3];
        for (light, layer) in frame.lights.iter().zip(&film.layers.shadow) {
            for (pixel, x, y) in pixels(film) {
                let rays = Sample::all(samples).map(|sample| sample.ray(&view, x, y));
                let lit = rays.filter(|ray| nearest(&frame, ray).is_some_and(|hit| is_lit(&frame, light, ray, &hit)));
                let expected = lit.count() as f32 / samples as f32;
                let found = layer.lit[pixel];
                assert!((found - expected).abs() < 1e-6, "{}: {found}, not {expected}, at {x}, {y}", light.name);
                shades[if found == 0.0 { 0 } else { 1 + usize::from(found < 1.0) }] += 1;
            }
        }
        assert!(shades[0] > 100 && shades[1] > 100 && (samples == 1 || shades[2] > 50), "{shades:?}");
        let below = &film.layers.shadow[2].lit;
        assert!(pixels(film).all(|(pixel, ..)| film.triangle[pixel] == 0 || below[pixel] < 1.0), "only the kite");
    }
}

#[test]
fn motion_is_what_lies_between_two_images() {
    /// A pixel's point, in an image without any of the renderer's code.
    fn pixel_of(view: &View, point: DVec3) -> DVec2 {
        let Projection::Perspective { tan_half_height } = view.camera.projection else {
            panic!("a perspective camera")
        };
        let offset = point - view.camera.position.as_dvec3();
        let [right, up, forward] = [view.camera.right, view.camera.up, view.camera.forward].map(Vec3::as_dvec3);
        let scale = 0.5 * f64::from(view.height) / (f64::from(tan_half_height) * offset.dot(forward));
        let middle = 0.5 * DVec2::new(view.width.into(), view.height.into());
        middle + DVec2::new(offset.dot(right), -offset.dot(up)) * scale
    }
    let scene = Scene::new(Box::new(Flight)).unwrap();
    let mut renderer = Renderer::default();
    for (samples, moment, later) in [(1, 0.1, 0.1 + 1.0 / FPS), (4, 0.5, 0.5 + 1.0 / FPS), (1, 0.99, 1.0)] {
        let settings = settings(samples);
        let film = renderer.render(&scene, moment, &settings).unwrap();
        let (frame, next) = (scene.at(moment).unwrap(), scene.at(later).unwrap());
        let [view, next_view] = [&frame, &next].map(|frame| settings.view(frame).unwrap());
        let sample = Sample::all(samples).next().unwrap();
        let mut moved = [0; 2];
        for (pixel, x, y) in pixels(film) {
            let motion = film.layers.motion[pixel];
            let Some(hit) = nearest(&frame, &sample.ray(&view, x, y)) else {
                assert_eq!(motion, Vec2::ZERO);
                continue;
            };
            let from = DVec2::new(x.into(), y.into()) + sample.offset_pixels;
            let [second, third] = hit.barycentric.map(f64::from);
            let [a, b, c] = next.triangles().corners(hit.triangle).map(Vec3::as_dvec3);
            let to = pixel_of(&next_view, a * (1.0 - second - third) + b * second + c * third);
            assert!((to - from).abs_diff_eq(motion.as_dvec2(), 1e-3), "{motion}, not {} at {x}, {y}", to - from);
            moved[usize::from(hit.triangle == 0)] += usize::from(motion.length() > 0.005);
        }
        assert!(moved.iter().all(|&count| count > 50), "{moved:?}: the camera moves the floor, too");
    }
}

#[test]
fn barycentrics_are_those_of_first_samples() {
    let scene = Scene::new(Box::new(Flight)).unwrap();
    for samples in [1, 4] {
        let settings = settings(samples);
        let mut renderer = Renderer::default();
        let film = renderer.render(&scene, 0.4, &settings).unwrap();
        let frame = scene.at(0.4).unwrap();
        let view = settings.view(&frame).unwrap();
        let sample = Sample::all(samples).next().unwrap();
        for (pixel, x, y) in pixels(film) {
            let expected = nearest(&frame, &sample.ray(&view, x, y)).map_or([0.0; 2], |hit| hit.barycentric);
            assert_eq!(film.layers.barycentric[pixel].to_array(), expected, "at {x}, {y}");
        }
    }
}

#[test]
fn objects_cover_what_their_samples_see() {
    let scene = Scene::new(Box::new(Flight)).unwrap();
    for samples in [1, 3, 16] {
        let settings = settings(samples);
        let mut renderer = Renderer::default();
        let film = renderer.render(&scene, 0.4, &settings).unwrap();
        let frame = scene.at(0.4).unwrap();
        let view = settings.view(&frame).unwrap();
        let layers = &film.layers;
        assert_eq!(layers.objects.iter().map(|name| &**name).collect::<Vec<_>>(), ["kite", "floor"]);
        let mut shared = 0;
        for (pixel, x, y) in pixels(film) {
            let mut counts = [0.0_f32; 2];
            let mut first = None;
            for sample in Sample::all(samples) {
                let object = nearest(&frame, &sample.ray(&view, x, y)).map(|hit| hit.triangle.min(1));
                object.into_iter().for_each(|object| counts[object as usize] += 1.0 / samples as f32);
                if sample.index == 0 {
                    first = object;
                }
            }
            assert_eq!(layers.object[pixel], first.unwrap_or(u32::MAX));
            let ranks = layers.coverage.pixels()[pixel];
            for (object, &expected) in counts.iter().enumerate() {
                let of_object = ranks.iter().filter(|covered| covered.object == object as u32);
                let found: f32 = of_object.map(|covered| covered.part).sum();
                assert!((found - expected).abs() < 1e-5, "{found}, not {expected}, of {object} at {x}, {y}");
            }
            assert!(ranks.is_sorted_by(|a, b| a.part >= b.part));
            shared += u32::from(counts.iter().all(|&part| part > 0.0));
        }
        assert!(samples == 1 || shared > 8, "{shared}");
    }
}

#[test]
fn what_nobody_asks_for_is_empty_and_changes_nothing() {
    let scene = Scene::new(Box::new(Flight)).unwrap();
    let mut renderer = Renderer::default();
    let plain = Settings { layers: Layers::NONE, ..settings(4) };
    let expected = renderer.render(&scene, 0.4, &plain).unwrap().clone();
    let with_layers = renderer.render(&scene, 0.4, &settings(4)).unwrap().clone();
    assert_eq!((&with_layers.color, &with_layers.depth), (&expected.color, &expected.depth));
    assert!(!with_layers.layers.motion.is_empty());
    for layer in [Layer::Shadow, Layer::Motion, Layer::Barycentric, Layer::Ids, Layer::Cryptomatte] {
        let settings = Settings { layers: layer.into(), ..settings(4) };
        let layers = &renderer.render(&scene, 0.4, &settings).unwrap().layers;
        let is_there = [
            (Layer::Shadow, !layers.shadow.is_empty()),
            (Layer::Motion, !layers.motion.is_empty()),
            (Layer::Barycentric, !layers.barycentric.is_empty()),
            (Layer::Ids, !layers.object.is_empty()),
            (Layer::Cryptomatte, !layers.coverage.pixels().is_empty()),
        ];
        assert!(is_there.iter().all(|&(of, is_there)| is_there == (of == layer)), "{layer}: {is_there:?}");
    }
    let layers = &renderer.render(&scene, 0.4, &plain).unwrap().layers;
    assert!(layers.shadow.is_empty() && layers.motion.is_empty() && layers.objects.is_empty());
    let frame = scene.at(0.4).unwrap();
    let refused = renderer.render_frame(&frame, &settings(4)).unwrap_err();
    assert!(matches!(refused, crate::Error::MotionOfFrame) && refused.is_of_settings());
}
