//! Compares the points found with the predicate's. Planes go through the camera, or nearly so, and contain its direction, or
//! nearly so. Coordinates are whole numbers, so most of the error is rounding.

use crate::dispatch;
use glam::Vec3;
use rayon::prelude::*;

use super::*;
use crate::precise::{Precise, cross as precise_cross, difference, dot as precise_dot, precise};
use crate::predicate::crossing;
use crate::random::Random;
use crate::shot::{Shifts, Shot};
use crate::{Camera, Projection, SimdLevel, View};

const TRIALS: u32 = 20_000;

/// Random whole numbers of magnitude below 2^`bits`.
fn whole(random: &mut Random, bits: f64) -> DVec3 {
    DVec3::from([0; 3].map(|_| (random.signed() * bits.exp2()).round()))
}

/// One, or two to a power from `least` to `most`.
fn two_to(random: &mut Random, least: f64, most: f64) -> f64 {
    if random.unit() < 0.3 { 1.0 } else { (least + (most - least) * random.unit()).round().exp2() }
}

/// A camera that looks along planes through its position, and a light.
struct EdgeOnView {
    random: Random,
    /// Two directions that span the planes: the camera looks along the first.
    along: DVec3,
    across: DVec3,
    middle: DVec3,
    camera: Camera,
    light: DVec3,
    /// Number of random rays from which the one that grazes the triangles most is taken.
    choices: u32,
}

impl EdgeOnView {
    fn new(mut random: Random) -> Self {
        let (along, across) = (whole(&mut random, 10.0) + 0.25, whole(&mut random, 10.0) + 0.5);
        let middle = whole(&mut random, 14.0) * f64::from(u8::from(random.unit() < 0.5));
        let anywhere = |random: &mut Random| DVec3::from([0; 3].map(|_| random.signed()));
        // Some rays graze planes by as little as roundings.
        let (aside, half_height, choices) =
            if random.unit() < 0.2 { ((-20.0, -12.0), (-17.0, -15.0), 40) } else { ((-20.0, 3.0), (-15.0, 1.0), 1) };
        let aside = anywhere(&mut random) * random.power(aside.0, aside.1);
        let light = middle + anywhere(&mut random) * random.power(-6.0, 6.0);
        let forward = (along / 1024.0).as_vec3();
        let right = forward.any_orthogonal_vector().normalize();
        let half_height = random.power(half_height.0, half_height.1) as f32;
        let projection = if random.unit() < 0.5 {
            Projection::Perspective { tan_half_height: half_height }
        } else {
            Projection::Orthographic { half_height: half_height * random.power(0.0, 4.0) as f32 }
        };
        let up = right.cross(forward.normalize());
        let camera = Camera { position: (middle + aside).as_vec3(), right, up, forward, projection };
        Self { random, along, across, middle, camera, light: light.as_vec3().as_dvec3(), choices }
    }

    /// A triangle around a point that a ray goes through.
    fn corners(&mut self) -> [Vec3; 3] {
        let Self { random, along, across, middle, .. } = self;
        let mut factor = || two_to(random, -10.0, 4.0);
        let behind = -*along * factor();
        let [left, right] = [*across * factor(), *across * -factor()];
        let mut corners = [behind + left, behind + right, *along * factor()];
        corners.rotate_left((random.unit() * 3.0) as usize);
        // Some are tilted, so that the camera doesn't just graze them.
        let tilt = if random.unit() < 0.3 { random.power(-10.0, 0.0) * 1024.0 } else { 0.0 };
        corners.map(|corner| (*middle + corner + DVec3::from([0; 3].map(|_| tilt * random.signed()))).as_vec3())
    }

    /// The largest error of a point relative to its bound, the predicate's largest assumed error relative to its bound, and
    /// the number of points.
    fn run(&mut self, level: SimdLevel) -> ([f64; 2], u32) {
        let positions: Vec<Vec3> = (0..8).flat_map(|_| self.corners()).collect();
        let ids: Vec<_> = (0..8).map(|id| [3 * id, 3 * id + 1, 3 * id + 2]).collect();
        let triangles = Triangles { positions: &positions, indices: &ids };
        let Self { random, camera, light, choices, .. } = self;
        let width = [64, 300, 2000][(random.unit() * 3.0) as usize];
        let view = View { camera: *camera, width, height: 64 };
        let offset_pixels = DVec2::new(random.unit(), random.unit());
        let shift = |()| {
            let steps = DVec2::new(random.signed(), random.signed()) * 0.5 / Shifts::STEP_PIXELS;
            steps.round() * Shifts::STEP_PIXELS
        };
        let shifts = Shifts::new([(); 4].map(shift));
        let shot = Shot { offset_pixels, shifts: shifts.unwrap_or_default(), ..Shot::new(triangles, view) };
        let mut seen = SeenPixels::default();
        seen.resize(view.width, view.height);
        let indices: [u32; 8] = std::array::from_fn(|id| {
            let slope = |&(x, y): &(u32, u32)| slope(shot.ray(x, y).direction, triangles.corners(id as u32));
            let pixels =
                (0..*choices).map(|_| ((random.unit() * f64::from(width)) as u32, (random.unit() * 64.0) as u32));
            let (x, y) = pixels.min_by(|a, b| slope(a).total_cmp(&slope(b))).unwrap();
            let index = seen.order().index(x, y);
            seen.triangle[index] = id as u32;
            index as u32
        });
        let (image, rays) = (SeenImage { shot: &shot, seen: &seen }, CameraRays::new(&shot));
        let (offset, errors, certain) = dispatch!(level, simd => {
            let found = EightPoints::find(simd, &image, &rays, indices, *light);
            let [x, y, z] = found.offset;
            let errors = [found.error.to_array(), found.predicate_error.to_array()];
            ([x.to_array(), y.to_array(), z.to_array()], errors, found.certain.to_bitmask())
        });
        let (mut worst, mut count) = ([0.0_f64; 2], 0);
        for (lane, index) in indices.into_iter().enumerate().filter(|(lane, _)| certain >> lane & 1 == 1) {
            let (x, y) = seen.order().column_and_row(index as usize);
            let ray = shot.ray(x, y);
            let Some(hit) = crossing(&ray, triangles.corners(seen.triangle[index as usize])) else { continue };
            let point = HitPoint::new(&ray, hit.t);
            let found = DVec3::from(offset.map(|axis| axis[lane]));
            let wrong = wrong_by(found, point, *light);
            worst = [worst[0].max(wrong / errors[0][lane]), worst[1].max(point.error / errors[1][lane])];
            count += 1;
        }
        (worst, count)
    }
}

/// The magnitude of a direction's product with a triangle's normal.
fn slope(direction: DVec3, corners: [Vec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| precise(corner.as_dvec3()));
    precise_dot(precise_cross(difference(b, a), difference(c, a)), precise(direction)).abs().to_f64()
}

/// The largest distance on any axis between a point's box and `found`, relative to a light.
fn wrong_by(found: DVec3, point: HitPoint, light: DVec3) -> f64 {
    let corners = [point.position - point.error, point.position + point.error];
    let wrong = corners.map(|corner| {
        let of_axes = difference(difference(precise(corner), precise(light)), precise(found)).map(Precise::abs);
        of_axes.into_iter().fold(0.0, |most: f64, wrong| most.max(wrong.to_f64()))
    });
    wrong[0].max(wrong[1])
}

#[test]
fn points_are_no_more_wrong_than_is_said() {
    let levels = SimdLevel::available();
    let of_trial = |seed: u32| EdgeOnView::new(Random::new(seed.into())).run(levels[seed as usize % levels.len()]);
    let trials: Vec<_> = (0..TRIALS).into_par_iter().map(of_trial).collect();
    let count: u32 = trials.iter().map(|(_, count)| count).sum();
    assert!(count > TRIALS, "{count}");
    let worst = trials.into_iter().fold([0.0; 2], |most, (one, _)| [0, 1].map(|at| f64::max(most[at], one[at])));
    // The bounds aren't much larger than the errors.
    assert!(worst.iter().all(|worst| (0.15..=1.0).contains(worst)), "{worst:?} of what may be");
}

#[test]
fn listed_points_are_no_more_wrong_than_is_said() {
    let levels = SimdLevel::available();
    let of_trial = |seed: u32| {
        let random = &mut Random::new(seed.into());
        let mut anywhere = |least, most| DVec3::from([0; 3].map(|_| random.signed() * random.power(least, most)));
        let light = anywhere(-20.0, 10.0).as_vec3().as_dvec3();
        let points: [HitPoint; 8] = std::array::from_fn(|_| {
            let position = anywhere(-10.0, 10.0);
            // The error is at most the size of a coordinate, as a rounding is.
            HitPoint { position, error: anywhere(-30.0, -3.0).x.abs() * position.max_element().abs() }
        });
        let (offset, error, of_predicate, certain) = dispatch!(levels[seed as usize % levels.len()], simd => {
            let found = EightPoints::new(simd, points, light);
            let [x, y, z] = found.offset;
            let offset = [x.to_array(), y.to_array(), z.to_array()];
            (offset, found.error.to_array(), found.predicate_error.to_array(), found.certain.to_bitmask())
        });
        assert!(certain == 0xff && of_predicate == points.map(|point| point.error));
        let wrong =
            |lane: usize| wrong_by(DVec3::from(offset.map(|axis| axis[lane])), points[lane], light) / error[lane];
        (0..8).map(wrong).fold(0.0, f64::max)
    };
    let worst = (0..TRIALS).into_par_iter().map(of_trial).reduce(|| 0.0, f64::max);
    // Up to a rounding of the error itself.
    assert!((0.5..=1.0 + 1e-15).contains(&worst), "{worst} of what may be");
}
