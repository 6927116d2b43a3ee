//! A rabbit that bursts, every triangle on its own path, and comes together again.

use std::sync::Arc;

use glam::{Mat3, Quat, Vec2, Vec3};
use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;

use super::build::math::{mix, rotation, rotation_between, smoothstep, turned, wave};
use super::build::{MeshBuilder, Paint, Random, hash, noise, srgb};
use super::{DemoScene, Moment, Pose, sculpture, studio};

pub(crate) const SCENE: DemoScene = DemoScene {
    name: "shatter",
    about: "a statue bursts, every triangle for itself",
    triangles: 252_000,
    seconds: 8.0,
    still_seconds: 1.6,
    open,
};

const PORCELAIN: Paint = Paint::dull("porcelain", 0xf3e3d0, 0.42);
const FLOOR: Paint = Paint::dull("floor", 0x77706a, 0.6);

/// A piece of the rabbit that flies as one at first, while it crumbles. Times are in seconds since the blast.
#[derive(Clone, Copy, Debug)]
struct Chunk {
    middle: Vec3,
    /// Time at which the blast reaches it.
    start: f32,
    velocity: Vec3,
    /// Axis of its tumbling, and its angular velocity in radians a second.
    spin: (Vec3, f32),
}

/// Motion of one triangle.
#[derive(Clone, Copy, Debug)]
struct Shard {
    /// Index of its first chunk.
    chunk: u32,
    /// Velocity relative to its chunk, reached slowly.
    velocity: Vec3,
    /// Half its own angular velocity, along its axis.
    spin: Vec3,
    /// Time at which it reaches the floor, in seconds since the blast; infinite if it doesn't within the scene.
    landing: f32,
    /// Its middle and its rotation at landing, relative to its home.
    landed: (Vec3, Quat),
    /// Seconds that it hops after its fall.
    hop: f32,
}

/// Time since the blast when the pieces turn back.
const LONGEST: f32 = 1.6;
/// Position of the blast.
const BLAST: Vec3 = Vec3::new(0.0, 0.85, 0.0);

fn open(triangles: usize) -> Pose {
    let columns = studio::backdrop_columns(triangles);
    let wanted = triangles.saturating_sub(studio::backdrop_triangles(columns));
    let surface = sculpture::mesh(&sculpture::rabbit(), wanted);
    let mut builder = MeshBuilder::new();
    // Three vertices to each triangle.
    builder.paint(PORCELAIN);
    for triangle in &surface.triangles {
        let corners = triangle.map(|vertex| {
            let vertex = vertex as usize;
            builder.vertex(surface.positions[vertex], surface.normals[vertex], Vec2::ZERO)
        });
        builder.triangle(corners);
    }
    let (chunks, shards) = break_up(&builder.positions);
    studio::backdrop(builder.paint(FLOOR), 13.0, 9.0, columns);
    let still = builder.finish();

    Box::new(move |Moment { seconds, part }, frame| {
        let (positions, normals) = (&still.positions, &still.normals);
        let pieces = 3 * shards.len();
        frame.positions.resize(positions.len(), Vec3::ZERO);
        frame.normals.resize(normals.len(), Vec3::ZERO);
        frame.tangents.clear();
        frame.mesh = Arc::clone(&still.mesh);
        frame.materials = Arc::clone(&still.materials);
        frame.positions[pieces..].copy_from_slice(&positions[pieces..]);
        frame.normals[pieces..].copy_from_slice(&normals[pieces..]);

        let now = since_blast(seconds);
        let flights: Vec<Flight> = chunks.iter().map(|chunk| chunk.flight(now)).collect();
        const BATCH: usize = 1024;
        let moved = frame.positions[..pieces].par_chunks_mut(3 * BATCH).zip(frame.normals.par_chunks_mut(3 * BATCH));
        let rest = positions.par_chunks(3 * BATCH).zip(normals.par_chunks(3 * BATCH));
        moved.zip(rest).zip(shards.par_chunks(BATCH)).each(|((moved, rest), shards)| {
            let moved = moved.0.chunks_exact_mut(3).zip(moved.1.chunks_exact_mut(3));
            let rest = rest.0.chunks_exact(3).zip(rest.1.chunks_exact(3));
            for ((moved, rest), shard) in moved.zip(rest).zip(shards) {
                shard.write(now, &flights[shard.chunk as usize], rest, moved);
            }
        });

        let apart = smoothstep(0.0, LONGEST, now);
        let target = Vec3::new(0.0, mix(1.12, 0.95, apart), 0.0);
        let away = mix(5.2, 7.2, apart);
        let eye = target + turned(-0.55 + 0.25 * wave(part)) * Vec3::new(0.0, 0.22 * away, away);
        studio::look(frame, "front", eye, target, 0.30);
        studio::light(frame, "key", Vec3::new(-3.4, 5.2, 3.6), BLAST, srgb(0xffeedd), 1.0);
        studio::light(frame, "rim", Vec3::new(4.0, 3.0, -4.0), BLAST, srgb(0x9fc4ff), 0.5);
    })
}

/// Time since the blast at a moment of the scene: at first it almost stands still, and in the end it runs back.
fn since_blast(seconds: f32) -> f32 {
    let out = ((seconds - 0.8) / 4.4).clamp(0.0, 1.0);
    LONGEST * out * (0.35 + 0.65 * out) * (1.0 - smoothstep(5.4, 7.7, seconds))
}

/// The mean of three corners.
fn middle(corners: &[Vec3]) -> Vec3 {
    (corners[0] + corners[1] + corners[2]) * (1.0 / 3.0)
}

/// Chunks and shards of the triangles that `corners` holds three by three.
fn break_up(corners: &[Vec3]) -> (Vec<Chunk>, Vec<Shard>) {
    const CHUNKS_PER_UNIT: f32 = 4.0;
    // Cracks run along the walls of a lattice's cells, bent so that no wall is flat.
    let cell_of = |position: Vec3| {
        let bend = Vec3::new(noise(position * 2.7), noise(position * 2.7 + 40.0), noise(position * 2.7 + 80.0));
        (position * CHUNKS_PER_UNIT + 0.9 * bend).floor().as_ivec3().to_array()
    };
    let cells: Vec<[i32; 3]> = corners.par_chunks_exact(3).map(|corners| cell_of(middle(corners))).collect();
    let mut found = cells.clone();
    found.sort_unstable();
    found.dedup();
    let chunks: Vec<Chunk> = found
        .iter()
        .map(|&[x, y, z]| {
            let middle = (Vec3::new(x as f32, y as f32, z as f32) + 0.5) / CHUNKS_PER_UNIT;
            Chunk::new(middle, u64::from(hash(x, y, z)))
        })
        .collect();
    let shards = cells.par_iter().zip(corners.par_chunks_exact(3)).enumerate().map(|(shard, (cell, corners))| {
        // Every cell was found, so the search succeeds.
        let chunk = found.binary_search(cell).unwrap_or(0);
        Shard::new(shard, chunk as u32, &chunks[chunk], middle(corners))
    });
    let shards = shards.collect();
    (chunks, shards)
}

/// Position of a flying chunk.
#[derive(Clone, Copy, Debug)]
struct Flight {
    /// Seconds since it broke off; zero or less before.
    age: f32,
    middle: Vec3,
    home: Vec3,
    turn: Quat,
}

impl Chunk {
    /// The chunk of the rabbit around `middle`: it flies away from the blast.
    fn new(middle: Vec3, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let offset = middle - BLAST;
        let distance = offset.length().max(0.05);
        let speed = 2.1 / (0.5 + distance) * random.range(0.6, 1.3);
        let velocity = offset / distance * speed + random.direction() * 0.35 + Vec3::Y * 0.8;
        let spin = (random.direction(), random.range(0.5, 4.0));
        Self { middle, start: 0.10 * distance, velocity, spin }
    }

    fn flight(&self, now: f32) -> Flight {
        const GRAVITY: f32 = 4.0;
        const DRAG: f32 = 0.35;
        let age = now - self.start;
        let flown = age.max(0.0);
        // Air takes speed away: the way goes on ever slower, and falling has a greatest speed.
        let slowed = 1.0 + DRAG * flown;
        let fallen = 0.5 * GRAVITY * flown * flown / slowed;
        let middle = self.middle + self.velocity * (flown / slowed) - Vec3::Y * fallen;
        Flight { age, middle, home: self.middle, turn: rotation(self.spin.0, self.spin.1 * flown) }
    }
}

impl Shard {
    /// Height of the middles of lying shards: enough that they don't share a plane with the floor.
    const LYING: f32 = 0.004;

    /// The flight of piece number `shard`, whose middle is at `position`.
    fn new(shard: usize, chunk: u32, whole: &Chunk, position: Vec3) -> Self {
        let mut random = Random::new(shard as u64);
        // Few leave their chunk fast, like splinters; most slowly, like crumbs.
        let hurry = random.unit();
        let velocity = random.direction() * mix(0.03, 1.1, hurry * hurry * hurry);
        let spin = random.direction() * random.range(0.3, 6.0) * (0.1 + hurry * hurry);
        let hop = random.range(0.08, 0.3);
        let mut piece = Self { chunk, velocity, spin, landing: f32::INFINITY, landed: (position, Quat::IDENTITY), hop };
        let height = |now: f32| piece.fly(&whole.flight(now), position).0.y - Self::LYING;
        let (mut above, mut below) = (0.0, LONGEST);
        if height(below) <= 0.0 {
            for _ in 0..20 {
                let half = 0.5 * (above + below);
                if height(half) > 0.0 { above = half } else { below = half }
            }
            piece.landed = piece.fly(&whole.flight(below), position);
            piece.landing = below;
        }
        piece
    }

    /// Position and rotation of the piece with its middle at `home`, in its chunk's flight.
    fn fly(&self, chunk: &Flight, home: Vec3) -> (Vec3, Quat) {
        let age = chunk.age.max(0.0);
        let apart = self.velocity * (age * age / (0.4 + age));
        let tumble = self.spin * (age * age / (0.4 + age));
        // Half the angle's tangent instead of the angle: it needs no sine, and ever slower turning looks like air.
        let own = Quat::from_xyzw(tumble.x, tumble.y, tumble.z, 1.0).normalize();
        (chunk.middle + chunk.turn * (home - chunk.home) + apart, chunk.turn * own)
    }

    /// Writes the piece's corners and normals at `now` seconds since the blast, from those at rest.
    fn write(&self, now: f32, chunk: &Flight, rest: (&[Vec3], &[Vec3]), moved: (&mut [Vec3], &mut [Vec3])) {
        if chunk.age <= 0.0 {
            moved.0.copy_from_slice(rest.0);
            moved.1.copy_from_slice(rest.1);
            return;
        }
        let home = middle(rest.0);
        let (mut position, mut turn) = if now > self.landing { self.landed } else { self.fly(chunk, home) };
        if now > self.landing {
            let lying = now - self.landing;
            let part = (lying / self.hop).min(1.0);
            position += self.velocity.with_y(0.0) * (0.3 * lying / (1.0 + 5.0 * lying));
            position.y += 1.2 * self.hop * self.hop * part * (1.0 - part);
            turn = turn.lerp(flat(turn, rest.0), part);
        }
        // Six vectors to turn: a matrix takes half the multiplications of a quaternion.
        let turn = Mat3::from_quat(turn);
        let mut lowest = f32::INFINITY;
        for corner in 0..3 {
            let position = position + turn * (rest.0[corner] - home);
            lowest = lowest.min(position.y);
            moved.0[corner] = position;
            moved.1[corner] = turn * rest.1[corner];
        }
        // A corner that tumbles into the floor lifts the piece.
        let lift = (0.5 * Self::LYING - lowest).max(0.0);
        for position in moved.0 {
            position.y += lift;
        }
    }
}

/// The rotation nearest to `turn` after which the triangle lies level.
fn flat(turn: Quat, corners: &[Vec3]) -> Quat {
    let normal = turn * (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or(Vec3::Y);
    let level = rotation_between(normal, if normal.y < 0.0 { Vec3::NEG_Y } else { Vec3::Y }) * turn;
    // Two quaternions stand for each rotation: take the near one, so that mixing them doesn't go the long way round.
    if level.dot(turn) < 0.0 { -level } else { level }
}
