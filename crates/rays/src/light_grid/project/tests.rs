//! Projected patches compared with precise numbers: vertices and boxes at the face's borders, about in the light's plane,
//! and as far away as the farthest point.

use glam::Vec3;
use rayon::prelude::*;

use super::*;
use crate::Triangles;
use crate::light_grid::choose::tests::{Scene, anywhere, distance, homogeneous, mapped, position};
use crate::light_grid::face::VertexErrors;
use crate::precise::Precise;
use crate::random::Random;
use crate::simd::vectors::vectors;

/// The largest error of coordinates in f64.
const WIDE_ERROR: f64 = HALF_ULP / 8.0;

/// A face, and positions to aim at.
struct Aim {
    random: Random,
    scene: Scene,
    face: Face,
    farthest: f64,
    /// Distance of vertices, in relation to the farthest point's.
    share: f64,
    level: SimdLevel,
}

impl Aim {
    fn new(seed: u32) -> Option<Self> {
        let levels = SimdLevel::available();
        let level = levels[seed as usize % levels.len()];
        let mut random = Random::new(seed.into());
        // Some scenes are so small that numbers underflow.
        let powers = if random.unit() < 0.1 { -45..=-39 } else { -8..=8 };
        let scene = Scene::new(&mut random, powers)?;
        let face = scene.face(&mut random);
        let farthest = face.farthest(&scene.tiles);
        let share = if random.unit() < 0.7 { 1.0 } else { random.power(-12.0, 0.0) };
        Some(Self { random, scene, face, farthest, share, level })
    }

    /// A position at X and Y, about as far from the light as some share of the farthest point.
    fn at(&self, x: f64, y: f64, share: f64) -> DVec3 {
        // Depths of a scene that is flat across parallel light are about zero.
        let depth = if self.face.is_parallel { self.farthest.max(1.0) } else { self.farthest } * share;
        let at = if self.face.is_parallel { DVec3::new(x, y, -depth) } else { DVec3::new(x, y, 1.0) * depth };
        position(&self.face, at)
    }

    /// A small number of either sign.
    fn little(&mut self) -> f64 {
        self.random.power(-17.0, -1.0).copysign(self.random.signed())
    }

    /// A position about on a side of the face's region: the four of X and Y, the light's plane and the farthest point's.
    fn on_side(&mut self, side: usize, limit: f64) -> DVec3 {
        let (little, is_beyond) = (self.little(), limit > FACE_LIMIT);
        let little = if is_beyond { little.abs() } else { little };
        let share = self.share * self.random.unit();
        let far = if is_beyond || self.random.unit() < 0.5 { 1.0 } else { self.random.power(0.0, 12.0) };
        let (beside, other) = (self.random.signed() * far, self.random.signed() * limit);
        let at = (limit * (1.0 + little)).copysign(0.5 - (side % 2) as f64);
        match side {
            0 | 1 => self.at(at, beside, share),
            2 | 3 => self.at(beside, at, share),
            4 if !self.face.is_parallel => {
                // X and Y in relation to the farthest depth.
                let [x, y] = [0; 2].map(|_| self.random.signed() * self.farthest);
                position(&self.face, DVec3::new(x, y, -self.farthest * little))
            }
            _ => self.at(beside, other, 1.0 + little),
        }
    }

    /// On the face, and for f32 as nearly at a nearness of zero as can be found.
    fn level(&mut self) -> DVec3 {
        let face = self.face;
        let tries = (0..256).map(|_| {
            let [x, y, share] = [1.9, 1.9, 1e-3].map(|most| self.random.signed() * most);
            self.at(x, y, share).as_vec3().as_dvec3()
        });
        let nearness = |&at: &DVec3| face.homogeneous(at).z.abs();
        tries.min_by(|a, b| nearness(a).total_cmp(&nearness(b))).expect("a try")
    }

    /// A position on the face or around it, as far from the light or as near as numbers go.
    fn anywhere(&mut self) -> DVec3 {
        let [x, y] = [0; 2].map(|_| self.random.signed() * 2.2);
        let [least, most] = [[-42.0, 42.0], [0.0, 12.0], [-2.0, 0.3], [-2.0, 0.3]][(self.random.unit() * 4.0) as usize];
        let share = self.random.power(least, most);
        self.at(x, y, share)
    }
}

/// The heights of a position over the sides of the face's region: below zero outside.
fn heights(face: &Face, farthest: f64, position: DVec3) -> [Precise; 6] {
    let [x, y, z] = homogeneous(face, position);
    let one = if face.is_parallel { 1.0.into() } else { z };
    let limit = one * FACE_LIMIT.into();
    [limit - x, limit + x, limit - y, limit + y, one, Precise::from(farthest) - distance(face, position)]
}

/// The largest errors of the found X, Y and W of a position: W in relation to its size, and X and Y to theirs up to a
/// `largest`; a size below one counts as one, except for W in perspective.
fn wrong(face: &Face, position: DVec3, found: [f64; 3], largest: f64) -> f64 {
    let of = |found: f64, at: Precise, [least, most]: [f64; 2]| {
        (at - found.into()).to_f64().abs() / at.to_f64().abs().clamp(least, most)
    };
    let [x, y, w] = mapped(face, position);
    let least = if face.is_parallel { 1.0 } else { 0.0 };
    let errors = [of(found[0], x, [1.0, largest]), of(found[1], y, [1.0, largest]), of(found[2], w, [least, f64::MAX])];
    // NaN is wrong.
    errors.into_iter().fold(0.0, |most, error| if error <= most { most } else { error })
}

#[test]
fn vertices_are_no_more_wrong_than_is_said_and_outside_where_that_is_said() {
    let of_trial = |seed: u32| {
        let Some(mut aim) = Aim::new(seed) else { return [0; 2] };
        let positions: [DVec3; 8] = std::array::from_fn(|lane| match lane {
            0..6 => aim.on_side(lane, FACE_LIMIT),
            _ => aim.anywhere(),
        });
        let face = &aim.face;
        let axes = [0, 1, 2].map(|axis| positions.map(|position| position[axis]));
        let (at, codes) = dispatch!(aim.level, simd => {
            let (at, codes) = project_eight(simd, face, vectors(simd, axes));
            ([at[0].to_array(), at[1].to_array(), at[2].to_array()], codes)
        });
        let mut counts = [0; 2];
        for (lane, &position) in positions.iter().enumerate() {
            for (side, height) in heights(face, aim.farthest, position).into_iter().enumerate().take(5) {
                let is_outside = codes[side] >> lane & 1 == 1;
                assert!(!is_outside || height < 0.0.into(), "{position} isn't outside of side {side} of {face:?}");
                counts[0] += u32::from(is_outside);
            }
            let found = [at[0][lane], at[1][lane], at[2][lane]];
            if !found[0].is_nan() {
                let rounded = found.map(|at| f64::from(at as f32));
                let (wide, narrow) = [found, rounded].map(|found| wrong(face, position, found, f64::MAX)).into();
                let about = || format!("{position} at {found:?}, by {wide}, {narrow}, on {face:?}");
                assert!(wide <= WIDE_ERROR && narrow <= VertexErrors::MOVED, "{}", about());
                counts[1] += 1;
            }
        }
        counts
    };
    let counts = (0..10_000_u32).into_par_iter().map(of_trial).reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    assert!(counts.iter().all(|&count| count > 10_000), "outside, usable: {counts:?}");
}

#[test]
fn boxes_that_are_outside_are_beyond_a_side() {
    let of_trial = |seed: u32| {
        let Some(mut aim) = Aim::new(seed) else { return 0 };
        let mut boxes = WorldBoxes::EMPTY;
        for lane in 0..LANES {
            let corner = aim.on_side(lane % 6, FACE_LIMIT).as_vec3();
            let size = aim.scene.size * aim.random.power(-6.0, 0.0) * aim.random.unit().round();
            let other = corner + (anywhere(&mut aim.random) * size).as_vec3();
            boxes.set(lane, [corner.min(other).to_array(), corner.max(other).to_array()]);
        }
        let (face, farthest) = (&aim.face, aim.farthest);
        let sides = Sides::new(face, farthest);
        let outside = dispatch!(aim.level, simd => sides.outside(simd, &boxes, face.origin));
        for lane in crate::simd::lanes::bits_of(outside) {
            let ends = boxes.get(lane).map(Vec3::from);
            let corner = |number: usize| Vec3::from([0, 1, 2].map(|axis| ends[number >> axis & 1][axis])).as_dvec3();
            let of_corners = (0..8).map(|number| heights(face, farthest, corner(number)));
            let beyond = of_corners
                .fold([true; 6], |all, heights| std::array::from_fn(|side| all[side] && heights[side] < 0.0.into()));
            assert!(beyond.contains(&true), "{ends:?} is inside of {face:?} up to {farthest}");
        }
        outside.count_ones()
    };
    let count: u32 = (0..6000_u32).into_par_iter().map(of_trial).sum();
    assert!(count > 10_000, "{count}");
}

/// Triangles of one patch or two.
const TRIANGLES: usize = 16;

/// Vertices that are all about on the same side of the face's region, with one that may be inside; or all on the face or
/// near it.
fn vertices(aim: &mut Aim) -> Vec<Vec3> {
    const INSIDE: f64 = 1.0 + 1.2 / 1024.0;
    let side = (aim.random.unit() * 12.0) as usize;
    let (is_one_inside, is_far) = (aim.random.unit() < 0.5, aim.random.unit() < 0.1);
    let is_level = aim.face.is_parallel && aim.random.unit() < 0.7;
    let is_wide = aim.random.unit() < 0.5;
    let twice = if aim.random.unit() < 0.5 { 2.0 * (1.0 + aim.little()) } else { 1.5 };
    let mut vertex = |number: usize| match side {
        0..6 if number == 0 && is_one_inside => aim.on_side(side, INSIDE),
        0..6 => aim.on_side(side, FACE_LIMIT * 1.2),
        _ if number == 0 && is_far => aim.anywhere(),
        _ if number == 0 && is_level => aim.level(),
        _ => {
            // Depths as different as they may be.
            let share = [1.0, twice, 1.0 + 0.5 * aim.random.unit()][number.min(2)];
            let mut at = [0; 2].map(|_| aim.random.signed() * 1.9);
            if number == 0 && is_wide {
                // About where rounding starts to move vertices farther aside by more.
                at[0] = (2.0 + 4.0 * HALF_ULP * aim.random.signed()).copysign(at[0]);
            }
            let [x, y] = at;
            aim.at(x, y, share)
        }
    };
    let mut vertices: Vec<_> = (0..3 * TRIANGLES).map(|number| vertex(number).as_vec3()).collect();
    if aim.random.unit() < 0.05 {
        vertices[3 * TRIANGLES / 2].y = [f32::NAN, f32::INFINITY][(aim.random.unit() * 2.0) as usize];
    }
    vertices
}

#[test]
fn patches_that_may_shadow_are_kept_and_in_their_boxes() {
    let of_trial = |seed: u32| {
        let Some(mut aim) = Aim::new(seed) else { return [0; 3] };
        let positions = vertices(&mut aim);
        let indices = std::array::from_fn::<_, TRIANGLES, _>(|id| [0, 1, 2].map(|corner| 3 * id as u32 + corner));
        let level = aim.level;
        let mut patches = Patches::default();
        patches.update(Triangles { positions: &positions, indices: &indices }, level);
        let (mut found, mut of_large) = (vec![[0.0; 4]; patches.vertex_count()], Vec::new());
        let mut sixteens = vec![SixteenBoxes::NOTHING; patches.len().div_ceil(LANES)];
        let (face, patches) = (&aim.face, &patches);
        let sides = Sides::new(face, aim.farthest);
        Projector { face, sides, patches, of_large: Mutex::new(&mut of_large), level }.project(
            0,
            &mut found,
            &mut sixteens,
        );
        let mut counts = [0; 3];
        for number in 0..patches.len() {
            let world = patches.get(number).vertices.iter().map(|&vertex| positions[vertex as usize].as_dvec3());
            let world: Vec<_> = world.collect();
            let around = sixteens[number / LANES].get(number % LANES);
            let is_large = of_large.contains(&(number as u32));
            let what = if is_large { 2 } else { usize::from(around.x[0] == f32::INFINITY) };
            match what {
                0 => check_inside(face, &world, &found[patches.vertex_range(number)], around),
                1 => {
                    let may_shadow =
                        world.iter().find(|&&vertex| vertex.is_finite() && aim.scene.may_shadow(face, vertex));
                    assert!(may_shadow.is_none(), "{may_shadow:?} of {face:?} up to {}", aim.farthest);
                }
                _ => {}
            }
            counts[what] += 1;
        }
        counts
    };
    let counts: Vec<_> = (0..3000_u32).into_par_iter().map(of_trial).collect();
    let counts = counts.into_iter().fold([0; 3], |sum, one| std::array::from_fn(|what| sum[what] + one[what]));
    assert!(counts.iter().all(|&count| count > 200), "inside, outside, large: {counts:?}");
}

/// Checks the projected vertices of a patch.
fn check_inside(face: &Face, world: &[DVec3], found: &[[f32; 4]], around: FaceBox) {
    let about = || format!("{world:?} in {around:?} of {face:?}");
    let mut depths = [f64::INFINITY, 0.0];
    for (&vertex, &[x, y, w, _]) in world.iter().zip(found) {
        assert!(wrong(face, vertex, [x, y, w].map(f64::from), 1.0) <= VertexErrors::MOVED, "{vertex}: {}", about());
        // The assumptions of the filter's errors.
        assert!(x.abs().max(y.abs()) < 2.0, "{vertex}: {}", about());
        assert!(face.is_parallel || (2.0_f32.powi(-60)..2.0_f32.powi(40)).contains(&w), "{vertex}: {}", about());
        let holds = |[low, high]: [f32; 2], at: Precise| at >= f64::from(low).into() && at <= f64::from(high).into();
        let [true_x, true_y, true_w] = mapped(face, vertex);
        let is_held = holds(around.x, true_x) && holds(around.y, true_y) && true_w <= f64::from(around.nearness).into();
        assert!(is_held, "{vertex}: {}", about());
        let depth = distance(face, vertex).to_f64();
        depths = [depths[0].min(depth), depths[1].max(depth)];
    }
    assert!(face.is_parallel || depths[1] <= 2.0 * depths[0], "{}", about());
}
