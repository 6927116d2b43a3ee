//! Chairs, tables, lamps, bookcases, chandeliers and a globe. Each stands on the origin of its own space.

use std::f32::consts::TAU;

use glam::{Affine3A, Vec2, Vec3};

use super::build::math::{mix, sin_cos, smoothstep, turned, wave};
use super::build::{Detail, MeshBuilder, Paint, Random, Sheet, fractal_noise, srgb};
use super::hall_paints as paints;

/// A turned leg or baluster from the origin to `height`.
fn turned_leg(builder: &mut MeshBuilder, foot: Vec3, height: f32, thickness: f32, detail: Detail) {
    let outline = [
        (0.6, 0.0),
        (0.75, 0.04),
        (0.5, 0.09),
        (0.62, 0.2),
        (0.95, 0.42),
        (0.7, 0.58),
        (0.5, 0.64),
        (0.9, 0.68),
        (0.9, 0.72),
        (0.55, 0.76),
        (0.8, 0.84),
        (1.0, 0.88),
        (1.0, 1.0),
    ]
    .map(|(out, up)| Vec2::new(out * thickness, up * height));
    let kept = detail.quads(outline.len() as u32, 3).min(outline.len() as u32) as usize;
    let outline: Vec<Vec2> = (0..kept).map(|point| outline[point * (outline.len() - 1) / (kept - 1)]).collect();
    builder.place(Affine3A::from_translation(foot), |builder| {
        builder.lathe(&outline, detail.quads(12, 3));
    });
}

fn board(builder: &mut MeshBuilder, center: Vec3, half_size: Vec3, detail: Detail) {
    let radius = half_size.min_element().min(0.012);
    if detail.quads(1, 0) > 0 {
        builder.place(Affine3A::from_translation(center), |builder| {
            builder.rounded_cuboid(half_size, radius, detail.quads(1, 1).min(4));
        });
    } else {
        builder.cuboid(center - half_size, center + half_size);
    }
}

/// A chair that faces −Z.
pub(super) fn chair(builder: &mut MeshBuilder, detail: Detail) {
    const SEAT: f32 = 0.46;
    builder.paint(paints::WOOD);
    for x in [-0.2, 0.2] {
        turned_leg(builder, Vec3::new(x, 0.0, -0.19), SEAT - 0.03, 0.028, detail);
        let back = [(0.2, 0.0), (0.2, SEAT), (0.23, 0.8), (0.27, 1.06)].map(|(z, y)| Vec3::new(x, y, z));
        builder.tube(&back, |part| mix(0.026, 0.02, part), detail.quads(8, 3));
        builder.sphere(Vec3::new(x, 1.08, 0.272), 0.028, detail.quads(8, 3), detail.quads(6, 2));
        let rail = [Vec3::new(x, 0.14, -0.19), Vec3::new(x, 0.14, 0.2)];
        builder.tube(&rail, |_| 0.012, detail.quads(6, 3));
    }
    let stretcher = [Vec3::new(-0.2, 0.14, 0.0), Vec3::new(0.2, 0.14, 0.0)];
    builder.tube(&stretcher, |_| 0.012, detail.quads(6, 3));
    board(builder, Vec3::new(0.0, SEAT - 0.02, 0.0), Vec3::new(0.235, 0.022, 0.225), detail);
    let curved = |y: f32, half_height: f32, builder: &mut MeshBuilder| {
        builder.sheet(Sheet::ring(detail.quads(6, 4), detail.quads(12, 3)), |u, v| {
            // A flat closed loop: out along the front of the rail and back along its rear.
            let (sin_v, cos_v) = sin_cos(TAU * v);
            let (sin_u, cos_u) = sin_cos(TAU * u);
            let z = 0.25 + 0.11 * (y - 0.8) + 0.03 * cos_v * cos_v;
            let thickness = 0.012 * cos_u;
            Vec3::new((0.2 + thickness * 0.3) * cos_v, y + half_height * sin_u, z + (0.006 + thickness) * -sin_v)
        });
    };
    curved(0.98, 0.05, builder);
    curved(0.72, 0.025, builder);
    for slat in -2..=2 {
        let x = 0.065 * slat as f32;
        let rod = [Vec3::new(x, 0.73, 0.226), Vec3::new(x, 0.96, 0.252)];
        builder.tube(&rod, |_| 0.009, detail.quads(6, 3));
    }
    builder.paint(paints::LEATHER);
    builder.place(Affine3A::from_translation(Vec3::new(0.0, SEAT + 0.018, -0.005)), |builder| {
        builder.rounded_cuboid(Vec3::new(0.205, 0.028, 0.195), 0.027, detail.quads(2, 1));
    });
}

/// A table, long along z.
pub(super) fn table(builder: &mut MeshBuilder, half_length: f32, detail: Detail) {
    const HEIGHT: f32 = 0.77;
    const HALF_WIDTH: f32 = 0.55;
    builder.paint(paints::WOOD);
    if !detail.is_ornate() {
        builder.cuboid(Vec3::new(-HALF_WIDTH, 0.0, -half_length), Vec3::new(HALF_WIDTH, HEIGHT, half_length));
        return;
    }
    board(builder, Vec3::new(0.0, HEIGHT - 0.022, 0.0), Vec3::new(HALF_WIDTH, 0.022, half_length), detail);
    board(builder, Vec3::new(0.0, HEIGHT - 0.09, 0.0), Vec3::new(HALF_WIDTH - 0.06, 0.045, half_length - 0.1), detail);
    for z in [-1.0, 0.0, 1.0] {
        for x in [-1.0, 1.0] {
            let foot = Vec3::new(x * (HALF_WIDTH - 0.1), 0.0, z * (half_length - 0.16));
            turned_leg(builder, foot, HEIGHT - 0.1, 0.06, detail);
        }
        board(builder, Vec3::new(0.0, 0.1, z * (half_length - 0.16)), Vec3::new(HALF_WIDTH - 0.1, 0.03, 0.035), detail);
    }
}

/// A reading lamp with a green shade, for a table's top.
pub(super) fn lamp(builder: &mut MeshBuilder, detail: Detail) {
    let around = detail.quads(20, 4);
    let foot = [(0.085, 0.0), (0.085, 0.012), (0.07, 0.024), (0.03, 0.034), (0.012, 0.06), (0.012, 0.2), (0.02, 0.21)];
    builder.paint(paints::BRASS).lathe(&foot.map(Vec2::from), around);
    let neck: Vec<Vec3> = (0..=6)
        .map(|row| {
            let (sin, cos) = sin_cos(TAU * 0.25 * row as f32 / 6.0);
            Vec3::new(0.0, 0.21 + 0.17 * sin, 0.05 * (1.0 - cos))
        })
        .collect();
    builder.tube(&neck, |_| 0.009, detail.quads(6, 3));
    builder.paint(paints::SHADE).sheet(Sheet::open(detail.quads(10, 2), detail.quads(12, 2)), |u, v| {
        let (sin, cos) = sin_cos(TAU * 0.5 * (1.0 - u));
        let taper = 1.0 - 0.25 * (2.0 * v - 1.0) * (2.0 * v - 1.0);
        Vec3::new(0.34 * (v - 0.5), 0.34 + 0.09 * sin * taper, 0.05 + 0.085 * cos)
    });
    builder.paint(paints::BRASS);
    builder.sphere(Vec3::new(0.0, 0.44, 0.05), 0.014, detail.quads(10, 3), detail.quads(6, 2));
}

/// An open book, lying.
pub(super) fn open_book(builder: &mut MeshBuilder, detail: Detail) {
    builder.paint(paints::PAPER).sheet(Sheet::open(2 * detail.quads(7, 1), 1), |u, v| {
        let x = (2.0 * u - 1.0).abs();
        let swell = 0.034 * (x * (1.0 - x)).sqrt() * 2.0 * (1.0 - 0.6 * x) + 0.012;
        Vec3::new((u - 0.5) * 0.4, swell, (0.5 - v) * 0.28)
    });
    builder.paint(paints::CLOTH).tint(srgb(0x6a_2a_22));
    builder.cuboid(Vec3::new(-0.21, 0.0, -0.15), Vec3::new(0.21, 0.008, 0.15));
}

/// Length of a bookcase along x, in metres.
pub(super) const CASE_LENGTH: f32 = 2.7;
const CASE_HALF_DEPTH: f32 = 0.36;
/// Heights of a bookcase's boards.
const SHELVES: [f32; 7] = [0.2, 0.62, 1.02, 1.4, 1.77, 2.13, 2.48];

/// Shelves for books of a bookcase, on both its sides.
pub(super) const SHELVES_IN_CASE: u32 = 2 * (SHELVES.len() as u32 - 1);

/// A bookcase without books, open towards +Z and −Z.
pub(super) fn bookcase(builder: &mut MeshBuilder, detail: Detail) {
    let half = 0.5 * CASE_LENGTH;
    builder.paint(paints::WOOD);
    if !detail.is_ornate() {
        builder.cuboid(Vec3::new(-half, 0.0, -0.05), Vec3::new(half, 2.7, 0.05));
        return;
    }
    for x in [-half, half] {
        board(builder, Vec3::new(x, 1.32, 0.0), Vec3::new(0.035, 1.32, CASE_HALF_DEPTH + 0.02), detail);
        turned_leg(builder, Vec3::new(x, 2.6, 0.0), 0.3, 0.07, detail);
        builder.sphere(Vec3::new(x, 2.95, 0.0), 0.085, detail.quads(14, 4), detail.quads(9, 3));
    }
    for height in SHELVES {
        builder.cuboid(Vec3::new(-half, height - 0.03, -CASE_HALF_DEPTH), Vec3::new(half, height, CASE_HALF_DEPTH));
    }
    builder.cuboid(Vec3::new(-half, 0.0, -0.02), Vec3::new(half, 2.48, 0.02));
    board(builder, Vec3::new(0.0, 0.09, 0.0), Vec3::new(half + 0.05, 0.09, CASE_HALF_DEPTH + 0.05), detail);
    board(builder, Vec3::new(0.0, 2.56, 0.0), Vec3::new(half + 0.07, 0.05, CASE_HALF_DEPTH + 0.07), detail);
    board(builder, Vec3::new(0.0, 2.64, 0.0), Vec3::new(half + 0.02, 0.035, CASE_HALF_DEPTH + 0.02), detail);
}

/// Triangles of a book whose back is rounded in `bends` steps.
pub(super) fn book_triangles(bends: u32) -> usize {
    3 * bends as usize + 5
}

/// Fills shelf number `shelf`, below [`SHELVES_IN_CASE`], of a bookcase with `count` books.
pub(super) fn books(builder: &mut MeshBuilder, random: &mut Random, shelf: u32, count: u32, bends: u32) {
    const COVERS: [u32; 12] = [
        0x7a_2e_24, 0x2f_4a_3a, 0x2c_3e_5c, 0x8a_6a_3a, 0x5a_3a_26, 0xa8_8a_5c, 0x40_2a_3c, 0x6e_1f_1f, 0x3a_5a_5e,
        0xc0_a8_7c, 0x24_2a_2e, 0x93_5a_2c,
    ];
    let (level, front) = ((shelf / 2) as usize, if shelf.is_multiple_of(2) { 1.0 } else { -1.0 });
    let floor = SHELVES[level.min(SHELVES.len() - 2)];
    let room = SHELVES[level.min(SHELVES.len() - 2) + 1] - floor - 0.03;
    let width = CASE_LENGTH - 0.12;
    let usual = (width / count.max(1) as f32).min(0.11);
    let mut at = -0.5 * width;
    let mut cover = srgb(COVERS[0]);
    let mut run = 0;
    let mut tall = 0.8;
    for book in 0..count {
        if run == 0 {
            // Works in several volumes stand together.
            run = if random.unit() < 0.3 { 3 + random.below(6) } else { 1 };
            cover = srgb(COVERS[random.below(COVERS.len() as u32) as usize]) * random.range(0.75, 1.25);
            tall = random.range(0.66, 0.95);
        }
        run -= 1;
        // The remaining books share the remaining width.
        let fair = ((0.5 * width - at) / (count - book) as f32).min(usual * 1.5);
        let thickness = if book + 1 == count { fair } else { fair * random.range(0.65, 1.35) };
        let size = Vec3::new(0.94 * thickness, room * tall * random.range(0.98, 1.0), random.range(0.19, 0.26));
        builder.paint(paints::CLOTH).tint(cover);
        let middle = Vec3::new(front * (at + 0.5 * thickness), floor, front * (CASE_HALF_DEPTH - 0.03));
        one_book(builder, middle, size, front, bends);
        at += thickness;
    }
}

/// A closed book whose back, rounded in `bends` steps, is above `foot` and looks along z towards `front`.
fn one_book(builder: &mut MeshBuilder, foot: Vec3, size: Vec3, front: f32, bends: u32) {
    let [x, z] = [Vec3::X * (0.5 * size.x * front), Vec3::Z * front];
    let up = Vec3::Y * size.y;
    let first = builder.positions.len() as u32;
    let bend = |step: u32| {
        let across = 2.0 * step as f32 / bends as f32 - 1.0;
        let round = 0.35 * size.x.min(0.05);
        (foot + x * across + z * (round * (1.0 - across * across) - round), (x * across * 1.2 + z * size.x).normalize())
    };
    for step in 0..=bends {
        let (position, normal) = bend(step);
        builder.vertex(position, normal, Vec2::new(0.0, 1.0));
        builder.vertex(position + up, normal, Vec2::new(0.0, 0.0));
    }
    for step in 0..bends {
        let corner = first + 2 * step;
        builder.triangle([corner, corner + 2, corner + 3]);
        builder.triangle([corner, corner + 3, corner + 1]);
    }
    let back = -z * size.z;
    let [left, right] = [bend(0).0, bend(bends).0];
    builder.quad([left + back, left, left + up, left + back + up], Vec2::ONE);
    builder.quad([right, right + back, right + back + up, right + up], Vec2::ONE);
    // The rear and the lower side are never seen.
    builder.paint(paints::PAPER);
    let rear = builder.vertex(left + back + up, Vec3::Y, Vec2::ZERO);
    for step in 0..=bends {
        builder.vertex(bend(step).0 + up, Vec3::Y, Vec2::ZERO);
    }
    builder.vertex(right + back + up, Vec3::Y, Vec2::ZERO);
    for step in 1..=bends + 1 {
        builder.triangle([rear, rear + step, rear + step + 1]);
    }
}

/// A chandelier that hangs from the origin, its ring `drop` below: a chain, a body, arms, candles and flames.
pub(super) fn chandelier(builder: &mut MeshBuilder, drop: f32, detail: Detail) {
    const RADIUS: f32 = 1.15;
    if !detail.is_ornate() {
        builder.paint(paints::BRASS).place(Affine3A::from_translation(Vec3::NEG_Y * drop), |builder| {
            builder.cylinder(RADIUS, 0.1, detail.quads(14, 6));
        });
        return;
    }
    let around = detail.quads(14, 3);
    builder.paint(paints::IRON);
    let links = detail.things(((drop - 1.2) / 0.11) as u32).max(1);
    let spacing = (drop - 1.2) / links as f32;
    for link in 0..links {
        let middle = Vec3::NEG_Y * (spacing * (link as f32 + 0.5));
        let turn = turned(TAU * 0.25 * (link % 2) as f32);
        builder.sheet(Sheet::ring(detail.quads(6, 3), detail.quads(12, 4)), |u, v| {
            let (sin_u, cos_u) = sin_cos(TAU * u);
            let (sin_v, cos_v) = sin_cos(TAU * v);
            let out = Vec3::new(0.034 * cos_v, 0.62 * spacing * sin_v, 0.0);
            let away = Vec3::new(cos_v, sin_v, 0.0);
            middle + turn * (out + away * (0.011 * cos_u) + Vec3::Z * (-0.011 * sin_u))
        });
    }
    builder.paint(paints::BRASS);
    let body = [
        (0.0, -0.35),
        (0.03, -0.33),
        (0.05, -0.28),
        (0.02, -0.24),
        (0.09, -0.18),
        (0.15, -0.08),
        (0.16, 0.0),
        (0.1, 0.08),
        (0.04, 0.14),
        (0.05, 0.3),
        (0.09, 0.4),
        (0.05, 0.5),
        (0.025, 0.6),
        (0.06, 0.72),
        (0.07, 0.8),
        (0.03, 0.9),
        (0.02, 1.2),
    ]
    .map(|(out, up)| Vec2::new(out, up - drop));
    builder.lathe(&body, detail.quads(24, 4));
    let ring = |u: f32, v: f32| {
        let (sin_u, cos_u) = sin_cos(TAU * u);
        let (sin_v, cos_v) = sin_cos(TAU * v);
        let out = RADIUS + 0.03 * cos_u;
        Vec3::new(out * cos_v, 0.05 * sin_u - drop, out * sin_v)
    };
    builder.sheet(Sheet::ring(detail.quads(10, 3), detail.quads(72, 6)), ring);
    let arms = detail.things(8).max(3);
    for arm in 0..arms {
        let (sin, cos) = sin_cos(TAU * arm as f32 / arms as f32);
        let out = Vec3::new(cos, 0.0, sin);
        let rows = detail.quads(14, 2);
        let path: Vec<Vec3> = (0..=rows)
            .map(|row| {
                let part = row as f32 / rows as f32;
                out * mix(0.12, RADIUS, part) + Vec3::Y * (-drop - 0.12 * wave(part) - 0.05 * (1.0 - part))
            })
            .collect();
        builder.paint(paints::BRASS).tube(&path, |_| 0.018, detail.quads(8, 3));
        let stay = [out * RADIUS - Vec3::Y * drop, Vec3::Y * (0.85 - drop)];
        builder.paint(paints::IRON).tube(&stay, |_| 0.006, 3);
    }
    let candles = detail.things(16).max(3);
    for candle in 0..candles {
        let (sin, cos) = sin_cos(TAU * (candle as f32 + 0.5) / candles as f32);
        let foot = Vec3::new(cos * RADIUS, 0.04 - drop, sin * RADIUS);
        builder.place(Affine3A::from_translation(foot), |builder| {
            let cup = [(0.012, 0.0), (0.02, 0.02), (0.06, 0.035), (0.075, 0.055), (0.068, 0.056), (0.03, 0.045)]
                .map(Vec2::from);
            builder.paint(paints::BRASS).lathe(&cup, around);
            let stick = [(0.026, 0.045), (0.024, 0.2), (0.018, 0.212), (0.0, 0.208)].map(Vec2::from);
            builder.paint(paints::WAX).lathe(&stick, around);
            let fire = [(0.0, 0.212), (0.014, 0.232), (0.016, 0.25), (0.009, 0.28), (0.0, 0.31)].map(Vec2::from);
            builder.paint(paints::FLAME).lathe(&fire, detail.quads(10, 3));
        });
    }
}

/// Height of the middle of the globe above the floor.
pub(super) const GLOBE_HEIGHT: f32 = 0.98;

/// The stand of a globe: three turned legs and a horizon ring.
pub(super) fn globe_stand(builder: &mut MeshBuilder, detail: Detail) {
    builder.paint(paints::WOOD);
    for leg in 0..3 {
        let (sin, cos) = sin_cos(TAU * leg as f32 / 3.0);
        turned_leg(builder, Vec3::new(cos * 0.47, 0.0, sin * 0.47), GLOBE_HEIGHT - 0.03, 0.05, detail);
        let rail = [Vec3::new(cos * 0.47, 0.2, sin * 0.47), Vec3::new(0.0, 0.2, 0.0)];
        builder.tube(&rail, |_| 0.022, detail.quads(8, 3));
    }
    let around = detail.quads(48, 6);
    let horizon = [(0.44, -0.03), (0.55, -0.03), (0.56, 0.0), (0.55, 0.02), (0.55, 0.02), (0.44, 0.02), (0.44, 0.02)]
        .map(|(out, up)| Vec2::new(out, GLOBE_HEIGHT + up));
    builder.lathe(&horizon, around).lathe(&[horizon[5], horizon[0]], around);
    builder.paint(paints::BRASS);
    builder.ring(Vec3::Y * GLOBE_HEIGHT, 0.425, [0.012, 0.014], [detail.quads(6, 3), around]);
}

/// The globe itself around the origin; it turns about y.
pub(super) fn globe(builder: &mut MeshBuilder, detail: Detail) {
    builder.paint(paints::GLOBE).sphere(Vec3::ZERO, 0.4, detail.quads(56, 6), detail.quads(30, 4));
    builder.paint(paints::BRASS);
    for side in [-1.0, 1.0] {
        builder.sphere(Vec3::Y * (0.405 * side), 0.02, detail.quads(10, 3), detail.quads(6, 2));
    }
}

/// A map of a world that never was: the colour at (u, v) of the globe.
pub(super) fn world_map(at: Vec2) -> Vec3 {
    let point = super::build::on_sphere(at.x, 1.0 - at.y);
    let land = fractal_noise(point * 1.7 + Vec3::new(3.1, 9.7, 1.3), 5) + 0.06;
    let lines = [at.x * 24.0, at.y * 12.0].map(|line| (line - line.round()).abs() < 0.02);
    let sea = srgb(0x8f_a8_9c).lerp(srgb(0x6a_8c_8c), smoothstep(0.0, -0.3, land));
    let shore = srgb(0xc8_a8_68).lerp(srgb(0x9a_86_4a), smoothstep(0.02, 0.2, land));
    let color = if land > 0.0 { shore } else { sea };
    let coast = smoothstep(0.012, 0.0, land.abs());
    color.lerp(srgb(0x4a_34_20), 0.7 * coast + if lines[0] || lines[1] { 0.25 } else { 0.0 })
}

/// A baluster of a rail.
pub(super) fn baluster(builder: &mut MeshBuilder, foot: Vec3, height: f32, paint: Paint, detail: Detail) {
    builder.paint(paint);
    turned_leg(builder, foot, height, 0.07, detail);
}
