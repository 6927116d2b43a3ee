//! The forest's floor, and the things on it.

use std::f32::consts::TAU;

use glam::{Affine3A, Vec2, Vec3, Vec3Swizzles};

use super::build::math::{mix, rotation, sin_cos, smoothstep, turned, wave};
use super::build::{Detail, MeshBuilder, Random, Sheet, fractal_noise, srgb};
use super::forest_paints as paints;
use super::plant;

/// Radius of the ring on which the gnomes walk, in metres.
pub(super) const PATH_RADIUS: f32 = 1.3;
/// Extent of the forest's floor, in metres.
const REACH: f32 = 60.0;

/// Height of the ground, in metres: level where the gnomes walk, hilly further out.
pub(super) fn ground_height(x: f32, z: f32) -> f32 {
    let distance = Vec2::new(x, z).length();
    let hills = smoothstep(2.2, 16.0, distance);
    let broad = fractal_noise(Vec3::new(x * 0.13, 3.7, z * 0.13), 3);
    let bumps = fractal_noise(Vec3::new(x * 0.9, 8.1, z * 0.9), 3);
    let trodden = smoothstep(0.0, 0.35, (distance - PATH_RADIUS).abs());
    hills * (1.6 * broad + 1.1 * smoothstep(5.0, 30.0, distance)) + 0.09 * bumps * mix(0.12, 1.0, trodden)
        - 0.035 * (1.0 - trodden)
}

/// Puts a point on the ground.
pub(super) fn on_ground(x: f32, z: f32) -> Vec3 {
    Vec3::new(x, ground_height(x, z), z)
}

/// Adds the ground: rings that widen outwards, tinted by vegetation.
pub(super) fn ground(builder: &mut MeshBuilder, detail: Detail) {
    let sheet = Sheet::tube(detail.quads(112, 8), detail.quads(64, 4));
    let first = builder.positions.len();
    builder.paint(paints::SOIL).sheet(sheet, |u, v| {
        let (sin, cos) = sin_cos(TAU * u);
        // Inwards, so that the upper side is the outer one.
        let inwards = 1.0 - v;
        let distance = REACH * inwards * (0.1 + 0.9 * inwards * inwards * inwards);
        on_ground(distance * cos, -distance * sin)
    });
    builder.wrap(first, Vec3::xz);
    for index in first..builder.positions.len() {
        builder.tint_vertex(index, soil_color(builder.positions[index]));
    }
}

fn soil_color(at: Vec3) -> Vec3 {
    let patch = fractal_noise(Vec3::new(at.x * 0.6, 1.3, at.z * 0.6), 4);
    let grain = fractal_noise(Vec3::new(at.x * 7.0, 5.0, at.z * 7.0), 2);
    let moss = srgb(0x5c_74_2c).lerp(srgb(0x6f_6a_35), smoothstep(-0.3, 0.4, patch));
    let distance = Vec2::new(at.x, at.z).length();
    let edge = 0.24 + 0.16 * patch;
    let path = smoothstep(edge + 0.2, edge - 0.1, (distance - PATH_RADIUS).abs());
    moss.lerp(srgb(0xa0_85_5c), path) * (1.0 + 0.3 * grain)
}

/// Adds a mossy boulder, sunk a little into the ground.
pub(super) fn rock(builder: &mut MeshBuilder, random: &mut Random, foot: Vec3, size: f32, detail: Detail) {
    let seed = random.direction() * 20.0;
    let stretch = Vec3::new(random.range(0.8, 1.3), random.range(0.55, 0.8), random.range(0.8, 1.2)) * size;
    let turn = turned(random.range(0.0, TAU));
    let first = builder.positions.len();
    let (columns, rows) = (detail.quads(24, 5), detail.quads(14, 4));
    builder.sheet(Sheet::tube(columns, rows), |u, v| {
        let direction = super::build::on_sphere(u, v);
        let lumps = fractal_noise(direction * 1.1 + seed, 4);
        // Flattening some directions gives the broken faces of a rock.
        let broken = 1.0 - 0.3 * fractal_noise(direction * 2.3 - seed, 2).abs();
        turn * (direction * stretch * (broken + 0.35 * lumps)) + foot + Vec3::Y * (0.25 * size)
    });
    for index in first..builder.positions.len() {
        let (position, normal) = (builder.positions[index], builder.normals[index]);
        let moss = smoothstep(0.35, 0.75, normal.y + 0.5 * fractal_noise(position * 6.0, 3));
        let grey = srgb(0x8b_88_80) * (1.0 + 0.35 * fractal_noise(position * 9.0, 3));
        builder.tint_vertex(index, grey.lerp(srgb(0x5f_7a_2c), moss));
    }
}

/// Adds the stump in the middle of the ring, with toadstools on and around it.
pub(super) fn stump(builder: &mut MeshBuilder, random: &mut Random, detail: Detail) {
    const HEIGHT: f32 = 0.3;
    const RADIUS: f32 = 0.34;
    let around = detail.quads(48, 6);
    let outline = |u: f32, part: f32| {
        let flare = smoothstep(0.7, 0.0, part);
        let lobes = 0.5 + 0.5 * wave(5.0 * u + 0.1);
        let (sin, cos) = sin_cos(TAU * u);
        let rough = 1.0 + 0.1 * fractal_noise(Vec3::new(cos * 4.0, part * 2.0, sin * 4.0), 3);
        let radius = RADIUS * rough * (1.0 + flare * flare * (0.3 + 0.6 * lobes));
        let slant = 0.05 * cos;
        Vec3::new(cos * radius, -0.06 + (HEIGHT + 0.06 + slant) * part, -sin * radius)
    };
    builder.paint(paints::BARK).sheet(Sheet::tube(around, detail.quads(14, 2)), outline);
    let first = builder.positions.len();
    builder.paint(paints::CUT_WOOD).sheet(Sheet::tube(around, detail.quads(6, 1)), |u, v| {
        Vec3::new(0.0, HEIGHT, 0.0).lerp(outline(u, 1.0), 1.0 - v)
    });
    builder.wrap(first, |position| position.xz() / (2.2 * RADIUS) + 0.5);
    for (x, y, z, height, radius) in [
        (-0.12, HEIGHT - 0.01, 0.06, 0.26, 0.17),
        (0.13, HEIGHT - 0.01, 0.1, 0.14, 0.085),
        (0.06, HEIGHT - 0.01, -0.16, 0.19, 0.11),
        (0.5, 0.0, 0.2, 0.12, 0.07),
        (-0.5, 0.0, 0.28, 0.17, 0.1),
        (-0.58, 0.0, 0.12, 0.09, 0.05),
    ] {
        let stand = plant::planted(random, Vec3::new(x, y, z), 0.16);
        builder.place(stand, |builder| {
            plant::toadstool(builder, height, radius, 0.55, detail);
        });
    }
}

/// Adds a fallen trunk between two points on the ground.
pub(super) fn log(builder: &mut MeshBuilder, ends: [Vec3; 2], radius: f32, detail: Detail) {
    let axis = (ends[1] - ends[0]).normalize_or(Vec3::X);
    let side = axis.any_orthonormal_vector();
    let other = axis.cross(side);
    let around = detail.quads(28, 5);
    let point = |u: f32, v: f32, part: f32| {
        let (sin, cos) = sin_cos(TAU * u);
        let rough = 1.0 + 0.14 * fractal_noise(Vec3::new(cos * 2.5, v * 7.0, sin * 2.5), 3);
        ends[0].lerp(ends[1], v) + (side * cos + other * sin) * (radius * rough * part)
    };
    builder.paint(paints::BARK).sheet(Sheet::tube(around, detail.quads(22, 2)), |u, v| point(u, v, 1.0));
    builder.paint(paints::CUT_WOOD);
    for end in [0.0, 1.0] {
        let first = builder.positions.len();
        builder.sheet(Sheet::tube(around, 2), |u, v| point(u, end, if end > 0.0 { 1.0 - v } else { v }));
        builder.wrap(first, |position| {
            let offset = position - ends[end as usize];
            Vec2::new(offset.dot(side), offset.dot(other)) / (2.2 * radius) + 0.5
        });
    }
}

/// Adds the gnomes' house, a great toadstool with a door towards +Z, standing at the origin.
pub(super) fn house(builder: &mut MeshBuilder, detail: Detail) {
    let around = detail.quads(56, 8);
    let wall = [(0.84, -0.3), (0.8, 0.0), (0.7, 0.25), (0.62, 0.6), (0.58, 1.0), (0.56, 1.35), (0.52, 1.6)];
    builder.paint(paints::STEM).sheet(Sheet::tube(around, detail.quads(24, 4)), |u, v| {
        let position = v * (wall.len() - 1) as f32;
        let low = (position as usize).min(wall.len() - 2);
        let [from, to] = [Vec2::from(wall[low]), Vec2::from(wall[low + 1])];
        let point = from.lerp(to, position - low as f32);
        let (sin, cos) = sin_cos(TAU * u);
        let bulge = 1.0 + 0.05 * fractal_noise(Vec3::new(cos * 1.5, point.y * 1.5, sin * 1.5), 3);
        Vec3::new(point.x * cos * bulge, point.y, -point.x * sin * bulge)
    });
    let gills = [(0.5, 1.52), (0.9, 1.36), (1.22, 1.22)].map(Vec2::from);
    builder.lathe(&gills, around);
    builder.paint(paints::SPOTTED).sheet(Sheet::tube(around, detail.quads(26, 4)), |u, v| {
        let (sin_v, cos_v) = sin_cos(mix(-0.05, 0.25, v) * TAU);
        let (sin, cos) = sin_cos(TAU * u);
        let across = if v >= 1.0 { 0.0 } else { 1.28 * cos_v };
        let dip = 0.05 * wave(3.0 * u + 0.2) * cos_v * cos_v;
        Vec3::new(across * cos + 0.1 * sin_v, 1.22 + 0.31 + sin_v + dip - 0.02, -across * sin)
    });
    door(builder, detail);
    round_window(builder, Vec3::new(0.44, 0.98, 0.42), 0.6, detail);
    round_window(builder, Vec3::new(-0.47, 0.9, 0.42), -0.75, detail);
    builder.paint(paints::STONE);
    let pot = [(0.1, 0.0), (0.1, 0.42), (0.125, 0.42), (0.125, 0.5), (0.09, 0.5), (0.08, 0.3)].map(Vec2::from);
    builder.place(Affine3A::from_translation(Vec3::new(-0.55, 2.0, -0.2)), |builder| {
        for edge in pot.windows(2) {
            builder.lathe(edge, detail.quads(16, 4));
        }
    });
}

/// An arched door with planks, a frame and a knob, in the wall towards +Z.
fn door(builder: &mut MeshBuilder, detail: Detail) {
    const HALF_WIDTH: f32 = 0.23;
    const SHOULDER: f32 = 0.55;
    let arc = detail.quads(12, 3);
    let arch = |half_width: f32| {
        (0..=arc).map(move |step| {
            let (sin, cos) = sin_cos(0.5 * TAU * step as f32 / arc as f32);
            Vec2::new(half_width * cos, SHOULDER + half_width * sin)
        })
    };
    let outline: Vec<Vec2> =
        [Vec2::new(-HALF_WIDTH, 0.0), Vec2::new(HALF_WIDTH, 0.0)].into_iter().chain(arch(HALF_WIDTH)).collect();
    // The wall leans back: so does the door.
    let lean = rotation(Vec3::X, -0.15);
    builder.place(Affine3A::from_rotation_translation(lean, Vec3::new(0.0, 0.03, 0.735)), |builder| {
        builder.paint(paints::DOOR).prism(&outline, 0.06);
        let mut frame: Vec<Vec3> = vec![Vec3::new(HALF_WIDTH + 0.02, -0.02, 0.05)];
        frame.extend(arch(HALF_WIDTH + 0.02).map(|point| point.extend(0.05)));
        frame.push(Vec3::new(-HALF_WIDTH - 0.02, -0.02, 0.05));
        builder.paint(paints::FRAME).tube(&frame, |_| 0.04, detail.quads(10, 4));
        builder.paint(paints::BRASS).sphere(
            Vec3::new(0.16, 0.4, 0.085),
            0.024,
            detail.quads(14, 4),
            detail.quads(8, 3),
        );
    });
    builder.paint(paints::STONE).place(Affine3A::from_translation(Vec3::new(0.0, 0.0, 0.95)), |builder| {
        let step = [(0.36, -0.1), (0.36, 0.03), (0.33, 0.05), (0.33, 0.05), (0.0, 0.05)].map(Vec2::from);
        builder.lathe(&step, detail.quads(28, 5));
    });
}

/// A lit window at `middle` that faces `radians` to the left of +Z.
fn round_window(builder: &mut MeshBuilder, middle: Vec3, radians: f32, detail: Detail) {
    const RADIUS: f32 = 0.13;
    let turn = turned(radians) * rotation(Vec3::X, -0.08);
    builder.place(Affine3A::from_rotation_translation(turn, middle), |builder| {
        let around = detail.quads(24, 6);
        builder.paint(paints::WINDOW).sheet(Sheet::tube(around, 1), |u, v| {
            let (sin, cos) = sin_cos(TAU * u);
            Vec3::new(cos, sin, 0.0) * (RADIUS * (1.0 - v)) + Vec3::Z * 0.03
        });
        builder.paint(paints::FRAME).ring(Vec3::Z * 0.03, RADIUS, [0.028; 2], [detail.quads(8, 3), around]);
        for [from, to] in [[Vec3::X, Vec3::NEG_X], [Vec3::Y, Vec3::NEG_Y]] {
            let bar = [from, to].map(|end| end * RADIUS + Vec3::Z * 0.035);
            builder.tube(&bar, |_| 0.011, detail.quads(6, 3));
        }
    });
}
