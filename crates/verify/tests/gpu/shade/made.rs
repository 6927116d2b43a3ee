//! Frames made to use every part of shading: textures of all kinds, lights of all kinds, surroundings and transparent
//! surfaces.

use std::f32::consts::{FRAC_PI_3, FRAC_PI_6, PI};
use std::sync::Arc;

use glam::{Affine2, Vec2, Vec3, Vec4};
use umbrage::rays::{Camera, LightSource, Projection};
use umbrage::scene::{
    Alpha, Anisotropy, Clearcoat, ColorSpace, Filter, Frame, Iridescence, Layers, Light, Material, Materials, Mesh,
    Sheen, Specular, Texture, TextureUse, Wrap,
};
use umbrage::{Background, Film, Panorama, Settings, ToneMap};
use umbrage_verify::Random;

use super::compare::{Difference, engines};
use super::develop::Developer;

const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];

/// Panels side by side in columns and rows, slightly bent, one for each of some materials.
fn panels(materials: Vec<Material>, textures: Vec<Texture>, columns: usize) -> Frame {
    let mut frame = Frame::default();
    let mut mesh = Mesh::default();
    for panel in 0..materials.len() {
        let middle = Vec3::new((panel % columns) as f32 * 1.1, (panel / columns) as f32 * 1.1, 0.0);
        let first = frame.positions.len() as u32;
        for corner in [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y] {
            let side = corner - 0.5;
            // Each panel leans its own way, so that footprints differ.
            let lean = 0.3 * (panel as f32).sin() * side.x + 0.9 * (panel as f32).cos() * side.y;
            frame.positions.push(middle + side.extend(lean));
            frame.normals.push(Vec3::new(-0.3 * (panel as f32).sin() + side.x, side.y, 1.0).normalize());
            frame.tangents.push(if panel % 2 == 0 { Vec4::ZERO } else { Vec4::new(1.0, 0.2, 0.1, -1.0) });
            mesh.tex_coords[0].push(corner * 3.0 - 1.2);
            mesh.tex_coords[1].push(Vec2::new(1.0 - corner.y, corner.x * 0.4));
            mesh.colors.push(Vec4::new(1.0 - 0.3 * corner.x, 0.8, 0.7 + 0.3 * corner.y, 1.0));
        }
        for triangle in [[0, 1, 2], [0, 2, 3]] {
            mesh.triangles.push(triangle.map(|corner| first + corner));
            mesh.material_of_triangle.push(panel as u32);
        }
    }
    frame.mesh = Arc::new(mesh);
    frame.materials = Arc::new(Materials { materials, textures });
    frame.lights = vec![light(LightSource::Directional { direction: Vec3::new(0.3, -0.4, -1.0).normalize() }, 3.0)];
    frame.animation_bounds = frame.triangles().bounds();
    frame
}

fn light(source: LightSource, intensity: f32) -> Light {
    Light { color: Vec3::new(1.0, 0.9, 0.7), ..Light::new(source, intensity) }
}

/// Soft random texels.
fn texture(size: [u32; 2], space: ColorSpace, filter: Filter, wrap: [Wrap; 2], random: &mut Random) -> Texture {
    let texels = (0..size[0] * size[1]).map(|_| [0; 4].map(|_| 40 + random.below(216) as u8)).collect();
    Texture::new("made", size, texels, space, filter, wrap)
}

/// Bytes of a frame's static parts.
fn still_bytes(frame: &Frame) -> u64 {
    let Mesh { triangles, tex_coords, colors, .. } = &*frame.mesh;
    let tex_coords: usize = tex_coords.iter().map(|coords| size_of_val(&**coords)).sum();
    let textures: usize = frame.materials.textures.iter().map(Texture::bytes).sum();
    (size_of_val(&**triangles) + tex_coords + size_of_val(&**colors) + textures) as u64
}

fn settings(side: u32) -> Settings {
    Settings { width: side, height: side - 20, ..Settings::default() }
}

/// All pairs of wraps, with all filters, spaces and coordinate sets, and a transform.
fn textured_panels() -> Frame {
    let mut random = Random::new(7);
    let (mut materials, mut textures) = (Vec::new(), Vec::new());
    for (across, down) in WRAPS.into_iter().flat_map(|across| WRAPS.map(|down| (across, down))) {
        for (filter, space) in [(Filter::Nearest, ColorSpace::Srgb), (Filter::Linear, ColorSpace::Linear)]
            .into_iter()
            .chain([(Filter::Linear, ColorSpace::Srgb)])
        {
            let place = textures.len() as u32;
            let size = [[16, 8], [5, 7], [64, 64], [1, 1]][textures.len() % 4];
            textures.push(texture(size, space, filter, [across, down], &mut random));
            let image_from_mesh =
                Affine2::from_scale_angle_translation(Vec2::new(1.5, -0.8), 0.3 * place as f32, Vec2::new(0.2, -3.1));
            let used = TextureUse { image_from_mesh, tex_coord_set: (place % 2) as u8, ..TextureUse::new(place) };
            materials.push(Material { base_color_texture: Some(used), double_sided: true, ..Material::default() });
        }
    }
    panels(materials, textures, 6)
}

/// All uses of textures, and materials from rough plastic to polished metal.
fn varied_panels() -> Frame {
    let mut random = Random::new(11);
    let mut made = |space| texture([32, 32], space, Filter::Linear, [Wrap::Repeat; 2], &mut random);
    let textures = vec![made(ColorSpace::Linear), made(ColorSpace::Srgb)];
    let (quantity, color) = (Some(TextureUse::new(0)), Some(TextureUse::new(1)));
    let plain = Material {
        base_color: Vec4::new(0.8, 0.5, 0.3, 1.0),
        roughness: 0.4,
        double_sided: true,
        ..Material::default()
    };
    let materials = vec![
        plain.clone(),
        Material { metallic: 1.0, roughness: 0.0, ..plain.clone() },
        Material { metallic: 1.0, roughness: 0.7, ..plain.clone() },
        Material { metallic: 1.0, roughness: 1.0, metallic_roughness_texture: quantity, ..plain.clone() },
        Material { normal_texture: quantity, normal_scale: 0.5, ..plain.clone() },
        Material { normal_texture: quantity, double_sided: true, ..plain.clone() },
        Material { occlusion_texture: quantity, occlusion_strength: 0.8, ..plain.clone() },
        Material { emissive: Vec3::new(0.2, 0.5, 0.1), emissive_texture: color, ..plain.clone() },
        Material { unlit: true, base_color_texture: color, ..plain.clone() },
        Material { ior: 2.4, roughness: 0.1, ..plain.clone() },
        Material { alpha: Alpha::Mask { cutoff: 0.6 }, base_color_texture: color, ..plain.clone() },
        Material { alpha: Alpha::Blend, base_color: Vec4::new(0.2, 0.3, 0.9, 0.4), ..plain.clone() },
        Material { alpha: Alpha::Blend, base_color_texture: color, ..plain.clone() },
        Material { transmission: 0.9, roughness: 0.1, ..plain.clone() },
        Material { transmission: 0.8, transmission_texture: quantity, ..plain.clone() },
        Material { catches_shadows: true, ..plain.clone() },
        plain,
    ];
    let mut frame = panels(materials, textures, 4);
    // A second wall of panels behind the first, so that transparent panels show panels behind them.
    let mut mesh = (*frame.mesh).clone();
    let (vertices, triangles) = (frame.positions.len() as u32, mesh.triangles.len());
    frame.positions.extend(frame.positions.clone().iter().map(|position| *position + Vec3::new(0.3, 0.4, -1.5)));
    frame.normals.extend_from_within(..);
    frame.tangents.extend_from_within(..);
    mesh.tex_coords.iter_mut().for_each(|coords| coords.extend_from_within(..));
    mesh.colors.extend_from_within(..);
    mesh.triangles.extend_from_within(..);
    mesh.triangles[triangles..].iter_mut().flatten().for_each(|vertex| *vertex += vertices);
    mesh.material_of_triangle.extend_from_within(..);
    frame.mesh = Arc::new(mesh);
    frame.animation_bounds = frame.triangles().bounds();
    frame
}

/// Every layer with and without its textures, alone and with others, on plastic and metal.
fn layered_panels() -> Frame {
    let mut random = Random::new(13);
    let mut made = |space| texture([32, 32], space, Filter::Linear, [Wrap::Repeat; 2], &mut random);
    let textures = vec![made(ColorSpace::Linear), made(ColorSpace::Srgb)];
    let (quantity, color) = (Some(TextureUse::new(0)), Some(TextureUse::new(1)));
    let plain = Material {
        base_color: Vec4::new(0.8, 0.5, 0.3, 1.0),
        roughness: 0.4,
        double_sided: true,
        ..Material::default()
    };
    let specular = Specular { factor: 0.7, color: Vec3::new(9.0, 3.0, 0.5), ..Specular::default() };
    let clearcoat = Clearcoat { factor: 0.9, roughness: 0.2, ..Clearcoat::default() };
    let sheen = Sheen { color: Vec3::new(0.9, 0.4, 0.2), roughness: 0.4, ..Sheen::default() };
    let anisotropy = Anisotropy { strength: 0.8, rotation_radians: 0.6, texture: None };
    let iridescence = Iridescence { factor: 0.9, ior: 1.6, ..Iridescence::default() };
    let none = Layers::default();
    let alone = [
        Layers { specular: specular.clone(), ..none.clone() },
        Layers { specular: Specular { texture: quantity, color_texture: color, ..specular.clone() }, ..none.clone() },
        Layers { clearcoat: clearcoat.clone(), ..none.clone() },
        Layers {
            clearcoat: Clearcoat { texture: quantity, roughness_texture: quantity, ..clearcoat.clone() },
            ..none.clone()
        },
        Layers {
            clearcoat: Clearcoat { normal_texture: quantity, normal_scale: 0.6, ..clearcoat.clone() },
            ..none.clone()
        },
        Layers { sheen: sheen.clone(), ..none.clone() },
        Layers { sheen: Sheen { color_texture: color, roughness_texture: quantity, ..sheen.clone() }, ..none.clone() },
        Layers { anisotropy: anisotropy.clone(), ..none.clone() },
        Layers { anisotropy: Anisotropy { texture: quantity, ..anisotropy.clone() }, ..none.clone() },
        Layers { iridescence: iridescence.clone(), ..none.clone() },
        Layers {
            iridescence: Iridescence { texture: quantity, thickness_texture: quantity, ..iridescence.clone() },
            ..none
        },
        Layers { specular, clearcoat, sheen, anisotropy, iridescence },
    ];
    let of_base = [
        plain.clone(),
        Material { metallic: 1.0, ..plain.clone() },
        Material { normal_texture: quantity, transmission: 0.5, ..plain },
    ];
    let with = |base: &Material, layers: &Layers| Material { layers: Some(Box::new(layers.clone())), ..base.clone() };
    let materials = of_base.iter().flat_map(|base| alone.iter().map(move |layers| with(base, layers)));
    panels(materials.chain(of_base.clone()).collect(), textures, 7)
}

fn lights() -> Vec<Light> {
    let position = Vec3::new(1.0, 2.0, 2.5);
    let direction = Vec3::new(0.3, 0.1, -1.0).normalize();
    let spot = |inner_radians| LightSource::Spot { position, direction, inner_radians, outer_radians: FRAC_PI_6 };
    vec![
        light(LightSource::Point { position }, 8.0),
        Light { range: Some(3.2), ..light(LightSource::Point { position }, 12.0) },
        light(spot(0.2), 20.0),
        light(spot(FRAC_PI_6), 20.0),
        Light { range: Some(4.0), ..light(spot(0.0), 20.0) },
        light(LightSource::Directional { direction }, 2.0),
        // From behind, and near a panel. A light in a panel's plane is on either side of it, by rounding.
        light(LightSource::Point { position: Vec3::new(1.5, 1.5, -2.0) }, 5.0),
        light(LightSource::Point { position: Vec3::new(1.1, 1.1, 0.01) }, 0.05),
    ]
}

/// A smooth panorama with one small sun.
fn panorama() -> Background {
    let (width, height) = (128, 64);
    let texel = |place: usize| {
        let (x, y) = ((place % width) as f32 / width as f32, (place / width) as f32 / height as f32);
        let sun = if place == 20 * width + 90 { 40.0 } else { 0.0 };
        Vec3::new(0.5 + 0.4 * (2.0 * PI * x).sin(), 1.0 - y, 0.3 + 0.3 * (6.0 * PI * x).cos() * y) + sun
    };
    let panorama = Panorama::new(width, height, (0..width * height).map(texel).collect()).expect("an image");
    Background::Image(Arc::new(panorama))
}

#[test]
fn textures_of_every_kind_look_the_same() {
    let Some(mut engines) = engines() else { return };
    let settings = settings(300);
    let films = engines.render(&textured_panels(), &settings).expect("a frame");
    let difference = Difference::of(&films.cpu, &films.gpu, &settings);
    difference.expect_alike("textures");
}

#[test]
fn samples_projections_and_tone_maps_look_the_same() {
    let Some(mut engines) = engines() else { return };
    let Some(mut developer) = Developer::open() else { return };
    let mut frame = varied_panels();
    frame.lights = lights();
    let camera = frame.framing_camera(1.0);
    let parallel = Camera { projection: Projection::Orthographic { half_height: 2.0 }, ..camera };
    let wide = Camera::look_at(Vec3::new(1.0, 1.2, 1.6), Vec3::new(1.2, 1.2, 0.0), Vec3::Y, 2.0 * FRAC_PI_3);
    for (name, camera) in [("parallel", parallel), ("wide", wide), ("framing", camera)] {
        for (samples, tone_map, exposure_stops) in [(1, ToneMap::Clip, -1.0), (3, ToneMap::PbrNeutral, 1.5)] {
            let settings = Settings {
                samples,
                tone_map,
                exposure_stops,
                camera: camera.into(),
                background: panorama(),
                ..settings(150)
            };
            let films = engines.render(&frame, &settings).expect("a frame");
            let difference = Difference::of(&films.cpu, &films.gpu, &settings);
            difference.expect_alike(&format!("{name}, {samples} samples"));
            assert_eq!(developer.developed_otherwise(&films.gpu, &settings), 0, "{name}");
        }
    }
}

#[test]
fn frames_that_share_memory_keep_apart() {
    let Some(mut engines) = engines() else { return };
    let settings = settings(100);
    let posed = textured_panels();
    // The same mesh and materials, moved, with other normals and without tangents, and then flat.
    let mut moved = posed.clone();
    moved.positions.iter_mut().for_each(|position| position.z += 0.1 * position.x);
    moved.normals.iter_mut().for_each(|normal| *normal = (*normal + Vec3::Y).normalize());
    moved.tangents.clear();
    let flat = Frame { normals: Vec::new(), ..moved.clone() };
    let frames = [varied_panels(), posed, moved, flat];
    // The bytes that a frame uploads when it is shown again: moving parts and parameters.
    let mut again = |frame: &Frame| {
        let twice = [(); 2].map(|()| engines.render(frame, &settings).expect("a frame").uploaded_bytes);
        twice[1]
    };
    let moving_bytes = frames.each_ref().map(&mut again);
    // Besides vertices, it uploads as much for a single panel without textures: neither mesh nor materials are part of it.
    let single = panels(vec![Material { double_sided: true, ..Material::default() }], Vec::new(), 1);
    let beside_vertices = |frame: &Frame, bytes: u64| {
        let Frame { positions, normals, tangents, .. } = frame;
        bytes - (size_of_val(&**positions) + size_of_val(&**normals) + size_of_val(&**tangents)) as u64
    };
    let least = beside_vertices(&single, again(&single));
    for place in 1..4 {
        assert_eq!(beside_vertices(&frames[place], moving_bytes[place]), least, "frame {place}");
    }
    // Frames 1 to 3 share all static parts.
    for (place, is_new) in [(0, true), (1, true), (2, false), (3, false), (1, false), (0, true), (3, true), (2, false)]
    {
        let films = engines.render(&frames[place], &settings).expect("a frame");
        Difference::of(&films.cpu, &films.gpu, &settings).expect_alike(&format!("frame {place}"));
        let still_bytes = films.uploaded_bytes - moving_bytes[place];
        println!("frame {place}: {still_bytes} bytes beside {}", moving_bytes[place]);
        if is_new {
            assert!(still_bytes >= self::still_bytes(&frames[place]), "frame {place}: {still_bytes} bytes");
        } else {
            assert_eq!(still_bytes, 0, "frame {place}");
        }
    }
}

#[test]
fn the_comparison_finds_what_differs() {
    let Some(mut engines) = engines() else { return };
    let Some(mut developer) = Developer::open() else { return };
    let settings = settings(100);
    let frame = textured_panels();
    let mut brighter = frame.clone();
    brighter.lights[0].intensity *= 1.1;
    let mut deeper = frame.clone();
    deeper.positions.iter_mut().for_each(|position| position.z -= 0.02);
    let films = [frame, brighter, deeper].map(|frame| engines.render(&frame, &settings).expect("a frame"));
    let camera_stays = |other: usize| Difference::of(&films[0].cpu, &films[other].gpu, &settings);
    let same = camera_stays(0);
    assert_eq!((same.colors, same.triangles), (0, 0), "{same:?}");
    assert!(camera_stays(1).colors > 1000, "{:?}", camera_stays(1));
    assert!(camera_stays(2).depths > 1000, "{:?}", camera_stays(2));
    let clipped = Settings { tone_map: ToneMap::Clip, ..settings.clone() };
    assert!(developer.developed_otherwise_than(&films[0].gpu, &settings, &clipped) > 1000);
    assert_eq!(developer.developed_otherwise(&films[0].gpu, &settings), 0);
}

#[test]
fn too_many_lights_are_refused() {
    let Some(mut engines) = engines() else { return };
    let lamp = light(LightSource::Point { position: Vec3::Z }, 1.0);
    let frame = Frame { lights: vec![lamp; 1025], ..textured_panels() };
    let error = engines.render(&frame, &settings(40)).expect_err("too many");
    assert!(error.to_string().contains("1025 lights"), "{error}");
}

/// Tests that take long, which `cargo run -p ci` runs with `--all` alone.
mod long {
    use super::*;

    #[test]
    fn materials_and_layers_look_the_same_with_every_light_in_all_surroundings() {
        let Some(mut engines) = engines() else { return };
        let frame = varied_panels();
        let color = Background::Color(Vec3::new(0.2, 0.4, 0.1));
        for (name, background) in [
            ("sky", Background::Sky),
            ("transparent", Background::Transparent),
            ("black", Background::Color(Vec3::ZERO)),
            ("colour", color),
            ("panorama", panorama()),
        ] {
            for (place, light) in lights().into_iter().enumerate() {
                let settings = Settings { background: background.clone(), ..settings(150) };
                let frame = Frame { lights: vec![light], ..frame.clone() };
                let films = engines.render(&frame, &settings).expect("a frame");
                let difference = Difference::of(&films.cpu, &films.gpu, &settings);
                difference.expect_alike(&format!("light {place} under {name}"));
            }
        }
    }

    #[test]
    fn layers_look_the_same_with_every_light_in_all_surroundings() {
        let Some(mut engines) = engines() else { return };
        let frame = layered_panels();
        for (name, background) in [("sky", Background::Sky), ("panorama", panorama())] {
            for (place, light) in lights().into_iter().enumerate() {
                let settings = Settings { background: background.clone(), ..settings(220) };
                let frame = Frame { lights: vec![light], ..frame.clone() };
                let films = engines.render(&frame, &settings).expect("a frame");
                Difference::of(&films.cpu, &films.gpu, &settings).expect_alike(&format!("light {place} under {name}"));
            }
        }
        // Flat, from behind, without tangents in the file.
        let frame = Frame { normals: Vec::new(), tangents: Vec::new(), lights: lights(), ..frame };
        let camera = Camera::look_at(Vec3::new(2.5, 3.5, -8.0), Vec3::new(3.0, 2.5, -0.5), Vec3::Y, 0.9);
        let settings = Settings { camera: camera.into(), ..settings(220) };
        let films = engines.render(&frame, &settings).expect("a frame");
        Difference::of(&films.cpu, &films.gpu, &settings).expect_alike("flat, from behind");
    }

    #[test]
    fn flat_surfaces_look_the_same_from_both_sides() {
        let Some(mut engines) = engines() else { return };
        let frame = Frame { normals: Vec::new(), tangents: Vec::new(), lights: lights(), ..varied_panels() };
        for z in [5.0, -6.5] {
            let camera = Camera::look_at(Vec3::new(0.5, 2.5, z), Vec3::new(1.7, 1.7, -0.5), Vec3::Y, 0.9);
            let settings = Settings { camera: camera.into(), ..settings(150) };
            let films = engines.render(&frame, &settings).expect("a frame");
            Difference::of(&films.cpu, &films.gpu, &settings).expect_alike(&format!("from {z}"));
            let seen = films.cpu.triangle.iter().filter(|&&triangle| triangle != Film::NO_TRIANGLE).count();
            assert!(seen > 5000, "{seen} pixels show a triangle");
        }
    }
}
