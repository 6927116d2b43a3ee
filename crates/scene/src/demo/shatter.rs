//! A rabbit that bursts, every triangle on its own path, and comes together again.

use std::sync::Arc;

use glam::{Quat, Vec2, Vec3};
use rayon::prelude::*;

use super::build::math::{mix, rotation, rotation_between, smoothstep, turned, wave};
use super::build::{MeshBuilder, Palette, Random, noise, srgb};
use super::{DemoScene, sculpture, studio};
use crate::Frame;
use crate::still::Still;

/// A rabbit that bursts, every triangle on its own path, and comes together again.
#[derive(Debug)]
pub(crate) struct Shatter {
    /// The whole rabbit, three vertices to each of its triangles, then the floor.
    still: Still,
    /// One for each of the rabbit's triangles.
    shards: Vec<Shard>,
}

/// How one triangle flies. Times are in seconds since the blast.
#[derive(Clone, Copy, Debug)]
struct Shard {
    /// When the blast reaches it.
    start: f32,
    /// How long it then takes to fall to the floor; infinite if it doesn't while the scene lasts.
    flight: f32,
    velocity: Vec3,
    /// Axis of its tumbling times its angular velocity, in radians a second.
    spin: Vec3,
    /// How fast air slows it down, one over seconds.
    drag: f32,
    /// How long it hops after its fall.
    hop: f32,
}

impl Shatter {
    pub(crate) const SCENE: DemoScene =
        DemoScene { name: "shatter", about: "a statue bursts, every triangle for itself", triangles: 252_000 };

    const SECONDS: f32 = 8.0;
    /// Time since the blast when the pieces turn back.
    const LONGEST: f32 = 2.6;
    /// Where the blast is.
    const BLAST: Vec3 = Vec3::new(0.0, 0.85, 0.0);

    /// The scene with about `triangles` triangles.
    pub(crate) fn open(triangles: usize) -> Self {
        let mut palette = Palette::default();
        let porcelain = palette.dull("porcelain", srgb(0xf3e3d0), 0.42);
        palette.material(porcelain).double_sided = true;
        let floor = palette.dull("floor", srgb(0x4a5a68), 0.6);

        let columns = studio::backdrop_columns(triangles);
        let wanted = triangles.saturating_sub(studio::backdrop_triangles(columns));
        let surface = sculpture::mesh(&sculpture::rabbit(), wanted);
        let mut builder = MeshBuilder::new();
        builder.material(porcelain);
        for triangle in &surface.triangles {
            let corners = triangle.map(|vertex| {
                let vertex = vertex as usize;
                builder.vertex(surface.positions[vertex], surface.normals[vertex], Vec2::ZERO)
            });
            builder.triangle(corners);
        }
        let shards = (0..surface.triangles.len())
            .into_par_iter()
            .map(|shard| Shard::new(shard, middle(&builder.positions[3 * shard..][..3])))
            .collect();
        studio::backdrop(builder.material(floor), 13.0, 9.0, columns);
        Self { still: builder.finish(palette.finish()), shards }
    }

    pub(crate) fn duration_seconds(&self) -> f64 {
        f64::from(Self::SECONDS)
    }

    /// Time since the blast at a moment of the scene: the pieces fly ever slower, stop, and come back.
    fn since_blast(seconds: f32) -> f32 {
        let left = 1.0 - ((seconds - 0.8) / 4.4).clamp(0.0, 1.0);
        let out = 1.0 - left * left;
        Self::LONGEST * out * (1.0 - smoothstep(5.4, 7.7, seconds))
    }

    pub(crate) fn pose(&self, seconds: f64, frame: &mut Frame) {
        let seconds = seconds as f32;
        let (positions, normals) = (&self.still.positions, &self.still.normals);
        let pieces = 3 * self.shards.len();
        frame.positions.resize(positions.len(), Vec3::ZERO);
        frame.normals.resize(normals.len(), Vec3::ZERO);
        frame.tangents.clear();
        frame.mesh = Arc::clone(&self.still.mesh);
        frame.materials = Arc::clone(&self.still.materials);
        frame.positions[pieces..].copy_from_slice(&positions[pieces..]);
        frame.normals[pieces..].copy_from_slice(&normals[pieces..]);

        let now = Self::since_blast(seconds);
        const BATCH: usize = 1024;
        let moved = frame.positions[..pieces].par_chunks_mut(3 * BATCH).zip(frame.normals.par_chunks_mut(3 * BATCH));
        let rest = positions.par_chunks(3 * BATCH).zip(normals.par_chunks(3 * BATCH));
        moved.zip(rest).zip(self.shards.par_chunks(BATCH)).for_each(|((moved, rest), shards)| {
            let moved = moved.0.chunks_exact_mut(3).zip(moved.1.chunks_exact_mut(3));
            let rest = rest.0.chunks_exact(3).zip(rest.1.chunks_exact(3));
            for ((moved, rest), shard) in moved.zip(rest).zip(shards) {
                shard.write(now, rest, moved);
            }
        });

        let turns = seconds / Self::SECONDS;
        let apart = smoothstep(0.0, Self::LONGEST, now);
        let target = Vec3::new(0.0, mix(1.12, 0.95, apart), 0.0);
        let away = mix(5.0, 6.4, apart);
        let eye = target + turned(-0.55 + 0.25 * wave(turns)) * Vec3::new(0.0, 0.22 * away, away);
        studio::look(frame, "front", eye, target, 0.30);
        studio::light(frame, "key", Vec3::new(-3.4, 5.2, 3.6), Self::BLAST, srgb(0xffeedd), 1.0);
        studio::light(frame, "rim", Vec3::new(4.0, 3.0, -4.0), Self::BLAST, srgb(0x9fc4ff), 0.5);
    }
}

/// The mean of three corners.
fn middle(corners: &[Vec3]) -> Vec3 {
    (corners[0] + corners[1] + corners[2]) * (1.0 / 3.0)
}

impl Shard {
    /// How high the middles of lying shards are: enough that they don't share a plane with the floor.
    const LYING: f32 = 0.004;

    /// The flight of piece number `shard`, whose middle is at `place`: away from the blast, faster where the rabbit is
    /// weaker, and a little at random.
    fn new(shard: usize, place: Vec3) -> Self {
        let mut random = Random::new(shard as u64);
        let offset = place - Shatter::BLAST;
        let distance = offset.length().max(0.05);
        // Neighbours share most of their speed, so that the cloud has streaks and holes rather than one density.
        let weakness = 1.0 + 0.7 * noise(place * 3.1) + 0.35 * noise(place * 9.0);
        let speed = (2.6 / (0.45 + distance)) * weakness.max(0.15) * random.range(0.75, 1.25);
        let velocity = offset / distance * speed + random.direction() * 0.35 + Vec3::Y * 0.9;
        let small = random.unit();
        let mut piece = Self {
            start: 0.16 * distance + 0.05 * random.unit(),
            flight: f32::INFINITY,
            velocity,
            spin: random.direction() * random.range(2.0, 16.0),
            drag: mix(0.25, 1.1, small * small),
            hop: random.range(0.08, 0.3),
        };
        piece.flight = piece.fall(place);
        piece
    }

    /// How far the piece has gone after `age` seconds in the air: air takes its speed away, and falling has an end.
    fn path(&self, age: f32) -> Vec3 {
        const GRAVITY: f32 = 5.5;
        let slowed = 1.0 + self.drag * age;
        let fallen = 0.5 * GRAVITY * age * age / slowed;
        self.velocity * (age / slowed) - Vec3::Y * fallen
    }

    /// When the piece that starts at `place` is down on the floor.
    fn fall(&self, place: Vec3) -> f32 {
        let height = |age: f32| place.y + self.path(age).y - Self::LYING;
        let (mut above, mut below) = (0.0, Shatter::LONGEST);
        if height(below) > 0.0 {
            return f32::INFINITY;
        }
        for _ in 0..24 {
            let half = 0.5 * (above + below);
            if height(half) > 0.0 { above = half } else { below = half }
        }
        below
    }

    /// Writes the piece's corners and normals at `now` seconds since the blast, from where they are at rest.
    fn write(&self, now: f32, rest: (&[Vec3], &[Vec3]), moved: (&mut [Vec3], &mut [Vec3])) {
        let age = now - self.start;
        if age <= 0.0 {
            moved.0.copy_from_slice(rest.0);
            moved.1.copy_from_slice(rest.1);
            return;
        }
        let home = middle(rest.0);
        let place = home + self.path(age.min(self.flight));
        let mut turn = self.tumble(age.min(self.flight));
        let mut offset = Vec3::ZERO;
        if age > self.flight {
            let lying = age - self.flight;
            let part = (lying / self.hop).min(1.0);
            let speed = self.velocity.with_y(0.0) * 0.25;
            offset =
                speed * (lying / (1.0 + 5.0 * lying)) + Vec3::Y * (1.2 * self.hop * self.hop * part * (1.0 - part));
            turn = turn.lerp(flat(turn, rest.0), part);
        }
        let mut lowest = f32::INFINITY;
        for corner in 0..3 {
            let position = place + offset + turn * (rest.0[corner] - home);
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

    /// How the piece has turned after `age` seconds in the air.
    fn tumble(&self, age: f32) -> Quat {
        let rate = self.spin.length();
        rotation(self.spin / rate, rate * age / (1.0 + 0.5 * self.drag * age))
    }
}

/// The rotation nearest to `turn` after which the triangle lies level.
fn flat(turn: Quat, corners: &[Vec3]) -> Quat {
    let normal = turn * (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or(Vec3::Y);
    let level = rotation_between(normal, if normal.y < 0.0 { Vec3::NEG_Y } else { Vec3::Y }) * turn;
    // Two quaternions stand for each rotation: take the near one, so that mixing them doesn't go the long way round.
    if level.dot(turn) < 0.0 { -level } else { level }
}
