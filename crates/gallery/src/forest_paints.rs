//! The forest's materials and textures.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::build::math::{mix, sin_cos, smoothstep, wave};
use super::build::{Paint, Random, color_texture, fractal_noise, srgb};
use super::character::Stuff;
use umbrage_scene::Texture;

pub(super) const SOIL: Paint = Paint::dull("soil", 0xff_ff_ff, 1.0);
pub(super) const STONE: Paint = Paint::dull("stone", 0xff_ff_ff, 0.9);
pub(super) const BARK: Paint = Paint::textured("bark", bark, [0.5, 0.25], 0.95);
pub(super) const CUT_WOOD: Paint = Paint::textured("cut wood", growth_rings, [1.0; 2], 0.8);
pub(super) const STEM: Paint = Paint::dull("stem", 0xea_df_c6, 0.8);
pub(super) const SPOTTED: Paint = Paint::textured("spotted", spots, [1.0; 2], 0.35);
pub(super) const DOOR: Paint = Paint::textured("door", planks, [0.5; 2], 0.6);
pub(super) const FRAME: Paint = Paint::dull("frame", 0x5a_3a_20, 0.7);
pub(super) const WINDOW: Paint = Paint::glowing("window", 0xff_b4_50, 1.0, 0.4);
pub(super) const BRASS: Paint = Paint::metal("brass", || Vec3::new(0.86, 0.62, 0.28), 0.32);
pub(super) const LEAVES: Paint = Paint::textured("leaves", leaf_spray, [1.0; 2], 0.6).masked();
pub(super) const FERN: Paint = Paint::textured("fern", frond, [1.0; 2], 0.6).masked();
pub(super) const GRASS: Paint = Paint::dull("grass", 0xff_ff_ff, 0.9);
pub(super) const PETAL: Paint = Paint::dull("petal", 0xff_ff_ff, 0.6);
pub(super) const HEART: Paint = Paint::dull("heart", 0xe8_b0_28, 0.8);

/// Hat, coat, trousers and leather of each gnome.
const CLOTHES: [[Paint; 4]; 2] = [
    [
        Paint::dull("red felt", 0xb8_2e_22, 0.9),
        Paint::dull("blue coat", 0x2f_5d_78, 0.85),
        Paint::dull("brown trousers", 0x6a_4a_2e, 0.9),
        Paint::dull("leather", 0x4e_2f_1c, 0.5),
    ],
    [
        Paint::dull("green felt", 0x3f_7a_3a, 0.9),
        Paint::dull("orange coat", 0xb0_6a_24, 0.85),
        Paint::dull("grey trousers", 0x4a_4a_5c, 0.9),
        Paint::dull("dark leather", 0x3c_28_1a, 0.5),
    ],
];

/// A gnome's paint for a part.
pub(super) fn of_gnome(who: usize, stuff: Stuff) -> Paint {
    let [hat, coat, trousers, leather] = CLOTHES[who];
    match stuff {
        Stuff::Skin => Paint::dull("skin", 0xe8_a9_84, 0.6),
        Stuff::Hat => hat,
        Stuff::Coat => coat,
        Stuff::Trousers => trousers,
        Stuff::Leather => leather,
        Stuff::Hair => Paint::dull("hair", 0xee_ea_e0, 0.85),
        Stuff::Brass => BRASS,
        Stuff::Eye => Paint::dull("eye", 0x14_10_0e, 0.1),
        Stuff::Wood => Paint::dull("wood", 0x7a_56_34, 0.8),
        Stuff::Toadstool => SPOTTED,
        Stuff::Flame => Paint::glowing("flame", 0xff_a8_38, 1.6, 0.4),
    }
}

/// Whether `at` is in a leaf from `stalk` to `tip`: then its distance from the leaf's middle vein, 0 … 1.
fn in_leaf(at: Vec2, stalk: Vec2, tip: Vec2, half_width: f32) -> Option<f32> {
    let axis = tip - stalk;
    let part = (at - stalk).dot(axis) / axis.length_squared();
    let across = (at - stalk).perp_dot(axis).abs() / axis.length();
    // Widest before the middle and pointed at the tip.
    let width = half_width * 4.0 * part * (1.0 - part) * (1.25 - 0.5 * part);
    ((0.0..1.0).contains(&part) && across < width).then(|| across / width)
}

/// Nine leaves on a twig that comes from the lower edge.
fn leaf_spray() -> Texture {
    const LEAVES: [[f32; 4]; 9] = [
        [0.5, 0.42, 0.52, 0.02],
        [0.5, 0.5, 0.18, 0.14],
        [0.5, 0.46, 0.84, 0.16],
        [0.5, 0.66, 0.04, 0.4],
        [0.5, 0.6, 0.97, 0.42],
        [0.5, 0.8, 0.06, 0.7],
        [0.5, 0.76, 0.95, 0.7],
        [0.5, 0.92, 0.2, 0.96],
        [0.5, 0.9, 0.82, 0.95],
    ];
    color_texture("leaf spray", [256, 256], |at| {
        for (leaf, [x, y, tip_x, tip_y]) in LEAVES.into_iter().enumerate() {
            if let Some(across) = in_leaf(at, Vec2::new(x, y), Vec2::new(tip_x, tip_y), 0.085) {
                let tone = 0.85 + 0.3 * wave(leaf as f32 * 0.37);
                let vein = smoothstep(0.0, 0.12, across);
                let green = srgb(0x9c_c0_54).lerp(srgb(0x5c_94_30), vein) * tone;
                return green.extend(1.0);
            }
        }
        let twig = (at.x - 0.5).abs() < 0.012 && at.y > 0.4;
        srgb(if twig { 0x5c_48_2c } else { 0x5a_86_30 }).extend(if twig { 1.0 } else { 0.0 })
    })
}

/// A fern's frond from the lower edge to the tip at the upper one.
fn frond() -> Texture {
    color_texture("frond", [128, 256], |at| {
        let part = 1.0 - at.y;
        let across = (at.x - 0.5).abs() * 2.0;
        let reach = (1.0 - part) * (0.35 + 2.6 * part).min(1.0);
        let leaflet = (part * 15.0 - across * 0.9).rem_euclid(1.0);
        let inside = across < reach * (0.86 + 0.14 * wave(part * 15.0)) && leaflet < 0.74 - 0.35 * across;
        let stalk = across < 0.035 && part < 0.97;
        let green = srgb(0x74_a0_3c).lerp(srgb(0x4e_80_2c), leaflet);
        green.extend(if inside || stalk { 1.0 } else { 0.0 })
    })
}

/// Bark that repeats along both axes, ridged along v.
fn bark() -> Texture {
    color_texture("bark", [128, 128], |at| {
        let (sin, cos) = sin_cos(TAU * at.x);
        let (sin_v, cos_v) = sin_cos(TAU * at.y);
        let point = Vec3::new(cos * 2.6 + 0.5 * cos_v, sin * 2.6 + 0.5 * sin_v, 0.6 * cos_v - 0.4 * sin_v);
        let ridge = (fractal_noise(point * 1.4, 4) * 2.4).abs().min(1.0);
        srgb(0x4a_38_2a).lerp(srgb(0x94_7c_60), ridge).extend(1.0)
    })
}

fn growth_rings() -> Texture {
    color_texture("growth rings", [256, 256], |at| {
        let offset = at - 0.5;
        let bend = 0.03 * fractal_noise((offset * 6.0).extend(1.0), 3);
        let ring = 0.5 + 0.5 * wave((offset.length() + bend) * 26.0);
        let edge = smoothstep(0.4, 0.46, offset.length());
        srgb(0xd8_b4_80).lerp(srgb(0xb8_8a_54), ring).lerp(srgb(0x5c_44_30), edge).extend(1.0)
    })
}

/// A toadstool's cap: u goes around it, and v from the crown at 0 to the rim at 1.
fn spots() -> Texture {
    let mut random = Random::new(41);
    let mut spots: Vec<(Vec2, f32)> = Vec::new();
    for _ in 0..400 {
        let at = Vec2::new(random.unit(), mix(0.03, 0.9, random.unit().sqrt()));
        let radius = random.range(0.035, 0.07);
        let apart = |&(other, other_radius): &(Vec2, f32)| cap_distance(at, other) > 1.25 * (radius + other_radius);
        if spots.iter().all(apart) {
            spots.push((at, radius));
        }
    }
    color_texture("spotted", [512, 256], |at| {
        let inside = spots.iter().any(|&(spot, radius)| {
            let wobble = 1.0 + 0.25 * fractal_noise(Vec3::new(at.x * 40.0, at.y * 20.0, 0.0), 2);
            cap_distance(at, spot) < radius * wobble
        });
        let red = srgb(0xc2_26_1c).lerp(srgb(0x96_14_14), smoothstep(0.5, 1.0, at.y));
        if inside { srgb(0xf4_ec_dc) } else { red }.extend(1.0)
    })
}

/// Distance of two points of a cap's texture on a disc whose radius is half a unit.
fn cap_distance(a: Vec2, b: Vec2) -> f32 {
    let on_disc = |at: Vec2| {
        let (sin, cos) = sin_cos(TAU * at.x);
        Vec2::new(cos, sin) * (0.5 * at.y)
    };
    on_disc(a).distance(on_disc(b))
}

fn planks() -> Texture {
    color_texture("planks", [128, 128], |at| {
        let plank = at.x * 5.0;
        let gap = (plank - plank.round()).abs() < 0.06;
        let grain = fractal_noise(Vec3::new(plank.floor() * 7.0 + at.x * 40.0, at.y * 3.0, 0.0), 3);
        let wood = srgb(0x8a_5a_30) * (1.0 + 0.4 * grain);
        if gap { srgb(0x38_22_12) } else { wood }.extend(1.0)
    })
}
