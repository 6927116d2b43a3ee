//! Reflections in mirrors.

use std::sync::Arc;

use glam::{Vec3, Vec4};
use umbrage::rays::{Camera, SimdLevel};
use umbrage::scene::{Frame, Material, Materials, Mesh};
use umbrage::{Background, Error, Renderer, Settings, Structure};
use umbrage_papers::{KdBuilder, KdTreeOptions, KdTrees, Listed, Uniform, UniformOptions};
use umbrage_verify::{Random, TestMesh};

/// Triangles, each with the index of its material.
#[derive(Default)]
struct Maker {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    materials: Vec<u32>,
}

const MIRROR: u32 = 0;

impl Maker {
    fn push(&mut self, corners: [Vec3; 3], material: u32) {
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.triangles.push([first, first + 1, first + 2]);
        self.materials.push(material);
    }

    fn quad(&mut self, [a, b, c, d]: [Vec3; 4], material: u32) {
        self.push([a, b, c], material);
        self.push([a, c, d], material);
    }

    /// A frame with a mirror of this brightness, and materials of plain colours after it.
    fn frame(self, mirror: f32, colors: &[Vec3]) -> Frame {
        let metal =
            Material { base_color: Vec3::splat(mirror).extend(1.0), metallic: 1.0, roughness: 0.0, ..Material::clay() };
        let plain =
            colors.iter().map(|color| Material { base_color: color.extend(1.0), unlit: true, ..Material::clay() });
        let mesh = Mesh { triangles: self.triangles, material_of_triangle: self.materials, ..Mesh::default() };
        let materials = Materials { materials: std::iter::once(metal).chain(plain).collect(), textures: Vec::new() };
        Frame { positions: self.positions, mesh: Arc::new(mesh), materials: Arc::new(materials), ..Frame::default() }
    }
}

const COLORS: [Vec3; 3] = [Vec3::new(0.8, 0.1, 0.2), Vec3::new(0.1, 0.7, 0.3), Vec3::new(0.2, 0.3, 0.9)];

/// Triangles above the plane z = 0, or their mirror images below, and the mirror itself.
fn above_mirror(is_mirrored: bool) -> Frame {
    let (mut maker, mut random) = (Maker::default(), Random::new(3));
    for material in (1..=COLORS.len() as u32).cycle().take(30) {
        let place = random.point() * Vec3::new(2.0, 2.0, 0.4) + Vec3::Z * 0.6;
        let corners = [0; 3].map(|_| (place + random.point() * 0.5).max(Vec3::new(-9.0, -9.0, 0.05)));
        let sign = if is_mirrored { -1.0 } else { 1.0 };
        maker.push(corners.map(|corner| corner * Vec3::new(1.0, 1.0, sign)), material);
    }
    if !is_mirrored {
        let at = |x: f32, y: f32| Vec3::new(x, y, 0.0) * 50.0;
        maker.quad([at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)], MIRROR);
    }
    maker.frame(1.0, &COLORS)
}

fn settings(structure: Structure, bounces: u32) -> Settings {
    let camera = Camera::look_at(Vec3::new(0.5, -9.0, 6.0), Vec3::new(0.0, 0.0, -0.5), Vec3::Z, 0.5);
    let background = Background::Color(Vec3::new(0.4, 0.5, 0.6));
    Settings { width: 90, height: 70, structure, bounces, background, camera: camera.into(), ..Settings::default() }
}

fn colors(frame: &Frame, settings: &Settings) -> Vec<Vec4> {
    let mut renderer = Renderer::default();
    renderer.render_frame(frame, settings).expect("a frame").color.clone()
}

#[test]
fn a_mirror_shows_the_mirrored_scene() {
    let mut renderer = Renderer::default();
    let settings = settings(Structure::default(), 1);
    let frame = above_mirror(false);
    let film = renderer.render_frame(&frame, &settings).expect("a frame");
    let mirrored = colors(&above_mirror(true), &settings);
    let is_mirror = |triangle: u32| frame.mesh.material_of_triangle.get(triangle as usize) == Some(&MIRROR);
    let mut shown = [0; 2];
    for ((color, &triangle), expected) in film.color.iter().zip(&film.triangle).zip(&mirrored) {
        if is_mirror(triangle) {
            let background = Vec3::new(0.4, 0.5, 0.6);
            let is_background = (expected.truncate() - background).length() < 1e-3;
            shown[usize::from(is_background)] += 1;
            let difference = (color.truncate() - expected.truncate()).abs().max_element();
            assert!(difference < 2e-3, "{color} in the mirror, {expected} seen directly");
        }
    }
    assert!(shown.iter().all(|&pixels| pixels > 200), "{shown:?}");
}

#[test]
fn every_structure_and_level_shows_the_same_in_mirrors() {
    let expected = colors(&above_mirror(false), &settings(Structure::default(), 3));
    let presorted = KdTreeOptions { builder: KdBuilder::Presorted, lazy_below: 20, ..KdTreeOptions::DEFAULT };
    let structures = [
        Structure::of::<Listed>(),
        Structure::of::<Uniform>(),
        Structure::new(Uniform(UniformOptions::NESTED)),
        Structure::of::<KdTrees>(),
        Structure::new(KdTrees { options: presorted, ..KdTrees::default() }),
        Structure::bvh(),
    ];
    for structure in structures {
        assert!(colors(&above_mirror(false), &settings(structure.clone(), 3)) == expected, "{structure:?}");
    }
    for level in SimdLevel::available() {
        let mut renderer = Renderer::with_simd_level(level);
        let film =
            renderer.render_frame(&above_mirror(false), &settings(Structure::of::<KdTrees>(), 3)).expect("a frame");
        assert!(film.color == expected, "{level}");
    }
}

#[test]
fn light_between_mirrors_comes_by_as_many_as_asked_for() {
    // Two mirrors face each other; the camera looks between them at one, and its rays climb until they leave.
    const MIRRORS: i32 = 7;
    let mut maker = Maker::default();
    for x in [-1.0, 1.0] {
        let at = |y: f32, z: f32| Vec3::new(x, y, z);
        maker.quad([at(-50.0, -50.0), at(50.0, -50.0), at(50.0, 1.0), at(-50.0, 1.0)], MIRROR);
    }
    // Half way to the first, then all the way across for each of the others.
    let steps = 1.0 + 2.0 * (MIRRORS - 1) as f32;
    let rise = 1.0 / (steps + 1.0);
    let camera = Camera::look_at(Vec3::ZERO, Vec3::new(1.0, 0.0, rise), Vec3::Z, 1e-3);
    for bounces in [0, 1, 2, 5, 6, 7, 100] {
        let frame = Maker {
            positions: maker.positions.clone(),
            triangles: maker.triangles.clone(),
            materials: maker.materials.clone(),
        };
        let settings = Settings {
            width: 5,
            height: 4,
            camera: camera.into(),
            background: Background::Color(Vec3::ONE),
            bounces,
            ..Settings::default()
        };
        let met = MIRRORS.min(bounces as i32 + 1);
        for color in colors(&frame.frame(0.5, &[]), &settings) {
            let ratio = color.x / 0.5_f32.powi(met);
            assert!((0.9..1.1).contains(&ratio), "{color} after {bounces} bounces: {ratio} of {met} mirrors' half");
        }
    }
}

#[test]
fn curved_mirrors_do_not_see_themselves_where_they_are_convex() {
    let ball = TestMesh::ball(4);
    let mut maker = Maker::default();
    for &[a, b, c] in &ball.indices {
        maker.push([a, b, c].map(|vertex| ball.positions[vertex as usize]), MIRROR);
    }
    // Without other surfaces, so that every mirror shows the background and nothing dims it twice.
    let frame = maker.frame(0.5, &[]);
    let camera = Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, Vec3::Y, 0.6);
    let settings = |bounces| Settings {
        width: 120,
        height: 100,
        camera: camera.into(),
        background: Background::Color(Vec3::ONE),
        bounces,
        ..Settings::default()
    };
    let once = colors(&frame, &settings(0));
    let often = colors(&frame, &settings(8));
    for (once, often) in once.iter().zip(&often) {
        assert!((*once - *often).abs().max_element() < 2e-3, "{once} without bounces, {often} with");
    }
}

#[test]
fn endless_bounces_are_refused() {
    let settings = settings(Structure::default(), Settings::MAX_BOUNCES + 1);
    let refused = Renderer::default().render_frame(&above_mirror(false), &settings).map(|_| ());
    assert!(matches!(&refused, Err(error @ Error::Bounces(1025)) if error.to_string().contains("1024")), "{refused:?}");
}
