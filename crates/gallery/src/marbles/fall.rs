use std::sync::LazyLock;

use glam::{Quat, Vec3};

use crate::build::Random;
use crate::build::math::rotation;

/// Duration of the fall.
pub(super) const SECONDS: f32 = 7.0;
/// Number of marbles.
pub(super) const MARBLES: usize = 110;
/// The tray's boards, as boxes from lowest to highest corner: the bottom first, then the four sides.
pub(super) const BOARDS: [[Vec3; 2]; 5] = [
    [Vec3::new(-INNER.x, 0.0, -INNER.z), Vec3::new(INNER.x, BOTTOM, INNER.z)],
    [Vec3::new(-OUTER.x, 0.0, INNER.z), Vec3::new(OUTER.x, RIM, OUTER.z)],
    [Vec3::new(-OUTER.x, 0.0, -OUTER.z), Vec3::new(OUTER.x, RIM, -INNER.z)],
    [Vec3::new(-OUTER.x, 0.0, -INNER.z), Vec3::new(-INNER.x, RIM, INNER.z)],
    [Vec3::new(INNER.x, 0.0, -INNER.z), Vec3::new(OUTER.x, RIM, INNER.z)],
];
const INNER: Vec3 = Vec3::new(1.6, 0.0, 1.2);
const OUTER: Vec3 = Vec3::new(1.7, 0.0, 1.3);
const BOTTOM: f32 = 0.08;
const RIM: f32 = 0.6;

const FRAMES_PER_SECOND: f32 = 60.0;
const STEPS_PER_FRAME: u32 = 8;

/// Positions of the marbles in every sixtieth of a second.
#[derive(Debug)]
pub(super) struct Fall {
    /// Radius of each marble.
    pub(super) radii: Vec<f32>,
    /// Middle and rotation of each marble, for each moment.
    moments: Vec<Vec<(Vec3, Quat)>>,
}

/// The one fall, which every scene of marbles shows.
pub(super) static FALL: LazyLock<Fall> = LazyLock::new(Fall::simulate);

impl Fall {
    /// Pours the marbles into the tray: spheres with spin, impulses with restitution and Coulomb friction.
    fn simulate() -> Self {
        let mut marbles = poured();
        let seconds = 1.0 / (FRAMES_PER_SECOND * STEPS_PER_FRAME as f32);
        let now = |marbles: &[Marble]| marbles.iter().map(|marble| (marble.middle, marble.turn)).collect();
        let mut moments = vec![now(&marbles)];
        for _ in 0..(SECONDS * FRAMES_PER_SECOND) as u32 {
            for _ in 0..STEPS_PER_FRAME {
                step(&mut marbles, seconds);
            }
            moments.push(now(&marbles));
        }
        Self { radii: marbles.iter().map(|marble| marble.radius).collect(), moments }
    }

    /// Middle and rotation of `marble` at a moment of 0 … [`SECONDS`].
    pub(super) fn pose(&self, marble: usize, seconds: f32) -> (Vec3, Quat) {
        let at = (seconds * FRAMES_PER_SECOND).clamp(0.0, (self.moments.len() - 1) as f32);
        let before = (at as usize).min(self.moments.len() - 2);
        let part = at - before as f32;
        let [(from, turned_from), (to, turned_to)] = [before, before + 1].map(|moment| self.moments[moment][marble]);
        (from + (to - from) * part, turned_from.lerp(turned_to, part))
    }
}

#[derive(Clone, Copy, Debug)]
struct Marble {
    radius: f32,
    middle: Vec3,
    turn: Quat,
    velocity: Vec3,
    /// Angular velocity in radians a second.
    spin: Vec3,
}

impl Marble {
    /// One over the mass, all marbles being of one material.
    fn inverse_mass(&self) -> f32 {
        1.0 / (self.radius * self.radius * self.radius)
    }

    /// Velocity of the surface at `offset` from the middle.
    fn surface_velocity(&self, offset: Vec3) -> Vec3 {
        self.velocity + self.spin.cross(offset)
    }

    fn push(&mut self, impulse: Vec3, offset: Vec3) {
        let inverse_mass = self.inverse_mass();
        self.velocity += impulse * inverse_mass;
        // A solid ball's moment of inertia is 2/5 · mass · radius².
        self.spin += offset.cross(impulse) * (2.5 * inverse_mass / (self.radius * self.radius));
    }
}

/// The marbles before they fall: a loose, slowly turning column high above the tray.
fn poured() -> Vec<Marble> {
    let mut random = Random::new(110);
    (0..MARBLES)
        .map(|marble| {
            let radius = if marble % 11 == 5 { 0.21 } else { random.range(0.135, 0.16) };
            let height = 2.4 + 0.17 * marble as f32;
            let aside = rotation(Vec3::Y, 0.37 * marble as f32) * Vec3::X * random.range(0.1, 0.6);
            Marble {
                radius,
                middle: aside + Vec3::Y * height,
                turn: rotation(random.direction(), random.range(0.0, 3.0)),
                velocity: Vec3::new(random.range(-0.3, 0.3), -1.5, random.range(-0.2, 0.2)),
                spin: random.direction() * random.range(0.0, 6.0),
            }
        })
        .collect()
}

fn step(marbles: &mut [Marble], seconds: f32) {
    /// Half of the Earth's: marbles as large as oranges.
    const GRAVITY: f32 = 5.0;
    for marble in marbles.iter_mut() {
        marble.velocity.y -= GRAVITY * seconds;
        marble.middle += marble.velocity * seconds;
        let turn = marble.spin * (0.5 * seconds);
        let change = Quat::from_xyzw(turn.x, turn.y, turn.z, 0.0) * marble.turn;
        marble.turn = (marble.turn + change).normalize();
    }
    for first in 1..marbles.len() {
        let (before, rest) = marbles.split_at_mut(first);
        let one = &mut rest[0];
        for other in before {
            let offset = other.middle - one.middle;
            let reach = one.radius + other.radius;
            if offset.length_squared() < reach * reach {
                collide(one, other, seconds);
            }
        }
    }
    for marble in marbles {
        for [low, high] in BOARDS {
            meet(marble, marble.middle.clamp(low, high), seconds);
        }
        meet(marble, marble.middle.with_y(0.0), seconds);
    }
}

/// Bounces two marbles that overlap off each other.
fn collide(one: &mut Marble, other: &mut Marble, seconds: f32) {
    let offset = other.middle - one.middle;
    let distance = offset.length();
    let normal = offset / distance.max(1e-6);
    let inverse_mass = one.inverse_mass() + other.inverse_mass();
    let arms = [normal * one.radius, normal * -other.radius];
    let closing = other.surface_velocity(arms[1]) - one.surface_velocity(arms[0]);
    let impulse = contact_impulse(closing, normal, inverse_mass);
    other.push(impulse, arms[1]);
    one.push(-impulse, arms[0]);
    let overlap = normal * (PUSH_APART * (one.radius + other.radius - distance) / inverse_mass);
    one.middle -= overlap * one.inverse_mass();
    other.middle += overlap * other.inverse_mass();
    for marble in [one, other] {
        roll(marble, seconds);
    }
}

/// Bounces a marble off a still surface whose nearest point is `nearest`, if they overlap.
fn meet(marble: &mut Marble, nearest: Vec3, seconds: f32) {
    let offset = marble.middle - nearest;
    let squared = offset.length_squared();
    if squared >= marble.radius * marble.radius || squared == 0.0 {
        return;
    }
    let distance = squared.sqrt();
    let normal = offset / distance;
    let arm = normal * -marble.radius;
    let impulse = contact_impulse(marble.surface_velocity(arm), normal, marble.inverse_mass());
    marble.push(impulse, arm);
    marble.middle += normal * (PUSH_APART * (marble.radius - distance));
    roll(marble, seconds);
}

/// Fraction of the approaching speed after a bounce.
const RESTITUTION: f32 = 0.45;
/// Fraction of an overlap that each step removes: less than all, so that piles come to rest.
const PUSH_APART: f32 = 0.5;

/// The impulse on the marble that `normal` points to, from the surfaces' relative velocity.
fn contact_impulse(closing: Vec3, normal: Vec3, inverse_mass: f32) -> Vec3 {
    const FRICTION: f32 = 0.25;
    /// Slower contacts don't bounce, or nothing would ever rest.
    const BOUNCE_SPEED: f32 = 0.25;
    let speed = closing.dot(normal);
    if speed >= 0.0 {
        return Vec3::ZERO;
    }
    let bounce = if speed < -BOUNCE_SPEED { 1.0 + RESTITUTION } else { 1.0 };
    let along_normal = -bounce * speed / inverse_mass;
    let sliding = closing - normal * speed;
    // A solid ball's surface yields 7/2 times as easily along as across, because it starts to spin.
    let stop = sliding * (-1.0 / (3.5 * inverse_mass));
    let strongest = FRICTION * along_normal;
    let friction = if stop.length() > strongest { stop.normalize_or_zero() * strongest } else { stop };
    normal * along_normal + friction
}

/// Slows a marble by rolling friction during `seconds` of contact.
fn roll(marble: &mut Marble, seconds: f32) {
    const LOSS: f32 = 1.0;
    let keep = 1.0 - LOSS * seconds;
    marble.spin *= keep;
    marble.velocity *= keep;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dropped_marble_falls_as_galileo_says_and_bounces_lower() {
        let at = Vec3::new(0.0, 3.0, 4.0);
        let mut marbles =
            [Marble { radius: 0.15, middle: at, turn: Quat::IDENTITY, velocity: Vec3::ZERO, spin: Vec3::ZERO }];
        for _ in 0..480 {
            step(&mut marbles, 1.0 / 480.0);
        }
        let fallen = 3.0 - marbles[0].middle.y;
        assert!((fallen - 2.5).abs() < 0.02, "{fallen}");
        let mut highest = 0.0_f32;
        for _ in 0..960 {
            step(&mut marbles, 1.0 / 480.0);
            highest = highest.max(if marbles[0].velocity.y > 0.0 { marbles[0].middle.y } else { 0.0 });
        }
        // The height above the surface falls by restitution squared.
        assert!((highest - 0.15 - 2.85 * RESTITUTION * RESTITUTION).abs() < 0.05, "{highest}");
    }

    #[test]
    fn at_the_end_the_tray_holds_marbles_that_rest_apart_from_each_other() {
        let end = FALL.moments.last().expect("there are moments");
        for (one, (middle, _)) in end.iter().enumerate() {
            assert!(middle.y > 0.1 && middle.y < 1.5, "{middle}");
            for (other, (neighbour, _)) in end[..one].iter().enumerate() {
                let overlap = FALL.radii[one] + FALL.radii[other] - middle.distance(*neighbour);
                assert!(overlap < 0.02, "marbles {one} and {other} overlap by {overlap}");
            }
        }
        let before = &FALL.moments[FALL.moments.len() - 30];
        // A few bounce out and may still roll across the table.
        let caught = end.iter().zip(before).filter(|(end, _)| end.0.x.abs() < INNER.x && end.0.z.abs() < INNER.z);
        let moves: Vec<f32> = caught.map(|(end, before)| end.0.distance(before.0)).collect();
        assert!(moves.len() > 80, "the tray caught only {}", moves.len());
        assert!(moves.iter().all(|&length| length < 0.2), "a marble still moves: {moves:?}");
    }
}
