//! Marbles poured into a wooden tray.

mod fall;

use std::ops::Range;

use glam::{Affine3A, Vec2, Vec3};
use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;

use self::fall::{BOARDS, FALL, MARBLES, SECONDS};
use super::build::math::{mix, smoothstep, wave};
use super::build::{
    MeshBuilder, Paint, ball_triangles, color_texture, fineness_of_balls, fractal_noise, mottled_texture, srgb,
};
use super::{DemoScene, Moment, Pose, studio};
use umbrage_scene::Texture;

pub(crate) const SCENE: DemoScene = DemoScene {
    name: "marbles",
    about: "110 marbles poured into a tray",
    triangles: 9_000,
    seconds: SECONDS,
    still_seconds: 2.2,
    open,
};

const WALNUT: Paint = Paint::textured("walnut", wood, [2.0, 0.5], 0.45);
const FELT: Paint = Paint::dull("felt", 0x23423a, 0.95);
const TABLE: Paint = Paint::dull("table", 0xd9cfc2, 0.7);

/// The scene with about `triangles` triangles; with too few, it has fewer marbles.
fn open(triangles: usize) -> Pose {
    let columns = studio::backdrop_columns(triangles);
    let budget = triangles.saturating_sub(12 * BOARDS.len() + studio::backdrop_triangles(columns));
    let mut builder = MeshBuilder::new();
    let mut marbles: Vec<Range<usize>> = Vec::new();
    // With too few for octahedra, fewer marbles.
    let count = (budget / ball_triangles(0)).clamp(1, MARBLES);
    for (marble, fineness) in fineness_of_balls(&vec![1.0; count], budget).into_iter().enumerate() {
        let first = builder.positions.len();
        builder.part().paint(FINISHES[(marble * 7 + marble / 5) % FINISHES.len()]);
        let radius = FALL.radii[marble];
        builder.ball(Vec3::ZERO, radius, fineness);
        marbles.push(first..builder.positions.len());
    }
    builder.still();
    for (board, [low, high]) in BOARDS.into_iter().enumerate() {
        builder.paint(if board == 0 { FELT } else { WALNUT }).cuboid(low, high);
    }
    studio::backdrop(builder.paint(TABLE), 14.0, 9.0, columns);
    let still = builder.finish();

    Box::new(move |Moment { seconds, .. }, frame| {
        frame.copy_surfaces(&still);
        let mut rest = (frame.positions.as_mut_slice(), frame.normals.as_mut_slice());
        let mut parts = Vec::with_capacity(marbles.len());
        for marble in &marbles {
            let (positions, other_positions) = rest.0.split_at_mut(marble.len());
            let (normals, other_normals) = rest.1.split_at_mut(marble.len());
            parts.push((positions, normals));
            rest = (other_positions, other_normals);
        }
        parts.into_par_iter().enumerate().each(|(marble, (positions, normals))| {
            let (middle, turn) = FALL.pose(marble, seconds);
            let turn = turn.normalize();
            let world_from_marble = Affine3A::from_rotation_translation(turn, middle);
            for (position, normal) in positions.iter_mut().zip(normals) {
                *position = world_from_marble.transform_point3(*position);
                *normal = world_from_marble.transform_vector3(*normal);
            }
        });

        let closer = smoothstep(0.0, 1.0, seconds / SECONDS);
        let eye = Vec3::new(mix(-1.7, -0.9, closer), mix(3.3, 3.0, closer), mix(4.9, 4.5, closer));
        studio::look(frame, "front", eye, Vec3::new(0.0, 0.36, 0.0), 0.34);
        studio::light(frame, "key", Vec3::new(-3.0, 5.0, 2.0), Vec3::ZERO, srgb(0xfff0dc), 0.95);
        studio::light(frame, "fill", Vec3::new(5.0, 4.0, -2.0), Vec3::ZERO, srgb(0xd6e4ff), 0.25);
    })
}

/// The marbles' materials: swirls of two colours, plain glossy ones, and steel.
const FINISHES: [Paint; 8] = [
    swirl("sea swirl", || swirl_texture("sea swirl", 0.0, 0x1c6e8c, 0xf2ead8)),
    swirl("ember swirl", || swirl_texture("ember swirl", 1.0, 0xb8322a, 0xf4d58d)),
    swirl("moss swirl", || swirl_texture("moss swirl", 2.0, 0x3d6b35, 0xe6e3c3)),
    swirl("ink swirl", || swirl_texture("ink swirl", 3.0, 0x27304f, 0xa9c4d9)),
    Paint::dull("ivory", 0xefe6d2, 0.12),
    Paint::dull("amber", 0xd98a2b, 0.12),
    Paint::dull("plum", 0x6b2d4f, 0.12),
    Paint::metal("steel", || srgb(0xc8ccd0), 0.08),
];

const fn swirl(name: &'static str, texture: fn() -> Texture) -> Paint {
    Paint::textured(name, texture, [1.0; 2], 0.12)
}

fn swirl_texture(name: &str, seed: f32, ground: u32, swirl: u32) -> Texture {
    let (ground, swirl) = (srgb(ground), srgb(swirl));
    color_texture(name, [128; 2], |at| {
        let bent = at + 0.16 * Vec2::new(wave(1.3 * at.y + seed * 0.3), wave(1.1 * at.x + seed * 0.7));
        let bands = wave(2.0 * bent.x + 0.7 * fractal_noise((3.0 * bent).extend(seed), 3));
        ground.lerp(swirl, smoothstep(0.35, 0.65, bands)).extend(1.0)
    })
}

/// Dark wood whose grain runs along x.
fn wood() -> Texture {
    let (dark, light) = (srgb(0x4a2c1a), srgb(0x8a5a36));
    mottled_texture("walnut", [256, 128], move |at| {
        let point = Vec2::new(at.x * 2.0, at.y * 9.0);
        let rings = wave(point.y * 0.8 + 1.5 * fractal_noise(point.extend(0.0), 3));
        let pores = fractal_noise(Vec3::new(at.x * 8.0, at.y * 80.0, 1.0), 2);
        (dark.lerp(light, (0.5 + 0.35 * rings + 0.25 * pores).clamp(0.0, 1.0))).extend(1.0)
    })
}
