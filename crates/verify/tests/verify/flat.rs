//! Unlit materials and backgrounds of one colour, which pictures show without exposure and tone mapping.

use std::sync::Arc;

use glam::{Vec3, Vec4};
use umbrage::rays::{Camera, LightSource};
use umbrage::scene::{Alpha, Frame, Light, Material, Materials, Mesh};
use umbrage::{Background, Film, Image, Renderer, Settings, ToneMap};

const SIDE: u32 = 24;
/// `#336699`, and another colour as levels.
const BLUE: [u8; 3] = [0x33, 0x66, 0x99];
const AMBER: [u8; 3] = [0xff, 0xb0, 0x10];

/// Linear light of sRGB levels.
fn linear(levels: [u8; 3]) -> Vec3 {
    Vec3::from(levels.map(|level| {
        let encoded = f32::from(level) / 255.0;
        if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
    }))
}

/// Squares before the camera, each from the left edge to its x, at its z. The camera sees −1 to 1 at z = 0.
fn frame(squares: &[(f32, f32, Material)]) -> Frame {
    let (mut frame, mut mesh, mut materials) = (Frame::default(), Mesh::default(), Vec::new());
    for (right, z, material) in squares {
        let first = frame.positions.len() as u32;
        frame
            .positions
            .extend([[-9.0, -9.0], [*right, -9.0], [*right, 9.0], [-9.0, 9.0]].map(|[x, y]| Vec3::new(x, y, *z)));
        mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|triangle| triangle.map(|corner| first + corner)));
        mesh.material_of_triangle.extend([materials.len() as u32; 2]);
        materials.push(material.clone());
    }
    frame.mesh = Arc::new(mesh);
    frame.materials = Arc::new(Materials { materials, textures: Vec::new() });
    frame
}

fn settings(background: Background) -> Settings {
    let camera = Camera {
        projection: umbrage::rays::Projection::Orthographic { half_height: 1.0 },
        ..Camera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, Vec3::Y, 1.0)
    };
    Settings { width: SIDE, height: SIDE, camera: camera.into(), background, ..Settings::default() }
}

fn unlit(levels: [u8; 3]) -> Material {
    Material { base_color: linear(levels).extend(1.0), unlit: true, double_sided: true, ..Material::clay() }
}

fn film(frame: &Frame, settings: &Settings) -> Film {
    Renderer::default().render_frame(frame, settings).expect("a picture").clone()
}

fn picture(frame: &Frame, settings: &Settings) -> Image {
    film(frame, settings).develop(settings)
}

/// The levels of a pixel in a file with eight bits.
fn levels(image: &Image, x: u32, y: u32) -> [u8; 3] {
    image.pixels[(y * SIDE + x) as usize].map(|level| ((u32::from(level) + 128) / 257) as u8)
}

/// Numbers of samples, exposures and tone maps that must not matter.
fn variants(settings: &Settings) -> Vec<Settings> {
    let mut variants = Vec::new();
    for samples in [1, 3, 4, 16] {
        for (exposure_stops, tone_map) in
            [(0.0, ToneMap::PbrNeutral), (2.0, ToneMap::PbrNeutral), (-1.0, ToneMap::Clip)]
        {
            variants.push(Settings { samples, exposure_stops, tone_map, ..settings.clone() });
        }
    }
    variants
}

#[test]
fn unlit_surfaces_and_backgrounds_of_one_colour_have_the_levels_that_they_were_given() {
    let frame = frame(&[(0.0, 0.0, unlit(AMBER))]);
    for settings in variants(&settings(Background::Color(linear(BLUE)))) {
        let image = picture(&frame, &settings);
        for y in 0..SIDE {
            for x in 0..SIDE {
                assert_eq!(levels(&image, x, y), if x < SIDE / 2 { AMBER } else { BLUE }, "({x}, {y}), {settings:?}");
            }
        }
    }
    // Only here: every other background is exposed and mapped.
    let of_sky = |exposure_stops| picture(&frame, &Settings { exposure_stops, ..settings(Background::Sky) });
    assert_ne!(levels(&of_sky(0.0), SIDE - 1, 0), levels(&of_sky(1.0), SIDE - 1, 0));
    assert_eq!(levels(&of_sky(1.0), 0, 0), AMBER);
}

#[test]
fn edges_are_mixed_in_linear_light() {
    // The edge is in the middle of a pixel.
    let edge = 1.0 / SIDE as f32;
    let settings = Settings { samples: 16, exposure_stops: 1.0, ..settings(Background::Color(linear(BLUE))) };
    let mixed = levels(&picture(&frame(&[(edge, 0.0, unlit(AMBER))]), &settings), SIDE / 2, 5);
    let expected = 0.5 * (linear(AMBER) + linear(BLUE));
    for (level, expected) in mixed.into_iter().zip(expected.to_array()) {
        assert!((linear([level; 3]).x - expected).abs() < 0.005, "{mixed:?}");
    }
    // Beside a lit surface, the rest of the pixel is exposed and mapped as if it were whole.
    let clay = Material { double_sided: true, ..Material::clay() };
    let image = picture(&frame(&[(edge, 0.0, clay)]), &settings);
    let [whole, half] = [2, SIDE / 2].map(|x| Vec3::from(levels(&image, x, 5).map(|level| linear([level; 3]).x)));
    assert!(half.distance(0.5 * (whole + linear(BLUE))) < 0.01, "{half} between {whole} and {}", linear(BLUE));
}

#[test]
fn what_is_seen_through_panes_is_a_part() {
    // Half of an unlit pane, and then half of the other.
    let pane = |levels| Material { alpha: Alpha::Blend, base_color: linear(levels).extend(0.5), ..unlit(levels) };
    let frame = frame(&[(9.0, 1.0, pane(AMBER)), (0.0, 0.0, pane([0, 0, 0]))]);
    for settings in variants(&settings(Background::Color(linear(BLUE)))) {
        let image = picture(&frame, &settings);
        for (x, behind) in [(2, 0.25), (SIDE - 2, 0.5)] {
            let expected = 0.5 * linear(AMBER) + behind * linear(BLUE);
            let shown = Vec3::from(levels(&image, x, 3).map(|level| linear([level; 3]).x));
            assert!(shown.distance(expected) < 0.01, "{shown} for {expected}, {settings:?}");
        }
    }
}

#[test]
fn what_is_lit_behind_an_unlit_pane_is_mapped_as_if_it_were_whole() {
    let clay = Material { double_sided: true, ..Material::clay() };
    let pane = Material { alpha: Alpha::Blend, base_color: linear(AMBER).extend(0.5), ..unlit(AMBER) };
    let settings = Settings { exposure_stops: 1.0, ..settings(Background::Sky) };
    let [whole, behind] = [vec![(9.0, 0.0, clay.clone())], vec![(9.0, 1.0, pane), (9.0, 0.0, clay)]].map(|squares| {
        Vec3::from(levels(&picture(&frame(&squares), &settings), 9, 9).map(|level| linear([level; 3]).x))
    });
    assert!(
        behind.distance(0.5 * (whole + linear(AMBER))) < 0.01,
        "{behind} for {whole} behind half of {}",
        linear(AMBER)
    );
}

#[test]
fn what_mirrors_show_is_exposed() {
    let mirror =
        Material { metallic: 1.0, roughness: 0.0, base_color: Vec4::ONE, double_sided: true, ..Material::clay() };
    let settings = Settings { bounces: 1, ..settings(Background::Color(linear(BLUE))) };
    let shown = film(&frame(&[(0.0, 0.0, mirror)]), &settings);
    for (number, (flat, triangle)) in shown.flat.iter().zip(&shown.triangle).enumerate() {
        let expected = if *triangle == Film::NO_TRIANGLE { linear(BLUE).extend(1.0) } else { Vec4::ZERO };
        assert!(flat.abs_diff_eq(expected, 1e-6), "{flat} at {number}");
    }
}

#[test]
fn pictures_over_nothing_keep_the_levels() {
    let pane = Material { alpha: Alpha::Blend, base_color: linear(AMBER).extend(0.5), ..unlit(AMBER) };
    let frame = frame(&[(0.0, 0.0, unlit(BLUE)), (9.0, -1.0, pane)]);
    for settings in variants(&settings(Background::Transparent)) {
        let image = picture(&frame, &settings);
        assert_eq!((levels(&image, 1, 1), image.alpha[0]), (BLUE, u16::MAX));
        assert_eq!(levels(&image, SIDE - 2, 1), AMBER);
        assert!(image.alpha[SIDE as usize - 2].abs_diff(u16::MAX / 2) < 4);
    }
}

#[test]
fn a_ground_that_only_catches_shadows_shows_the_background_where_it_is_lit() {
    let ground = Material { catches_shadows: true, double_sided: true, ..Material::clay() };
    // A narrow pole before it, whose shadow is beside it.
    let mut frame = frame(&[(9.0, -1.0, ground), (-0.5, 0.0, unlit(AMBER))]);
    frame.lights.push(Light {
        name: "sun".into(),
        ..Light::new(LightSource::Directional { direction: Vec3::new(0.5, 0.0, -1.0) }, 3.0)
    });
    for bounces in [0, 1] {
        let settings = Settings { bounces, ..settings(Background::Color(linear(BLUE))) };
        for settings in variants(&settings) {
            let film = film(&frame, &settings);
            let image = film.develop(&settings);
            assert_eq!(levels(&image, SIDE - 1, 9), BLUE, "{settings:?}");
            let shadowed = levels(&image, SIDE / 4 + 2, 9);
            assert!(shadowed[2] < BLUE[2] - 20, "{shadowed:?}");
            // All of it is shown without tone mapping, except for the shadow's darkness.
            for (color, flat) in film.color.iter().zip(&film.flat).filter(|(color, _)| color.w < 0.9) {
                assert!((color.w + flat.w - 1.0).abs() < 1e-5 && color.truncate() == flat.truncate(), "{color} {flat}");
            }
        }
    }
}

#[test]
fn films_have_no_such_plane_where_nothing_is_shown_so() {
    let clay = frame(&[(0.0, 0.0, Material::clay())]);
    assert!(film(&clay, &settings(Background::Sky)).flat.is_empty());
}
