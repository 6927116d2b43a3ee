//! The terminator on round surfaces made of triangles.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use glam::{Vec3, Vec4};
use umbrage::rays::{Camera, LightSource};
use umbrage::scene::{Frame, Light, Material, Materials};
use umbrage::{Background, Film, Renderer, Seen, Settings};

const SMOOTH: bool = true;
const FACETS: bool = false;

/// The ball's corners and triangles: one corner at a pole twice, which makes some that no ray can hit.
const RINGS: u32 = 6;
const COLUMNS: u32 = 10;

/// A ball with the normals of a sphere above a floor of two triangles, and behind it another square of some material.
fn scene(behind: Option<Material>) -> Frame {
    let of_ball = |ring: u32, column: u32| {
        let (polar, around) = (PI * ring as f32 / RINGS as f32, TAU * column as f32 / COLUMNS as f32);
        Vec3::new(polar.sin() * around.cos(), polar.cos(), polar.sin() * around.sin())
    };
    let rings = (0..=RINGS).flat_map(|ring| (0..COLUMNS).map(move |column| of_ball(ring, column)));
    let (mut positions, mut triangles): (Vec<Vec3>, Vec<[u32; 3]>) = (rings.collect(), Vec::new());
    let mut normals = positions.clone();
    for (ring, column) in (0..RINGS).flat_map(|ring| (0..COLUMNS).map(move |column| (ring, column))) {
        let at = |ring: u32, column: u32| ring * COLUMNS + column % COLUMNS;
        let [a, b] = [0, 1].map(|further| at(ring, column + further));
        let [c, d] = [0, 1].map(|further| at(ring + 1, column + further));
        triangles.extend([[a, b, d], [a, d, c]]);
    }
    let mut square = |middle: Vec3, x: Vec3, y: Vec3| {
        let first = positions.len() as u32;
        positions.extend([-x - y, x - y, x + y, y - x].map(|corner| middle + corner * 6.0));
        normals.extend([x.cross(y); 4]);
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    };
    square(Vec3::NEG_Y * 1.2, Vec3::Z, Vec3::X);
    if behind.is_some() {
        square(Vec3::NEG_Z * 3.0, Vec3::X, Vec3::Y);
    }
    let mut frame = Frame::from_triangles(positions, triangles);
    frame.normals = normals;
    let mesh = Arc::make_mut(&mut frame.mesh);
    if behind.is_some() {
        mesh.material_of_triangle.iter_mut().rev().take(2).for_each(|material| *material = 1);
    }
    let clay = Material::clay();
    let behind = behind.unwrap_or_else(|| clay.clone());
    frame.materials = Arc::new(Materials { materials: vec![clay, behind], textures: Vec::new() });
    frame.lights =
        vec![Light { name: "sun".into(), ..Light::new(LightSource::Directional { direction: -towards_sun() }, 3.0) }];
    frame
}

fn towards_sun() -> Vec3 {
    Vec3::new(1.0, 0.5, 0.4).normalize()
}

fn settings(eye: Vec3, smooth_terminator: bool) -> Settings {
    let camera = Camera::look_at(eye, Vec3::ZERO, Vec3::Y, 0.5).into();
    let background = Background::Color(Vec3::ZERO);
    Settings { width: 96, height: 96, camera, background, smooth_terminator, ..Settings::default() }
}

fn render(frame: &Frame, settings: &Settings) -> Film {
    Renderer::default().render_frame(frame, settings).expect("a picture").clone()
}

/// Numbers of the ball's pixels that are lit although their normals face away from the sun, and dark although they face it.
fn wrong_pixels(frame: &Frame, settings: &Settings) -> [usize; 2] {
    const MARGIN: f32 = 0.06;
    let film = render(frame, settings);
    let mut renderer = Renderer::default();
    let seen = renderer.see(frame, &settings.view(frame).expect("a camera")).expect("a small image");
    let mut wrong = [0; 2];
    for (pixel, &triangle) in seen.triangle.iter().enumerate() {
        if triangle == Seen::NO_TRIANGLE || triangle >= 2 * RINGS * COLUMNS {
            continue;
        }
        let [a, b, c] = frame.mesh.triangles[triangle as usize].map(|vertex| frame.normals[vertex as usize]);
        let [second, third] = seen.barycentric[pixel];
        let normal = a * (1.0 - second - third) + b * second + c * third;
        let (cosine, is_lit) =
            (normal.normalize().dot(towards_sun()), film.color[pixel].truncate().max_element() > 0.0);
        wrong[0] += usize::from(is_lit && cosine < -MARGIN);
        wrong[1] += usize::from(!is_lit && cosine > MARGIN);
    }
    wrong
}

#[test]
fn light_ends_where_normals_say() {
    let frame = scene(None);
    let eye = Vec3::new(-2.0, 1.0, 6.0);
    let [lit, dark] = wrong_pixels(&frame, &settings(eye, FACETS));
    assert!(lit == 0 && dark > 50, "{lit} and {dark} pixels of facets");
    assert_eq!(wrong_pixels(&frame, &settings(eye, SMOOTH)), [0, 0]);
    // Some of four samples may show the floor behind the ball.
    let [_, dark] = wrong_pixels(&frame, &Settings { samples: 4, ..settings(eye, SMOOTH) });
    assert_eq!(dark, 0, "four samples");
}

#[test]
fn what_is_flat_stays_as_it_is() {
    let mut frame = scene(Some(Material::clay()));
    let eye = Vec3::new(-2.0, 1.0, 6.0);
    let [smooth, facets] = [SMOOTH, FACETS].map(|smooth| render(&frame, &settings(eye, smooth)));
    let colors = || smooth.color.iter().zip(&facets.color).zip(&smooth.triangle);
    let is_of_ball = |triangle: u32| triangle < 2 * RINGS * COLUMNS;
    assert!(colors().all(|((smooth, facets), &triangle)| is_of_ball(triangle) || smooth == facets));
    assert!(colors().any(|((smooth, facets), _)| smooth != facets));
    let shadow = colors().filter(|((_, color), triangle)| !is_of_ball(**triangle) && color.truncate() == Vec3::ZERO);
    assert!(shadow.count() > 100, "the ball's shadow is seen");
    // Without normals a ball is as flat as its triangles.
    frame.normals.clear();
    let [smooth, facets] = [SMOOTH, FACETS].map(|smooth| render(&frame, &settings(eye, smooth)));
    assert_eq!(smooth.color, facets.color);
}

#[test]
fn mirrors_show_the_same() {
    let mirror = Material { base_color: Vec4::ONE, metallic: 1.0, roughness: 0.0, ..Material::clay() };
    let [direct, mirrored] = [scene(None), scene(Some(mirror))];
    let (eye, image) = (Vec3::new(5.0, 0.5, 3.0), Vec3::NEG_Z * 6.0);
    for smooth in [SMOOTH, FACETS] {
        let camera = Camera::look_at(eye, image, Vec3::Y, 0.2).into();
        let in_mirror = render(&mirrored, &Settings { camera, bounces: 1, ..settings(eye, smooth) });
        let camera = Camera::look_at(Vec3::new(eye.x, eye.y, -6.0 - eye.z), Vec3::ZERO, Vec3::Y, 0.2).into();
        let expected = render(&direct, &Settings { camera, ..settings(eye, smooth) });
        let color = |film: &Film, pixel: usize| film.color[pixel].truncate();
        let flipped = |pixel: usize| pixel / 96 * 96 + 95 - pixel % 96;
        let differs = |pixel: &usize| !color(&in_mirror, *pixel).abs_diff_eq(color(&expected, flipped(*pixel)), 0.01);
        let differing = (0..96 * 96).filter(differs).count();
        assert!(differing < 20, "{differing} pixels differ");
    }
}
