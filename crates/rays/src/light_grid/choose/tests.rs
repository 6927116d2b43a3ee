//! Faces compared with precise numbers: of lights near the points and far from them, and among them, where cubes and cones
//! end, in scenes of all sizes and far from zero.

use std::ops::RangeInclusive;

use glam::{DMat3, Vec3};
use rayon::prelude::*;

use super::*;
use crate::light_grid::face::{HALF_ULP, LARGEST_POINT_ERROR};
use crate::light_grid::point_set::{PointList, PointSet};
use crate::precise::{Precise, PreciseVector, difference, dot, precise};
use crate::predicate::HitPoint;
use crate::random::Random;
use crate::shot::SeenPixels;

/// Some tiles, a light, and its faces.
pub(crate) struct Scene {
    pub(crate) light: LightSource,
    pub(crate) tiles: Vec<SurveyedTile>,
    pub(crate) faces: Vec<Face>,
    /// The extent of all tiles together.
    pub(crate) size: f64,
}

/// A vector with components from minus one to one.
pub(crate) fn anywhere(random: &mut Random) -> DVec3 {
    DVec3::from([0; 3].map(|_| random.signed()))
}

/// The light's homogeneous coordinates of a position.
pub(crate) fn homogeneous(face: &Face, position: DVec3) -> PreciseVector {
    let v = difference(precise(position), precise(face.origin));
    [face.x, face.y, face.z].map(|axis| dot(precise(axis), v))
}

/// X, Y and W of a position.
pub(crate) fn mapped(face: &Face, position: DVec3) -> PreciseVector {
    let [x, y, z] = homogeneous(face, position);
    if face.is_parallel { [x, y, z] } else { [x / z, y / z, Precise::from(face.near) / z] }
}

/// Whether a position is in front of the light, with X and Y in two ranges.
fn is_within(face: &Face, position: DVec3, ranges: [[f64; 2]; 2]) -> bool {
    let [x, y, z] = homogeneous(face, position);
    let one = if face.is_parallel { 1.0.into() } else { z };
    let is_in = |at: Precise, [low, high]: [f64; 2]| at >= one * low.into() && at <= one * high.into();
    one > 0.0.into() && is_in(x, ranges[0]) && is_in(y, ranges[1])
}

/// The distance of a position from the light, as in [`Face::farthest`].
pub(crate) fn distance(face: &Face, position: DVec3) -> Precise {
    let [_, _, z] = homogeneous(face, position);
    if face.is_parallel { -z } else { z }
}

/// The position with about these homogeneous coordinates.
pub(crate) fn position(face: &Face, at: DVec3) -> DVec3 {
    face.origin + DMat3::from_cols(face.x, face.y, face.z).transpose().inverse() * at
}

impl Scene {
    /// `None` where a light sees nothing, or is none.
    pub(crate) fn new(random: &mut Random, powers: RangeInclusive<i32>) -> Option<Self> {
        let size = random.power((*powers.start()).into(), (*powers.end()).into());
        let from_zero = if random.unit() < 0.3 { 0.0 } else { size * random.power(-1.0, 7.0) };
        let middle = anywhere(random) * from_zero;
        // Where coordinates near zero aren't rounded, the light is at zero.
        let away = size * random.power(-2.0, 5.0);
        let middle = if from_zero == 0.0 && random.unit() < 0.5 { anywhere(random) * away } else { middle };
        let at = if from_zero == 0.0 { DVec3::ZERO } else { middle + anywhere(random) * away };
        let flat = [DVec3::ONE, DVec3::ONE, DVec3::new(1.0, 0.0, 1.0), DVec3::ZERO][(random.unit() * 4.0) as usize];
        let tile = |random: &mut Random| {
            let middle = middle + anywhere(random) * size * flat;
            let half = size * random.power(-3.0, 0.0);
            SurveyedTile {
                points: 1,
                has_unknown: false,
                corners: [0; 8].map(|_| middle + anywhere(random) * half * flat),
            }
        };
        let mut tiles: Vec<_> = (0..=(random.unit() * 3.0) as u32).map(|_| tile(random)).collect();
        let direction = (middle - at + anywhere(random) * size).normalize_or(DVec3::Z).as_vec3();
        let position = at.as_vec3();
        let light = match (random.unit() * 4.0) as u32 {
            0 | 1 => LightSource::Point { position },
            2 => spot(position, direction, random.power(-2.0, 0.1) as f32),
            _ => LightSource::Directional { direction },
        };
        if let (LightSource::Directional { direction }, true) = (light, random.unit() < 0.5) {
            // Flat across the light.
            let along = direction.as_dvec3();
            let corners = tiles.iter_mut().flat_map(|tile| &mut tile.corners);
            corners.for_each(|corner| *corner -= along * along.dot(*corner - middle));
        }
        let mut faces = Vec::new();
        choose(&light, anywhere(random), &tiles, &mut faces)?;
        Some(Self { light, tiles, faces, size }).filter(|scene| !scene.faces.is_empty())
    }

    /// One of the faces.
    pub(crate) fn face(&self, random: &mut Random) -> Face {
        self.faces[(random.unit() * self.faces.len() as f64) as usize]
    }

    /// The distance of the farthest corner from a face's light.
    pub(crate) fn farthest(&self, face: &Face) -> Precise {
        let distances = corners(&self.tiles).map(|corner| distance(face, corner));
        distances.reduce(|most, one| if one > most { one } else { most }).expect("a corner")
    }

    /// Whether a position is possible for an occluder of a point that is found on a face, rightly or not.
    pub(crate) fn may_shadow(&self, face: &Face, position: DVec3) -> bool {
        const LIMIT: f64 = POINT_LIMIT + LARGEST_POINT_ERROR;
        is_within(face, position, [[-LIMIT, LIMIT]; 2]) && distance(face, position) <= self.farthest(face)
    }
}

fn spot(position: Vec3, direction: Vec3, outer_radians: f32) -> LightSource {
    LightSource::Spot { position, direction, inner_radians: 0.0, outer_radians }
}

/// Whether a point is on one of the faces, and in the range that this one owns.
fn is_on_some(faces: &[Face], point: DVec3) -> bool {
    faces.iter().any(|face| {
        is_within(face, point, [[-POINT_LIMIT, POINT_LIMIT]; 2])
            && face.owned.is_none_or(|owned| is_within(face, point, owned))
    })
}

#[test]
fn every_point_of_a_tile_is_on_some_face() {
    (0..4000_u32).into_par_iter().for_each(|seed| {
        let mut random = Random::new(seed.into());
        let Some(scene) = Scene::new(&mut random, -20..=20) else { return };
        let cone = Cone::of(&scene.light);
        for tile in &scene.tiles {
            let [a, b] = [0; 2].map(|_| tile.corners[(random.unit() * 8.0) as usize]);
            for point in [a, b, a.lerp(b, random.unit())] {
                // The light itself is in no direction from there.
                let is_apart = scene.faces.iter().all(|face| face.is_parallel || point != face.origin);
                let is_seen = is_apart && cone.is_none_or(|cone| cone.contains(point));
                assert!(!is_seen || is_on_some(&scene.faces, point), "{point} of {:?}, {:?}", scene.light, scene.faces);
            }
        }
    });
}

#[test]
fn points_where_sides_of_a_cube_meet_are_on_one() {
    (0..4000_u32).into_par_iter().for_each(|seed| {
        let mut random = Random::new(seed.into());
        let light = if random.unit() < 0.5 { Vec3::ZERO } else { anywhere(&mut random).as_vec3() * 1e3 };
        // Around the light, so that there is a cube, and one as small as faces may be.
        let size = random.power(-6.0, 0.0);
        let (side, other) = (anywhere(&mut random).signum(), random.signed());
        let mut diagonal = side * DVec3::new(1.0, 1.0, if random.unit() < 0.3 { 1.0 } else { other });
        diagonal = DVec3::from(std::array::from_fn(|axis| diagonal[(axis + seed as usize) % 3]));
        let point = light.as_dvec3() + diagonal * random.power(-2.0, 2.0);
        let around = |middle: DVec3, random: &mut Random| SurveyedTile {
            points: 1,
            corners: [0; 8].map(|_| middle + anywhere(random) * size * random.unit().round()),
            ..SurveyedTile::default()
        };
        let tiles = [around(point, &mut random), around(2.0 * light.as_dvec3() - point, &mut random)];
        let mut faces = Vec::new();
        choose(&LightSource::Point { position: light }, DVec3::X, &tiles, &mut faces).expect("a light");
        for point in corners(&tiles) {
            assert!(is_on_some(&faces, point), "{point} around {light}: {faces:?}");
        }
    });
}

#[test]
fn points_on_the_edge_of_a_cone_are_on_its_face() {
    let seen: u32 = (0..4000_u32)
        .into_par_iter()
        .map(|seed| {
            let mut random = Random::new(seed.into());
            let light = spot(Vec3::ZERO, anywhere(&mut random).as_vec3(), random.power(-2.0, 0.0) as f32);
            let cone = Cone::of(&light).expect("a cone");
            let forward = cone.axis.normalize();
            let (right, up) = across(forward, DVec3::X);
            let aside = [right, -right, up, -up][(random.unit() * 4.0) as usize];
            let tangent = (cone.axis.length_squared() / cone.squared_cosine - 1.0).sqrt();
            let depth = random.power(-3.0, 3.0);
            // The outermost point in the cone, among some that differ by roundings.
            let at = |step: i32| (forward + aside * tangent * (1.0 - f64::from(step) * f64::EPSILON)) * depth;
            let Some(point) = (-8..8).map(at).find(|&point| cone.contains(point)) else { return 0 };
            let mut faces = Vec::new();
            choose(
                &light,
                DVec3::X,
                &[SurveyedTile { points: 1, corners: [point; 8], ..SurveyedTile::default() }],
                &mut faces,
            );
            assert!(is_on_some(&faces, point), "{point} of {light:?}, {faces:?}");
            1
        })
        .sum();
    assert!(seen > 2000, "{seen}");
}

#[test]
fn points_practically_on_a_spot_are_on_its_face() {
    let seen: u32 = (0..20_000_u32)
        .into_par_iter()
        .map(|seed| {
            let mut random = Random::new(seed.into());
            let light = spot(Vec3::ZERO, anywhere(&mut random).as_vec3(), random.power(-0.3, 0.0) as f32);
            let cone = Cone::of(&light).expect("a cone");
            // Two corners in the light's plane, on either side of the light: rounding decides the side of points between
            // them.
            let corner = cone.axis.cross(anywhere(&mut random));
            let round = |at: f64| at * 3.0;
            let other = DVec3::from(corner.to_array().map(round));
            let point = corner.mul_add(DVec3::splat(3.0), -other) * 0.25;
            let corners = std::array::from_fn(|number| if number % 2 == 0 { corner } else { -other });
            let mut faces = Vec::new();
            choose(&light, DVec3::X, &[SurveyedTile { points: 1, corners, ..SurveyedTile::default() }], &mut faces);
            let is_seen = point != DVec3::ZERO && cone.contains(point);
            assert!(!is_seen || is_on_some(&faces, point), "{point} of {light:?}, {faces:?}");
            u32::from(is_seen)
        })
        .sum();
    assert!(seen > 1000, "{seen}");
}

#[test]
fn no_point_is_farther_than_is_said() {
    (0..4000_u32).into_par_iter().for_each(|seed| {
        let mut random = Random::new(seed.into());
        let Some(mut scene) = Scene::new(&mut random, -20..=20) else { return };
        let face = scene.face(&mut random);
        if random.unit() < 0.5 && !face.is_parallel {
            // About in the light's plane.
            let mut corner = || {
                let [x, y, depth] = [1.0, 1.0, random.power(-20.0, -8.0)].map(|most| random.signed() * most);
                position(&face, DVec3::new(x, y, depth) * scene.size)
            };
            scene.tiles =
                vec![SurveyedTile { points: 1, corners: [0; 8].map(|_| corner()), ..SurveyedTile::default() }];
        }
        let said = face.farthest(&scene.tiles);
        assert!(scene.farthest(&face) <= said.into(), "{said} of {face:?} for {:?}", scene.tiles);
    });
}

#[test]
fn no_face_has_a_point_of_a_tile_that_is_ruled_out() {
    (0..20_000_u32).into_par_iter().for_each(|seed| {
        let mut random = Random::new(seed.into());
        let Some(scene) = Scene::new(&mut random, -20..=20) else { return };
        let face = scene.face(&mut random);
        let Some(owned) = face.owned else { return };
        // All corners but one are outside, and that one is about where the face, or its own range, ends.
        let (axis, end) = ((random.unit() * 2.0) as usize, random.unit().round() as usize);
        let depth = scene.size * random.power(-3.0, 3.0);
        let beside = owned[1 - axis][0] + (owned[1 - axis][1] - owned[1 - axis][0]) * random.unit();
        let corner = |beyond: f64| {
            let mut at = DVec3::splat(beside);
            at[axis] = owned[axis][end] * (1.0 + beyond.copysign(owned[axis][end] * (end as f64 - 0.5)));
            position(&face, at.with_z(1.0) * depth)
        };
        let first = corner(0.0);
        let corners = std::array::from_fn(|number| if number == 0 { first } else { corner(1.0) });
        let tile = SurveyedTile { points: 1, corners, ..SurveyedTile::default() };
        let has_point = corners.iter().any(|&corner| is_within(&face, corner, owned));
        assert!(!has_point || face.may_own(&tile), "{corners:?} and {face:?}");
    });
}

#[test]
fn axes_are_right_angled() {
    (0..1000_u32).for_each(|seed| {
        let mut random = Random::new(seed.into());
        let forward = anywhere(&mut random).normalize();
        let along = forward + anywhere(&mut random) * random.power(-17.0, 1.0);
        let (right, up) = across(forward, along);
        let angles = [right.dot(forward), up.dot(forward), right.dot(up)].map(f64::abs);
        assert!(angles.iter().all(|&cosine| cosine < 1e-8), "{forward} along {along}: {angles:?}");
        assert!([right, up].iter().all(|axis| (axis.length() - 1.0).abs() < 1e-8), "{right}, {up}");
    });
}

#[test]
fn what_points_may_be_wrong_by_is_allowed_for() {
    let mut list = PointList::default();
    for seed in 0..1000 {
        let mut random = Random::new(seed);
        let Some(scene) = Scene::new(&mut random, -20..=20) else { continue };
        let positions: Vec<_> = corners(&scene.tiles).collect();
        let error = if random.unit() < 0.1 { 0.0 } else { scene.size * random.power(-14.0, 0.0) };
        list.fill(positions.len(), |number| Some((HitPoint { position: positions[number], error }, SeenPixels::NONE)));
        let (points, mut face) = (PointSet::Listed(&list), scene.face(&mut random));
        face.choose_point_error(&points, &scene.tiles);
        let depths = positions.iter().map(|&position| face.homogeneous(position).z);
        let in_front = depths.filter(|&depth| face.is_parallel || depth > 0.0);
        let errors: Vec<_> = in_front.map(|depth| points.error_at(&face, DVec3::ZERO, depth)).collect();
        let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
        // Unless a point is practically on the light.
        let is_allowed =
            |&error: &f64| 4.0 * error <= face.point_error || 4.0 * error > 1000.0 * least && 4.0 * error > HALF_ULP;
        assert!(face.point_error > 0.0 && errors.iter().all(is_allowed), "{errors:?} of {face:?}");
    }
}

#[test]
fn axes_across_are_so_to_a_few_roundings() {
    let mut random = Random::new(1);
    for trial in 0..40_000 {
        let mut vector = || DVec3::from([0; 3].map(|_| random.signed()));
        let (forward, aside) = (vector().normalize(), vector());
        let (right, up) = across(forward, forward + aside * 10.0_f64.powi(-trial % 18));
        let along = forward.dot(right).abs().max(forward.dot(up).abs());
        assert!(along < 8.0 * ROUNDING, "{forward} {right} {up}: {along}");
        assert!(right.is_normalized() && up.is_normalized() && right.dot(up).abs() < 8.0 * ROUNDING);
    }
}
