//! A sheet that falls over a ball, which then turns under it.

mod drape;

use std::sync::LazyLock;

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;

use self::drape::Drape;
use super::build::math::{mix, smoothstep, turned};
use super::build::{MeshBuilder, Paint, Sheet, color_texture, fractal_noise, mottled_texture, noise, srgb};
use super::{DemoScene, Moment, Pose, studio};
use umbrage_scene::Texture;

/// The cloth's motion doesn't depend on its resolution in a scene, so it is simulated once for all scenes.
static DRAPE: LazyLock<Drape> = LazyLock::new(Drape::simulate);

pub(crate) const SCENE: DemoScene = DemoScene {
    name: "cloth",
    about: "a sheet falls over a ball that turns",
    triangles: 92_000,
    seconds: drape::SECONDS,
    still_seconds: 2.5,
    open,
};

const SILK: Paint = Paint::textured("silk", weave, [1.0; 2], 0.55);
const BRASS: Paint = Paint::metal("ball", || srgb(0xe0b878), 0.18);
const PLASTER: Paint = Paint::textured("floor", plaster, [9.0; 2], 0.75);

/// The ball's share of the triangles.
const BALL_SHARE: f32 = 0.06;

fn open(triangles: usize) -> Pose {
    let ball_rows = ((triangles as f32 * BALL_SHARE / 4.0).sqrt() as u32).max(3);
    let ball_triangles = 4 * ball_rows * (ball_rows - 1);
    let columns = studio::backdrop_columns(triangles);
    let sheet = Sheet::of_triangles(
        triangles.saturating_sub(ball_triangles as usize + studio::backdrop_triangles(columns)),
        1.0,
    );

    // The cloth's vertices come first.
    let cloth = 0..sheet.vertices();
    let mut builder = MeshBuilder::new();
    builder.paint(SILK).sheet(sheet, |u, v| Vec3::new(u, 0.0, -v));
    builder.paint(BRASS).sphere(drape::BALL_CENTER, drape::BALL_RADIUS, 2 * ball_rows, ball_rows);
    let ball = cloth.end..builder.positions.len();
    studio::backdrop(builder.paint(PLASTER), 11.0, 9.0, columns);
    let still = builder.finish();

    Box::new(move |Moment { seconds, .. }, frame| {
        frame.copy_surfaces(&still);
        DRAPE.write_sheet(seconds, sheet, &mut frame.positions[cloth.clone()]);
        sheet.write_normals(&frame.positions[cloth.clone()], &mut frame.normals[cloth.clone()]);

        let spin = turned(drape::ball_turn_radians(seconds));
        let vertices = frame.positions[ball.clone()].par_iter_mut().zip(&mut frame.normals[ball.clone()]);
        vertices.each(|(position, normal)| {
            *position = drape::BALL_CENTER + spin * (*position - drape::BALL_CENTER);
            *normal = spin * *normal;
        });

        let approach = smoothstep(0.0, 1.0, seconds / drape::SECONDS);
        let eye = Vec3::new(mix(-2.6, -1.4, approach), mix(2.9, 2.3, approach), 5.4);
        studio::look(frame, "front", eye, Vec3::new(0.0, mix(0.95, 0.62, approach), 0.0), 0.33);
        studio::light(frame, "key", Vec3::new(3.6, 6.0, 3.4), drape::BALL_CENTER, srgb(0xfff2e0), 0.95);
        studio::light(frame, "rim", Vec3::new(-5.0, 3.5, -3.0), drape::BALL_CENTER, srgb(0xcfe0ff), 0.3);
    })
}

/// Teal silk with golden bands along its edges and a small golden figure all over.
fn weave() -> Texture {
    let (teal, gold) = (srgb(0x0f5c63), srgb(0xd9a441));
    color_texture("silk", [1024; 2], move |at| {
        let to_edge = |at: Vec2| at.x.min(at.y).min(1.0 - at.x).min(1.0 - at.y);
        let band = |from: f32, to: f32| to_edge(at) > from && to_edge(at) < to;
        let in_cell = (at * 16.0).fract() - 0.5;
        // Decided at the middle of its cell, so that no figure is cut off.
        let figure = to_edge(at - in_cell / 16.0) > 0.1 && in_cell.x.abs() + in_cell.y.abs() < 0.11;
        let thread = 1.0 + 0.10 * noise((at * 420.0).extend(0.0));
        let color = if band(0.02, 0.035) || band(0.045, 0.075) || figure { gold } else { teal };
        (color * thread).extend(1.0)
    })
}

/// Warm grey plaster.
fn plaster() -> Texture {
    let color = srgb(0xcfc6ba);
    mottled_texture("plaster", [256; 2], move |at| {
        (color * (1.0 + 0.06 * fractal_noise((at * 8.0).extend(0.5), 4))).extend(1.0)
    })
}
