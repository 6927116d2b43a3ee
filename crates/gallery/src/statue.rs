//! A statue of very many small triangles on a plinth.

use glam::{Affine3A, Vec2, Vec3};

use super::build::math::{mix, smoothstep, turned, wave};
use super::build::{MeshBuilder, Paint, fractal_noise, mottled_texture, srgb};
use super::{DemoScene, Moment, Pose, sculpture, studio};
use umbrage_scene::Texture;

pub(crate) const SCENE: DemoScene = DemoScene {
    name: "statue",
    about: "a carved Buddha of small triangles",
    triangles: 1_100_000,
    seconds: 12.0,
    still_seconds: 2.25,
    open,
};

const LIMESTONE: Paint = Paint::textured("limestone", limestone, [1.0; 2], 0.7);
const GRANITE: Paint = Paint::textured("granite", granite, [1.0; 2], 0.25);
const WALL: Paint = Paint::dull("wall", 0x7d7872, 0.85);

/// The sculpture's share of the triangles; the plinth has the rest.
const SCULPTURE_SHARE: f32 = 0.95;
const PLINTH_HEIGHT: f32 = 0.55;

fn open(triangles: usize) -> Pose {
    let mut builder = MeshBuilder::new();
    let surface = sculpture::mesh(&sculpture::buddha(), (triangles as f32 * SCULPTURE_SHARE) as usize);
    builder.paint(LIMESTONE);
    let raised = Vec3::Y * (PLINTH_HEIGHT - 0.02);
    for (&position, &normal) in surface.positions.iter().zip(&surface.normals) {
        // Dust and rain darken low and sheltered surfaces; noise varies it from place to place.
        let age = mix(0.72, 1.0, smoothstep(-0.1, 0.6, normal.y + 0.8 * fractal_noise(position * 3.0, 2)));
        builder.tint(Vec3::new(age, age * mix(0.97, 1.0, age), age * mix(0.9, 1.0, age)));
        builder.vertex(position + raised, normal, Vec2::new(position.x + position.z, -position.y) * 0.4);
    }
    builder.triangles_from(0, surface.triangles);
    let columns = studio::backdrop_columns(triangles);
    studio::backdrop(builder.paint(WALL), 12.0, 9.0, columns);
    let left = triangles.saturating_sub(builder.triangles.len());
    builder.paint(GRANITE).place(Affine3A::from_translation(Vec3::Z * 0.12), |builder| plinth(builder, left));
    let still = builder.finish();

    Box::new(move |Moment { part, .. }, frame| {
        frame.copy_surfaces(&still);
        let middle = Vec3::new(0.0, 1.72, 0.1);
        let eye = middle + turned(-0.35 + 0.45 * wave(part)) * Vec3::new(0.0, 0.35 + 0.25 * wave(part + 0.25), 6.2);
        studio::look(frame, "front", eye, middle, 0.30);
        let sun = turned(-0.6 + 0.4 * wave(part + 0.5)) * Vec3::new(0.0, 5.2, 5.4);
        studio::light(frame, "key", sun, middle, srgb(0xfff0d8), 1.0);
        studio::light(frame, "rim", Vec3::new(4.5, 3.2, -3.4), middle, srgb(0xbfd4ff), 0.45);
    })
}

/// A round plinth with a moulded foot and edge, of about `triangles` triangles.
fn plinth(builder: &mut MeshBuilder, triangles: usize) {
    let height = PLINTH_HEIGHT;
    let sharp = [
        (1.32, 0.0),
        (1.32, 0.10),
        (1.24, 0.15),
        (1.20, 0.20),
        (1.20, height - 0.14),
        (1.24, height - 0.09),
        (1.30, height - 0.07),
        (1.30, height - 0.015),
        (1.285, height),
        (0.0, height),
    ]
    .map(Vec2::from);
    // As many rows as make quads about square, spread over the straight pieces by their length.
    let length: f32 = sharp.windows(2).map(|ends| ends[0].distance(ends[1])).sum();
    let quads = (triangles / 2) as f32;
    let rows = (quads * length / (std::f32::consts::TAU * 1.2)).sqrt().max(9.0);
    let mut profile = vec![sharp[0]];
    for ends in sharp.windows(2) {
        let steps = (rows * ends[0].distance(ends[1]) / length).round().max(1.0) as u32;
        profile.push(ends[0]);
        profile.extend((1..=steps).map(|step| ends[0].lerp(ends[1], step as f32 / steps as f32)));
    }
    let rows = profile.len() as u32 - sharp.len() as u32;
    let columns = (quads / rows as f32 + 0.5) as u32;
    let first = builder.positions.len();
    builder.lathe(&profile, columns.max(6));
    builder.wrap(first, |Vec3 { x, y, z }| Vec2::new(x + 0.4 * z, y + z));
}

fn limestone() -> Texture {
    let (light, warm) = (srgb(0xe6d9bf), srgb(0xc9ae86));
    mottled_texture("limestone", [256; 2], move |at| {
        let blotches = 0.5 + 0.7 * fractal_noise((at * 5.0).extend(2.0), 4);
        let veins = fractal_noise(Vec3::new(at.x * 4.0, at.y * 22.0, 7.0), 3);
        light.lerp(warm, (0.6 * blotches + 0.5 * veins).clamp(0.0, 1.0)).extend(1.0)
    })
}

fn granite() -> Texture {
    let (dark, grey) = (srgb(0x1e2226), srgb(0x5b6066));
    mottled_texture("granite", [256; 2], move |at| {
        let grains = 0.5 + 0.9 * fractal_noise((at * 40.0).extend(4.0), 3);
        dark.lerp(grey, grains.clamp(0.0, 1.0) * 0.7).extend(1.0)
    })
}
