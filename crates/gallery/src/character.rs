//! Gnomes: a body of soft tubes, posed anew for every moment.
//!
//! Lengths are metres in a gnome's own space: +X to its left, +Y up, +Z ahead, the origin on the ground below it.

use std::f32::consts::PI;

use glam::Vec3;

use super::build::math::{cos, mix, sin, sin_cos, smoothstep};
use super::sweep::{Section, Sweep};

/// A piece of a gnome.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) stuff: Stuff,
    /// Quads along and around the tube at the default number of triangles.
    pub(super) quads: [u32; 2],
    pub(super) sweep: Sweep,
}

/// Material of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stuff {
    Skin,
    Hat,
    Coat,
    Trousers,
    Leather,
    Hair,
    Brass,
    Eye,
    Wood,
    Toadstool,
    Flame,
}

/// A gnome's prop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Prop {
    /// A lantern that swings from a stick.
    Lantern,
    /// A toadstool, as a parasol.
    Toadstool,
}

/// A point on the ground, and the level unit vector of the way ahead.
#[derive(Clone, Copy, Debug)]
pub(super) struct Footing {
    pub(super) ground: Vec3,
    pub(super) ahead: Vec3,
}

/// A gnome at one moment.
#[derive(Clone, Debug)]
pub(super) struct Gnome {
    pub(super) parts: Vec<Part>,
    /// World position of the lantern's flame, or of the parasol's middle.
    pub(super) prop: Vec3,
}

impl Footing {
    fn left(self) -> Vec3 {
        Vec3::Y.cross(self.ahead)
    }

    fn turned(self, own: Vec3) -> Vec3 {
        self.left() * own.x + Vec3::Y * own.y + self.ahead * own.z
    }

    fn world_from_own(self, own: Vec3) -> Vec3 {
        self.ground + self.turned(own)
    }

    fn own_from_world(self, world: Vec3) -> Vec3 {
        let offset = world - self.ground;
        Vec3::new(offset.dot(self.left()), offset.y, offset.dot(self.ahead))
    }
}

/// A foot at one moment: its ankle, and the sine and cosine of the angle by which the toes point down.
#[derive(Clone, Copy)]
struct Foot {
    ankle: Vec3,
    pitch: (f32, f32),
}

/// Half the stance time of a foot, in steps.
const HALF_STANCE: f32 = 0.6;
const ANKLE_HEIGHT: f32 = 0.045;
const HIP: Vec3 = Vec3::new(0.062, 0.2, 0.0);
const SHOULDER: Vec3 = Vec3::new(0.108, 0.365, 0.0);

/// The gnome after `steps` steps of its walk; `footing` maps steps to footprints.
pub(super) fn gnome(steps: f32, footing: impl Fn(f32) -> Footing, prop: Prop) -> Gnome {
    let here = footing(steps);
    let feet = [0.0, 1.0].map(|side| foot(steps, side, here, &footing));
    let posture = Posture::new(steps);
    let mut parts = Vec::with_capacity(40);
    posture.trunk(&mut parts);
    posture.face(&mut parts);
    let hand = match prop {
        Prop::Lantern => Vec3::new(-0.15, 0.27, 0.14),
        Prop::Toadstool => Vec3::new(-0.14, 0.29, 0.12),
    };
    let hand = posture.torso(hand);
    for (left, foot) in [(1.0, feet[0]), (-1.0, feet[1])] {
        posture.leg(left, foot, &mut parts);
        posture.arm(left, if left > 0.0 { posture.free_hand() } else { hand }, &mut parts);
    }
    let middle = match prop {
        Prop::Lantern => posture.lantern(hand, &mut parts),
        Prop::Toadstool => posture.toadstool(hand, &mut parts),
    };
    for part in &mut parts {
        part.sweep.move_by(|own| here.world_from_own(own), |own| here.turned(own));
    }
    Gnome { parts, prop: here.world_from_own(middle) }
}

/// The foot on side 0 (left, planted at even steps) or 1 (right, at odd ones).
fn foot(steps: f32, side: f32, here: Footing, footing: impl Fn(f32) -> Footing) -> Foot {
    const LIFT: f32 = 0.075;
    let plant = 2.0 * (0.5 * (steps - side) + 0.5).floor() + side;
    let since = steps - plant;
    let swing_steps = 2.0 - 2.0 * HALF_STANCE;
    let (from, part) = if since > HALF_STANCE {
        (plant, (since - HALF_STANCE) / swing_steps)
    } else if since < -HALF_STANCE {
        (plant - 2.0, (since + 2.0 - HALF_STANCE) / swing_steps)
    } else {
        (plant, 0.0)
    };
    let footprint = footing(from + 2.0 * smoothstep(0.0, 1.0, part));
    let lateral = if side == 0.0 { 0.06 } else { -0.06 };
    let planted = here.own_from_world(footprint.ground + footprint.left() * lateral);
    let pitch = if part > 0.0 {
        mix(0.75, -0.45, smoothstep(0.0, 0.9, part))
    } else {
        0.75 * smoothstep(0.2, HALF_STANCE, since) - 0.45 * smoothstep(-0.35, -HALF_STANCE, since)
    };
    let heel_off = 0.09 * sin(pitch.max(0.0));
    let lift = LIFT * sin(PI * part);
    Foot { ankle: planted + Vec3::Y * (ANKLE_HEIGHT + heel_off + lift), pitch: sin_cos(pitch) }
}

/// How the body above the hips moves with the steps.
struct Posture {
    bob: f32,
    sway: f32,
    twist: (f32, f32),
    /// Swing of the left arm, radians ahead; the right one swings the other way.
    arm_swing: f32,
    /// Offset of trailing parts: hat, beard and lantern lag behind the body.
    lag: Vec3,
}

impl Posture {
    fn new(steps: f32) -> Self {
        let stride = PI * steps;
        Self {
            bob: 0.014 * cos(2.0 * stride),
            sway: 0.018 * cos(stride),
            twist: sin_cos(-0.16 * sin(stride)),
            arm_swing: 0.6 * sin(stride),
            lag: Vec3::new(-0.045 * cos(stride - 0.9), 0.0, 0.03 * cos(2.0 * stride - 1.2)),
        }
    }

    /// Takes a point of the body at rest along with the upper body.
    fn torso(&self, rest: Vec3) -> Vec3 {
        let height = ((rest.y - 0.15) / 0.3).clamp(0.0, 1.0);
        let (sin, cos) = (self.twist.0 * height, mix(1.0, self.twist.1, height));
        Vec3::new(
            rest.x * cos + rest.z * sin + self.sway * (0.6 + 0.8 * height),
            rest.y + self.bob,
            rest.z * cos - rest.x * sin + 0.02 * height,
        )
    }

    /// A point of the hat or beard at rest: `looseness` 0 moves with the head and 1 trails behind it.
    fn loose(&self, rest: Vec3, looseness: f32) -> Vec3 {
        self.torso(rest) + self.lag * looseness
    }

    /// Coat, belt and neck.
    fn trunk(&self, parts: &mut Vec<Part>) {
        let section =
            |y: f32, z: f32, width: f32, depth: f32| Section::new(self.torso(Vec3::new(0.0, y, z)), width, depth);
        let coat = [
            section(0.125, 0.0, 0.142, 0.132),
            section(0.17, 0.0, 0.146, 0.138),
            section(0.23, 0.006, 0.138, 0.136),
            section(0.3, 0.004, 0.122, 0.116),
            section(0.36, -0.004, 0.1, 0.088),
            section(0.405, -0.006, 0.06, 0.056),
        ];
        parts.push(Part::new(Stuff::Coat, [20, 28], Sweep::new(&coat, Vec3::X, [0.05, 0.12])));
        let belt = [section(0.2, 0.004, 0.147, 0.143), section(0.234, 0.006, 0.144, 0.142)];
        parts.push(Part::new(Stuff::Leather, [6, 28], Sweep::new(&belt, Vec3::X, [0.2, 0.2])));
        let buckle = self.torso(Vec3::new(0.0, 0.217, 0.148));
        parts.push(Part::new(Stuff::Brass, [8, 12], Sweep::ellipsoid(buckle, Vec3::Y * 0.026, Vec3::X, 0.03, 0.012)));
        let collar = [section(0.372, -0.004, 0.098, 0.09), section(0.402, -0.002, 0.092, 0.084)];
        parts.push(Part::new(Stuff::Hat, [8, 24], Sweep::new(&collar, Vec3::X, [0.5, 0.5])));
        for height in [0.27, 0.32] {
            let button = self.torso(Vec3::new(0.0, height, if height < 0.3 { 0.128 } else { 0.112 }));
            parts.push(Part::new(Stuff::Brass, [6, 8], Sweep::ellipsoid(button, Vec3::Z * 0.006, Vec3::X, 0.01, 0.01)));
        }
    }

    /// Everything from the neck up.
    fn face(&self, parts: &mut Vec<Part>) {
        let at = |x: f32, y: f32, z: f32| self.torso(Vec3::new(x, y, z));
        let mut ball = |stuff: Stuff, quads: [u32; 2], center: Vec3, half: Vec3| {
            parts.push(Part::new(stuff, quads, Sweep::ellipsoid(center, Vec3::Y * half.y, Vec3::X, half.x, half.z)));
        };
        ball(Stuff::Skin, [18, 24], at(0.0, 0.478, 0.008), Vec3::new(0.103, 0.104, 0.1));
        ball(Stuff::Skin, [12, 16], at(0.0, 0.47, 0.12), Vec3::new(0.03, 0.027, 0.032));
        for left in [-1.0, 1.0] {
            ball(Stuff::Skin, [8, 10], at(left * 0.056, 0.462, 0.083), Vec3::new(0.03, 0.026, 0.024));
            ball(Stuff::Skin, [8, 10], at(left * 0.108, 0.475, 0.0), Vec3::new(0.02, 0.034, 0.014));
            ball(Stuff::Eye, [8, 10], at(left * 0.037, 0.503, 0.099), Vec3::new(0.0115, 0.0145, 0.009));
        }
        for left in [-1.0, 1.0] {
            let brow = [(0.016, 0.529, 0.106, 0.009), (0.04, 0.537, 0.102, 0.011), (0.07, 0.525, 0.086, 0.006)]
                .map(|(x, y, z, radius)| Section::round(at(left * x, y, z), radius));
            parts.push(Part::new(Stuff::Hair, [8, 8], Sweep::new(&brow, Vec3::Y, [0.25, 0.3])));
            let moustache = [(0.0, 0.45, 0.118, 0.014), (0.04, 0.438, 0.122, 0.017), (0.082, 0.425, 0.102, 0.006)]
                .map(|(x, y, z, radius)| Section::round(at(left * x, y, z), radius));
            parts.push(Part::new(Stuff::Hair, [10, 10], Sweep::new(&moustache, Vec3::Y, [0.25, 0.4])));
        }
        let beard = [
            (0.452, 0.05, 0.098, 0.05, 0.0),
            (0.41, 0.078, 0.1, 0.052, 0.05),
            (0.35, 0.108, 0.08, 0.044, 0.2),
            (0.29, 0.132, 0.05, 0.03, 0.5),
            (0.235, 0.15, 0.014, 0.01, 0.9),
        ]
        .map(|(y, z, width, depth, looseness)| Section::new(self.loose(Vec3::new(0.0, y, z), looseness), width, depth));
        parts.push(Part::new(Stuff::Hair, [18, 20], Sweep::new(&beard, Vec3::X, [0.12, 0.2])));
        self.hat(parts);
    }

    fn hat(&self, parts: &mut Vec<Part>) {
        let cone = [
            (0.536, 0.0, 0.118, 0.0),
            (0.61, -0.012, 0.09, 0.05),
            (0.69, -0.036, 0.064, 0.25),
            (0.76, -0.075, 0.042, 0.6),
            (0.81, -0.13, 0.026, 1.2),
            (0.825, -0.195, 0.012, 2.0),
        ]
        .map(|(y, z, radius, looseness)| Section::round(self.loose(Vec3::new(0.0, y, z), looseness), radius));
        parts.push(Part::new(Stuff::Hat, [24, 24], Sweep::new(&cone, Vec3::X, [0.02, 0.1])));
        let brim = [0.527, 0.556].map(|y| Section::round(self.torso(Vec3::new(0.0, y, 0.0)), 0.125));
        parts.push(Part::new(Stuff::Leather, [8, 28], Sweep::new(&brim, Vec3::X, [0.5, 0.5])));
        let bobble = self.loose(Vec3::new(0.0, 0.823, -0.205), 2.1);
        parts.push(Part::new(Stuff::Hair, [10, 12], Sweep::ellipsoid(bobble, Vec3::Y * 0.022, Vec3::X, 0.022, 0.022)));
    }

    fn leg(&self, left: f32, foot: Foot, parts: &mut Vec<Part>) {
        let hip = Vec3::new(left * HIP.x + self.sway * 0.6, HIP.y + self.bob, HIP.z);
        let (knee, ankle) = two_bones(hip, foot.ankle, 0.095, 0.09, Vec3::new(left * 0.25, 0.1, 1.0));
        let trousers = [Section::round(hip, 0.062), Section::round(knee, 0.05), Section::round(ankle, 0.042)];
        parts.push(Part::new(Stuff::Trousers, [14, 14], Sweep::new(&trousers, Vec3::X, [0.15, 0.1])));
        let (sin, cos) = foot.pitch;
        let boot = |y: f32, z: f32| ankle + Vec3::new(0.0, y * cos - z * sin, z * cos + y * sin);
        let shoe = [
            (-0.016, -0.046, 0.034, 0.03),
            (-0.014, 0.0, 0.042, 0.036),
            (-0.02, 0.045, 0.042, 0.028),
            (-0.014, 0.085, 0.032, 0.024),
            (0.018, 0.112, 0.012, 0.012),
        ]
        .map(|(y, z, width, depth)| Section::new(boot(y, z), width, depth));
        parts.push(Part::new(Stuff::Leather, [16, 16], Sweep::new(&shoe, Vec3::X, [0.15, 0.12])));
        let cuff = [(0.006, 0.046), (0.042, 0.05)].map(|(y, radius)| Section::round(boot(y, -0.004), radius));
        parts.push(Part::new(Stuff::Leather, [6, 16], Sweep::new(&cuff, Vec3::X, [0.35, 0.35])));
    }

    /// Position of the free left hand.
    fn free_hand(&self) -> Vec3 {
        let (sin, cos) = sin_cos(self.arm_swing);
        let shoulder = self.torso(SHOULDER);
        shoulder + Vec3::new(0.06, -0.15 * cos, 0.15 * sin + 0.03)
    }

    fn arm(&self, left: f32, hand: Vec3, parts: &mut Vec<Part>) {
        let shoulder = self.torso(SHOULDER * Vec3::new(left, 1.0, 1.0));
        let (elbow, hand) = two_bones(shoulder, hand, 0.1, 0.1, Vec3::new(left * 0.8, -0.4, -0.6));
        let sleeve = [
            Section::round(shoulder - Vec3::X * (left * 0.02), 0.05),
            Section::round(elbow, 0.042),
            Section::round(hand.lerp(elbow, 0.15), 0.046),
        ];
        parts.push(Part::new(Stuff::Coat, [14, 14], Sweep::new(&sleeve, Vec3::Z, [0.25, 0.06])));
        let reach = (hand - elbow).normalize_or(Vec3::NEG_Y);
        let palm = hand + reach * 0.02;
        parts.push(Part::new(Stuff::Skin, [10, 12], Sweep::ellipsoid(palm, reach * 0.036, Vec3::Z, 0.032, 0.027)));
        let thumb = [Section::round(palm, 0.014), Section::round(palm + Vec3::new(-left * 0.02, 0.008, 0.03), 0.011)];
        parts.push(Part::new(Stuff::Skin, [6, 8], Sweep::new(&thumb, Vec3::X, [0.4, 0.4])));
    }

    /// Adds a lantern on a stick; returns the flame's position.
    fn lantern(&self, hand: Vec3, parts: &mut Vec<Part>) -> Vec3 {
        let grip = hand + Vec3::new(0.0, -0.005, 0.02);
        let tip = self.torso(Vec3::new(-0.2, 0.66, 0.5));
        let butt = grip + (grip - tip) * 0.45;
        let bowed = grip.lerp(tip, 0.6) + Vec3::new(0.0, 0.035, -0.02);
        let stick = [(butt, 0.011), (grip, 0.011), (bowed, 0.009), (tip, 0.006)]
            .map(|(center, radius)| Section::round(center, radius));
        parts.push(Part::new(Stuff::Wood, [12, 8], Sweep::new(&stick, Vec3::X, [0.03, 0.03])));
        let down = (Vec3::NEG_Y * 0.22 + self.lag * 1.6).normalize();
        let hung = |below: f32| tip + down * below;
        let cord = [hung(0.0), hung(0.05)].map(|center| Section::round(center, 0.003));
        parts.push(Part::new(Stuff::Leather, [2, 6], Sweep::new(&cord, Vec3::X, [0.0, 0.0])));
        let roof = [(0.045, 0.004), (0.062, 0.012), (0.078, 0.042), (0.086, 0.046)]
            .map(|(below, radius)| Section::round(hung(below), radius));
        parts.push(Part::new(Stuff::Brass, [10, 16], Sweep::new(&roof, Vec3::X, [0.1, 0.1])));
        let base = [(0.158, 0.044), (0.172, 0.046)].map(|(below, radius)| Section::round(hung(below), radius));
        parts.push(Part::new(Stuff::Brass, [6, 16], Sweep::new(&base, Vec3::X, [0.3, 0.3])));
        let flame = hung(0.122);
        parts.push(Part::new(Stuff::Flame, [14, 16], Sweep::ellipsoid(flame, down * 0.038, Vec3::X, 0.032, 0.032)));
        let across = down.cross(Vec3::Z).normalize_or(Vec3::X);
        for bar in [across, -across, down.cross(across), -down.cross(across)] {
            let post = [0.084, 0.16].map(|below| Section::round(hung(below) + bar * 0.04, 0.004));
            parts.push(Part::new(Stuff::Brass, [2, 6], Sweep::new(&post, Vec3::X, [0.0, 0.0])));
        }
        flame
    }

    /// Adds a toadstool held over the head; returns the middle of its cap.
    fn toadstool(&self, hand: Vec3, parts: &mut Vec<Part>) -> Vec3 {
        let grip = hand + Vec3::new(0.0, -0.005, 0.03);
        let crown = self.loose(Vec3::new(-0.1, 0.93, 0.02), 0.5);
        let up = (crown - grip).normalize_or(Vec3::Y);
        let stem = [
            (grip - up * 0.08, 0.02),
            (grip, 0.017),
            (grip.lerp(crown, 0.5) + Vec3::new(-0.03, 0.0, 0.0), 0.017),
            (crown, 0.024),
        ]
        .map(|(center, radius)| Section::round(center, radius));
        parts.push(Part::new(Stuff::Hair, [14, 12], Sweep::new(&stem, Vec3::X, [0.06, 0.02])));
        let cap = [(-0.03, 0.24), (-0.012, 0.252), (0.05, 0.222), (0.11, 0.14), (0.137, 0.05)]
            .map(|(above, radius)| Section::round(crown + up * above, radius));
        parts.push(Part::new(Stuff::Toadstool, [22, 36], Sweep::new(&cap, Vec3::X, [0.02, 0.12])));
        let gills = Sweep::ellipsoid(crown - up * 0.027, up * 0.014, Vec3::X, 0.228, 0.228);
        parts.push(Part::new(Stuff::Hair, [6, 36], gills));
        crown
    }
}

impl Part {
    fn new(stuff: Stuff, quads: [u32; 2], sweep: Sweep) -> Self {
        Self { stuff, quads, sweep }
    }
}

/// The joint between two bones from `root` towards `end`, bent to the side of `towards`, and the end that they reach.
fn two_bones(root: Vec3, end: Vec3, first: f32, second: f32, towards: Vec3) -> (Vec3, Vec3) {
    let span = end - root;
    let reach = span.length().clamp((first - second).abs() + 1e-4, (first + second) * 0.999);
    let along = span.normalize_or(Vec3::NEG_Y);
    let to_foot_of_joint = (first * first - second * second + reach * reach) / (2.0 * reach);
    let height = (first * first - to_foot_of_joint * to_foot_of_joint).max(0.0).sqrt();
    let side = (towards - along * along.dot(towards)).normalize_or(along.any_orthonormal_vector());
    (root + along * to_foot_of_joint + side * height, root + along * reach)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f32 = 0.16;

    fn straight(steps: f32) -> Footing {
        Footing { ground: Vec3::Z * (STEP * steps), ahead: Vec3::Z }
    }

    #[test]
    fn a_foot_that_stands_does_not_slide() {
        for (side, plant) in [(0.0, 4.0), (1.0, 5.0)] {
            let world = |steps: f32| straight(steps).ground + foot(steps, side, straight(steps), straight).ankle;
            let planted = world(plant);
            assert!((planted.z - STEP * plant).abs() < 1e-6, "{planted}");
            for since in [-0.3, -0.1, 0.1, 0.19] {
                assert!(world(plant + since).abs_diff_eq(planted, 1e-5), "side {side}, {since} steps later");
            }
            for change in [HALF_STANCE, 1.0, 2.0 - HALF_STANCE] {
                let [before, after] = [-1e-3, 1e-3].map(|moment| world(plant + change + moment));
                assert!(before.distance(after) < 5e-3, "side {side} leaps {change} steps later");
            }
            assert!(world(plant + 1.0).y > planted.y + 0.05, "it is lifted halfway through its swing");
            assert!((world(plant + 2.0).z - planted.z - 2.0 * STEP).abs() < 1e-5, "and comes down two steps on");
        }
    }

    #[test]
    fn joints_keep_the_lengths_of_their_bones() {
        for end in [Vec3::new(0.1, -0.1, 0.05), Vec3::new(0.0, -5.0, 0.0), Vec3::new(0.0, -0.001, 0.0)] {
            let (joint, reached) = two_bones(Vec3::ZERO, end, 0.1, 0.09, Vec3::Z);
            assert!((joint.length() - 0.1).abs() < 1e-5, "{end}");
            assert!((joint.distance(reached) - 0.09).abs() < 1e-5, "{end}");
            assert!(joint.z >= 0.0);
        }
    }
}
