//! Trees, leaves, grass, ferns, flowers and toadstools.

use std::f32::consts::TAU;

use glam::{Affine3A, Vec2, Vec3};
use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;

use super::build::math::{cos, mix, rotation, rotation_between, sin_cos, smoothstep, turned, wave};
use super::build::{Detail, MeshBuilder, Random, Sheet, fractal_noise, math};
use super::forest_paints as paints;

/// A place for leaves: the end of a branch, or the middle of a bush.
#[derive(Clone, Copy, Debug)]
pub(super) struct Twig {
    pub(super) position: Vec3,
    /// Distance of leaves from there, in metres.
    pub(super) radius: f32,
    /// Size of the sprays of leaves, relative to the usual one: larger far from the camera.
    pub(super) coarseness: f32,
}

/// A tree's size and habit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Habit {
    pub(super) height: f32,
    pub(super) trunk_radius: f32,
    /// The fraction of the height below the branches.
    pub(super) bare: f32,
}

/// Adds a tree with its roots at `foot`, without leaves, and pushes the twigs for its leaves.
pub(super) fn tree(
    builder: &mut MeshBuilder,
    random: &mut Random,
    foot: Vec3,
    habit: Habit,
    detail: Detail,
    twigs: &mut Vec<Twig>,
) {
    let Habit { height, trunk_radius, bare } = habit;
    let lean = Vec3::new(random.range(-0.09, 0.09), 0.0, random.range(-0.09, 0.09));
    let seed = random.range(0.0, 100.0);
    let bend = |part: f32, axis: f32| {
        0.09 * height * fractal_noise(Vec3::new(part * 2.2, seed, axis), 2) * part.max(0.0).sqrt()
    };
    let trunk =
        |part: f32| foot + (Vec3::Y + lean) * (height * part) + Vec3::new(bend(part, 0.0), 0.0, bend(part, 9.0));
    let thickness = |part: f32| trunk_radius * mix(1.0, 0.12, part) * (1.0 - 0.25 * part);
    let lobes = 4.0 + (seed as u32 % 3) as f32;
    // Part 0 of the sheet is a little below the ground, where roots spread.
    builder.sheet(Sheet::tube(detail.quads(18, 4), detail.quads(26, 3)), |u, v| {
        let part = mix(-0.02, 1.0, v * v * 0.6 + 0.4 * v);
        let flare = smoothstep(0.16, -0.02, part);
        let buttress = 0.5 + 0.5 * wave(lobes * u + seed);
        let (sin, cos) = sin_cos(TAU * u);
        let ridges = 1.0 + 0.07 * fractal_noise(Vec3::new(cos * 3.0, part * 6.0, sin * 3.0 + seed), 2);
        let radius = thickness(part.max(0.0)) * ridges * (1.0 + flare * flare * (0.5 + 1.5 * buttress));
        trunk(part) + Vec3::new(cos, 0.0, -sin) * radius
    });
    let branches = detail.things(11);
    for branch in 0..branches {
        let part = mix(bare, 0.97, (branch as f32 + random.unit()) / branches as f32);
        let angle = 2.4 * branch as f32 + random.range(-0.4, 0.4);
        let (sin, cos) = sin_cos(angle);
        let length = height * mix(0.36, 0.14, (part - bare) / (1.0 - bare)) * random.range(0.8, 1.2);
        let direction = Vec3::new(cos, random.range(0.25, 0.6), sin).normalize();
        let from = trunk(part);
        branch_from(builder, random, &Limb { from, direction, length, radius: thickness(part) * 0.5 }, detail, twigs);
    }
    twigs.push(Twig { position: trunk(1.0), radius: 0.09 * height, coarseness: 1.0 });
}

struct Limb {
    from: Vec3,
    direction: Vec3,
    length: f32,
    radius: f32,
}

/// Adds a branch and the smaller ones that spring from it.
fn branch_from(builder: &mut MeshBuilder, random: &mut Random, limb: &Limb, detail: Detail, twigs: &mut Vec<Twig>) {
    let Limb { from, direction, length, radius } = *limb;
    let droop = random.range(-0.1, 0.16);
    let side = direction.cross(Vec3::Y).normalize_or(Vec3::X) * random.range(-0.16, 0.16);
    let at = |part: f32| from + (direction * part + (side + Vec3::Y * droop) * (part * part)) * length;
    let rows = detail.quads(6, 2);
    let path: Vec<Vec3> = (0..=rows).map(|row| at(row as f32 / rows as f32)).collect();
    builder.tube(&path, |part| radius * mix(1.0, 0.2, part), detail.quads(7, 3));
    twigs.push(Twig { position: at(1.0), radius: 0.26 * length, coarseness: 1.0 });
    let smaller = detail.things(3);
    for twig in 0..smaller {
        let part = mix(0.4, 0.9, (twig as f32 + random.unit()) / smaller as f32);
        let turn = rotation(Vec3::Y, random.range(0.5, 1.1) * if twig % 2 == 0 { 1.0 } else { -1.0 });
        let towards = (turn * direction + Vec3::Y * random.range(-0.1, 0.3)).normalize();
        let end = at(part) + towards * (length * 0.42);
        builder.tube(&[at(part), end], |part| radius * mix(0.45, 0.1, part), detail.quads(5, 3));
        twigs.push(Twig { position: end, radius: 0.22 * length, coarseness: 1.0 });
    }
}

/// Adds about `triangles` triangles of leaf sprays around `twigs`, two for each spray.
pub(super) fn leaves(
    builder: &mut MeshBuilder,
    wind: &mut Wind,
    random: &mut Random,
    twigs: &[Twig],
    triangles: usize,
    tints: &[Vec3],
) {
    const USUAL_SPRAYS: f32 = 32_000.0;
    const USUAL_SIZE: f32 = 0.2;
    let Some(last) = twigs.len().checked_sub(1) else { return };
    let sprays = triangles / 2;
    let size = USUAL_SIZE * (USUAL_SPRAYS / sprays.max(1) as f32).sqrt().clamp(0.3, 2.5);
    // Twigs get leaves by the area of the ball around them.
    let mut sums = Vec::with_capacity(twigs.len());
    let mut sum = 0.0;
    for twig in twigs {
        let across = twig.radius / twig.coarseness;
        sum += across * across;
        sums.push(sum);
    }
    for _ in 0..sprays {
        let chosen = random.range(0.0, sum);
        let index = sums.partition_point(|&sum| sum < chosen).min(last);
        let twig = twigs[index];
        let out = random.direction();
        let position = twig.position + out * (twig.radius * random.unit().sqrt()) * Vec3::new(1.0, 0.75, 1.0);
        // Sprays lie rather flat and hang a little outwards.
        let normal = (random.direction() * 0.75 + Vec3::Y * 0.8 + out * 0.45).normalize_or(Vec3::Y);
        let turn = rotation_between(Vec3::Y, normal) * turned(random.range(0.0, TAU));
        let half = size * twig.coarseness * random.range(0.65, 1.25);
        let [x, z] = [turn * Vec3::X * half, turn * Vec3::Z * half];
        let shade = random.range(0.8, 1.15);
        builder.tint(tints[index % tints.len()] * shade);
        let phase = random.unit();
        let flutter = 0.12 * half;
        for sway in [0.02, 0.02 + flutter, 0.02 + flutter, 0.02] {
            wind.bends(sway, phase);
        }
        builder.quad([position - x + z, position + x + z, position + x - z, position - x - z], Vec2::ONE);
    }
}

/// Adds a blade of grass: three triangles.
pub(super) fn blade(builder: &mut MeshBuilder, wind: &mut Wind, random: &mut Random, foot: Vec3, height: f32) {
    // Fronts face the sun and the camera: the soft normal below is that of the front.
    let (sin, cos) = sin_cos(random.range(-0.22, 0.02) * TAU);
    let across = Vec3::new(cos, 0.0, sin) * (0.0055 + 0.014 * height);
    let lean = Vec3::new(-sin, 0.0, cos) * (height * random.range(-0.6, 0.6));
    let middle = foot + Vec3::Y * (0.6 * height) + lean * 0.3;
    let tip = foot + Vec3::Y * height + lean;
    // Grass is lit as if it were a soft mound rather than blade by blade.
    let normal = (Vec3::Y * 1.5 + lean * (0.6 / height)).normalize();
    let mut vertex = |position: Vec3, sway: f32, u: f32, v: f32| {
        wind.bends(sway * height, random_phase(position));
        builder.vertex(position, normal, Vec2::new(u, v))
    };
    let [a, b] = [vertex(foot - across, 0.0, 0.0, 1.0), vertex(foot + across, 0.0, 1.0, 1.0)];
    let [c, d] = [vertex(middle - across * 0.7, 0.08, 0.1, 0.4), vertex(middle + across * 0.7, 0.08, 0.9, 0.4)];
    let e = vertex(tip, 0.2, 0.5, 0.0);
    builder.triangle([a, b, d]);
    builder.triangle([a, d, c]);
    builder.triangle([c, d, e]);
}

/// Gusts travel over the grass: neighbours have neighbouring phases.
fn random_phase(position: Vec3) -> f32 {
    let phase = 0.31 * position.x + 0.17 * position.z;
    phase - phase.floor()
}

/// Adds a fern: a rosette of arching fronds, each a strip that wears a masked texture.
pub(super) fn fern(
    builder: &mut MeshBuilder,
    wind: &mut Wind,
    random: &mut Random,
    foot: Vec3,
    size: f32,
    detail: Detail,
) {
    let fronds = 6 + random.below(4);
    let rows = detail.quads(6, 2);
    for frond in 0..fronds {
        let (sin, cos) = sin_cos(TAU * (frond as f32 + 0.6 * random.unit()) / fronds as f32);
        let out = Vec3::new(cos, 0.0, sin);
        let side = Vec3::new(-sin, 0.0, cos) * (0.2 * size);
        let (length, rise) = (size * random.range(0.75, 1.1), random.range(0.55, 0.95));
        let spine = |part: f32| {
            let arch = rise * part - (0.35 + 0.45 * rise) * part * part * part;
            foot + out * (length * part) + Vec3::Y * (length * arch)
        };
        let first = builder.positions.len() as u32;
        let phase = random.unit();
        for row in 0..=rows {
            let part = row as f32 / rows as f32;
            let center = spine(part);
            let tangent = spine(part + 0.01) - spine(part - 0.01);
            let normal = side.cross(tangent).normalize_or(Vec3::Y);
            let normal = if normal.y < 0.0 { -normal } else { normal };
            for (edge, u) in [(-1.0, 0.0), (1.0, 1.0)] {
                builder.vertex(center + side * edge, normal, Vec2::new(u, 1.0 - part));
                wind.bends(0.06 * size * part, phase);
            }
        }
        for row in 0..rows {
            let corner = first + 2 * row;
            builder.triangle([corner, corner + 2, corner + 3]);
            builder.triangle([corner, corner + 3, corner + 1]);
        }
    }
}

/// Adds a flower: a bent stalk and five petals around a heart.
pub(super) fn flower(builder: &mut MeshBuilder, wind: &mut Wind, random: &mut Random, foot: Vec3, petal_tint: Vec3) {
    let height = random.range(0.08, 0.17);
    let top = foot + Vec3::new(random.range(-0.03, 0.03), height, random.range(-0.03, 0.03));
    let phase = random_phase(foot);
    let sway = 0.12 * height;
    builder.paint(paints::GRASS);
    let across = Vec3::new(0.0025, 0.0, 0.0015);
    for (position, sway) in [(foot - across, 0.0), (foot + across, 0.0), (top, sway)] {
        builder.vertex(position, Vec3::ZERO, Vec2::ZERO);
        wind.bends(sway, phase);
    }
    let last = builder.positions.len() as u32;
    builder.triangle([last - 3, last - 2, last - 1]);
    let face = (Vec3::Y + 0.6 * random.direction().with_y(0.0) + Vec3::Z * 0.4).normalize();
    let turn = rotation_between(Vec3::Y, face) * turned(random.range(0.0, TAU));
    let radius = random.range(0.018, 0.03);
    builder.paint(paints::PETAL).tint(petal_tint);
    for petal in 0..5 {
        let corner = |out: f32, turns: f32, up: f32| {
            let (sin, cos) = sin_cos(TAU * (petal as f32 + turns) / 5.0);
            top + turn * (Vec3::new(cos * out, up, sin * out) * radius)
        };
        let corners =
            [corner(0.1, 0.0, 0.0), corner(0.8, -0.36, 0.22), corner(1.15, 0.0, 0.3), corner(0.8, 0.36, 0.22)];
        builder.quad(corners, Vec2::ONE);
        (0..4).for_each(|_| wind.bends(sway, phase));
    }
    builder.paint(paints::HEART);
    let first = builder.positions.len();
    builder.icosphere(top + face * (0.1 * radius), 0.32 * radius, 1);
    (first..builder.positions.len()).for_each(|_| wind.bends(sway, phase));
}

/// Adds a toadstool with its foot at the origin and its cap `height` above. The cap's texture goes around with u, and
/// from the rim to the crown with v from 1 to 0.
pub(super) fn toadstool(builder: &mut MeshBuilder, height: f32, cap_radius: f32, openness: f32, detail: Detail) {
    let around = detail.quads(24, 5);
    let stem_radius = cap_radius * 0.24;
    let stem_outline = [(1.35, -0.05), (1.2, 0.06), (0.9, 0.3), (0.78, 0.6), (0.8, 0.9), (0.85, 1.0)]
        .map(|(radius, part)| Vec2::new(radius * stem_radius, part * height));
    builder.paint(paints::STEM).lathe(&stem_outline, around);
    let skirt = [(1.0, 0.74), (1.75, 0.66), (1.7, 0.65), (0.9, 0.71)]
        .map(|(radius, part)| Vec2::new(radius * stem_radius, part * height));
    builder.lathe(&[skirt[2], skirt[1], skirt[0]], around);
    let drop = cap_radius * mix(0.55, 0.12, openness);
    let rim = Vec2::new(cap_radius * mix(0.85, 1.0, openness), height - drop);
    let gills = [Vec2::new(stem_radius * 0.8, height - 0.12 * drop), Vec2::new(0.6 * rim.x, height - 0.45 * drop), rim];
    builder.lathe(&gills, around);
    let dome = cap_radius * mix(0.75, 0.42, openness);
    let rows = detail.quads(12, 3);
    builder.paint(paints::SPOTTED).sheet(Sheet::tube(around, rows), |u, v| {
        let (sin_v, cos_v) = sin_cos(mix(-0.06, 0.25, v) * TAU);
        let across = if v >= 1.0 { 0.0 } else { cos_v * rim.x / 0.93 };
        math::around(u, across, rim.y + (sin_v + 0.368) * 0.8 * dome)
    });
}

/// The movement of a part that stands on the ground at `foot`, turned at random and tilted by up to `tilt` radians.
pub(super) fn planted(random: &mut Random, foot: Vec3, tilt: f32) -> Affine3A {
    let axis = random.direction().with_y(0.0).normalize_or(Vec3::X);
    let turn = rotation(axis, random.range(-tilt, tilt)) * turned(random.range(0.0, TAU));
    Affine3A::from_rotation_translation(turn, foot)
}

/// Amplitude and phase of each plant vertex in the wind.
///
/// Eight bytes a vertex.
#[derive(Clone, Debug, Default)]
pub(super) struct Wind {
    /// Amplitude in metres, and phase in turns, 0 … 1.
    bends: Vec<[f32; 2]>,
}

impl Wind {
    /// Sets the motion of the next vertex.
    pub(super) fn bends(&mut self, amplitude: f32, phase: f32) {
        self.bends.push([amplitude, phase]);
    }

    /// Number of moving vertices.
    pub(super) fn len(&self) -> usize {
        self.bends.len()
    }

    /// Moves `positions`, one for each call of [`Wind::bends`], from rest to `part`, 0 … 1, of a cycle; the cycle ends
    /// where it starts.
    pub(super) fn blow(&self, part: f32, positions: &mut [Vec3]) {
        /// Gusts for each cycle, slow and quick, whole numbers.
        const GUSTS: [f32; 2] = [5.0, 13.0];
        const STEPS: usize = 512;
        /// Vertices for each task.
        const CHUNK: usize = 4096;
        // One sine for each phase rather than for each vertex.
        let gust: [Vec3; STEPS] = std::array::from_fn(|step| {
            let phase = step as f32 / STEPS as f32;
            let slow = 0.4 + wave(GUSTS[0] * part + phase);
            let quick = cos(TAU * (GUSTS[1] * part + 2.0 * phase));
            Vec3::new(-slow - 0.25 * quick, 0.3 * quick, -0.35 * slow + 0.4 * quick)
        });
        positions.par_chunks_mut(CHUNK).zip(self.bends.par_chunks(CHUNK)).each(|(positions, bends)| {
            for (position, &[amplitude, phase]) in positions.iter_mut().zip(bends) {
                let step = (phase * STEPS as f32) as usize;
                *position += gust[step.min(STEPS - 1)] * amplitude;
            }
        });
    }
}
