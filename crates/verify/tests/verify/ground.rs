//! A ground under a scene, and transparent surfaces around it.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Vec3, Vec4};
use umbrage::rays::{Camera, LightSource};
use umbrage::scene::{Animated, Error, Frame, Ground, GroundSurface, Light, Material, Materials, Mesh, Scene};
use umbrage::{Background, Film, Panorama, Renderer, Settings};
use umbrage_papers::structures;

/// A square of 2 by 2 above y = 0, and the quads `others`.
#[derive(Debug)]
struct Square {
    height: f32,
    others: Vec<([Vec3; 4], Material)>,
}

impl Animated for Square {
    fn duration_seconds(&self) -> f64 {
        0.0
    }

    fn pose(&self, _seconds: f64, frame: &mut Frame) -> Result<(), Error> {
        let corner = |x: f32, z: f32| Vec3::new(x, self.height, z);
        let square = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
        let (mut mesh, mut materials) = (Mesh::default(), Vec::new());
        frame.positions.clear();
        for (corners, material) in [(square, Material::clay())].into_iter().chain(self.others.iter().cloned()) {
            let first = frame.positions.len() as u32;
            frame.positions.extend(corners);
            mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|triangle| triangle.map(|corner| first + corner)));
            mesh.material_of_triangle.extend([materials.len() as u32; 2]);
            materials.push(material);
        }
        frame.mesh = Arc::new(mesh);
        frame.materials = Arc::new(Materials { materials, textures: Vec::new() });
        frame
            .lights
            .push(Light { name: "sun".into(), ..Light::new(LightSource::Directional { direction: Vec3::NEG_Y }, 2.0) });
        Ok(())
    }
}

fn scene(others: Vec<([Vec3; 4], Material)>) -> Scene {
    let mut scene = Scene::new(Box::new(Square { height: 1.0, others })).expect("a scene");
    scene.set_ground(Some(Ground { surface: GroundSurface::Shadow, height: Some(0.0) }));
    scene
}

const SIDE: u32 = 64;

/// A view of the ground from above and one side, with the square's shadow beside the square.
fn settings(background: Background) -> Settings {
    let camera = Camera::look_at(Vec3::new(0.0, 9.0, 9.0), Vec3::ZERO, Vec3::Y, 0.5);
    Settings { width: SIDE, height: SIDE, camera: camera.into(), background, ..Settings::default() }
}

fn film(scene: &Scene, settings: &Settings) -> Film {
    Renderer::default().render(scene, 0.0, settings).expect("a picture").clone()
}

/// The colours of the pixels that show the ground, in shadow and lit.
fn of_ground(film: &Film, first_triangle: u32) -> (Vec<Vec4>, Vec<Vec4>) {
    let shown = film.color.iter().zip(&film.triangle);
    let colors = shown.filter(|(_, triangle)| (first_triangle..first_triangle + 2).contains(triangle));
    colors.map(|(color, _)| *color).partition(|color| color.w > 0.1)
}

#[test]
fn a_ground_is_darker_by_the_light_that_is_kept_away() {
    let around = Vec3::new(0.8, 0.4, 0.2);
    let (shadowed, lit) = of_ground(&film(&scene(Vec::new()), &settings(Background::Color(around))), 2);
    assert!(shadowed.len() > 100 && lit.len() > 1000, "{} and {}", shadowed.len(), lit.len());
    // Of all light, π times the surroundings' radiance and two of the sun, only the surroundings' remains.
    let left = around * PI / (around * PI + 2.0);
    let expected = (around * left).extend(1.0 - left.element_sum() / 3.0);
    for color in shadowed {
        assert!(color.abs_diff_eq(expected, 3e-3), "{color}, not {expected}");
    }
    for color in lit {
        assert!(color.abs_diff_eq(around.extend(0.0), 1e-6), "{color}");
    }
    // At the end of the ground, seen from close above it, the ground looks like the surroundings too.
    let camera = Camera::look_at(Vec3::new(0.0, 0.5, 0.0), Vec3::new(40.0, 0.25, 7.0), Vec3::Y, 0.2).into();
    let far = film(&scene(Vec::new()), &Settings { camera, ..settings(Background::Color(around)) });
    let shows_ground = |triangle: &&u32| **triangle != Film::NO_TRIANGLE;
    assert!((100..SIDE * SIDE - 100).contains(&(far.triangle.iter().filter(shows_ground).count() as u32)));
    assert!(far.color.iter().all(|color| color.abs_diff_eq(around.extend(0.0), 1e-6)));
}

#[test]
fn a_ground_leaves_alpha_alone_where_nothing_is_seen_around_it() {
    let shown = film(&scene(Vec::new()), &settings(Background::Transparent));
    let sky = film(&scene(Vec::new()), &settings(Background::Sky));
    let (shadowed, lit) = of_ground(&shown, 2);
    assert!(shadowed.len() > 100 && lit.iter().all(|color| color.abs_diff_eq(Vec4::ZERO, 1e-6)));
    for (color, with_sky) in shown.color.iter().zip(&sky.color) {
        assert_eq!(color.w, with_sky.w);
        assert!(color.truncate().cmple(with_sky.truncate()).all());
    }
    assert!(shadowed.iter().all(|color| color.truncate() == Vec3::ZERO && (0.1..0.9).contains(&color.w)));
    let image = shown.develop(&settings(Background::Transparent));
    assert_eq!(image.alpha.len(), shown.color.len());
    let square = shown.triangle.iter().position(|&triangle| triangle < 2).expect("the square is seen");
    assert_eq!(image.alpha[square], u16::MAX);
    assert_eq!(image.pixels[square], sky.develop(&settings(Background::Sky)).pixels[square]);
    assert!(sky.develop(&settings(Background::Sky)).alpha.is_empty());
}

#[test]
fn panes_and_mirrors_show_the_shadows_on_a_ground() {
    // A clear pane before the camera, without reflections.
    let pane = Material { transmission: 1.0, ior: 1.0, double_sided: true, ..Material::default() };
    let at = |x: f32, y: f32| Vec3::new(x, 6.0 + y, 6.0 - y);
    let pane = ([at(-3.0, -3.0), at(3.0, -3.0), at(3.0, 3.0), at(-3.0, 3.0)], pane);
    for background in [Background::Color(Vec3::new(0.8, 0.4, 0.2)), Background::Transparent] {
        let settings = settings(background);
        let direct = film(&scene(Vec::new()), &settings);
        for bounces in [0, 2] {
            let through = film(&scene(vec![pane.clone()]), &Settings { bounces, ..settings.clone() });
            assert!(through.triangle.iter().all(|triangle| (2..4).contains(triangle)));
            for (color, expected) in through.color.iter().zip(&direct.color) {
                assert!(color.abs_diff_eq(*expected, 2e-3), "{color} through the pane, {expected} without");
            }
        }
    }
    // A mirror that stands on the ground shows the other half of the world.
    let mirror = Material { metallic: 1.0, roughness: 0.0, double_sided: true, ..Material::default() };
    let at = |x: f32, y: f32| Vec3::new(x, y, -3.0);
    let mirror = ([at(-9.0, 0.0), at(9.0, 0.0), at(9.0, 9.0), at(-9.0, 9.0)], mirror);
    let camera =
        |side: f32| Camera::look_at(Vec3::new(0.0, 4.0, -3.0 + 6.0 * side), Vec3::new(0.0, 1.0, -3.0), Vec3::Y, 0.9);
    let color = Background::Color(Vec3::new(0.8, 0.4, 0.2));
    let bounced = Settings { bounces: 1, camera: camera(1.0).into(), ..settings(color.clone()) };
    let mirrored = film(&scene(vec![mirror]), &bounced);
    let direct = film(&scene(Vec::new()), &Settings { camera: camera(-1.0).into(), ..bounced });
    let mut shown = 0;
    for (pixel, color) in
        mirrored.color.iter().enumerate().filter(|&(pixel, _)| (2..4).contains(&mirrored.triangle[pixel]))
    {
        let (x, y) = (pixel as u32 % SIDE, pixel as u32 / SIDE);
        let other = (y * SIDE + SIDE - 1 - x) as usize;
        let expected = direct.color[other];
        shown += usize::from(direct.triangle[other] >= 2 && expected.w > 0.1);
        assert!(color.truncate().abs_diff_eq(expected.truncate(), 0.02), "{color} in the mirror, {expected}");
    }
    assert!(shown > 20, "{shown} pixels with shadow");
}

#[test]
fn all_structures_show_the_same_ground() {
    let expected = film(&scene(Vec::new()), &settings(Background::Sky));
    for structure in structures().iter() {
        let shown = film(&scene(Vec::new()), &Settings { structure: structure.clone(), ..settings(Background::Sky) });
        assert!(shown.color == expected.color, "{structure:?}");
    }
}

#[test]
fn shadows_of_all_the_sky_are_the_part_of_it_that_is_hidden() {
    let camera = Camera::look_at(Vec3::new(0.0, 0.6, 6.0), Vec3::ZERO, Vec3::Y, 0.01);
    let background = Background::Color(Vec3::new(0.8, 0.4, 0.2));
    let evenly = Settings {
        width: 15,
        height: 15,
        samples: 2048,
        sky_shadows: true,
        lights: Some(Vec::new()),
        camera: camera.into(),
        ..settings(background.clone())
    };
    let shown = film(&scene(Vec::new()), &evenly);
    // Below the middle of the square: four rectangles of 1 by 1 at a height of 1 over their corner, each of which hides
    // this fraction of the ground's light (Howell's catalogue of configuration factors, B-4).
    let hidden = 4.0 * 2.0 * (0.5_f32.sqrt() * 0.5_f32.sqrt().atan()) / (2.0 * PI);
    let middle = shown.color[15 * 7 + 7];
    assert!((middle.w - hidden).abs() < 0.02, "{middle}, not {hidden}");
    let expected = Vec3::new(0.8, 0.4, 0.2) * (1.0 - middle.w);
    assert!(middle.truncate().abs_diff_eq(expected, 2e-3), "{middle}, not {expected}");

    // Far from the square, which hides nothing of the sky there.
    let lit = |settings: &Settings| {
        let above = Camera::look_at(Vec3::new(20.0, 9.0, 0.0), Vec3::new(20.0, 0.0, 0.1), Vec3::Y, 0.05);
        film(&scene(Vec::new()), &Settings { samples: 64, camera: above.into(), ..settings.clone() })
    };
    for background in [background, Background::Sky] {
        let shown = lit(&Settings { background: background.clone(), ..evenly.clone() });
        for color in shown.color {
            assert!(color.w.abs() < 0.01, "{color} under {background:?}");
        }
    }
    let none = lit(&Settings { background: Background::Color(Vec3::ZERO), ..evenly });
    assert!(none.color.iter().all(|color| color.truncate() == Vec3::ZERO));
}

#[test]
fn light_from_all_around_is_as_much_with_shadows_where_nothing_casts_any() {
    let texels = (0..64 * 32).map(|texel| Vec3::new(0.2, 0.3, 0.5) * if texel % 64 < 20 { 3.0 } else { 1.0 });
    let panorama = Arc::new(Panorama::new(64, 32, texels.collect()).expect("a panorama"));
    for background in [Background::Sky, Background::Image(panorama)] {
        for normal in [Vec3::Y, Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.8, 0.6, 0.0), Vec3::new(0.0, -0.8, 0.6)] {
            let (right, up) = normal.any_orthonormal_pair();
            let corners = vec![-right - up, right - up, right + up, up - right];
            let frame = Frame::from_triangles(corners, vec![[0, 1, 2], [0, 2, 3]]);
            let camera = Camera::look_at(normal * 9.0, Vec3::ZERO, right, 0.02).into();
            let background = background.clone();
            let even = Settings { width: 2, height: 2, samples: 512, camera, background, ..Settings::default() };
            let color = |settings: &Settings| {
                Renderer::default().render_frame(&frame, settings).expect("a picture").color[0].truncate()
            };
            let (expected, shown) = (color(&even), color(&Settings { sky_shadows: true, ..even }));
            let difference = ((shown - expected) / expected).abs().max_element();
            // Without shadows, the light is that of nine harmonics.
            assert!(difference < 0.06, "{shown} is {difference} off {expected} at {normal}");
        }
    }
}

#[test]
fn what_is_bright_around_the_scene_casts_the_darkest_shadow() {
    // A sun in the sky of an image, 45° above +X.
    let bright = (8 * 64 + 48, Vec3::splat(2e3));
    let texels = (0..64 * 32).map(|texel| if texel == bright.0 { bright.1 } else { Vec3::splat(0.1) }).collect();
    let background = Background::Image(Arc::new(Panorama::new(64, 32, texels).expect("a panorama")));
    let camera = Camera::look_at(Vec3::new(0.0, 20.0, 0.1), Vec3::ZERO, Vec3::Y, 0.35);
    let settings = Settings {
        width: 65,
        height: 65,
        samples: 64,
        sky_shadows: true,
        lights: Some(Vec::new()),
        camera: camera.into(),
        background,
        ..Settings::default()
    };
    let shown = film(&scene(Vec::new()), &settings);
    // 3.5 units to the side of the middle are half the picture: the shadow is from -2 to 0, the square hides half of it.
    let coverage = |x: f32| shown.color[65 * 32 + (32.0 + x * 65.0 / 7.07) as usize].w;
    assert!(coverage(-1.5) > 0.85, "{}", coverage(-1.5));
    assert!(coverage(1.8) < 0.1 && coverage(-2.6) < 0.1, "{} and {}", coverage(1.8), coverage(-2.6));
}
