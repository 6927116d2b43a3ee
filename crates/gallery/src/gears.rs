//! A machine full of turning gears in a closed case: nearly all triangles are hidden from the camera and from the lights.

use std::f32::consts::TAU;

use glam::{Affine3A, Vec2, Vec3};

use super::build::math::{mix, rotation, sin_cos, turned, wave};
use super::build::{Detail, MeshBuilder, Paint, Sheet, hash, srgb};
use super::hall_paints::{BRASS, IRON, WOOD};
use super::{DemoScene, Moment, Pose, studio};

pub(crate) const SCENE: DemoScene = DemoScene {
    name: "gears",
    about: "a machine full of gears, in a closed case that hides nearly all of them",
    triangles: 500_000,
    seconds: 24.0,
    still_seconds: 4.5,
    open,
};

const LACQUER: Paint = Paint::dull("green lacquer", 0x1f_4a_40, 0.3);
const STEEL: Paint = Paint::metal("steel", || srgb(0xc8_cc_d0), 0.3);
const BRONZE: Paint = Paint::metal("bronze", || srgb(0xb8_7c_4c), 0.35);
const TABLE: Paint = Paint::dull("table", 0xc4_b8_a8, 0.75);

/// Shafts of a row and of a column, and gears along each.
const SHAFTS: [u32; 2] = [6, 4];
const LAYERS: u32 = 9;
/// Distances between two shafts, and between two gears on one.
const SPACING: f32 = 0.62;
const LAYER_SPACING: f32 = 0.18;
/// Half the thickness of a gear.
const HALF_THICKNESS: f32 = 0.065;
const SHAFT_RADIUS: f32 = 0.045;
/// Middle of the shafts, and half the size of the case around it.
const MIDDLE: Vec3 = Vec3::new(0.0, 2.05, 0.0);
const HALF_CASE: Vec3 = Vec3::new(2.16, 1.5, 0.94);
const WALL: f32 = 0.06;

/// Foot and tip of a tooth, and the gap after it: position around the gear in teeth, and height in modules.
const OUTLINE: [Vec2; 5] =
    [Vec2::new(-0.38, -1.2), Vec2::new(-0.1, 1.0), Vec2::new(0.1, 1.0), Vec2::new(0.38, -1.2), Vec2::new(0.62, -1.2)];

/// A gear, by its shaft's column and row and by its layer.
#[derive(Clone, Copy, Debug)]
struct Gear {
    shaft: [u32; 2],
    layer: u32,
}

fn open(triangles: usize) -> Pose {
    let columns = studio::backdrop_columns(triangles);
    let detail = Detail::for_triangles(triangles, SCENE.triangles);
    let mut builder = detail.within(triangles / 5, case, |case| case.triangles.len());
    studio::backdrop(builder.paint(TABLE), 14.0, 9.0, columns);
    let left = triangles.saturating_sub(builder.triangles.len());
    let shafts = train(&mut builder, left, detail);
    let still = builder.finish();

    Box::new(move |Moment { part, .. }, frame| {
        frame.copy_surfaces(&still);
        for (shaft, vertices) in &shafts {
            studio::turn(frame, vertices.clone(), axis(*shaft), rotation(Vec3::Z, TAU * turns_at(*shaft, part)));
        }
        let eye = MIDDLE + turned(0.5 + 0.3 * wave(part)) * Vec3::new(0.0, 1.7 + 0.35 * wave(part + 0.2), 9.4);
        studio::look(frame, "front", eye, MIDDLE - 0.12 * Vec3::Y, 0.31);
        let key = turned(0.25 + 0.35 * wave(part + 0.5)) * Vec3::new(0.0, 5.0, 6.5);
        studio::light(frame, "key", key, MIDDLE, srgb(0xff_f0_d8), 1.0);
        studio::light(frame, "rim", Vec3::new(6.0, 4.5, -2.5), MIDDLE, srgb(0xbf_d4_ff), 0.5);
    })
}

/// Shafts turn against their four neighbours: every second one is slow, with gears of twice the size, the others are fast.
fn is_slow([column, row]: [u32; 2]) -> bool {
    (column + row).is_multiple_of(2)
}

/// Turns of a shaft at `part` of the cycle, which has whole turns.
fn turns_at(shaft: [u32; 2], part: f32) -> f32 {
    if is_slow(shaft) { -2.0 * part } else { 4.0 * part }
}

/// Middle of a shaft.
fn axis(shaft: [u32; 2]) -> Vec3 {
    let from_middle = |axis: usize| SPACING * (shaft[axis] as f32 - 0.5 * (SHAFTS[axis] - 1) as f32);
    MIDDLE + Vec3::new(from_middle(0), from_middle(1), 0.0)
}

/// Adds shafts with their gears, each around the origin, in about `triangles` triangles; returns each shaft's vertices.
fn train(builder: &mut MeshBuilder, triangles: usize, detail: Detail) -> Vec<([u32; 2], std::ops::Range<usize>)> {
    const LEAST: usize = 1_200;
    let end = builder.triangles.len() + triangles;
    let shafts = (0..SHAFTS[0]).flat_map(|column| (0..SHAFTS[1]).map(move |row| [column, row]));
    // A quarter of the gears is left out, so that the gears behind are visible.
    let is_there = |gear: &Gear| !hash(gear.shaft[0] as i32, gear.shaft[1] as i32, gear.layer as i32).is_multiple_of(4);
    let all = (0..LAYERS).rev().flat_map(|layer| shafts.clone().map(move |shaft| Gear { shaft, layer }));
    let all: Vec<Gear> = all.filter(is_there).collect();
    // With few triangles only the front gears remain.
    let count = all.len().min((triangles / LEAST).max(1));
    let mut done = 0;
    let shafts = shafts.filter(|shaft| all[..count].iter().any(|gear| gear.shaft == *shaft));
    shafts
        .map(|shaft| {
            let first = builder.positions.len();
            let length = HALF_CASE.z - 0.5 * WALL;
            along_z(builder.part().paint(STEEL), -length, |builder| {
                builder.cylinder(SHAFT_RADIUS, 2.0 * length, detail.quads(12, 3));
            });
            for gear in all[..count].iter().filter(|gear| gear.shaft == shaft) {
                // The remaining gears share the remaining triangles.
                let left = end.saturating_sub(builder.triangles.len());
                gear.make(builder, left / (count - done), detail);
                done += 1;
            }
            (shaft, first..builder.positions.len())
        })
        .collect()
}

impl Gear {
    /// Number of teeth; slow gears have twice as many as fast ones. Multiples of four, so that a gear meets all its
    /// neighbours in the same way.
    fn teeth(self) -> u32 {
        let fast = [12, 20, 16][self.layer as usize % 3];
        if is_slow(self.shaft) { 2 * fast } else { fast }
    }

    /// Radius of the pitch circle.
    fn radius(self) -> f32 {
        SPACING * if is_slow(self.shaft) { 2.0 / 3.0 } else { 1.0 / 3.0 }
    }

    /// The point of [`OUTLINE`] after `teeth` teeth, at `along` on the axis.
    fn outline(self, teeth: f32, along: f32) -> Vec2 {
        let side = (4.0 * teeth.fract()).min(3.999);
        let point = OUTLINE[side as usize].lerp(OUTLINE[side as usize + 1], side.fract());
        point + Vec2::X * (teeth.floor() + self.shift(along))
    }

    /// Shift of a tooth around the gear at `along` the axis, −1 … 1, in teeth: gears are straight, helical, or herringbones.
    fn shift(self, along: f32) -> f32 {
        let shift = [0.0, 0.45 * along, 0.6 * along.abs()][self.layer as usize % 3];
        // A slow gear has a gap where a fast one has a tooth.
        if is_slow(self.shaft) { 0.5 - shift } else { shift }
    }

    /// Adds it on a shaft along z through the origin, in about `triangles` triangles.
    fn make(self, builder: &mut MeshBuilder, triangles: usize, detail: Detail) {
        let Self { shaft: [column, row], layer } = self;
        let middle = Vec3::Z * (LAYER_SPACING * (layer as f32 - 0.5 * (LAYERS - 1) as f32));
        let first = builder.triangles.len();
        builder.paint([BRASS, STEEL, BRONZE][(column + 2 * row + layer) as usize % 3]);
        builder.place(Affine3A::from_translation(middle), |builder| {
            let bore = if is_slow(self.shaft) { 0.74 * self.radius() } else { SHAFT_RADIUS };
            if is_slow(self.shaft) {
                wheel(builder, bore, detail);
            }
            let left = triangles.saturating_sub(builder.triangles.len() - first);
            self.rim(builder, bore, left / 2);
        });
    }

    /// Adds its teeth, from its bore to around its pitch circle, in about `quads` quads.
    fn rim(self, builder: &mut MeshBuilder, bore: f32, quads: usize) {
        let (teeth, radius) = (self.teeth(), self.radius());
        let around = (4 * teeth) as usize;
        let columns = around * ((quads as f32 / (6 * around) as f32).sqrt().round() as usize).max(1);
        // Two faces and the bore are a row each.
        let rows = (quads / columns).max(4);
        let across = (rows - 3) as f32;
        let module = 2.0 * radius / teeth as f32;
        let first = builder.positions.len();
        builder.sheet(Sheet::ring(columns as u32, rows as u32), |u, v| {
            let row = (v * rows as f32).round();
            // Along the teeth, and back along the bore.
            let along = if row <= across { row } else { across * (rows as f32 - 1.0 - row) } / across * 2.0 - 1.0;
            let point = self.outline(u * teeth as f32, along);
            let (sin, cos) = sin_cos(TAU * point.x / teeth as f32);
            let out = if row <= across { radius + module * point.y } else { bore };
            Vec3::new(out * cos, out * sin, HALF_THICKNESS * along)
        });
        builder.normals[first..].fill(Vec3::ZERO);
    }
}

/// Adds the shapes of `make`, with their y axis along z, moved by `from` along it.
fn along_z(builder: &mut MeshBuilder, from: f32, make: impl FnOnce(&mut MeshBuilder)) {
    let turn = rotation(Vec3::X, 0.25 * TAU);
    builder.place(Affine3A::from_rotation_translation(turn, Vec3::Z * from), make);
}

/// Adds a hub and spokes around the origin, up to `reach` from the z axis.
fn wheel(builder: &mut MeshBuilder, reach: f32, detail: Detail) {
    const SPOKES: u32 = 6;
    let half = 1.2 * HALF_THICKNESS;
    along_z(builder, -half, |builder| {
        builder.cylinder(0.24 * reach + 0.02, 2.0 * half, detail.quads(24, 4));
    });
    for spoke in 0..SPOKES {
        let turn = rotation(Vec3::Z, TAU * spoke as f32 / SPOKES as f32);
        builder.place(Affine3A::from_quat(turn), |builder| {
            let [wide, thick] = [0.09 * reach, 0.6 * HALF_THICKNESS];
            builder.cuboid(Vec3::new(0.2 * reach, -wide, -thick), Vec3::new(1.02 * reach, wide, thick));
        });
    }
}

/// Radius of the portholes, half the side of their plates, and the plates' positions relative to the case's middle.
const PORTHOLE: f32 = 0.43;
const HALF_PLATE: f32 = 0.62;
const PLATES: [Vec2; 3] = [Vec2::new(-1.24, -0.31), Vec2::new(0.0, -0.31), Vec2::new(1.24, -0.31)];

/// The case, which stands still.
fn case(detail: Detail) -> MeshBuilder {
    let mut builder = MeshBuilder::new();
    builder.place(Affine3A::from_translation(MIDDLE), |builder| {
        walls(builder.paint(LACQUER));
        for at in PLATES {
            plate(builder.paint(LACQUER), at, detail);
        }
        slats(builder);
        let Vec3 { x, y, z } = HALF_CASE;
        let block = |builder: &mut MeshBuilder, middle: Vec3, half_size: Vec3| {
            builder.place(Affine3A::from_translation(middle), |builder| {
                if detail.is_ornate() {
                    builder.rounded_cuboid(half_size, 0.05, detail.quads(4, 1));
                } else {
                    builder.cuboid(-half_size, half_size);
                }
            });
        };
        for (paint, height, half_size) in [
            (IRON, -y - 0.06, Vec3::new(x + 0.1, 0.09, z + 0.1)),
            (WOOD, -y - 0.33, Vec3::new(x + 0.3, 0.19, z + 0.3)),
            (IRON, y + 0.05, Vec3::new(x + 0.1, 0.08, z + 0.1)),
            (LACQUER, y + 0.2, Vec3::new(x - 0.1, 0.1, z - 0.1)),
        ] {
            block(builder.paint(paint), Vec3::Y * height, half_size);
        }
        for [x, z] in [[-x, -z], [x, -z], [-x, z], [x, z]] {
            block(builder.paint(IRON), Vec3::new(x, 0.0, z), Vec3::new(0.07, y, 0.07));
        }
        if detail.is_ornate() {
            ornaments(builder, detail);
        }
    });
    builder
}

/// Everything of the case's six sides but the plates and the slats.
fn walls(builder: &mut MeshBuilder) {
    let Vec3 { x, y, z } = HALF_CASE;
    let inner = z - WALL;
    let [left, right] = [PLATES[0].x - HALF_PLATE, PLATES[2].x + HALF_PLATE];
    let [below, above] = [PLATES[0].y - HALF_PLATE, PLATES[0].y + HALF_PLATE];
    let mut side = |low: [f32; 3], high: [f32; 3]| {
        builder.cuboid(low.into(), high.into());
    };
    side([-x, -y, -z], [x, y, -inner]);
    side([-x, -y, -inner], [WALL - x, y, inner]);
    side([x - WALL, -y, -inner], [x, y, inner]);
    side([-x, -y, -inner], [x, WALL - y, inner]);
    side([-x, y - WALL, -inner], [x, y, inner]);
    side([-x, -y, inner], [left, y, z]);
    side([right, -y, inner], [x, y, z]);
    side([left, -y, inner], [right, below, z]);
    side([left, above, inner], [right, SLITS[0], z]);
    side([left, SLITS[1], inner], [right, y, z]);
}

/// Heights of the lower and the upper end of the front's slits.
const SLITS: [f32; 2] = [0.62, 1.2];

/// Adds slanting slats with slits between them, and their holders.
fn slats(builder: &mut MeshBuilder) {
    const COUNT: u32 = 6;
    const HOLDERS: u32 = 4;
    let reach = PLATES[2].x + HALF_PLATE;
    let z = HALF_CASE.z - 0.5 * WALL;
    for slat in 0..COUNT {
        let height = mix(SLITS[0], SLITS[1], (slat as f32 + 0.5) / COUNT as f32);
        let place = Affine3A::from_rotation_translation(rotation(Vec3::X, 0.6), Vec3::new(0.0, height, z));
        builder.paint(LACQUER).place(place, |builder| {
            builder.cuboid(Vec3::new(-reach, -0.036, -0.012), Vec3::new(reach, 0.036, 0.012));
        });
    }
    for holder in 0..=HOLDERS {
        let x = mix(-reach, reach, holder as f32 / HOLDERS as f32);
        let half = Vec3::new(0.04, 0.0, 0.6 * WALL);
        builder.paint(IRON).cuboid(Vec3::new(x, SLITS[0], z) - half, Vec3::new(x, SLITS[1], z) + half);
    }
}

/// Adds a square plate of the front with a porthole.
fn plate(builder: &mut MeshBuilder, at: Vec2, detail: Detail) {
    let columns = 8 * detail.quads(6, 1);
    let first = builder.positions.len();
    builder.sheet(Sheet::ring(columns, 4), |u, v| {
        let (sin, cos) = sin_cos(TAU * u);
        let row = (4.0 * v).round() as usize;
        let reach = if row < 2 { HALF_PLATE / cos.abs().max(sin.abs()) } else { PORTHOLE };
        let back = if row == 1 || row == 2 { 0.0 } else { WALL };
        Vec3::new(at.x + reach * cos, at.y + reach * sin, HALF_CASE.z - back)
    });
    builder.normals[first..].fill(Vec3::ZERO);
}

/// Adds rims and bolts around the portholes, handles, domes and a pipe.
fn ornaments(builder: &mut MeshBuilder, detail: Detail) {
    const BOLTS: u32 = 12;
    let Vec3 { x, y, z } = HALF_CASE;
    let fineness = detail.quads(3, 1);
    for at in PLATES {
        let sheet = [detail.quads(16, 3), detail.quads(64, 8)];
        builder.paint(BRASS).ring(at.extend(z), PORTHOLE + 0.02, [0.055, 0.04], sheet);
        builder.paint(STEEL);
        for bolt in 0..BOLTS {
            let (sin, cos) = sin_cos(TAU * (bolt as f32 + 0.5) / BOLTS as f32);
            builder.ball((at + Vec2::new(cos, sin) * (PORTHOLE + 0.115)).extend(z), 0.022, fineness);
        }
    }
    for side in [-1.0, 1.0] {
        let path: Vec<Vec3> = (0..=12)
            .map(|step| {
                let (sin, cos) = sin_cos(0.5 * TAU * step as f32 / 12.0);
                Vec3::new(side * (x - 0.02 + 0.2 * sin), 0.1 - 0.35 * cos, 0.0)
            })
            .collect();
        builder.paint(BRASS).tube(&path, |_| 0.035, detail.quads(14, 3));
        builder.paint(LACQUER).place(Affine3A::from_translation(Vec3::new(side * 1.35, y + 0.28, 0.0)), |builder| {
            let outline = [
                (0.38, 0.0),
                (0.38, 0.05),
                (0.38, 0.05),
                (0.3, 0.06),
                (0.3, 0.06),
                (0.29, 0.17),
                (0.25, 0.27),
                (0.18, 0.35),
                (0.08, 0.4),
                (0.05, 0.5),
            ]
            .map(Vec2::from);
            builder.lathe(&outline, detail.quads(40, 5));
            builder.paint(BRASS).ball(Vec3::Y * 0.53, 0.08, detail.quads(6, 1));
        });
    }
    let pipe: Vec<Vec3> = (0..=24)
        .map(|step| {
            let (sin, cos) = sin_cos(0.5 * TAU * step as f32 / 24.0);
            Vec3::new(-1.35 * cos, y + 0.45 + 0.4 * sin, 0.0)
        })
        .collect();
    builder.paint(BRONZE).tube(&pipe, |_| 0.07, detail.quads(18, 3));
    builder.paint(BRASS).cuboid(Vec3::new(-0.5, -1.32, z), Vec3::new(0.5, -1.1, z + 0.02));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn teeth_run_in_the_gaps_of_their_neighbours() {
        let shafts = [[2, 2], [2, 3]];
        for (layer, step) in (0..LAYERS).flat_map(|layer| (0..16).map(move |step| (layer, step))) {
            let [slow, fast] = shafts.map(|shaft| Gear { shaft, layer });
            assert!(is_slow(slow.shaft) && fast.teeth() * 2 == slow.teeth());
            let [slow_radius, fast_radius] = [slow, fast].map(Gear::radius);
            let module = 2.0 * fast_radius / fast.teeth() as f32;
            let turns = |gear: Gear| turns_at(gear.shaft, step as f32 / 2_000.0);
            // Depth of the slow gear's outline, in its own space, inside the fast one's.
            let depth = |index: u32| {
                let along = index as f32 / 16.0;
                let point = slow.outline(along, 0.5);
                let radius = slow_radius + module * point.y;
                let (sin, cos) = sin_cos(TAU * (point.x / slow.teeth() as f32 + turns(slow)));
                let from_fast = Vec2::new(cos, sin) * radius - Vec2::Y * SPACING;
                let around = from_fast.to_angle() / TAU - turns(fast);
                // The fast gear's outline next to it.
                let teeth = fast.teeth() as f32;
                let tooth = (around * teeth - fast.shift(0.5) + 0.5).rem_euclid(1.0) - 0.5;
                let height = OUTLINE.windows(2).find_map(|ends| {
                    let part = (tooth - ends[0].x) / (ends[1].x - ends[0].x);
                    (0.0..=1.0).contains(&part).then(|| mix(ends[0].y, ends[1].y, part))
                });
                fast_radius / module + height.unwrap_or(OUTLINE[0].y) - from_fast.length() / module
            };
            let deepest = (0..16 * slow.teeth()).map(depth).fold(f32::MIN, f32::max);
            // They come close, but straight flanks cut into each other by no more than a fifth of a tooth's height.
            assert!((-0.5..0.4).contains(&deepest), "layer {layer}, step {step}: {deepest} modules");
        }
    }
}
