use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Vec3};
use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;

use super::build::math::{mix, sin_cos, smoothstep, turned, wave};
use super::build::{Detail, MeshBuilder, Random, Sheet, fractal_noise, srgb};
use super::character::{self, Footing, Gnome, Part, Prop};
use super::forest_paints as paints;
use super::glade::{self, PATH_RADIUS, on_ground};
use super::plant::{self, Habit, Twig, Wind};
use super::{DemoScene, Moment, Pose, studio};

pub(crate) const SCENE: DemoScene = DemoScene {
    name: "forest",
    about: "two gnomes marching through a clearing, leaves and grass in the wind",
    triangles: 174_000,
    seconds: 20.0,
    still_seconds: 3.75,
    open,
};

/// Each gnome's prop, and its distance behind the first, in steps.
const GNOMES: [(Prop, f32); 2] = [(Prop::Lantern, 0.0), (Prop::Toadstool, -6.35)];
/// Steps of one round; a whole even number, so that a round ends on the foot that it began with.
const STEPS: f32 = 48.0;

fn open(triangles: usize) -> Pose {
    let cast = gnomes(0.0);
    let detail = Detail::for_triangles(triangles, SCENE.triangles);
    let (mut builder, twigs, detail, people) = detail.within(
        triangles * 3 / 5,
        |detail| {
            let (still_life, twigs) = still_life(detail);
            let mut people = MeshBuilder::new();
            add_gnomes(&mut people, &cast, detail);
            (still_life, twigs, detail, people)
        },
        |(still_life, _, _, people)| still_life.triangles.len() + people.triangles.len(),
    );
    let first_windy = builder.positions.len();
    let mut wind = Wind::default();
    let left = triangles.saturating_sub(builder.triangles.len() + people.triangles.len());
    undergrowth(&mut builder, &mut wind, detail, left / 3);
    let left = triangles.saturating_sub(builder.triangles.len() + people.triangles.len());
    foliage(&mut builder, &mut wind, &twigs, left);
    let windy = first_windy..builder.positions.len();
    debug_assert_eq!(windy.len(), wind.len(), "each vertex bends");
    builder.instance(&people, Affine3A::IDENTITY);
    let sheets: Vec<Sheet> = cast.iter().flat_map(|gnome| &gnome.parts).map(|part| sheet_of(part, detail)).collect();
    let still = builder.finish();

    Box::new(move |Moment { part, .. }, frame| {
        frame.copy_surfaces(&still);
        wind.blow(part, &mut frame.positions[windy.clone()]);
        let cast = gnomes(part);
        let mut positions = &mut frame.positions[windy.end..];
        let mut normals = &mut frame.normals[windy.end..];
        for (part, &sheet) in cast.iter().flat_map(|gnome| &gnome.parts).zip(&sheets) {
            let (own_positions, other_positions) = positions.split_at_mut(sheet.vertices());
            let (own_normals, other_normals) = normals.split_at_mut(sheet.vertices());
            write_part(part, sheet, own_positions, own_normals);
            (positions, normals) = (other_positions, other_normals);
        }

        let swing = wave(part);
        let eye = Vec3::new(0.5 + 0.6 * swing, 0.8 + 0.1 * wave(part + 0.3), 3.75 - 0.2 * swing);
        studio::look(frame, "clearing", eye, Vec3::new(-0.32 + 0.06 * swing, 0.6, 0.0), 0.34);
        studio::sun(frame, Vec3::new(-0.68, -0.56, -0.42), srgb(0xff_ea_c8), 1.3);
        let flicker = 1.0 + 0.06 * wave(37.0 * part) + 0.04 * wave(61.0 * part);
        studio::lamp(frame, "lantern", cast[0].prop, srgb(0xff_b0_58), 0.35 * flicker, Some(4.0));
    })
}

/// The gnomes at `part`, 0 … 1, of their round.
fn gnomes(part: f32) -> [Gnome; 2] {
    let footing = |steps: f32| {
        let (sin, cos) = sin_cos(TAU * (steps / STEPS - 0.07));
        Footing { ground: on_ground(PATH_RADIUS * sin, PATH_RADIUS * cos), ahead: Vec3::new(cos, 0.0, -sin) }
    };
    GNOMES.map(|(prop, behind)| character::gnome(STEPS * part + behind, footing, prop))
}

fn sheet_of(part: &Part, detail: Detail) -> Sheet {
    let [along, around] = part.quads;
    Sheet::tube(detail.quads(around, 3), detail.quads(along, 2))
}

/// The point at (u, v) of a gnome's part, and its normal.
fn part_point(part: &Part, sheet: Sheet, column: u32, row: u32) -> (Vec3, Vec3) {
    let ring = part.sweep.ring(part.sweep.along(row, sheet.rows));
    // The last column is the first one again.
    let (sin, cos) = sin_cos(TAU * (column % sheet.columns) as f32 / sheet.columns as f32);
    ring.point(cos, sin)
}

fn add_gnomes(builder: &mut MeshBuilder, cast: &[Gnome], detail: Detail) {
    for (who, gnome) in cast.iter().enumerate() {
        for part in &gnome.parts {
            let sheet = sheet_of(part, detail);
            let (columns, rows) = (sheet.columns as f32, sheet.rows as f32);
            builder.paint(paints::of_gnome(who, part.stuff)).sheet(sheet, |u, v| {
                let (column, row) = ((u * columns).round() as u32, (v * rows).round() as u32);
                part_point(part, sheet, column, row).0
            });
        }
    }
}

fn write_part(part: &Part, sheet: Sheet, positions: &mut [Vec3], normals: &mut [Vec3]) {
    let stride = sheet.columns as usize + 1;
    let rows = positions.par_chunks_mut(stride).zip(normals.par_chunks_mut(stride)).enumerate();
    // Small parts are quicker on one thread.
    rows.with_min_len(4096 / stride + 1).each(|(row, (positions, normals))| {
        let ring = part.sweep.ring(part.sweep.along(row as u32, sheet.rows));
        for (column, (position, normal)) in positions.iter_mut().zip(normals).enumerate() {
            let (sin, cos) = sin_cos(TAU * (column % (stride - 1)) as f32 / (stride - 1) as f32);
            (*position, *normal) = ring.point(cos, sin);
        }
    });
}

/// Adds everything that stands still, and the twigs for leaves.
fn still_life(detail: Detail) -> (MeshBuilder, Vec<Twig>) {
    let mut builder = MeshBuilder::new();
    let mut random = Random::new(11);
    let mut twigs = Vec::new();
    glade::ground(&mut builder, detail);
    glade::stump(&mut builder, &mut random, detail);
    let house = Affine3A::from_rotation_translation(turned(0.42), on_ground(-2.15, -2.7));
    builder.place(house, |builder| glade::house(builder, detail));
    glade::log(
        &mut builder,
        [on_ground(1.75, -2.0) + Vec3::Y * 0.2, on_ground(3.9, -0.9) + Vec3::Y * 0.14],
        0.26,
        detail,
    );
    for (x, z, size) in
        [(-1.2, 2.35, 0.2), (-1.5, 2.2, 0.11), (2.2, 0.9, 0.3), (2.5, 0.6, 0.16), (-2.9, 0.4, 0.42), (1.0, -3.6, 0.5)]
    {
        builder.paint(paints::STONE);
        glade::rock(&mut builder, &mut random, on_ground(x, z), size, detail);
    }
    toadstools(&mut builder, &mut random, detail);
    trees(&mut builder, &mut random, detail, &mut twigs);
    (builder, twigs)
}

fn toadstools(builder: &mut MeshBuilder, random: &mut Random, detail: Detail) {
    let clusters = [(1.75, 1.55), (-1.95, 1.35), (2.1, -1.5), (-0.9, -2.0), (0.5, 2.55), (-3.0, -1.1), (3.0, -0.6)];
    for (x, z) in clusters {
        for _ in 0..detail.things(4) {
            let (sin, cos) = sin_cos(random.range(0.0, TAU));
            let away = random.range(0.02, 0.24);
            let height = random.range(0.06, 0.2);
            let stand = plant::planted(random, on_ground(x + cos * away, z + sin * away), 0.25);
            let radius = height * random.range(0.45, 0.7);
            let openness = random.unit();
            builder.place(stand, |builder| {
                plant::toadstool(builder, height, radius, openness, detail);
            });
        }
    }
}

fn trees(builder: &mut MeshBuilder, random: &mut Random, detail: Detail, twigs: &mut Vec<Twig>) {
    // Position on the ground, height and trunk radius.
    const TREES: [[f32; 4]; 17] = [
        [-4.1, -1.6, 7.5, 0.36],
        [-0.4, -4.6, 8.5, 0.42],
        [2.7, -3.9, 7.0, 0.3],
        [4.7, -1.9, 7.5, 0.34],
        [-6.2, -4.4, 9.0, 0.4],
        [-3.4, -6.6, 9.0, 0.38],
        [1.6, -7.4, 9.5, 0.4],
        [5.4, -5.8, 9.0, 0.36],
        [7.6, -3.2, 8.0, 0.34],
        [-7.4, -0.6, 8.0, 0.35],
        [-1.6, -10.2, 10.0, 0.4],
        [-8.8, -8.4, 10.0, 0.4],
        [8.6, -9.4, 10.0, 0.4],
        [3.9, -11.5, 10.0, 0.4],
        [-5.4, 2.6, 7.0, 0.33],
        [-6.0, -12.0, 10.0, 0.4],
        [12.0, -6.0, 9.0, 0.36],
    ];
    let count = detail.things(TREES.len() as u32).max(1) as usize;
    for &[x, z, height, trunk_radius] in &TREES[..count] {
        let habit = Habit { height, trunk_radius, bare: random.range(0.17, 0.26) };
        builder.paint(paints::BARK);
        plant::tree(builder, random, on_ground(x, z), habit, detail, twigs);
    }
    thicket(random, detail, twigs);
}

/// Pushes the twigs of bushes that close the gaps between the trunks and hide the horizon.
fn thicket(random: &mut Random, detail: Detail, twigs: &mut Vec<Twig>) {
    for _ in 0..detail.things(64) {
        let (sin, cos) = sin_cos(random.range(0.02 * PI, 1.02 * PI));
        let distance = random.range(4.3, 12.0);
        let foot = on_ground(cos * distance, -sin * distance);
        let size = mix(0.45, 1.3, (distance - 4.3) / 7.7) * random.range(0.7, 1.2);
        for _ in 0..4 {
            let offset = Vec3::new(random.range(-1.0, 1.0), random.range(0.1, 1.6), random.range(-1.0, 1.0));
            let radius = random.range(0.5, 0.9) * size;
            twigs.push(Twig { position: foot + offset * size, radius, coarseness: mix(1.0, 1.6, size - 0.4) });
        }
    }
    for _ in 0..detail.things(120) {
        let (sin, cos) = sin_cos(random.range(-0.05 * PI, 1.05 * PI));
        let distance = random.range(15.0, 20.0);
        let position = on_ground(cos * distance, -sin * distance) + Vec3::Y * random.range(0.3, 5.5);
        twigs.push(Twig { position, radius: random.range(1.2, 2.0), coarseness: 3.2 });
    }
}

/// Adds grass, ferns and flowers, in about `triangles` triangles.
fn undergrowth(builder: &mut MeshBuilder, wind: &mut Wind, detail: Detail, triangles: usize) {
    let mut random = Random::new(23);
    let target = builder.triangles.len() + triangles;
    builder.paint(paints::FERN);
    for _ in 0..detail.things(54) {
        let (sin, cos) = sin_cos(random.range(-0.12 * PI, 1.12 * PI));
        let distance = random.range(2.5, 7.0);
        let size = random.range(0.35, 0.75);
        if builder.triangles.len() + 200 < target {
            plant::fern(builder, wind, &mut random, on_ground(cos * distance, -sin * distance), size, detail);
        }
    }
    let colors = [0xf6_f2_e8, 0xf0_d2_48, 0xd8_86_c8, 0x8a_9a_ea].map(srgb);
    for _ in 0..detail.things(150) {
        let (sin, cos) = sin_cos(random.range(0.0, TAU));
        let distance = if random.unit() < 0.25 { random.range(0.55, 1.0) } else { random.range(1.6, 3.8) };
        let patch = 2.0 * fractal_noise(Vec3::new(cos * distance, 7.0, sin * distance), 2) + 2.0;
        let color = colors[(patch as usize).min(colors.len() - 1)];
        if builder.triangles.len() + 60 < target {
            let foot = on_ground(cos * distance, -sin * distance);
            plant::flower(builder, wind, &mut random, foot, color);
        }
    }
    let mut misses = 0;
    while builder.triangles.len() + 3 <= target {
        let (sin, cos) = sin_cos(random.range(0.0, TAU));
        // Denser where the camera is near.
        let distance = 0.42 + 8.0 * random.unit() * random.unit();
        let foot = on_ground(cos * distance, -sin * distance);
        let trodden = (distance - PATH_RADIUS).abs();
        let patch = fractal_noise(Vec3::new(foot.x * 0.9, 2.0, foot.z * 0.9), 2);
        let lush = smoothstep(0.14, 0.5, trodden) * smoothstep(-0.45, 0.25, patch);
        if random.unit() > lush && misses < triangles {
            misses += 1;
            continue;
        }
        let height = random.range(0.05, 0.15) * mix(0.5, 1.35, lush) * mix(1.0, 1.7, smoothstep(1.8, 4.0, distance));
        let dry = srgb(0x9c_9a_48).lerp(srgb(0x62_8c_30), smoothstep(-0.3, 0.2, patch));
        builder.paint(paints::GRASS).tint(dry * random.range(0.75, 1.2));
        plant::blade(builder, wind, &mut random, foot, height);
    }
}

fn foliage(builder: &mut MeshBuilder, wind: &mut Wind, twigs: &[Twig], triangles: usize) {
    let tints = [0xf4_ff_d8, 0xd8_f4_b8, 0xff_f2_b8, 0xc4_e8_b0, 0xe8_ff_c4].map(srgb);
    builder.paint(paints::LEAVES);
    plant::leaves(builder, wind, &mut Random::new(5), twigs, triangles, &tints);
}

#[cfg(test)]
mod tests {
    use umbrage_scene::Frame;

    use super::*;

    #[test]
    fn the_round_ends_where_it_begins() {
        let pose = open(6_000);
        let [mut start, mut end] = [Frame::default(), Frame::default()];
        pose(Moment { seconds: 0.0, part: 0.0 }, &mut start);
        pose(Moment { seconds: SCENE.seconds, part: 1.0 }, &mut end);
        for (vertex, (from, to)) in start.positions.iter().zip(&end.positions).enumerate() {
            assert!(from.abs_diff_eq(*to, 1e-3), "vertex {vertex}: {from}, then {to}");
        }
    }
}
