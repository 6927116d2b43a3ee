//! Results of f64 compared with the predicate: points and triangles where roundings, or the errors of points, decide.

use std::sync::Mutex;

use crate::dispatch;
use glam::{DVec3, Vec3};

use super::*;
use crate::light_grid::point_set::PointList;
use crate::predicate::HitPoint;
use crate::predicate::ShadowRay;
use crate::random::Random;
use crate::shot::{MaskAnswers, SeenPixels, Shot};
use crate::{Camera, Projection, Sides, SimdLevel, Triangles, View};

const TRIALS: u32 = 40_000;

fn anywhere(random: &mut Random, size: f64) -> DVec3 {
    DVec3::from([0; 3].map(|_| random.signed())) * size
}

/// As f32 has it.
fn rounded(position: DVec3) -> DVec3 {
    position.as_vec3().as_dvec3()
}

const NOWHERE: HitPoint = HitPoint { position: DVec3::NAN, error: 0.0 };

/// Eight points and eight triangles to settle, a pair to a lane.
struct EightPairs {
    light: LightSource,
    triangles: [[Vec3; 3]; 8],
    points: [HitPoint; 8],
}

/// How a triangle's corners, a light and a point are placed.
#[derive(Clone, Copy)]
enum Aim {
    /// The ray goes past an edge or a corner.
    Edge,
    /// All coordinates are nearly the same except for their signs, so that cancelling products are as large as they can be.
    /// The light, or the point, is so near zero that it is lost in the difference.
    Cube,
    /// The point is in the triangle's plane, or its error away from it.
    Plane,
    /// The light is in the triangle's plane.
    Light,
    /// The point is so near a corner that products underflow.
    Tiny,
}

impl Aim {
    const ALL: [Self; 5] = [Self::Edge, Self::Cube, Self::Plane, Self::Light, Self::Tiny];
}

impl EightPairs {
    fn new(random: &mut Random) -> Self {
        let aim = Aim::ALL[(random.unit() * 5.0) as usize];
        // Mostly such that nothing over- or underflows.
        let world = if random.unit() < 0.9 { random.power(-3.0, 3.0) } else { random.power(-37.0, 34.0) };
        let world = world.log2().round().exp2();
        let is_directional = random.unit() < 0.4 && !matches!(aim, Aim::Light) || matches!(aim, Aim::Tiny);
        let lost = 0.99 * f64::EPSILON / 2.0;
        let middle = match aim {
            Aim::Cube => anywhere(random, lost),
            Aim::Light => (anywhere(random, 1.0) * f64::from(1 << 20)).round() / f64::from(1 << 20),
            _ if random.unit() < 0.3 => DVec3::ZERO,
            _ => anywhere(random, 1.0) * random.power(-10.0, 3.0),
        };
        let signs = anywhere(random, 1.0).signum();
        let middle = if matches!(aim, Aim::Cube) && random.unit() < 0.5 { signs * lost } else { middle };
        let middle = rounded(middle * world);
        let (size, away) = (random.power(-4.0, 2.0), random.power(-4.0, 2.0));
        let nearness = if random.unit() < 0.5 { 0.0 } else { random.power(-12.0, -1.0) };
        let direction = rounded(anywhere(random, 1.0) * random.power(-3.0, 3.0));
        let light = if is_directional {
            LightSource::Directional { direction: direction.as_vec3() }
        } else {
            LightSource::Point { position: middle.as_vec3() }
        };
        let mut trial = Self { light, triangles: [[Vec3::ZERO; 3]; 8], points: [NOWHERE; 8] };
        for lane in 0..8 {
            let corners = match aim {
                Aim::Cube => [(); 3].map(|()| {
                    let corner = anywhere(random, 1.0).signum() + anywhere(random, 1.0 / 512.0).abs();
                    corner * random.power(-3.0, 3.0).log2().round().exp2() * world
                }),
                Aim::Light => {
                    let mut whole =
                        || (anywhere(random, 1.0) * f64::from(1 << 18)).round() * world / f64::from(1 << 20);
                    let (first, second) = (whole(), whole());
                    [-first - second, first, second].map(|corner| middle + corner)
                }
                Aim::Tiny => {
                    let mut corner = || anywhere(random, world) * random.power(-10.0, 0.0);
                    [DVec3::ZERO, corner(), corner()]
                }
                _ => {
                    let at = middle + anywhere(random, away * world);
                    [(); 3].map(|()| at + anywhere(random, size * world) * random.power(-2.0, 0.0))
                }
            };
            trial.triangles[lane] = corners.map(DVec3::as_vec3);
            let error = nearness * (away + size) * world;
            trial.points[lane] = trial.point(random, aim, lane, middle, error);
        }
        trial
    }

    fn point(&self, random: &mut Random, aim: Aim, lane: usize, middle: DVec3, error: f64) -> HitPoint {
        let mut corners = self.triangles[lane].map(Vec3::as_dvec3);
        corners.rotate_left((random.unit() * 3.0) as usize);
        let [a, b, c] = corners;
        let tiny = random.power(-20.0, 0.0);
        let along = [random.unit(), tiny, 1.0 - tiny][(random.unit() * 3.0) as usize];
        let inside = [random.unit() * (1.0 - along), tiny][usize::from(random.unit() < 0.5)];
        let inside = if matches!(aim, Aim::Plane) { inside } else { inside * f64::from(u8::from(random.unit() < 0.5)) };
        // Some weights are halfway between two f32.
        let bits = f64::from(1 << 24);
        let (along, inside) = if random.unit() < 0.3 {
            (((along * bits).floor() + 0.5) / bits, (inside * bits).floor() / bits)
        } else {
            (along, inside)
        };
        let on = a + (b - a) * along + (c - a) * inside;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let beyond = random.power(-8.0, 1.0) * if random.unit() < 0.2 { -1.0 } else { 1.0 };
        // Some are beyond f32, and so far that products overflow.
        let beyond = if random.unit() < 0.01 { random.power(100.0, 290.0) } else { beyond };
        let position = match (aim, self.light) {
            (Aim::Light, LightSource::Point { .. }) => middle + anywhere(random, 1.0) * beyond,
            (Aim::Tiny, LightSource::Directional { direction }) => {
                let edge = self.triangles[lane][1].as_dvec3();
                (edge * random.unit() + direction.as_dvec3() * random.signed()) * random.power(-322.0, -302.0)
            }
            (Aim::Plane, _) => on + normal * error * (random.signed() * 2.0 * normal.abs().element_sum()),
            (_, LightSource::Directional { direction }) => on + direction.as_dvec3() * beyond,
            _ => middle + (on - middle) * (1.0 + beyond),
        };
        HitPoint { position, error: if random.unit() < 0.5 { error } else { 0.0 } }
    }

    /// The numbers of shadowed, lit and undecided pairs, and the largest error of the weights in relation to its bound.
    fn check(&self, level: SimdLevel, points: &PointSet<'_>, at: [u32; 8]) -> ([u32; 3], f64) {
        let indices: [[u32; 3]; 8] = std::array::from_fn(|id| [0, 1, 2].map(|corner| 3 * id as u32 + corner));
        let triangles = Triangles { positions: self.triangles.as_flattened(), indices: &indices };
        let lanes = std::array::from_fn(|lane| lane as u32);
        let found = dispatch!(level, simd => settle_eight(simd, triangles, points, &self.light, at, lanes));
        let seen = Seen::default();
        let opacity = OpacityOfSides::between(triangles, (&seen, Sides::Both), &self.light);
        let settler = Settler { points: *points, light: &self.light, opacity, level };
        let (mut counts, mut worst) = ([0; 3], 0.0_f64);
        for (lane, index) in at.into_iter().enumerate() {
            let Some(ray) = points.shadow_ray(index as usize, &self.light) else { continue };
            let weights = ray.blocked_by(self.triangles[lane]);
            let is_shadowed = found.shadowed >> lane & 1 == 1;
            let is_undecided = found.undecided >> lane & 1 == 1;
            counts[if is_undecided { 2 } else { usize::from(!is_shadowed) }] += 1;
            let about = || format!("{ray:?} and {:?}", self.triangles[lane]);
            assert!(is_undecided || is_shadowed == weights.is_some(), "shadowed: {is_shadowed}, {}", about());
            let Some(weights) = weights.filter(|_| is_shadowed) else { continue };
            assert!(settler.stops(lane as u32, &found, lane).is_none());
            let asked = seen.0.lock().unwrap().take().unwrap();
            for (weight, asked_weight) in weights.into_iter().zip(asked.barycentric) {
                let wrong = (f64::from(asked_weight[0]) - f64::from(weight)).abs();
                worst = worst.max(wrong / f64::from(asked.error[0]));
            }
        }
        (counts, worst)
    }
}

/// The points that masks were asked about.
#[derive(Default)]
struct Seen(Mutex<Option<MaskPoints>>);

impl Opacity for Seen {
    fn is_opaque(&self, _: u32) -> bool {
        false
    }

    fn stops(&self, _: u32, _: [f32; 2]) -> bool {
        true
    }

    fn which_stop(&self, _: u32, points: &MaskPoints) -> MaskAnswers {
        *self.0.lock().unwrap() = Some(*points);
        MaskAnswers::default()
    }
}

/// All trials' answers.
fn all(of_trial: impl Fn(&mut Random, SimdLevel) -> ([u32; 3], f64) + Sync) {
    let levels = SimdLevel::available();
    let of_seed = |seed: u32| of_trial(&mut Random::new(seed.into()), levels[seed as usize % levels.len()]);
    let trials: Vec<_> = (0..TRIALS).into_par_iter().map(of_seed).collect();
    let worst = trials.iter().fold(0.0, |most: f64, (_, worst)| most.max(*worst));
    let counts = [0, 1, 2].map(|which| trials.iter().map(|(counts, _)| counts[which]).sum::<u32>());
    assert!(counts.iter().all(|&count| count > TRIALS / 4), "shadowed, lit, undecided: {counts:?}");
    assert!((0.1..=1.0).contains(&worst), "weights are wrong by {worst} of what they may be");
}

#[test]
fn what_is_settled_of_listed_points_is_so() {
    all(|random, level| {
        let trial = EightPairs::new(random);
        let mut list = PointList::default();
        list.points = trial.points.to_vec();
        trial.check(level, &PointSet::Listed(&list), std::array::from_fn(|lane| lane as u32))
    });
}

/// Eight pixels that show triangles grazed by their rays, so that the points' errors are far larger than other roundings.
struct Grazed {
    view: View,
    pixels: [(u32, u32); 8],
    /// Positions of the triangles.
    positions: [[Vec3; 3]; 8],
    depth: f64,
}

impl Grazed {
    fn new(random: &mut Random) -> Self {
        let mut whole = || (anywhere(random, 1.0) * 512.0).round() / 512.0 + 1.0 / 1024.0;
        let (along, across) = (whole(), whole());
        let forward = along.as_vec3();
        let right = forward.any_orthogonal_vector().normalize();
        let up = right.cross(forward.normalize());
        let size = random.power(-13.0, 0.0) as f32;
        let is_perspective = random.unit() < 0.5;
        let projection = if is_perspective {
            Projection::Perspective { tan_half_height: size }
        } else {
            Projection::Orthographic { half_height: size }
        };
        let mut camera = Camera { position: Vec3::ZERO, right, up, forward, projection };
        // So that rays meet the plane at about this depth.
        let depth = random.unit();
        let normal = along.cross(across).normalize();
        if is_perspective {
            let slope = normal.dot((right + up).as_dvec3()) * f64::from(size) * random.signed();
            camera.position = (normal * -slope * depth).as_vec3();
        }
        let positions = [(); 8].map(|()| {
            let mut factor = || random.power(-1.0, 1.0).log2().round().exp2();
            let (behind, left, right) = (-along * factor(), across * factor(), -across * factor());
            [behind + left, along * 4.0, behind + right].map(DVec3::as_vec3)
        });
        let pixels = [(); 8].map(|()| ((random.unit() * 64.0) as u32, (random.unit() * 64.0) as u32));
        Self { view: View { camera, width: 64, height: 64 }, pixels, positions, depth }
    }

    /// A triangle with an edge that the segment between a point and a light goes past, or with the point in its plane.
    fn aimed(&self, random: &mut Random, ray: &ShadowRay) -> [Vec3; 3] {
        let towards_light = match ray.ray.t_max {
            1.0 => -ray.ray.direction,
            _ => ray.ray.direction,
        };
        let part = if random.unit() < 0.3 { 0.0 } else { random.unit() };
        let moved = self.view.camera.forward.as_dvec3() * (self.depth * random.signed() * random.power(-9.0, -1.0));
        let at = ray.point() + towards_light * part + moved;
        let [first, second] = [(); 2].map(|()| anywhere(random, 1.0) * random.power(-3.0, 1.0));
        let inside = if part == 0.0 { first * -0.3 } else { second * 0.0 };
        [at + first + inside, at + second + inside, at - second + inside].map(DVec3::as_vec3)
    }
}

#[test]
fn what_is_settled_of_pixels_is_so() {
    all(|random, level| {
        let grazed = Grazed::new(random);
        let indices: [[u32; 3]; 8] = std::array::from_fn(|id| [0, 1, 2].map(|corner| 3 * id as u32 + corner));
        let triangles = Triangles { positions: grazed.positions.as_flattened(), indices: &indices };
        let shot = Shot::new(triangles, grazed.view);
        let mut seen = SeenPixels::default();
        seen.resize(64, 64);
        let at = grazed.pixels.map(|(x, y)| seen.order().index(x, y) as u32);
        (0..).zip(at).for_each(|(id, index)| seen.triangle[index as usize] = id);
        let image = SeenImage { shot: &shot, seen: &seen };
        let points = PointSet::Seen(image, CameraRays::new(&shot));
        let size = random.power(-3.0, 1.0);
        let place = anywhere(random, size).as_vec3();
        let light = if random.unit() < 0.5 {
            LightSource::Point { position: place }
        } else {
            LightSource::Directional { direction: place }
        };
        let triangles = at.map(|index| {
            let ray = points.shadow_ray(index as usize, &light);
            ray.map_or([Vec3::ZERO; 3], |ray| grazed.aimed(random, &ray))
        });
        EightPairs { light, triangles, points: [NOWHERE; 8] }.check(level, &points, at)
    });
}
