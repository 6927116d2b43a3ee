//! Points as they are mapped, beside the same in f64, with depths as wrong as they may be.

use fearless_simd::dispatch;
use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::*;
use crate::light_grid::choose::choose;
use crate::light_grid::survey::Survey;
use crate::predicate::HitPoint;
use crate::random::Random;
use crate::shot::Shot;
use crate::{Camera, LightSource, Projection, SimdLevel, Triangles, View};

const TRIALS: u32 = 2000;

/// A view of something at about one depth, and a light anywhere, often near the camera, where depths don't matter.
struct Trial {
    random: Random,
    level: SimdLevel,
    view: View,
    light: LightSource,
    depth: f64,
}

impl Trial {
    fn new(mut random: Random, level: SimdLevel) -> Self {
        let mut anywhere = |size: f64| DVec3::from([0; 3].map(|_| random.signed() * size)).as_vec3();
        let (position, at, sideways) = (anywhere(10.0), anywhere(10.0), anywhere(1.0));
        let (near, far) = (anywhere(1.0), anywhere(30.0));
        let camera = Camera::look_at(position, at, Vec3::Y, 0.7);
        let projection = Projection::Orthographic { half_height: random.power(-1.0, 1.0) as f32 };
        let projection = if random.unit() < 0.3 { projection } else { camera.projection };
        let light = match (random.unit() * 3.0) as u32 {
            0 => LightSource::Point { position: position + near * random.power(-8.0, 0.0) as f32 },
            1 => LightSource::Point { position: far },
            _ => LightSource::Directional { direction: camera.forward + sideways * random.power(-8.0, 1.0) as f32 },
        };
        let view = View { camera: Camera { projection, ..camera }, width: 100, height: 100 };
        Self { depth: random.power(0.0, 2.0), random, level, view, light }
    }

    /// How wrong X or Y, and W, of a point are at most in relation to what they may be.
    fn run(&mut self) -> Option<[f64; 2]> {
        let Self { random, level, view, light, depth } = self;
        let offset_pixels = DVec2::new(random.unit(), random.unit());
        // For what can't be mapped from depths.
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let shot =
            Shot { offset_pixels, ..Shot::new(Triangles { positions: &positions, indices: &[[0, 1, 2]] }, *view) };
        let mut seen = SeenPixels::default();
        seen.resize(view.width, view.height);
        let is_rough = random.unit() < 0.5;
        let mut true_depth = vec![0.0; seen.triangle.len()];
        let (least, error) = (random.unit(), random.power(-3.0, 0.0).min(0.5));
        for (index, true_depth) in true_depth.iter_mut().enumerate() {
            let Some((x, y)) = seen.order().pixel(index) else { continue };
            let along = if is_rough { random.unit() } else { (f64::from(x) + 2.0 * f64::from(y)) / 300.0 };
            *true_depth = *depth * (1.0 + error * along);
            let wrong = random.signed() * least + (1.0 - least).copysign(random.signed());
            // The rest is for rounding.
            let wrong = wrong * 0.96 * f64::from(SeenPixels::RELATIVE_ERROR);
            seen.inverse_depth[index] = ((1.0 + wrong) / *true_depth) as f32;
            seen.triangle[index] = 0;
        }
        let mut survey = Survey::default();
        survey.find(&shot, &seen, *level);
        let mut faces = Vec::new();
        choose(light, survey.rays.step_x, &survey.tiles, &mut faces)?;
        let number = (random.unit() * faces.len() as f64) as usize;
        let face = faces.get_mut(number)?;
        let image = SeenImage { shot: &shot, seen: &seen };
        let points = PointSet::Seen(image, survey.rays);
        face.choose_point_error(&points, &survey.tiles);
        let pixels = PixelMap::new(face, &survey.rays);
        let tile = (random.unit() * survey.tiles.len() as f64) as usize;
        let origin = origin(&image, &pixels, tile);
        let map = TileMap::new(&points, face, &pixels, tile, origin);
        let (mut blocks, mut outliers, mut worst) = (Box::new([Block::EMPTY; TILE_BLOCKS]), Vec::new(), [0.0; 2]);
        for group in 0..GROUPS {
            let mut refined = 0;
            let found = dispatch!(level.0, simd =>
                map.map_group(simd, group, &mut blocks, &mut outliers, &mut refined));
            let Some(found) = found.filter(|_| refined == 0 && outliers.is_empty()) else { continue };
            for (index, members) in found.members.into_iter().enumerate() {
                let block = block_of(group, index);
                for lane in bits_of(members) {
                    let index = tile * TileOrder::TILE_PIXELS + block * LANES + lane;
                    let (column, row) = seen.order().column_and_row(index);
                    let ray = view.ray(f64::from(column) + offset_pixels.x, f64::from(row) + offset_pixels.y);
                    let p = face.homogeneous(ray.origin + ray.direction * true_depth[index]);
                    let wrong = wrong_by(face, p, origin, &blocks[block], lane);
                    let [position, nearness] = found.errors.map(f64::from);
                    worst[0] = f64::max(worst[0], wrong.x.max(wrong.y) / position);
                    worst[1] = f64::max(worst[1], wrong.z / nearness);
                }
            }
        }
        Some(worst)
    }
}

/// By how much X, Y and W of a block's point are from where its homogeneous coordinates are.
fn wrong_by(face: &Face, p: DVec3, origin: [f32; 3], points: &Block, lane: usize) -> DVec3 {
    let at = if face.is_parallel { p } else { DVec3::new(p.x, p.y, face.near) / p.z };
    let to = DVec3::from([points.x[lane], points.y[lane], points.nearness[lane]].map(f64::from));
    (at - DVec3::from(origin.map(f64::from)) - to).abs()
}

/// The most of what trials say.
fn worst(of_trial: impl Fn(Random, SimdLevel) -> Option<[f64; 2]> + Sync) -> [f64; 2] {
    let levels = SimdLevel::available();
    let of_seed = |seed: u32| of_trial(Random::new(seed.into()), levels[seed as usize % levels.len()]);
    let all: Vec<_> = (0..TRIALS).into_par_iter().filter_map(of_seed).collect();
    assert!(all.len() > TRIALS as usize / 2, "{}", all.len());
    all.into_iter().fold([0.0; 2], |most, one| [0, 1].map(|axis| f64::max(most[axis], one[axis])))
}

#[test]
fn points_are_no_more_wrong_than_is_said() {
    let most = worst(|random, level| Trial::new(random, level).run());
    // What is allowed isn't much more than what there is.
    assert!(most.iter().all(|most| (0.5..=1.0).contains(most)), "{most:?} of what may be");
}

/// The same of listed points in a box of any size and place.
fn listed(mut random: Random, level: SimdLevel) -> Option<[f64; 2]> {
    let mut anywhere = |size: f64| DVec3::from([0; 3].map(|_| random.signed() * size));
    let (middle, half, far, sideways) = (anywhere(10.0), anywhere(2.0), anywhere(30.0), anywhere(1.0));
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
        let found = dispatch!(level.0, simd => map.map_group(simd, group, &mut blocks, &mut outliers, &mut refined));
        let Some(found) = found.filter(|_| refined == 0 && outliers.is_empty()) else { continue };
        for (index, members) in found.members.into_iter().enumerate() {
            let block = block_of(group, index);
            for lane in bits_of(members) {
                let p = face.homogeneous(list.points[block * LANES + lane].position);
                let wrong = wrong_by(face, p, map.origin, &blocks[block], lane);
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
