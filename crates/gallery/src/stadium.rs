use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Vec2, Vec3, Vec3Swizzles, Vec4};

use super::build::math::{cos, mix, pow, rotation, sin_cos, smoothstep, turned, wave};
use super::build::{Detail, MeshBuilder, Paint, Sheet, color_texture, fractal_noise, srgb};
use super::{DemoScene, Moment, Pose, studio, trophy};
use umbrage_scene::{Frame, Texture};

pub(crate) const SCENE: DemoScene = DemoScene {
    name: "stadium",
    about: "a finely wrought cup in the middle of a vast arena, seen from near and far",
    triangles: 200_000,
    seconds: 24.0,
    still_seconds: 1.5,
    open,
};

/// Half the length and the width of the ground inside the stands, in metres.
const GROUND: Vec2 = Vec2::new(70.0, 50.0);
/// Height of the plinth's top above the grass.
const PLINTH_TOP: f32 = 1.62;
/// Highest and lowest points of the profile of the stands, (distance beyond the ground's edge, height), and steps.
const TIERS: [([f32; 2], [f32; 2], u32); 2] = [([1.0, 1.2], [18.0, 8.2], 18), ([20.0, 12.5], [38.0, 25.0], 22)];

const GRASS: Paint = Paint::textured("grass", grass, [140.0; 2], 0.95);
const TRACK: Paint = Paint::textured("track", track, [1.0; 2], 0.9);
const CONCRETE: Paint = Paint::dull("concrete", 0xc9_c5_bc, 0.85);
const SEATS: Paint = Paint::textured("seats", seats, [1.0 / 40.0, 1.0], 0.5);
const ROOF: Paint = Paint::dull("roof", 0xf1_f0_ec, 0.5);
const STEEL: Paint = Paint::dull("steel", 0xe4_e6_e8, 0.35);
const LAMPS: Paint = Paint::glowing("lamps", 0xff_ff_ff, 1.6, 0.3);
const MARBLE: Paint = Paint::textured("marble", || marble(0xe9_e4_da, 0x8d_86_7c), [0.125, 0.5], 0.25);
const DARK_MARBLE: Paint = Paint::textured("dark marble", || marble(0x12_2a_22, 0x9f_b8_a6), [0.5; 2], 0.12);
const GOLD: Paint = Paint::metal("gold", || Vec3::new(1.0, 0.64, 0.22), 0.2);
const BANNER: Paint = Paint::textured("banner", banner, [1.0 / 24.0, 1.0], 0.6);

fn open(triangles: usize) -> Pose {
    let detail = Detail::for_triangles(triangles, SCENE.triangles);
    let mut builder = detail.within(triangles * 2 / 5, arena, |arena| arena.triangles.len());
    let first_of_cup = builder.positions.len();
    let left = triangles.saturating_sub(builder.triangles.len());
    builder.paint(GOLD);
    builder.place(Affine3A::from_translation(Vec3::Y * PLINTH_TOP), |builder| trophy::cup(builder, left));
    let still = builder.finish();

    Box::new(move |Moment { part, .. }, frame| {
        frame.copy_surfaces(&still);
        studio::turn(frame, first_of_cup..still.positions.len(), Vec3::ZERO, turned(TAU * part));
        flight(part, frame);
        studio::sun(frame, Vec3::new(0.62, -0.66, -0.42), srgb(0xff_f0_dc), 1.15);
    })
}

/// From beside the cup up to the stands and back: the distance changes a hundredfold, evenly in its logarithm.
fn flight(part: f32, frame: &mut Frame) {
    let away = smoothstep(0.1, 0.5, part) * smoothstep(0.96, 0.56, part);
    let distance = pow(2.0, mix(0.55, 6.12, away));
    let (sin, cos) = sin_cos(TAU * (0.15 + part));
    let rise = mix(-0.06, 0.3, smoothstep(0.0, 0.8, away)) + 0.35 * away * (1.0 - away);
    let target = Vec3::Y * mix(PLINTH_TOP + 0.36, PLINTH_TOP, away);
    let eye = target + Vec3::new(cos * 1.0, rise, sin * 0.85) * distance;
    studio::look(frame, "flight", eye, target + Vec3::Y * (0.02 * distance), mix(0.36, 0.5, away));
}

/// Everything except the cup.
fn arena(detail: Detail) -> MeshBuilder {
    let mut builder = MeshBuilder::new();
    let around = detail.quads(160, 8);
    ground(&mut builder, detail);
    for (low, high, steps) in TIERS {
        tier(&mut builder, low, high, detail.quads(steps, 1), around);
    }
    walls_and_roof(&mut builder, around);
    let masts = detail.things(40);
    for mast in 0..masts {
        let angle = TAU * (mast as f32 + 0.5) / masts as f32;
        truss(&mut builder, angle, detail);
    }
    for corner in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
        floodlight(&mut builder, Vec2::from(corner), detail);
    }
    plinth(&mut builder, detail);
    builder
}

/// The point at `angle` of the oval `out` metres beyond the ground's edge.
fn oval(angle: f32, out: f32, height: f32) -> Vec3 {
    let (sin, cos) = sin_cos(angle);
    Vec3::new((GROUND.x + out) * cos, height, -(GROUND.y + out) * sin)
}

/// Adds a strip around the oval between two points of its profile (distance beyond the edge, height); its outer side
/// is on the left of the way from the first to the second, seen along the strip.
fn strip(builder: &mut MeshBuilder, from: [f32; 2], to: [f32; 2], around: u32) {
    builder.sheet(Sheet::tube(around, 1), |u, v| oval(TAU * u, mix(from[0], to[0], v), mix(from[1], to[1], v)));
}

fn ground(builder: &mut MeshBuilder, detail: Detail) {
    let around = detail.quads(96, 8);
    builder.paint(CONCRETE).floor(Vec3::Y * -0.06, Vec2::new(420.0, 380.0), [2, 2]);
    builder.paint(TRACK);
    strip(builder, [-1.0, 0.0], [-11.0, 0.0], around);
    builder.paint(CONCRETE);
    strip(builder, [1.0, -0.02], [-1.0, -0.02], around);
    let first = builder.positions.len();
    builder.paint(GRASS).sheet(Sheet::tube(around, 2), |u, v| {
        let edge = oval(TAU * u, -11.0, 0.0);
        if v >= 1.0 { Vec3::ZERO } else { edge * (1.0 - v) }
    });
    builder.wrap(first, Vec3::xz);
}

/// Adds a tier of steps, from its foot to its back, with a parapet at its foot.
fn tier(builder: &mut MeshBuilder, low: [f32; 2], high: [f32; 2], steps: u32, around: u32) {
    let at = |step: u32| {
        let part = step as f32 / steps as f32;
        [mix(low[0], high[0], part), mix(low[1], high[1], part)]
    };
    for step in (0..steps).rev() {
        let [[front, lower], [back, upper]] = [at(step), at(step + 1)];
        builder.paint(SEATS);
        strip(builder, [back, upper], [back, lower], around);
        builder.paint(CONCRETE);
        strip(builder, [back, lower], [front, lower], around);
    }
    builder.paint(BANNER);
    strip(builder, [low[0] - 0.3, low[1] + 0.9], [low[0] - 0.3, low[1] - 1.3], around);
    builder.paint(CONCRETE);
    strip(builder, [low[0], low[1] + 0.9], [low[0] - 0.3, low[1] + 0.9], around);
    strip(builder, [low[0], low[1]], [low[0], low[1] + 0.9], around);
}

fn walls_and_roof(builder: &mut MeshBuilder, around: u32) {
    builder.paint(CONCRETE);
    // Between the tiers, behind the upper one, and the outside.
    strip(builder, [19.7, 11.4], [19.7, 8.2], around);
    strip(builder, [20.0, 8.2], [18.0, 8.2], around);
    strip(builder, [18.0, 8.2], [18.0, 8.21], around);
    strip(builder, [38.0, 31.5], [38.0, 25.0], around);
    strip(builder, [40.0, 0.0], [40.0, 31.5], around);
    builder.paint(ROOF);
    let inner = [14.0, 33.5];
    strip(builder, [41.5, 31.5], [41.5, 32.3], around);
    strip(builder, [41.5, 32.3], [inner[0], inner[1] + 0.5], around);
    strip(builder, [inner[0], inner[1] + 0.5], [inner[0], inner[1]], around);
    strip(builder, inner, [41.5, 31.5], around);
}

/// Adds one of the arched beams that carry the roof.
fn truss(builder: &mut MeshBuilder, angle: f32, detail: Detail) {
    let rows = detail.quads(10, 2);
    let path: Vec<Vec3> = (0..=rows)
        .map(|row| {
            let part = row as f32 / rows as f32;
            oval(angle, mix(42.5, 13.0, part), 32.6 + 7.5 * part * (1.0 - part) + 1.4 * part)
        })
        .collect();
    builder.paint(STEEL).tube(&path, |_| 0.4, detail.quads(8, 3));
    let mast = [oval(angle, 42.5, 0.0), oval(angle, 42.5, 33.0)];
    builder.tube(&mast, |_| 0.55, detail.quads(10, 3));
}

fn floodlight(builder: &mut MeshBuilder, corner: Vec2, detail: Detail) {
    let foot = Vec3::new(corner.x * 92.0, 0.0, corner.y * 76.0);
    let top = 58.0;
    builder.paint(STEEL).place(Affine3A::from_translation(foot), |builder| {
        builder.cone(1.6, 0.7, top, detail.quads(16, 3));
    });
    let heading = libm::atan2f(-corner.x, -corner.y);
    let lean = turned(heading) * rotation(Vec3::X, 0.45);
    builder.place(Affine3A::from_rotation_translation(lean, foot + Vec3::Y * (top + 3.0)), |builder| {
        builder.cuboid(Vec3::new(-6.5, -4.5, -0.6), Vec3::new(6.5, 4.5, 0.0));
        builder.paint(LAMPS);
        let lamps = [detail.things(8), detail.things(5)];
        for lamp in 0..lamps[0] * lamps[1] {
            let (column, row) = ((lamp % lamps[0]) as f32, (lamp / lamps[0]) as f32);
            let at = Vec3::new(-5.6 + 1.6 * column, -3.6 + 1.8 * row, 0.0);
            builder.place(Affine3A::from_rotation_translation(rotation(Vec3::X, PI / 2.0), at), |builder| {
                builder.cone(0.55, 0.7, 0.35, detail.quads(12, 3));
            });
        }
    });
}

/// Round steps in the grass, and the plinth under the cup.
fn plinth(builder: &mut MeshBuilder, detail: Detail) {
    let around = detail.quads(72, 6);
    let step = |low: f32, high: f32, radius: f32| {
        let bevel = 0.02;
        [(radius, low), (radius, high - bevel), (radius, high - bevel), (radius - bevel, high)].map(Vec2::from)
    };
    let top = |radius: f32, height: f32, inner: f32| [Vec2::new(radius, height), Vec2::new(inner, height)];
    builder.paint(MARBLE);
    for (low, high, radius, inner) in [(0.0, 0.16, 5.2, 4.1), (0.16, 0.32, 4.2, 3.1), (0.32, 0.48, 3.2, 0.3)] {
        builder.lathe(&step(low, high, radius), around).lathe(&top(radius - 0.02, high, inner), around);
    }
    builder.paint(DARK_MARBLE);
    let outline = [
        (0.36, 0.48),
        (0.36, 0.56),
        (0.36, 0.56),
        (0.345, 0.575),
        (0.31, 0.585),
        (0.275, 0.62),
        (0.255, 0.68),
        (0.255, 0.68),
        (0.235, 1.46),
        (0.235, 1.46),
        (0.25, 1.49),
        (0.285, 1.52),
        (0.3, 1.55),
        (0.3, 1.55),
        (0.3, PLINTH_TOP - 0.008),
        (0.3, PLINTH_TOP - 0.008),
        (0.292, PLINTH_TOP),
        (0.292, PLINTH_TOP),
        (0.0, PLINTH_TOP),
    ]
    .map(Vec2::from);
    builder.lathe(&outline, around);
    builder.paint(GOLD);
    for height in [0.70, 1.43] {
        let radius = mix(0.255, 0.235, (height - 0.68) / 0.78) + 0.004;
        let band = [(-0.012, -0.006), (-0.008, 0.004), (0.0, 0.007), (0.008, 0.004), (0.012, -0.006)]
            .map(|(up, out)| Vec2::new(radius + out, height + up));
        builder.lathe(&band, around);
    }
}

fn seats() -> Texture {
    color_texture("seats", [64, 8], |at| {
        let aisle = at.x < 0.06;
        let shade = 0.8 + 0.3 * wave(at.x * 30.0);
        let seat = srgb(0x1d_5c_96).lerp(srgb(0x2f_86_b8), 0.5 + 0.5 * wave(at.x * 2.0)) * shade;
        if aisle { srgb(0xb5_b2_aa) } else { seat }.extend(1.0)
    })
}

fn banner() -> Texture {
    color_texture("banner", [128, 16], |at| {
        let colors = [0xc8_3a_2e, 0xf2_ee_e4, 0xe8_a8_2c, 0x1f_4f_7c];
        let stripe = ((at.x * 4.0) as usize).min(3);
        let border = at.y < 0.12 || at.y > 0.88;
        if border { srgb(0xf4_f1_ea) } else { srgb(colors[stripe]) }.extend(1.0)
    })
}

/// A field of 140 m by 140 m with mown stripes and white lines around the middle of the image.
fn grass() -> Texture {
    const METRES: f32 = 140.0;
    color_texture("grass", [1024, 1024], |at| {
        // Texture coordinates are metres from the middle, and the image repeats.
        let field = (at - (at + 0.5).floor()) * METRES;
        let field = field.abs();
        let stripe = if wave(field.x / 11.0) > 0.0 { 1.0 } else { 0.8 };
        let grain = 0.92 + 0.16 * fractal_noise(Vec3::new(field.x, field.y, 0.0) * 0.9, 3);
        let green = srgb(0x5a_8c_42) * (stripe * grain);
        let near = |distance: f32| distance.abs() < 0.09;
        let inside = field.x < 46.1 && field.y < 30.1;
        let line = near(field.x)
            || near(field.x - 46.0)
            || near(field.y - 30.0)
            || near(field.length() - 9.15)
            || (near(field.x - 29.5) && field.y < 20.0)
            || (near(field.y - 20.0) && field.x > 29.5);
        if inside && line { Vec4::new(0.85, 0.87, 0.83, 1.0) } else { green.extend(1.0) }
    })
}

/// Eight lanes across the image.
fn track() -> Texture {
    color_texture("track", [4, 256], |at| {
        let lane = at.y * 8.0;
        let edge = (lane - lane.round()).abs() < 0.03;
        if edge { srgb(0xf2_ec_e4) } else { srgb(0xb5_4f_35) }.extend(1.0)
    })
}

fn marble(ground: u32, vein: u32) -> Texture {
    color_texture("marble", [256, 256], |at| {
        // Noise on two circles repeats where the image does.
        let ([sin_x, cos_x], [sin_y, cos_y]) = ([wave(at.x), cos(TAU * at.x)], [wave(at.y), cos(TAU * at.y)]);
        let point = Vec3::new(cos_x + 0.7 * cos_y, sin_x - 0.7 * sin_y, 0.8 * sin_y + 0.5 * cos_x) * 1.3;
        let bent = fractal_noise(point * 1.5, 4);
        let line = (fractal_noise(point + Vec3::splat(1.4 * bent), 4) * 2.2).abs();
        let strength = 0.75 * smoothstep(0.14, 0.0, line) + 0.12 * (bent + 0.5).clamp(0.0, 1.0);
        srgb(ground).lerp(srgb(vein), strength).extend(1.0)
    })
}
