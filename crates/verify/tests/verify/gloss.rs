//! Reflections of rough surfaces, and ambient occlusion.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DVec3, Vec3};
use umbrage::rays::Camera;
use umbrage::scene::{Frame, Material, Materials, Volume};
use umbrage::{Background, Panorama, Renderer, Settings};

/// The mean of a picture of a large square in the plane z = 0, or of several above each other, seen from above and one
/// side, in front of a background.
fn mean(material: &Material, heights: &[f32], cosine: f32, settings: &Settings) -> Vec3 {
    let corner = |x: f32, y: f32, z: f32| Vec3::new(9.0 * x, 9.0 * y, z);
    let square = |z: f32| {
        let corners = [corner(-1.0, -1.0, z), corner(1.0, -1.0, z), corner(1.0, 1.0, z), corner(-1.0, 1.0, z)];
        // A square below z = 0 faces downwards.
        if z < 0.0 { [corners[0], corners[3], corners[2], corners[1]] } else { corners }
    };
    let positions: Vec<Vec3> = heights.iter().flat_map(|&z| square(z)).collect();
    let first = (0..).step_by(4).take(heights.len());
    let mut frame =
        Frame::from_triangles(positions, first.flat_map(|a| [[a, a + 1, a + 2], [a, a + 2, a + 3]]).collect());
    frame.materials = Arc::new(Materials { materials: vec![material.clone()], textures: Vec::new() });
    let eye = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine) * 5.0;
    let camera = Camera::look_at(eye, Vec3::ZERO, Vec3::Y, 0.01).into();
    let settings = Settings { width: 8, height: 8, camera, ..settings.clone() };
    let film = Renderer::default().render_frame(&frame, &settings).expect("a picture").clone();
    film.color.iter().map(|color| color.truncate()).sum::<Vec3>() / 64.0
}

fn white() -> Settings {
    Settings {
        samples: 256,
        bounces: 1,
        gloss: true,
        background: Background::Color(Vec3::ONE),
        lights: Some(Vec::new()),
        ..Settings::default()
    }
}

fn metal(roughness: f32) -> Material {
    Material { metallic: 1.0, roughness, ..Material::clay() }
}

fn white_metal(roughness: f32) -> Material {
    Material { base_color: Vec3::ONE.extend(1.0), ..metal(roughness) }
}

#[test]
fn rough_mirrors_in_a_white_furnace_are_white() {
    for cosine in [0.3, 0.7, 1.0] {
        for roughness in [0.1, 0.3, 0.6, 1.0] {
            let shown = mean(&white_metal(roughness), &[0.0], cosine, &white()).x;
            assert!((shown - 1.0).abs() < 0.02, "{shown} at roughness {roughness}, cosine {cosine}");
            // Coloured and dielectric ones look as with the table of the integral, without random directions.
            for material in [metal(roughness), Material { metallic: 0.0, ..metal(roughness) }] {
                let drawn = mean(&material, &[0.0], cosine, &white()).x;
                let tabled = mean(&material, &[0.0], cosine, &Settings { gloss: false, ..white() }).x;
                assert!((drawn - tabled).abs() < 0.02, "{drawn}, {tabled} at roughness {roughness}, cosine {cosine}");
            }
        }
    }
}

/// The part of a rough white mirror's reflection that comes from directions with x < 0: the integral of GGX with
/// Smith's height-correlated shadowing over the hemisphere.
fn part_of_left(roughness: f64, cosine: f64) -> f64 {
    const STEPS: usize = 1024;
    let a2 = roughness.powi(4);
    let view = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
    let mut sums = [0.0; 2];
    for row in 0..STEPS {
        // Evenly in the cosine.
        let z = (row as f64 + 0.5) / STEPS as f64;
        for column in 0..STEPS {
            let angle = (column as f64 + 0.5) / STEPS as f64 * TAU;
            let light = DVec3::new((1.0 - z * z).sqrt() * angle.cos(), (1.0 - z * z).sqrt() * angle.sin(), z);
            let n_h = (view + light).normalize().z;
            let d = n_h * n_h * (a2 - 1.0) + 1.0;
            let masking = z * (cosine * cosine * (1.0 - a2) + a2).sqrt();
            let shadowing = cosine * (z * z * (1.0 - a2) + a2).sqrt();
            sums[usize::from(light.x < 0.0)] += a2 / (PI * d * d) * 0.5 / (masking + shadowing) * z;
        }
    }
    sums[1] / (sums[0] + sums[1])
}

#[test]
fn rough_mirrors_blur_what_is_around_as_the_integral_says() {
    // White where x < 0, black elsewhere: −Z is in the middle of the image.
    let texels = (0..512 * 256).map(|texel| if texel % 512 < 256 { Vec3::ONE } else { Vec3::ZERO }).collect();
    let background = Background::Image(Arc::new(Panorama::new(512, 256, texels).expect("a panorama")));
    for cosine in [0.5, 0.95] {
        for roughness in [0.2, 0.5, 1.0] {
            let settings = Settings { background: background.clone(), ..white() };
            let shown = mean(&white_metal(roughness), &[0.0], cosine, &settings).x;
            let expected = part_of_left(roughness.into(), cosine.into()) as f32;
            assert!((shown - expected).abs() < 0.015, "{shown}, not {expected}, at {roughness}, {cosine}");
        }
    }
}

#[test]
fn rough_glass_makes_no_light() {
    for cosine in [0.4, 1.0] {
        for roughness in [0.0, 0.2, 0.5] {
            let volume = Volume { thickness: 1.0, ..Volume::default() };
            let base_color = Vec3::ONE.extend(1.0);
            let glass = Material { base_color, transmission: 1.0, roughness, volume, ..Material::default() };
            let settings = Settings { bounces: 24, least_contribution: 1e-4, ..white() };
            let shown = mean(&glass, &[0.5, -0.5], cosine, &settings).x;
            // Small facets hide each other, and light that bounces between them is lost: most near the critical angle.
            let least = if roughness == 0.0 { 0.99 } else { 0.85 - 0.4 * roughness };
            assert!(shown < 1.001 && shown > least, "{shown} at roughness {roughness}, cosine {cosine}");
        }
    }
}

#[test]
fn what_is_near_keeps_light_from_all_around_away() {
    // Below a square at a height of 4, 18 wide: the fraction that it hides of the ambient light below its middle.
    let side = 9.0_f32 / 4.0;
    let part = side / (1.0 + side * side).sqrt() * (side / (1.0 + side * side).sqrt()).atan();
    let hidden = 4.0 * 2.0 * part / (2.0 * std::f32::consts::PI);
    let clay = Material { base_color: Vec3::splat(0.5).extend(1.0), roughness: 1.0, ior: 1.0, ..Material::clay() };
    let looking = |ambient_occlusion| {
        let settings = Settings { gloss: false, bounces: 0, ambient_occlusion, ..white() };
        // Seen from between the squares.
        mean(&clay, &[0.0, 4.0], 0.3, &settings).x
    };
    let open = looking(0.0);
    assert!((looking(3.99) / open - 1.0).abs() < 1e-3, "{} of {open}", looking(3.99));
    assert!((looking(1e3) / open - (1.0 - hidden)).abs() < 0.02, "{} of {open}, not {}", looking(1e3), 1.0 - hidden);
    // A single sample has no ambient occlusion.
    let single = Settings { samples: 1, gloss: false, bounces: 0, ambient_occlusion: 1e3, ..white() };
    assert_eq!(mean(&clay, &[0.0, 4.0], 0.3, &single).x, open);
}
