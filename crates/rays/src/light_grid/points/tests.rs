//! Mapped points compared with true positions, for depths with the largest allowed error.

use crate::dispatch;
use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::*;
use crate::light_grid::choose::choose;
use crate::light_grid::face::FACE_LIMIT;
use crate::light_grid::survey::Survey;
use crate::precise::{Precise, difference, dot, precise};
use crate::predicate::{HitPoint, crossing};
use crate::random::Random;
use crate::shot::Shot;
use crate::{Camera, LightSource, Projection, SimdLevel, Triangles, View};

const TRIALS: u32 = 1000;

/// A view of an object at about one depth, and a light anywhere, often near the camera, where depths don't matter, or near
/// the object, where only they matter.
struct ViewedObject {
    random: Random,
    level: SimdLevel,
    view: View,
    light: LightSource,
    depth: f64,
    zoom: f64,
}

impl ViewedObject {
    fn new(mut random: Random, level: SimdLevel) -> Self {
        let far = if random.unit() < 0.7 { 1.0 } else { random.power(0.0, 6.0) };
        let depth = random.power(0.0, 2.0);
        let mut anywhere = |size: f64| DVec3::from([0; 3].map(|_| random.signed() * size)).as_vec3();
        let (position, at, sideways) = (anywhere(10.0 * far), anywhere(10.0), anywhere(1.0));
        let (near, away) = (anywhere(1.0), anywhere(30.0));
        // Whether the object is far away in relation to its size.
        let zoom = if random.unit() < 0.5 { 1.0 } else { random.power(-6.0, 0.0) };
        let camera = Camera::look_at(position, position + at, Vec3::Y, 0.7 * zoom as f32);
        let projection = Projection::Orthographic { half_height: (depth * zoom) as f32 };
        let projection = if random.unit() < 0.3 { projection } else { camera.projection };
        let ahead = position + camera.forward * (depth * (1.0 + 0.3 * random.unit() * zoom)) as f32;
        let light = match (random.unit() * 4.0) as u32 {
            0 => LightSource::Point { position: position + near * random.power(-8.0, 0.0) as f32 },
            1 => LightSource::Point { position: position + away },
            2 => LightSource::Point { position: ahead + near * (depth * zoom * random.power(-3.0, 0.0)) as f32 },
            _ => LightSource::Directional { direction: camera.forward + sideways * random.power(-8.0, 1.0) as f32 },
        };
        let view = View { camera: Camera { projection, ..camera }, width: 64, height: 64 };
        Self { random, level, view, light, depth, zoom }
    }

    /// The largest errors of X or Y, and of W, of a point in relation to their bounds.
    fn run(&mut self) -> Option<[f64; 2]> {
        let Self { random, level, view, light, depth, zoom } = self;
        let offset_pixels = DVec2::new(random.unit(), random.unit());
        let mut seen = SeenPixels::default();
        seen.resize(view.width, view.height);
        let is_rough = random.unit() < 0.5;
        // Whether all depths are wrong in the same direction.
        let one_sign = random.unit() < 0.5;
        let (least, error) = (random.unit(), *zoom * random.power(-3.0, 0.0).min(0.5));
        // Each pixel shows a triangle of its own, for points that can't be mapped from depths.
        let (mut positions, mut true_depth) = (Vec::new(), Vec::new());
        for index in 0..seen.triangle.len() {
            let (column, row) = seen.order().column_and_row(index);
            let [x, y] = [column, row].map(f64::from);
            let ray = view.ray(x + offset_pixels.x, y + offset_pixels.y);
            let along = if is_rough { random.unit() } else { (x + 2.0 * y) / 200.0 };
            let at = ray.origin + ray.direction * (*depth * (1.0 + error * along));
            let corners = [(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)].map(|(right, up)| {
                let size = 0.1 * *depth as f32;
                at.as_vec3() + view.camera.right * (right * size) + view.camera.up * (up * size)
            });
            let t = crossing(&ray, corners).map_or(f64::NAN, |crossing| crossing.t);
            let sign = random.signed();
            let sign = if one_sign { 1.0 } else { sign };
            let wrong = (random.unit() * least + (1.0 - least)).copysign(sign);
            // The rest is for rounding.
            let wrong = wrong * 0.96 * f64::from(SeenPixels::RELATIVE_ERROR);
            seen.inverse_depth[index] = ((1.0 + wrong) / t) as f32;
            seen.triangle[index] = index as u32;
            true_depth.push(t);
            positions.extend(corners);
        }
        let indices: Vec<_> = (0..true_depth.len() as u32).map(|id| [3 * id, 3 * id + 1, 3 * id + 2]).collect();
        let triangles = Triangles { positions: &positions, indices: &indices };
        let shot = Shot { offset_pixels, ..Shot::new(triangles, *view) };
        let mut survey = Survey::default();
        survey.find(&shot, &seen, *level);
        let mut faces = Vec::new();
        choose(light, survey.rays.step_x, &survey.tiles, &mut faces)?;
        let points = PointSet::Seen(SeenImage { shot: &shot, seen: &seen }, survey.rays);
        let (mut worst, mut on_faces) = ([0.0; 2], vec![0_u16; TILE_BLOCKS]);
        for face in &mut faces {
            face.choose_point_error(&points, &survey.tiles);
            let pixels = PixelMap::new(face, &survey.rays);
            let PointSet::Seen(image, _) = &points else { return None };
            let map = TileMap::new(&points, face, &pixels, 0, origin(image, &pixels, 0));
            let mut blocks = Box::new([Block::EMPTY; TILE_BLOCKS]);
            for group in 0..GROUPS {
                let (mut outliers, mut refined) = (Vec::new(), 0);
                let found = dispatch!(*level, simd =>
                    map.map_group(simd, group, &mut blocks, &mut outliers, &mut refined));
                for index in outliers.into_iter().map(|index| index as usize) {
                    on_faces[index / LANES] |= 1 << (index % LANES);
                }
                let Some(found) = found else { continue };
                for (index, members) in found.members.into_iter().enumerate() {
                    let block = block_of(group, index);
                    on_faces[block] |= members;
                    for lane in bits_of(members) {
                        let index = block * LANES + lane;
                        let (column, row) = seen.order().column_and_row(index);
                        let ray = view.ray(f64::from(column) + offset_pixels.x, f64::from(row) + offset_pixels.y);
                        let hit = HitPoint::new(&ray, true_depth[index]);
                        let (wrong, at) = wrong_by(face, hit.position, map.origin, &blocks[block], lane);
                        let depth = if face.is_parallel { 1.0 } else { face.near / at.z };
                        let [position, nearness] = found.errors.map(f64::from);
                        worst[0] = f64::max(worst[0], wrong.x.max(wrong.y) / position);
                        worst[1] = f64::max(worst[1], wrong.z / nearness);
                        assert!(hit.error <= face.point_error * depth, "{hit:?} on {face:?}");
                        assert!(at.x.abs().max(at.y.abs()) < FACE_LIMIT, "{at} of {face:?}");
                    }
                }
            }
        }
        let is_on_face = |index: usize| on_faces[index / LANES] >> (index % LANES) & 1 == 1;
        let are_on_faces = true_depth.iter().enumerate().all(|(index, depth)| depth.is_nan() || is_on_face(index));
        assert!(are_on_faces, "not all points of {view:?} are on faces of {light:?}");
        Some(worst)
    }
}

/// The differences of X, Y and W of a block's point from those of a world position, and the latter.
fn wrong_by(face: &Face, position: DVec3, origin: [f32; 3], points: &Block, lane: usize) -> (DVec3, DVec3) {
    let v = difference(precise(position), precise(face.origin));
    let [x, y, z] = [face.x, face.y, face.z].map(|axis| dot(precise(axis), v));
    let at = if face.is_parallel { [x, y, z] } else { [x / z, y / z, Precise::from(face.near) / z] };
    let to = [points.x[lane], points.y[lane], points.nearness[lane]].map(|value| Precise::from(f64::from(value)));
    let wrong = difference(difference(at, precise(DVec3::from(origin.map(f64::from)))), to);
    (DVec3::from(wrong.map(|wrong| wrong.abs().to_f64())), DVec3::from(at.map(Precise::to_f64)))
}

/// The largest results of all trials.
fn worst(of_trial: impl Fn(Random, SimdLevel) -> Option<[f64; 2]> + Sync) -> [f64; 2] {
    let levels = SimdLevel::available();
    let of_seed = |seed: u32| of_trial(Random::new(seed.into()), levels[seed as usize % levels.len()]);
    let all: Vec<_> = (0..TRIALS).into_par_iter().filter_map(of_seed).collect();
    assert!(all.len() > TRIALS as usize / 2, "{}", all.len());
    all.into_iter().fold([0.0; 2], |most, one| [0, 1].map(|axis| f64::max(most[axis], one[axis])))
}

#[test]
fn points_are_no_more_wrong_than_is_said() {
    let most = worst(|random, level| ViewedObject::new(random, level).run());
    // The bounds aren't much larger than the errors.
    assert!(most.iter().all(|most| (0.5..=1.0).contains(most)), "{most:?} of what may be");
}

/// The same of listed points in a box of any size and place.
fn listed(mut random: Random, level: SimdLevel) -> Option<[f64; 2]> {
    let out = if random.unit() < 0.7 { 1.0 } else { random.power(0.0, 6.0) };
    let size = 2.0 * random.power(-6.0, 0.0);
    let mut anywhere = |size: f64| DVec3::from([0; 3].map(|_| random.signed() * size));
    let (middle, half, far, sideways) = (anywhere(10.0 * out), anywhere(size), anywhere(30.0), anywhere(1.0));
    let positions: Vec<DVec3> = (0..300).map(|_| middle + half * anywhere(1.0)).collect();
    let light = match (random.unit() * 3.0) as u32 {
        0 => LightSource::Point { position: (positions[0] + sideways * random.power(-3.0, 0.0)).as_vec3() },
        1 => LightSource::Point { position: far.as_vec3() },
        _ => LightSource::Directional { direction: sideways.as_vec3() },
    };
    let mut list = PointList::default();
    list.fill(positions.len(), |number| Some((HitPoint { position: positions[number], error: 0.0 }, SeenPixels::NONE)));
    let points = PointSet::Listed(&list);
    let mut faces = Vec::new();
    choose(&light, points.along(), &list.tiles, &mut faces)?;
    let number = (random.unit() * faces.len() as f64) as usize;
    let face = faces.get_mut(number)?;
    face.choose_point_error(&points, &list.tiles);
    let map = TileMap::new(&points, face, &PixelMap::default(), 0, [0.0; 3]);
    let (mut blocks, mut outliers, mut worst) = (Box::new([Block::EMPTY; TILE_BLOCKS]), Vec::new(), [0.0; 2]);
    for group in 0..GROUPS {
        let mut refined = 0;
        let found = dispatch!(level, simd => map.map_group(simd, group, &mut blocks, &mut outliers, &mut refined));
        let Some(found) = found.filter(|_| refined == 0 && outliers.is_empty()) else { continue };
        for (index, members) in found.members.into_iter().enumerate() {
            let block = block_of(group, index);
            for lane in bits_of(members) {
                let position = list.points[block * LANES + lane].position;
                let (wrong, _) = wrong_by(face, position, map.origin, &blocks[block], lane);
                let [position, nearness] = found.errors.map(f64::from);
                worst[0] = f64::max(worst[0], wrong.x.max(wrong.y) / position);
                worst[1] = f64::max(worst[1], wrong.z / nearness);
            }
        }
    }
    Some(worst)
}

#[test]
fn listed_points_are_no_more_wrong_than_is_said() {
    let most = worst(listed);
    assert!(most.iter().all(|most| (0.1..=1.0).contains(most)), "{most:?} of what may be");
}

/// Quotients with an error in their divisor alone, which comes from s: R₃ = s − (1 − η) with s = 1, without any rounding.
#[test]
fn wrong_divisors_make_quotients_no_more_wrong_than_is_said() {
    let mut list = PointList::default();
    list.fill(1, |_| Some((HitPoint { position: DVec3::ZERO, error: 0.0 }, SeenPixels::NONE)));
    let points = PointSet::Listed(&list);
    let mut faces = Vec::new();
    choose(&LightSource::Directional { direction: Vec3::Z }, points.along(), &list.tiles, &mut faces);
    let map = TileMap {
        slopes: [0.0, 0.0, 0.0, 1.0],
        spreads: [0.0; 4],
        rounded: [0.0; 4],
        wide_errors: [[0.0; 2]; 4],
        point_errors: [0.0; 2],
        point_error: 1.0,
        ..TileMap::new(&points, &faces[0], &PixelMap::default(), 0, [0.0; 3])
    };
    for level in SimdLevel::available() {
        let (mut exact, mut worst) = (0, [0.0; 2]);
        for step in 0..64 {
            let divisors: [f32; LANES] =
                std::array::from_fn(|lane| OF_DEPTH * 128.0 * (1.0 + (step * LANES + lane) as f32 / 128.0));
            let (x, nearness) = (0.01, 7.0);
            let said = dispatch!(level, simd => {
                let inverse = splat(simd, 1.0) / f32x16::simd_from(simd, divisors);
                let [x, nearness, zero] = [x, nearness, 0.0].map(|value| [splat(simd, value); 2]);
                let extremes = Extremes { x, y: zero, nearness, inverse, depth: inverse };
                let (position, nearness, is_exact) = map.errors(simd, &[zero[0]; 4], &extremes);
                (position.to_array(), nearness.to_array(), is_exact.to_bitmask())
            });
            for lane in bits_of(said.2) {
                exact += 1;
                let divisor = f64::from(divisors[lane]);
                for (number, (value, said)) in [(x, said.0), (nearness, said.1)].into_iter().enumerate() {
                    let wrong = f64::from(value) * (divisor / (divisor - f64::from(OF_DEPTH)) - 1.0);
                    worst[number] = f64::max(worst[number], wrong / f64::from(said[lane]));
                }
            }
        }
        assert!((1..64 * LANES).contains(&exact), "{exact}");
        assert!(worst.iter().all(|worst| (0.999..=1.0).contains(worst)), "{worst:?} of what may be");
    }
}
