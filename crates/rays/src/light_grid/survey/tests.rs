//! Tiles of random views, with depths as wrong as they may be.

use glam::{DVec2, Vec3};

use super::*;
use crate::precise::{cross, difference, dot, precise};
use crate::random::Random;
use crate::shot::Shifts;
use crate::{Camera, Projection, Triangles, View};

fn random_shot(random: &mut Random) -> Shot<'static> {
    let mut anywhere = |size: f64| DVec3::from([0; 3].map(|_| random.signed() * size)).as_vec3();
    let (position, at) = (anywhere(10.0), anywhere(10.0));
    let angle = random.power(-6.0, 0.0) as f32;
    let camera = Camera::look_at(position, at, Vec3::Y, angle);
    let projection = Projection::Orthographic { half_height: random.power(-5.0, 2.0) as f32 };
    let projection = if random.unit() < 0.4 { projection } else { camera.projection };
    let view = View { camera: Camera { projection, ..camera }, width: 100, height: 70 };
    let mut shift = || (random.signed() * 2048.0).round() * Shifts::STEP_PIXELS;
    let shifts = Shifts::new([0; 4].map(|_| DVec2::new(shift(), shift()))).expect("shifts");
    let shifts = if random.unit() < 0.5 { shifts } else { Shifts::NONE };
    let offset_pixels = DVec2::new(random.unit(), random.unit());
    Shot { offset_pixels, shifts, ..Shot::new(Triangles::default(), view) }
}

/// Whether a point is between each two opposite sides of a frustum.
fn is_in(corners: &[DVec3; 8], point: DVec3) -> bool {
    (0..6).all(|side| {
        let axis = side / 2;
        let (end, others) = ((side % 2) << axis, [1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3)]);
        let at = |corner: usize| precise(corners[corner]);
        let origin = at(end);
        let normal = cross(difference(at(end + others[0]), origin), difference(at(end + others[1]), origin));
        let height = |point| dot(normal, difference(point, origin));
        let (of_point, of_inside) = (height(precise(point)), height(at(end ^ 1 << axis)));
        of_point * of_inside >= 0.0.into()
    })
}

#[test]
fn the_points_of_a_tile_are_in_its_frustum() {
    let levels = SimdLevel::available();
    let (mut seen, mut survey) = (SeenPixels::default(), Survey::default());
    for seed in 0..3000 {
        let mut random = Random::new(seed);
        let shot = random_shot(&mut random);
        seen.resize(shot.view.width, shot.view.height);
        seen.triangle.fill(SeenPixels::NONE);
        seen.inverse_depth.fill(f32::NAN);
        let depth = random.power(-3.0, 3.0);
        let error = random.power(-8.0, 0.0);
        let (mut points, mut unknown) = (Vec::new(), Vec::new());
        // Where tiles end, most of all.
        let mut end = |size: u32| [0.0, 63.0, 64.0, f64::from(size) - 1.0, random.unit() * f64::from(size)];
        let (columns, rows) = (end(100), end(70));
        for _ in 0..8 {
            let mut one_of = |ends: [f64; 5]| ends[(random.unit() * 5.0) as usize] as u32;
            let (x, y) = (one_of(columns), one_of(rows));
            let index = seen.order().index(x, y);
            if seen.triangle[index] != SeenPixels::NONE {
                continue;
            }
            seen.triangle[index] = 0;
            if random.unit() < 0.1 {
                unknown.push(index as u32);
                continue;
            }
            let t = depth * (1.0 + random.unit() * error);
            let wrong = f64::from(SeenPixels::RELATIVE_ERROR) * 0.96_f64.copysign(random.signed());
            seen.inverse_depth[index] = ((1.0 + wrong) / t) as f32;
            let ray = shot.ray(x, y);
            points.push((index, ray.origin + ray.direction * t));
        }
        survey.find(&shot, &seen, levels[seed as usize % levels.len()]);
        unknown.sort_unstable();
        assert_eq!(survey.unknown, unknown);
        for (number, tile) in survey.tiles.iter().enumerate() {
            let is_of = |index: usize| index / TileOrder::TILE_PIXELS == number;
            let of_tile: Vec<_> = points.iter().filter(|(index, _)| is_of(*index)).collect();
            assert_eq!(tile.points as usize, of_tile.len());
            assert_eq!(tile.has_unknown, unknown.iter().any(|&index| is_of(index as usize)));
            for (_, point) in of_tile {
                assert!(is_in(&tile.corners, *point), "{point} isn't in {:?} of {:?}", tile.corners, shot.view);
            }
        }
    }
}
