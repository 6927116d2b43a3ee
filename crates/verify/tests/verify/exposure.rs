//! A lens, an open shutter and lights with a size, against formulas.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};
use umbrage::rays::{Camera, LightSource, Projection};
use umbrage::scene::{Animated, Frame, Light, LightShape, Material, Materials, Mesh, Scene, check_lights};
use umbrage::{Background, Error, Film, Renderer, Settings, Structure};
use umbrage_papers::structures;

/// A rectangle in the plane z = `z`, white without any light.
fn white(least: Vec2, most: Vec2, z: f32) -> Frame {
    frame(&[[least.extend(z), Vec3::new(most.x, least.y, z), most.extend(z), Vec3::new(least.x, most.y, z)]], true)
}

fn frame(quads: &[[Vec3; 4]], unlit: bool) -> Frame {
    let first = (0..).step_by(4).take(quads.len());
    let triangles: Vec<[u32; 3]> = first.flat_map(|i| [[i, i + 1, i + 2], [i, i + 2, i + 3]]).collect();
    let material =
        Material { base_color: Vec3::ONE.extend(1.0), roughness: 1.0, unlit, double_sided: true, ..Material::clay() };
    let mesh = Mesh { material_of_triangle: vec![0; triangles.len()], triangles, ..Mesh::default() };
    let materials = Materials { materials: vec![material], textures: Vec::new() };
    let positions = quads.concat();
    Frame { positions, mesh: Arc::new(mesh), materials: Arc::new(materials), ..Frame::default() }
}

/// A camera at z = 0 that looks along −z, on a black background: a hundred pixels for each unit of x/z.
fn settings(samples: u32) -> Settings {
    let camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 2.0 * 0.04_f32.atan());
    let background = Background::Color(Vec3::ZERO);
    Settings { width: 300, height: 8, samples, camera: camera.into(), background, ..Settings::default() }
}

fn render(frame: &Frame, settings: &Settings) -> Film {
    Renderer::default().render_frame(frame, settings).expect("a picture").clone()
}

/// The fraction of a uniform unit disk that is left of x.
fn left_of(x: f32) -> f32 {
    let x = x.clamp(-1.0, 1.0);
    0.5 + (x * (1.0 - x * x).sqrt() + x.asin()) / PI
}

/// Compares a row of values between 0 and 1 with an edge blurred by a disk of `radius` pixels.
fn expect_disk(values: &[f32], edge: f32, radius: f32, name: &str) {
    let mut largest = 0.0_f32;
    for (column, &value) in values.iter().enumerate() {
        let expected = left_of((edge - (column as f32 + 0.5)) / radius);
        largest = largest.max((value - expected).abs());
    }
    let partly: Vec<usize> = (0..values.len()).filter(|&x| values[x] > 2e-3 && values[x] < 0.998).collect();
    let width = partly.last().zip(partly.first()).map_or(0, |(last, first)| last - first + 1) as f32;
    println!("{name}: {width} pixels of {}, off by {largest} at most", 2.0 * radius);
    assert!(largest < 0.02, "{name}: off by {largest}");
    assert!(width <= 2.0 * radius + 1.5 && width > 1.7 * radius, "{name}: {width} pixels of {}", 2.0 * radius);
}

fn row(film: &Film) -> Vec<f32> {
    let first = (film.height / 2 * film.width) as usize;
    film.color[first..first + film.width as usize].iter().map(|color| color.x).collect()
}

#[test]
fn the_circle_of_confusion_is_that_of_the_formula() {
    for (aperture, focus, depth) in [(0.5, 2.0, 6.0), (0.8, 5.0, 2.5), (0.3, 40.0, 1.0)] {
        let half = white(Vec2::new(-1e3, -1e3), Vec2::new(0.0, 1e3), -depth);
        let settings = Settings { aperture, focus: Some(focus), ..settings(1024) };
        let film = render(&half, &settings);
        let pixels_per_slope = 100.0;
        let radius = 0.5 * aperture * (depth - focus).abs() / (depth * focus) * pixels_per_slope;
        expect_disk(&row(&film), 150.0, radius, &format!("a lens of {aperture} with focus {focus} at {depth}"));
    }
}

#[test]
fn what_is_in_focus_is_sharp() {
    let square = white(Vec2::new(-0.5, -0.5), Vec2::new(0.497, 0.511), -3.0);
    let sharp = settings(64);
    let expected = render(&square, &sharp);
    // Without a number, the focus is on the point in the middle of the image.
    for focus in [Some(3.0), None] {
        let film = render(&square, &Settings { aperture: 1.5, focus, ..sharp.clone() });
        assert!(film.color == expected.color, "{focus:?}");
    }
    let blurred = render(&square, &Settings { aperture: 1.5, focus: Some(2.5), ..sharp.clone() });
    assert!(blurred.color != expected.color);
}

/// Light on a floor at y = 0, with a roof above the half left of x = 0, at a height of one; seen from below the roof.
fn under_a_roof(source: LightSource, shape: LightShape, settings: &Settings) -> Vec<f32> {
    let flat = |least: Vec2, most: Vec2, y: f32| {
        [[least.x, least.y], [most.x, least.y], [most.x, most.y], [least.x, most.y]].map(|[x, z]| Vec3::new(x, y, z))
    };
    let floor = flat(Vec2::splat(-50.0), Vec2::splat(50.0), 0.0);
    let roof = flat(Vec2::splat(-50.0), Vec2::new(0.0, 50.0), 1.0);
    let camera = Camera {
        position: Vec3::Y * 0.5,
        projection: Projection::Orthographic { half_height: 0.08 },
        ..Camera::look_at(Vec3::Y, Vec3::ZERO, Vec3::Z, 1.0)
    };
    // The image's right is to the left of this camera, which looks down.
    let camera = Camera { right: Vec3::NEG_X, up: Vec3::Z, forward: Vec3::NEG_Y, ..camera };
    let settings = Settings { height: 16, camera: camera.into(), ..settings.clone() };
    let rows = [false, true].map(|has_roof| {
        let quads = if has_roof { vec![floor, roof] } else { vec![floor] };
        let mut frame = frame(&quads, false);
        frame.lights = vec![Light { shape, ..Light::new(source, 5.0) }];
        row(&render(&frame, &settings))
    });
    rows[0].iter().zip(&rows[1]).map(|(open, roofed)| roofed / open).collect()
}

#[test]
fn large_lamps_are_as_bright_as_points() {
    let floor =
        [Vec3::new(-9.0, 0.0, -9.0), Vec3::new(-9.0, 0.0, 9.0), Vec3::new(9.0, 0.0, 9.0), Vec3::new(9.0, 0.0, -9.0)];
    let mut frame = frame(&[floor], false);
    let light = Light::new(LightSource::Point { position: Vec3::new(0.3, 2.0, 0.2) }, 3.0);
    let camera = Camera::look_at(Vec3::new(0.0, 4.0, 6.0), Vec3::ZERO, Vec3::Y, 0.7);
    let settings = Settings { width: 40, height: 30, camera: camera.into(), ..settings(1024) };
    let [small, large] = [0.0, 1.0].map(|radius| {
        frame.lights = vec![Light { shape: LightShape::Ball(radius), ..light.clone() }];
        render(&frame, &settings)
    });
    for (small, large) in small.color.iter().zip(&large.color).filter(|(small, _)| small.w == 1.0) {
        // The floor isn't perfectly diffuse: its specular reflection differs.
        assert!((large.x / small.x - 1.0).abs() < 0.03, "{large} for {small}");
    }
}

/// Lambert's formula: the irradiance at `point` of a floor below all corners of a polygon of radiance one that faces it.
fn lamberts_irradiance(point: DVec3, corners: &[DVec3]) -> f64 {
    let towards: Vec<DVec3> = corners.iter().map(|corner| (corner - point).normalize()).collect();
    let edges = towards.iter().zip(towards.iter().cycle().skip(1));
    let sum: f64 = edges.map(|(one, other)| one.angle_between(*other) * one.cross(*other).normalize().y).sum();
    0.5 * sum.abs()
}

#[test]
fn flat_lamps_are_as_bright_as_lamberts_formula_says() {
    let floor = [-9.0, 9.0].map(|x| Vec3::new(x, 0.0, 0.0));
    let along = Vec3::Z * 9.0;
    let mut frame = frame(&[[floor[0] - along, floor[0] + along, floor[1] + along, floor[1] - along]], false);
    // Without specular reflection it looks the same from everywhere.
    Arc::make_mut(&mut frame.materials).materials[0].ior = 1.0;
    let camera = Camera {
        position: Vec3::Y,
        right: Vec3::X,
        up: Vec3::NEG_Z,
        forward: Vec3::NEG_Y,
        projection: Projection::Orthographic { half_height: 3.0 },
    };
    let settings = Settings { width: 40, height: 30, camera: camera.into(), ..settings(1024) };
    let position = Vec3::new(0.3, 2.0, 0.2);
    for (direction, shape) in [
        (Vec3::NEG_Y, LightShape::Rectangle { width: 2.0, height: 1.0 }),
        (Vec3::new(0.6, -0.8, 0.0), LightShape::Rectangle { width: 2.0, height: 1.0 }),
        (Vec3::new(0.0, -0.8, 0.6), LightShape::Rectangle { width: 0.0, height: 0.0 }),
        (Vec3::new(0.6, -0.8, 0.0), LightShape::Disk(0.8)),
    ] {
        let light = Light { shape, ..Light::new(LightSource::to_one_side(position, direction), 3.0) };
        frame.lights = vec![light];
        let film = render(&frame, &settings);
        let middle = position.as_dvec3();
        // The width is level, along x if the light faces straight down.
        let across = if direction == Vec3::NEG_Y { DVec3::X } else { direction.cross(Vec3::Y).normalize().as_dvec3() };
        let up = across.cross(direction.as_dvec3());
        let corner = |x: f64, y: f64| middle + across * x + up * y;
        let (corners, area): (Vec<_>, f64) = match shape {
            LightShape::Rectangle { width, height } => {
                // A point is as bright as a small rectangle.
                let (x, y) = (0.5 * f64::from(width.max(1e-2)), 0.5 * f64::from(height.max(1e-2)));
                (vec![corner(-x, -y), corner(x, -y), corner(x, y), corner(-x, y)], 4.0 * x * y)
            }
            LightShape::Disk(radius) | LightShape::Ball(radius) => {
                let radius = f64::from(radius);
                let angles = (0..256).map(|i| f64::from(i) / 256.0 * std::f64::consts::TAU);
                let corners = angles.map(|a| corner(radius * a.cos(), radius * a.sin())).collect();
                (corners, std::f64::consts::PI * radius * radius)
            }
        };
        let (mut largest, mut dark) = (0.0_f64, 0);
        for (pixel, color) in (0..40 * 30).zip(&film.color) {
            let (x, z) = (f64::from(pixel % 40) + 0.5, f64::from(pixel / 40) + 0.5);
            let point = DVec3::new((x - 20.0) * 0.2, 0.0, (z - 15.0) * 0.2);
            let in_front = corners.iter().filter(|corner| (point - **corner).dot(direction.as_dvec3()) > 0.05).count();
            let expected = lamberts_irradiance(point, &corners) * 3.0 / area / std::f64::consts::PI;
            if in_front == corners.len() {
                largest = largest.max((f64::from(color.x) - expected).abs() / expected.max(0.01));
            } else if corners.iter().all(|corner| (point - *corner).dot(direction.as_dvec3()) < -0.2) {
                assert_eq!(color.truncate(), Vec3::ZERO, "behind {shape:?} at {point}");
                dark += 1;
            }
        }
        println!("{shape:?} that faces {direction}: off by {largest} at most, {dark} pixels are behind it");
        assert!(
            largest < 0.01 && (dark > 10) == (direction.x > 0.0 || direction.z > 0.0),
            "{shape:?}: {largest}, {dark}"
        );
    }
}

/// A white square that is `WIDTH` wide and moves along x.
#[derive(Debug)]
struct Moving;

impl Moving {
    const WIDTH: f32 = 0.2;
    const SPEED: f64 = 2.0;
}

impl Animated for Moving {
    fn duration_seconds(&self) -> f64 {
        1.0
    }

    fn pose(&self, seconds: f64, frame: &mut Frame) -> Result<(), umbrage::scene::Error> {
        let x = (Self::SPEED * (seconds - 0.5)) as f32;
        let Frame { positions, mesh, materials, .. } = white(Vec2::new(x, -1.0), Vec2::new(x + Self::WIDTH, 1.0), -1.0);
        (frame.positions, frame.mesh, frame.materials) = (positions, mesh, materials);
        Ok(())
    }
}

fn of_moving(seconds: f64, settings: &Settings) -> Vec<f32> {
    let scene = Scene::new(Box::new(Moving)).expect("a scene");
    row(Renderer::default().render(&scene, seconds, settings).expect("a picture"))
}

#[test]
fn streaks_are_as_long_as_the_way() {
    let shutter_seconds = 0.4;
    let settings = Settings { shutter_seconds, ..settings(1024) };
    let row = of_moving(0.5, &settings);
    // 100 pixels a unit: the square, 20 wide, moves by 80 pixels, half of them before the middle of the exposure.
    let way = (100.0 * Moving::SPEED * shutter_seconds) as f32;
    let width = 100.0 * Moving::WIDTH;
    for (column, value) in row.iter().enumerate() {
        let x = column as f32 + 0.5 - 150.0;
        let passed = (x + 0.5 * way).min(0.5 * way + width - x).clamp(0.0, width);
        assert!((value - passed / way).abs() < 0.02, "{value} for {} at {x}", passed / way);
    }
    let shown = row.iter().filter(|value| **value > 0.0).count() as f32;
    assert!((shown - (way + width)).abs() <= 1.0, "{shown} pixels");
    // At the animation's start it stands still for the half of the exposure before that, and isn't at its end position.
    let row = of_moving(0.0, &settings);
    let at_start = &row[50..70];
    assert!(at_start.iter().all(|value| *value > 0.5), "{at_start:?}");
    assert!(row[150..].iter().all(|value| *value == 0.0));
}

/// Settings with all effects at once.
fn everything(samples: u32) -> Settings {
    let structure = Structure::default();
    Settings {
        width: 70,
        height: 50,
        samples,
        structure,
        aperture: 0.2,
        shutter_seconds: 0.1,
        light_radius: 0.4,
        ..Settings::default()
    }
}

#[test]
fn pictures_are_the_same_on_any_number_of_threads_and_through_every_structure() {
    let scene = umbrage::open("demo:cloth?triangles=2000").expect("a scene of the gallery");
    let render =
        |settings: &Settings| Renderer::default().render(&scene, 1.0, settings).expect("a picture").color.clone();
    let expected = render(&everything(6));
    assert!(expected != render(&everything(1)));
    for threads in [1, 2, 3, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        assert!(pool.install(|| render(&everything(6))) == expected, "{threads} threads");
    }
    for structure in structures().iter() {
        assert!(render(&Settings { structure: structure.clone(), ..everything(6) }) == expected, "{structure:?}");
    }
}

#[test]
fn a_single_sample_has_everything_sharp() {
    let scene = umbrage::open("demo:cloth?triangles=2000").expect("a scene of the gallery");
    let mut renderer = Renderer::default();
    let settings = everything(1);
    let expected = Settings { aperture: 0.0, shutter_seconds: 0.0, light_radius: 0.0, ..settings.clone() };
    let expected = renderer.render(&scene, 1.0, &expected).expect("a picture").color.clone();
    assert!(renderer.render(&scene, 1.0, &settings).expect("a picture").color == expected);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let square = white(Vec2::splat(-1.0), Vec2::splat(1.0), -3.0);
    let refused = |settings: Settings| {
        let error = Renderer::default().render_frame(&square, &settings).expect_err("refused");
        assert!(error.is_of_settings(), "{error}");
        error
    };
    for number in [-1.0, f32::NAN, f32::INFINITY] {
        assert!(matches!(refused(Settings { aperture: number, ..settings(2) }), Error::NotFromZero(_)));
        assert!(matches!(refused(Settings { light_radius: number, ..settings(2) }), Error::NotFromZero(_)));
        assert!(matches!(refused(Settings { shutter_seconds: number.into(), ..settings(2) }), Error::NotFromZero(_)));
        assert!(matches!(refused(Settings { focus: Some(number), ..settings(2) }), Error::Focus));
    }
    assert!(matches!(refused(Settings { shutter_seconds: 0.1, ..settings(2) }), Error::ShutterOfFrame));
    let panel = |width| LightShape::Rectangle { width, height: 1.0 };
    let to_one_side = LightSource::to_one_side(Vec3::ZERO, Vec3::NEG_Z);
    let everywhere = LightSource::Point { position: Vec3::ZERO };
    let sun = LightSource::Directional { direction: Vec3::NEG_Z };
    for (source, shape, why) in [
        (to_one_side, panel(-1.0), "width or height"),
        (to_one_side, panel(f32::NAN), "width or height"),
        (to_one_side, LightShape::Disk(f32::INFINITY), "radius"),
        (everywhere, LightShape::Ball(-1.0), "radius"),
        (everywhere, panel(1.0), "one side"),
        (sun, LightShape::Disk(1.0), "one side"),
        (sun, LightShape::Ball(46.0), "45 degrees"),
    ] {
        let error = check_lights(&[Light { shape, ..Light::new(source, 1.0) }]).expect_err("refused").to_string();
        assert!(error.contains(why), "{error}");
    }
    assert_eq!(check_lights(&[Light { shape: panel(0.0), ..Light::new(to_one_side, 1.0) }]), Ok(()));
    let behind = Camera::look_at(Vec3::NEG_Z * 4.0, Vec3::NEG_Z * 9.0, Vec3::Y, 1.0);
    let wide = Settings { aperture: 0.1, ..settings(2) };
    assert!(matches!(refused(Settings { camera: behind.into(), ..wide.clone() }), Error::NoFocus));
    let parallel = Camera { projection: Projection::Orthographic { half_height: 1.0 }, ..behind };
    assert!(matches!(refused(Settings { camera: parallel.into(), ..wide }), Error::ParallelLens));
}

/// Tests that take long, which `cargo run -p ci` runs with `--all` alone.
mod long {
    use super::*;

    #[test]
    fn penumbras_are_as_wide_as_the_formula_says() {
        let settings = settings(1024);
        // 16 rows are 0.16 units.
        let pixels_per_unit = 100.0;
        let lamp = LightSource::Point { position: Vec3::new(0.0, 6.0, 0.0) };
        let lit = under_a_roof(lamp, LightShape::Ball(0.75), &settings);
        // The edge is 5 below the light and 1 above the floor.
        expect_disk(&lit, 150.0, 0.75 / 5.0 * pixels_per_unit, "a lamp");
        let sun = LightSource::Directional { direction: Vec3::NEG_Y };
        for degrees in [2.0_f32, 15.0, 25.0] {
            let lit = under_a_roof(sun, LightShape::Ball(degrees), &settings);
            expect_disk(
                &lit,
                150.0,
                degrees.to_radians().tan() * pixels_per_unit,
                &format!("a sun of {degrees} degrees"),
            );
        }
        // A panel's edge is a ramp as wide as the panel.
        let panel = LightShape::Rectangle { width: 1.5, height: 0.5 };
        let source = LightSource::to_one_side(Vec3::new(0.0, 6.0, 0.0), Vec3::NEG_Y);
        for (column, lit) in under_a_roof(source, panel, &settings).into_iter().enumerate() {
            let expected = ((150.0 - (column as f32 + 0.5)) / (1.5 / 5.0 * pixels_per_unit) + 0.5).clamp(0.0, 1.0);
            assert!((lit - expected).abs() < 0.02, "{column}: {lit} for {expected}");
        }
        // A common radius for all lights gives the same.
        let of_all = under_a_roof(lamp, LightShape::POINT, &Settings { light_radius: 0.75, ..settings.clone() });
        assert!(of_all == under_a_roof(lamp, LightShape::Ball(0.75), &settings));
    }

    #[test]
    fn pictures_are_done_where_they_are_even_enough() {
        let scene = umbrage::open("demo:hall?triangles=3000").expect("a scene of the gallery");
        let most = Settings { width: 64, height: 48, samples: 512, light_radius: 1.0, ..Settings::default() };
        let mut renderer = Renderer::default();
        let mut shown = |settings: &Settings| {
            let image = renderer.render(&scene, 0.3, settings).expect("a picture").develop(settings);
            (image, renderer.stats().samples)
        };
        let (reference, samples) = shown(&Settings { samples: 2048, ..most.clone() });
        assert_eq!(samples, 2048);
        let mut last = 0;
        for noise in [8.0, 4.0] {
            let (image, samples) = shown(&Settings { noise, ..most.clone() });
            let levels = |pixels: &[[u16; 3]]| pixels.iter().flatten().map(|&level| f64::from(level) / 257.0).collect();
            let [image, reference]: [Vec<f64>; 2] = [levels(&image.pixels), levels(&reference.pixels)];
            let squares = image.iter().zip(&reference).map(|(a, b)| (a - b) * (a - b));
            let error = (squares.sum::<f64>() / image.len() as f64).sqrt();
            println!("noise of {noise}: {samples} samples, off by {error}");
            assert!(error < 1.3 * f64::from(noise), "off by {error} after {samples} samples");
            assert!(samples > last && samples < 512, "{samples} samples for {noise}");
            last = samples;
        }
    }
}
