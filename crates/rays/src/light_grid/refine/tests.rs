//! Mapped points compared with real numbers, for positions anywhere in the predicate's box.

use crate::dispatch;
use glam::Vec3;
use rayon::prelude::*;

use super::*;
use crate::light_grid::choose::choose;
use crate::light_grid::point_set::PointList;
use crate::precise::{Precise, difference, precise};
use crate::predicate::HitPoint;
use crate::random::Random;
use crate::shot::{CameraRays, SeenImage, SeenPixels, Shot};
use crate::{Camera, LightSource, Projection, SimdLevel, Triangles, View};

const TRIALS: u32 = 20_000;

fn anywhere(random: &mut Random, size: f64) -> DVec3 {
    DVec3::from([0; 3].map(|_| random.signed())) * size
}

/// The homogeneous coordinates of a position, precisely.
fn homogeneous(face: &Face, position: DVec3) -> [Precise; 3] {
    let v = difference(precise(position), precise(face.origin));
    [face.x, face.y, face.z].map(|axis| crate::precise::dot(precise(axis), v))
}

/// X, Y and W of homogeneous coordinates.
fn on_face(face: &Face, [x, y, z]: [Precise; 3]) -> [Precise; 3] {
    if face.is_parallel { [x, y, z] } else { [x / z, y / z, Precise::from(face.near) / z] }
}

/// A face of some light about a box of points.
fn face(random: &mut Random) -> Option<(Face, DVec3, f64)> {
    let world = random.power(-6.0, 6.0);
    let (middle, size) = (anywhere(random, world) * random.power(-4.0, 4.0), world * random.power(-4.0, 0.0));
    let along = DVec3::from([0; 3].map(|_| random.signed() * if random.unit() < 0.5 { 1e-9 } else { 1.0 }));
    let light = match (random.unit() * 4.0) as u32 {
        0 => LightSource::Point { position: (middle + anywhere(random, size)).as_vec3() },
        1 => {
            LightSource::Point { position: (middle + anywhere(random, 1.0) * random.power(-1.0, 5.0) * size).as_vec3() }
        }
        2 => LightSource::Point { position: Vec3::ZERO },
        _ => LightSource::Directional { direction: along.as_vec3() },
    };
    let mut list = PointList::default();
    let flat = DVec3::from([0; 3].map(|_| if random.unit() < 0.3 { random.power(-6.0, 0.0) } else { 1.0 }));
    let points: Vec<_> = (0..8).map(|_| middle + anywhere(random, size) * flat).collect();
    list.fill(points.len(), |number| Some((HitPoint { position: points[number], error: 0.0 }, SeenPixels::NONE)));
    let mut faces = Vec::new();
    choose(&light, DVec3::X, &list.tiles, &mut faces)?;
    let number = (random.unit() * faces.len() as f64) as usize;
    let face = *faces.get(number)?;
    // Mostly more than the points' errors.
    Some((Face { point_error: random.power(-12.0, 0.0), ..face }, middle, size))
}

/// A point anywhere about a face: inside, beside it or at the border of its own range, between the light and it or behind
/// the light.
fn point(random: &mut Random, face: &Face, middle: DVec3, size: f64) -> HitPoint {
    let x = (random.signed() * 1.002).clamp(-1.0015, 1.0015);
    let mut place = [x, random.signed()];
    if let Some(owned) = face.owned.filter(|_| random.unit() < 0.5) {
        let axis = usize::from(random.unit() < 0.5);
        place[axis] = owned[axis][usize::from(random.unit() < 0.5)];
    }
    let depth = if random.unit() < 0.1 { -1.0 } else { random.power(-1.0, 2.0) };
    let depth = if random.unit() < 0.1 { depth * random.power(-20.0, 0.0) } else { depth };
    // Rows of a matrix whose inverse takes coordinates to positions.
    let map = glam::DMat3::from_cols(face.x, face.y, face.z).transpose().inverse();
    let position = if face.is_parallel {
        face.origin + map * DVec3::new(place[0], place[1], random.signed())
    } else {
        face.origin + map * DVec3::new(place[0], place[1], 1.0) * (face.near * depth)
    };
    let position = if random.unit() < 0.1 { middle + anywhere(random, size) } else { position };
    let away = (position - face.origin).abs().max_element();
    let error = if random.unit() < 0.3 { 0.0 } else { away * random.power(-17.0, 0.5) };
    HitPoint { position, error }
}

/// The largest errors of X or Y, and of W, of exact points in relation to their bounds, and the number of such points.
fn run(random: &mut Random, level: SimdLevel) -> Option<([f64; 2], u32)> {
    let (face, middle, size) = face(random)?;
    let points: [HitPoint; 8] = std::array::from_fn(|_| point(random, &face, middle, size));
    let mut list = PointList::default();
    list.points = points.to_vec();
    let lanes = std::array::from_fn(|lane| lane as u32);
    let found = dispatch!(level, simd => refine_eight(simd, &PointSet::Listed(&list), &face, lanes));
    let (mut worst, mut count) = ([0.0_f64; 2], 0);
    for (lane, point) in points.into_iter().enumerate() {
        let (is_member, is_exact) = (found.members >> lane & 1 == 1, found.exact >> lane & 1 == 1);
        let at = found.at.map(|axis| axis[lane]);
        let [position_error, nearness_error] = found.errors.map(|errors| errors[lane]);
        if is_exact {
            let relative = nearness_error / if face.is_parallel { 1.0 } else { at[2] };
            let is_near = at[0].abs().max(at[1].abs()) <= POINT_LIMIT && at[2].abs() < 1e15;
            assert!(is_near && position_error <= LARGEST_POINT_ERROR && relative < 1.0 / 15.0, "{at:?}");
            let depth = if face.is_parallel { 1.0 } else { face.near / at[2] };
            assert!(point.error <= face.point_error * depth * (1.0 + 1e-9), "{point:?} on {face:?}");
            count += 1;
        }
        for signs in 0..8 {
            let sign = |axis: u32| if signs >> axis & 1 == 0 { -1.0 } else { 1.0 };
            let corner = point.position + DVec3::new(sign(0), sign(1), sign(2)) * point.error;
            let [x, y, z] = homogeneous(&face, corner);
            if let Some(owned) = face.owned.filter(|_| !is_member) {
                let is_within = |at: Precise, [low, high]: [f64; 2]| at >= z * low.into() && at <= z * high.into();
                let is_owned = z > 0.0.into() && is_within(x, owned[0]) && is_within(y, owned[1]);
                assert!(!is_owned, "{point:?} is on {face:?}");
            }
            if is_exact {
                assert!(face.is_parallel || z > 0.0.into(), "{point:?} is behind the light");
                let wrong = difference(on_face(&face, [x, y, z]), precise(DVec3::from(at))).map(|at| at.abs().to_f64());
                worst[0] = worst[0].max(wrong[0].max(wrong[1]) / position_error);
                worst[1] = worst[1].max(wrong[2] / nearness_error);
            }
        }
        assert!(is_member || face.owned.is_some());
    }
    Some((worst, count))
}

#[test]
fn points_are_no_more_wrong_than_is_said_and_elsewhere_only_if_they_are() {
    let levels = SimdLevel::available();
    let of_seed = |seed: u32| run(&mut Random::new(seed.into()), levels[seed as usize % levels.len()]);
    let all: Vec<_> = (0..TRIALS).into_par_iter().filter_map(of_seed).collect();
    let count: u32 = all.iter().map(|(_, count)| count).sum();
    assert!(count > TRIALS, "{count}");
    let worst = all.iter().fold([0.0; 2], |most, (one, _)| [0, 1].map(|at| f64::max(most[at], one[at])));
    assert!(worst.iter().all(|worst| (0.9..=1.0).contains(worst)), "{worst:?} of what may be");
}

/// The hit point of a ray nearly in its triangle's plane is less certain than all others: no face maps such a point, and it
/// belongs to every face.
#[test]
fn points_of_triangles_seen_edge_on_are_of_every_face() {
    let in_front = [Vec3::new(-9.0, -9.0, -4.0), Vec3::new(9.0, -9.0, -4.0), Vec3::new(0.0, 9.0, -4.0)];
    let edge_on = [Vec3::new(0.0, -9.0, -3.0), Vec3::new(0.0, 9.0, -4.0), Vec3::new(0.0, 0.0, -5.0)];
    let positions = [in_front, edge_on].concat();
    let triangles = Triangles { positions: &positions, indices: &[[0, 1, 2], [3, 4, 5]] };
    // From so far beside the plane, rays at the image's border meet it four units away.
    const SLOPE: f32 = 1e-13;
    let camera = Camera {
        projection: Projection::Perspective { tan_half_height: SLOPE },
        ..Camera::look_at(Vec3::new(-4.0 * SLOPE, 0.0, 0.0), Vec3::new(-4.0 * SLOPE, 0.0, -1.0), Vec3::Y, 1.0)
    };
    let shot = Shot::new(triangles, View { camera, width: 64, height: 64 });
    let mut seen = SeenPixels::default();
    seen.resize(64, 64);
    let indices: [u32; 8] = std::array::from_fn(|lane| {
        let index = seen.order().index(63, 8 * lane as u32);
        (seen.triangle[index], seen.inverse_depth[index]) = (lane as u32 % 2, 0.25);
        index as u32
    });
    let points = PointSet::Seen(SeenImage { shot: &shot, seen: &seen }, CameraRays::new(&shot));
    // Far enough for the error to be little on its faces.
    let light = DVec3::Z * 1e4;
    let mut around = PointList::default();
    let corner = |number: usize| light + DVec3::AXES[number / 2] * [2e4, -2e4][number % 2];
    around.fill(6, |number| Some((HitPoint { position: corner(number), error: 0.0 }, SeenPixels::NONE)));
    let mut faces = Vec::new();
    choose(&LightSource::Point { position: light.as_vec3() }, DVec3::X, &around.tiles, &mut faces).expect("a light");
    assert_eq!(faces.len(), 6);
    for face in faces.into_iter().map(|face| Face { point_error: 1.0, ..face }) {
        let of_face = if face.z.z < -0.5 { 0b0101_0101 } else { 0 };
        for level in SimdLevel::available() {
            let found = dispatch!(level, simd => refine_eight(simd, &points, &face, indices));
            assert_eq!((found.members, found.exact), (0b1010_1010 | of_face, of_face), "{face:?}");
        }
    }
}
