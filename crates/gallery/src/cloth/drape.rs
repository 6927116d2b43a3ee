use glam::Vec3;
use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;

use crate::build::math::{rotation, smoothstep, turned};
use crate::build::{Sheet, noise};

/// Duration of the drape.
pub(super) const SECONDS: f32 = 6.0;
/// The ball's middle; it rests on the floor, y = 0.
pub(super) const BALL_CENTER: Vec3 = Vec3::new(0.0, BALL_RADIUS, 0.0);
/// The ball's radius.
pub(super) const BALL_RADIUS: f32 = 0.8;

/// Particles along each side of the cloth.
const SIDE: usize = 68;
/// Length of each side.
const SIDE_LENGTH: f32 = 4.0;
const SPACING: f32 = SIDE_LENGTH / (SIDE - 1) as f32;
const START_HEIGHT: f32 = 2.1;
const FRAMES_PER_SECOND: f32 = 60.0;
/// Small steps with one iteration each stiffen cloth more than few steps with many (Macklin et al. 2019).
const STEPS_PER_FRAME: u32 = 6;
/// Keeps the drawn cloth, which cuts corners between particles, out of the ball and the floor.
const THICKNESS: f32 = 0.025;
/// Minimum distance of the drawn cloth.
const DRAWN_THICKNESS: f32 = 0.008;

/// Rotation of the ball about the vertical axis: first none, then ever faster, then to a stop.
pub(super) fn ball_turn_radians(seconds: f32) -> f32 {
    2.6 * smoothstep(2.4, 5.2, seconds)
}

/// A cloth's motion: the positions of a grid of particles in every sixtieth of a second.
#[derive(Debug)]
pub(super) struct Drape {
    /// SIDE · SIDE positions for each moment, row after row.
    moments: Vec<Vec<Vec3>>,
}

impl Drape {
    /// Drops the cloth (position-based dynamics with distance constraints, Müller et al. 2007).
    pub(super) fn simulate() -> Self {
        let mut cloth = Particles::hanging();
        let frames = (SECONDS * FRAMES_PER_SECOND) as u32;
        let seconds = 1.0 / (FRAMES_PER_SECOND * STEPS_PER_FRAME as f32);
        let mut moments = vec![cloth.positions.clone()];
        for frame in 0..frames {
            for step in 0..STEPS_PER_FRAME {
                let now = (frame * STEPS_PER_FRAME + step) as f32 * seconds;
                cloth.step(now, seconds);
            }
            moments.push(cloth.positions.clone());
        }
        Self { moments }
    }

    /// Writes the points of `sheet`, smooth between the particles, at a moment of 0 … [`SECONDS`].
    pub(super) fn write_sheet(&self, seconds: f32, sheet: Sheet, positions: &mut [Vec3]) {
        let at = (seconds * FRAMES_PER_SECOND).clamp(0.0, (self.moments.len() - 1) as f32);
        let before = (at as usize).min(self.moments.len() - 2);
        let part = at - before as f32;
        let [from, to] = [&self.moments[before], &self.moments[before + 1]];
        let stride = sheet.columns as usize + 1;
        positions.par_chunks_mut(stride).enumerate().each(|(row, line)| {
            let (first_row, row_weights) = spline(row as f32 / sheet.rows as f32);
            // Four rows of particles mixed into one, with a ghost beyond each end.
            let mut mixed = [Vec3::ZERO; SIDE + 2];
            for column in 0..SIDE {
                let along = (0..4).map(|tap| {
                    let weight = row_weights[tap];
                    let position = |row: usize| {
                        let vertex = row * SIDE + column;
                        from[vertex] + (to[vertex] - from[vertex]) * part
                    };
                    beyond(first_row + tap, position) * weight
                });
                mixed[column + 1] = along.sum();
            }
            mixed[0] = 2.0 * mixed[1] - mixed[2];
            mixed[SIDE + 1] = 2.0 * mixed[SIDE] - mixed[SIDE - 1];
            for (column, position) in line.iter_mut().enumerate() {
                let (first, weights) = spline(column as f32 / sheet.columns as f32);
                let smooth: Vec3 = (0..4).map(|tap| mixed[first + tap] * weights[tap]).sum();
                *position = outside(smooth, DRAWN_THICKNESS);
            }
        });
    }
}

/// Row `at` of a grid of SIDE rows with an extra row at each end, which continues the cloth straight.
fn beyond(at: usize, position: impl Fn(usize) -> Vec3) -> Vec3 {
    match at {
        0 => 2.0 * position(0) - position(1),
        at if at == SIDE + 1 => 2.0 * position(SIDE - 1) - position(SIDE - 2),
        at => position(at - 1),
    }
}

/// The first of four neighbouring points, of SIDE with one more before them, and their weights in the uniform cubic
/// B-spline at `part` of its length.
fn spline(part: f32) -> (usize, [f32; 4]) {
    let at = part * (SIDE - 1) as f32;
    let first = (at as usize).min(SIDE - 2);
    let t = at - first as f32;
    let s = 1.0 - t;
    let weights = [s * s * s, 3.0 * t * t * t - 6.0 * t * t + 4.0, 3.0 * s * s * s - 6.0 * s * s + 4.0, t * t * t];
    (first, weights.map(|weight| weight / 6.0))
}

/// The nearest point to `position` that is `gap` away from the ball and the floor.
fn outside(position: Vec3, gap: f32) -> Vec3 {
    let offset = position - BALL_CENTER;
    let squared = offset.length_squared();
    let radius = BALL_RADIUS + gap;
    let position =
        if squared < radius * radius { BALL_CENTER + offset * (radius / squared.sqrt().max(1e-6)) } else { position };
    position.with_y(position.y.max(gap))
}

struct Particles {
    positions: Vec<Vec3>,
    before: Vec<Vec3>,
}

impl Particles {
    /// Level, a little turned, and not quite flat, so that it folds like cloth rather than like a symmetric pattern.
    fn hanging() -> Self {
        let tilt = turned(0.35) * rotation(Vec3::Z, 0.05);
        let half = 0.5 * (SIDE - 1) as f32;
        let positions: Vec<Vec3> = (0..SIDE * SIDE)
            .map(|index| {
                let (column, row) = ((index % SIDE) as f32, (index / SIDE) as f32);
                let flat = Vec3::new(column - half, 0.0, half - row) * SPACING;
                let bump = 0.004 * noise(2.0 * flat + 0.3);
                Vec3::Y * START_HEIGHT + tilt * flat.with_y(bump)
            })
            .collect();
        Self { before: positions.clone(), positions }
    }

    fn step(&mut self, now: f32, seconds: f32) {
        /// Half of the Earth's: the ball looks twice as large as it is.
        const GRAVITY: Vec3 = Vec3::new(0.0, -5.0, 0.0);
        /// Part of the speed that air takes away each second.
        const DRAG: f32 = 0.9;
        let keep = 1.0 - DRAG * seconds;
        for (position, before) in self.positions.iter_mut().zip(&mut self.before) {
            let next = *position + (*position - *before) * keep + GRAVITY * (seconds * seconds);
            *before = std::mem::replace(position, next);
        }
        self.hold_together();
        self.touch(ball_turn_radians(now + seconds) - ball_turn_radians(now));
    }

    /// Pulls neighbours to their distance: along the threads, across them, and two apart against bending.
    fn hold_together(&mut self) {
        const THREAD: f32 = 1.0;
        const SHEAR: f32 = 0.35;
        const BEND: f32 = 0.04;
        const DIAGONAL: f32 = std::f32::consts::SQRT_2;
        for row in 0..SIDE {
            self.pull(row * SIDE, 1, SIDE - 1, SPACING, THREAD);
            self.pull(row * SIDE, 2, SIDE - 2, 2.0 * SPACING, BEND);
            if row + 1 < SIDE {
                self.pull(row * SIDE, SIDE, SIDE, SPACING, THREAD);
                self.pull(row * SIDE, SIDE + 1, SIDE - 1, DIAGONAL * SPACING, SHEAR);
                self.pull(row * SIDE + 1, SIDE - 1, SIDE - 1, DIAGONAL * SPACING, SHEAR);
            }
            if row + 2 < SIDE {
                self.pull(row * SIDE, 2 * SIDE, SIDE, 2.0 * SPACING, BEND);
            }
        }
    }

    /// Moves `count` pairs from `first` on, `step` particles apart, towards `length`.
    fn pull(&mut self, first: usize, step: usize, count: usize, length: f32, stiffness: f32) {
        // Every other run of `step` pairs first: their pairs are independent, so the processor overlaps them, and the
        // pull has no direction that cloth would creep along.
        for start in (0..count).step_by(2 * step).chain((step..count).step_by(2 * step)) {
            for low in first + start..first + count.min(start + step) {
                let high = low + step;
                let offset = self.positions[high] - self.positions[low];
                let distance = offset.length().max(1e-6);
                let move_by = offset * (0.5 * stiffness * (distance - length) / distance);
                self.positions[low] += move_by;
                self.positions[high] -= move_by;
            }
        }
    }

    /// Keeps particles out of the ball, which turns by `turn_radians`, and the floor, and rubs them against both.
    fn touch(&mut self, turn_radians: f32) {
        const BALL_FRICTION: f32 = 0.5;
        const FLOOR_FRICTION: f32 = 0.3;
        for (position, before) in self.positions.iter_mut().zip(&mut self.before) {
            let resting = outside(*position, THICKNESS);
            if resting == *position {
                continue;
            }
            let offset = resting - BALL_CENTER;
            let on_floor = resting.y <= THICKNESS;
            // Displacement of the surface below in this step, and the fraction of the difference that friction takes.
            let (surface, normal, friction) = if on_floor {
                (Vec3::ZERO, Vec3::Y, FLOOR_FRICTION)
            } else {
                (Vec3::new(offset.z, 0.0, -offset.x) * turn_radians, offset.normalize_or(Vec3::Y), BALL_FRICTION)
            };
            let moved = resting - *before - surface;
            let along = moved - normal * moved.dot(normal);
            *position = resting;
            // Speed is the last displacement: no bounce off the surface, and less along it.
            *before = resting - surface - along * (1.0 - friction);
        }
    }
}
