//! The hall's floors, materials and textures.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::build::math::{sin_cos, smoothstep, wave};
use super::build::{MeshBuilder, Paint, color_texture, fractal_noise, srgb};
use super::furniture;
use super::hall::{AISLE, BAY, BAYS, NAVE};
use umbrage_scene::Texture;

pub(super) const MARBLE: Paint = Paint::textured("marble floor", marble_floor, [2.0; 2], 0.22);
pub(super) const FLAGS: Paint = Paint::textured("flagstones", ashlar, [1.6; 2], 0.7);
pub(super) const CARPET: Paint = Paint::textured("carpet", carpet, [1.0; 2], 0.95);
/// Walls; texture coordinates are metres.
pub(super) const ASHLAR: Paint = Paint::textured("ashlar", ashlar, [1.6; 2], 0.85);
/// Columns and ribs.
pub(super) const STONE: Paint = Paint::dull("stone", 0xc0_ac_8a, 0.75);
/// Webs between the ribs of a vault.
pub(super) const PLASTER: Paint = Paint::dull("plaster", 0xcc_bc_9c, 0.9);
/// Bars of windows.
pub(super) const LEAD: Paint = Paint::dull("lead", 0x3a_3c_40, 0.6);
pub(super) const WOOD: Paint = Paint::dull("walnut", 0x6a_40_24, 0.38);
pub(super) const LEATHER: Paint = Paint::dull("leather", 0x6e_22_1c, 0.45);
pub(super) const BRASS: Paint = Paint::metal("brass", || Vec3::new(0.88, 0.64, 0.3), 0.25);
pub(super) const IRON: Paint = Paint::dull("iron", 0x2c_2a_28, 0.5);
pub(super) const WAX: Paint = Paint::dull("wax", 0xf2_e8_d0, 0.5);
pub(super) const FLAME: Paint = Paint::glowing("flame", 0xff_c8_70, 4.0, 0.6);
pub(super) const SHADE: Paint = Paint::dull("shade", 0x1c_6a_48, 0.15);
pub(super) const PAPER: Paint = Paint::dull("paper", 0xea_e0_c8, 0.9);
/// Covers of books, tinted.
pub(super) const CLOTH: Paint = Paint::dull("cloth", 0xff_ff_ff, 0.55);
pub(super) const GLOBE: Paint = Paint::textured("map", map, [1.0; 2], 0.35);

/// Adds the floors of the nave and the aisles, and the runner between the tables.
pub(super) fn lay_floors(builder: &mut MeshBuilder) {
    let length = BAY * BAYS as f32;
    let middle = Vec3::new(0.0, 0.0, -0.5 * length);
    builder.paint(MARBLE).floor(middle, Vec2::new(2.0 * NAVE, length + 1.4), [1, 1]);
    for side in [-1.0, 1.0] {
        let center = middle + Vec3::X * (side * 0.5 * (NAVE + AISLE + 0.3));
        builder.paint(FLAGS).floor(center, Vec2::new(AISLE - NAVE + 0.3, length + 1.4), [1, 1]);
    }
    runner(builder, Vec3::new(0.0, 0.006, -12.0), Vec2::new(2.0, 23.2));
}

/// A carpet around `middle`, of `size` along x and z.
pub(super) fn runner(builder: &mut MeshBuilder, middle: Vec3, size: Vec2) {
    let corner = |x: f32, z: f32| middle + Vec3::new(x * size.x, 0.0, z * size.y) * 0.5;
    let corners = [corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)];
    builder.paint(CARPET).quad(corners, Vec2::new(1.0, size.y / size.x));
}

fn map() -> Texture {
    color_texture("map", [512, 256], |at| furniture::world_map(at).extend(1.0))
}

/// Four courses of stone blocks with thin joints, each course shifted by half a block.
fn ashlar() -> Texture {
    color_texture("ashlar", [256, 256], |at| {
        let course = at.y * 4.0;
        let block = at.x * 2.0 + 0.5 * (course.floor() as u32 % 2) as f32;
        let joint = (block - block.round()).abs() < 0.008 || (course - course.round()).abs() < 0.018;
        // Blocks differ a little; the noise repeats with the image.
        let tone = 0.07 * wave(course.floor() * 0.37 + block.floor().rem_euclid(2.0) * 0.61);
        let (sin, cos) = sin_cos(TAU * at.x);
        let (sin_v, cos_v) = sin_cos(TAU * at.y);
        let grain = 0.12 * fractal_noise(Vec3::new(cos + 0.6 * cos_v, sin + 0.6 * sin_v, cos_v - sin) * 3.0, 4);
        let stone = srgb(0xb6_a0_7c) * (1.0 + tone + grain);
        if joint { srgb(0x96_82_62) } else { stone }.extend(1.0)
    })
}

/// Two by two slabs of light and dark marble with veins.
fn marble_floor() -> Texture {
    color_texture("marble floor", [512, 512], |at| {
        let odd = (at.x < 0.5) != (at.y < 0.5);
        let slab = (at * 2.0).fract();
        let joint = slab.min_element() < 0.008 || slab.max_element() > 0.992;
        let point = Vec3::new(at.x * 5.0, at.y * 5.0, if odd { 3.0 } else { 11.0 });
        let bent = fractal_noise(point, 4);
        let line = (fractal_noise(point * 0.8 + Vec3::splat(1.6 * bent), 4) * 2.0).abs();
        let vein = smoothstep(0.12, 0.0, line);
        let (ground, veins) = if odd { (0x4a_2e_26, 0x9a_7a_68) } else { (0xe4_da_c6, 0xb0_a0_88) };
        let color = srgb(ground).lerp(srgb(veins), 0.6 * vein + 0.1 * (bent + 0.5).clamp(0.0, 1.0));
        if joint { srgb(0x8a_7c_68) } else { color }.extend(1.0)
    })
}

/// A red runner with a border along both sides and a row of medallions.
fn carpet() -> Texture {
    color_texture("carpet", [256, 256], |at| {
        let edge = (at.x - 0.5).abs() * 2.0;
        let (red, dark, gold) = (srgb(0x8a_1c_1a), srgb(0x3e_10_1c), srgb(0xc8_9a_4a));
        let weave = 0.92 + 0.16 * wave(at.x * 90.0) * wave(at.y * 90.0);
        let center = (at - 0.5).abs();
        let diamond = center.x / 0.3 + center.y / 0.42;
        let color = if edge > 0.96 || (0.76..0.79).contains(&edge) {
            gold
        } else if edge > 0.79 {
            let leaf = wave(at.y * 8.0) * 0.05 + 0.875;
            if (edge - leaf).abs() < 0.022 { gold } else { dark }
        } else if (0.9..1.0).contains(&diamond) || diamond < 0.16 {
            gold
        } else if diamond < 0.9 && (0.4..0.55).contains(&diamond) {
            dark
        } else {
            red
        };
        (color * weave).extend(1.0)
    })
}
