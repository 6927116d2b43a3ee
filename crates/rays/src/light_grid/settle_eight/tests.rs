//! What f64 settles, beside the predicate: triangles whose edges, corners and planes are where shadow rays are, as exactly as
//! f32 can say.

use fearless_simd::dispatch;
use glam::Vec3;
use rayon::prelude::*;

use super::*;
use crate::SimdLevel;
use crate::light_grid::point_set::PointList;
use crate::predicate::{HitPoint, ShadowRay};
use crate::random::Random;
use crate::shot::SeenPixels;

const TRIALS: u32 = 60_000;

/// A point, a light and a triangle between them.
struct Pair {
    point: HitPoint,
    corners: [Vec3; 3],
}

/// A light and how large all is.
struct Trial {
    random: Random,
    light: LightSource,
    /// Of a triangle, in relation to how far the light is.
    size: f64,
    /// How far points and lights are from zero.
    out: f64,
    scale: f64,
    /// Vectors with a determinant of hardly more than the last bits of its terms; light is at zero then, or goes along the last.
    dependent: Option<[DVec3; 3]>,
}

impl Trial {
    fn new(mut random: Random) -> Self {
        let out = if random.unit() < 0.5 { 0.0 } else { random.power(-2.0, 4.0) };
        // Sizes whose products are among the least and largest of f64 are rare.
        let scale = if random.unit() < 0.9 { random.power(-3.0, 3.0) } else { random.power(-37.0, 30.0) };
        let mut at = |size: f64| DVec3::from([0; 3].map(|_| random.signed() * size)).as_vec3();
        let light = at(scale * (1.0 + out));
        let light = if random.unit() < 0.5 {
            LightSource::Point { position: light }
        } else {
            LightSource::Directional { direction: light }
        };
        let size = random.power(-6.0, 1.0);
        let mut trial = Self { random, light, size, out, scale, dependent: None };
        if trial.random.unit() < 0.3 {
            let [u, v, w] = trial.nearly_dependent();
            trial.dependent = Some([u, v, w]);
            trial.light = match light {
                LightSource::Directional { .. } => LightSource::Directional { direction: w.as_vec3() },
                _ => LightSource::Point { position: Vec3::ZERO },
            };
        }
        trial
    }

    fn vector(&mut self, size: f64) -> DVec3 {
        DVec3::from([0; 3].map(|_| self.random.signed() * size))
    }

    fn pair(&mut self) -> Pair {
        match self.dependent {
            Some(vectors) => self.nearly_dependent_pair(vectors),
            None if self.random.unit() < 0.7 => self.aimed_pair(),
            None => self.any_pair(),
        }
    }

    /// Where rays come from, and a point on one.
    fn ray(&mut self) -> [DVec3; 2] {
        match self.light {
            LightSource::Point { position } | LightSource::Spot { position, .. } => {
                let from = position.as_dvec3();
                [from, from + self.vector(self.scale)]
            }
            LightSource::Directional { direction } => {
                let from = self.vector(self.scale * (1.0 + self.out));
                [from, from + direction.as_dvec3().normalize_or_zero() * (self.scale * self.random.unit())]
            }
        }
    }

    /// As wrong as points are, or much more.
    fn error(&mut self, point: DVec3) -> f64 {
        let rounding = ROUNDING * (point.abs().max_element() + self.scale);
        if self.random.unit() < 0.5 { 0.0 } else { rounding * self.random.power(0.0, 8.0) }
    }

    /// A triangle of any kind near a ray, or before or behind a point.
    fn any_pair(&mut self) -> Pair {
        let [from, point] = self.ray();
        let way = point - from;
        let size = way.length() * self.size;
        let at = |part: f64| from + way * part;
        let near = self.random.power(-8.0, 0.0);
        let part = if self.random.unit() < 0.5 { self.random.unit() } else { 1.0 - near };
        let [u, v, w] = [(); 3].map(|()| self.vector(size));
        let [s, t] = [self.random.unit(), self.random.unit()];
        let corners = match (self.random.unit() * 5.0) as u32 {
            0 => [at(part), at(part) + u, at(part) + v],
            1 => [at(part) + u * s, at(part) - u * t, at(part) + u * (s - t) * 0.5 + w * near],
            2 => [point + u, point + v, point - (u + v) * (0.3 + s)],
            3 => [at(part) + u * s, at(part) - u * t, at(-s) + v],
            _ => [at(part) + u, at(part) + v, at(part) + w],
        };
        Pair { point: HitPoint { position: point, error: self.error(point) }, corners: corners.map(DVec3::as_vec3) }
    }

    /// A point whose ray passes by an edge of a triangle, or that is in its plane, but for about what f64 loses.
    fn aimed_pair(&mut self) -> Pair {
        let [from, middle] = self.ray();
        let size = (middle - from).length() * self.size;
        let corners = [(); 3].map(|()| (middle + self.vector(size)).as_vec3());
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let [s, t] = [self.random.unit(), self.random.unit() * if self.random.unit() < 0.5 { 1.0 } else { 0.0 }];
        let met = a + (b - a) * s + (c - a) * (t * (1.0 - s));
        // Behind an edge by any length, else in the plane.
        let behind = if t == 0.0 { self.random.power(-6.0, 1.0) } else { 0.0 };
        let point = match self.light {
            LightSource::Directional { direction } => {
                met + direction.as_dvec3().normalize_or_zero() * (behind * self.scale)
            }
            _ => met + (met - from) * behind,
        };
        let error = self.error(point);
        let little = ROUNDING * (point.abs().max_element() + self.scale) * self.random.power(-1.0, 4.0);
        let little = if error > 0.0 && self.random.unit() < 0.5 { error * 3.0 } else { little };
        Pair { point: HitPoint { position: point + self.vector(little), error }, corners }
    }

    /// Three vectors of whole numbers of about a million with a determinant of one, or little more.
    fn nearly_dependent(&mut self) -> [DVec3; 3] {
        let mut number = |most: f64| (self.random.signed() * most).round();
        let largest = 1_000_000.0;
        let (p, q) = (number(largest), number(largest));
        // Euclid's algorithm: p x + q y is their greatest common divisor.
        let (mut rest, mut x, mut y) = ([p, q], [1.0, 0.0], [0.0, 1.0]);
        while rest[1] != 0.0 {
            let quotient = (rest[0] / rest[1]).trunc();
            for pair in [&mut rest, &mut x, &mut y] {
                *pair = [pair[1], pair[0] - quotient * pair[1]];
            }
        }
        let (u, v) = (DVec3::new(p, q, number(largest)), DVec3::new(-y[0], x[0], number(largest)));
        let w = u * number(1.5) + v * number(1.5) + DVec3::Z;
        [u, v, w]
    }

    /// A triangle with an edge in a plane with a ray, or with its plane through the light or through the point, but for the last
    /// bits of determinants.
    fn nearly_dependent_pair(&mut self, [u, v, w]: [DVec3; 3]) -> Pair {
        let is_directional = matches!(self.light, LightSource::Directional { .. });
        let third = self.vector(1e6).round();
        let (point, corners) = match ((self.random.unit() * 3.0) as u32, is_directional) {
            (0, false) => (w, [u, v, third]),
            (0, true) => (DVec3::ZERO, [u, v, third]),
            (1, false) => ((u + v + w) * 2.0, [u, v, w]),
            _ => (third + u, [third + u - v, third + v, third + w]),
        };
        Pair { point: HitPoint { position: point, error: 0.0 }, corners: corners.map(DVec3::as_vec3) }
    }

    /// How many pairs are settled, and are not, and how wrong weights are at most of what they may be.
    fn run(&mut self, level: SimdLevel) -> ([u32; 2], f64) {
        let pairs: [Pair; 8] = std::array::from_fn(|_| self.pair());
        let mut list = PointList::default();
        list.fill(8, |number| Some((pairs[number].point, number as u32)));
        let numbers: Vec<_> = PointSet::Listed(&list).own().to_vec();
        let indices = std::array::from_fn(|lane| {
            let is_it = |&number: &u32| number != SeenPixels::NONE && number == lane as u32;
            numbers.iter().position(is_it).expect("a point") as u32
        });
        let positions: Vec<_> = pairs.iter().flat_map(|pair| pair.corners).collect();
        let triangles: Vec<_> = (0..8).map(|id| [3 * id, 3 * id + 1, 3 * id + 2]).collect();
        let triangles = Triangles { positions: &positions, indices: &triangles };
        let points = PointSet::Listed(&list);
        let ids = std::array::from_fn(|lane| lane as u32);
        let settled = dispatch!(level.0, simd => settle_eight(simd, triangles, &points, &self.light, indices, ids));
        let (mut counts, mut worst) = ([0; 2], 0.0_f64);
        for (lane, Pair { point, corners }) in pairs.iter().enumerate() {
            let weights = ShadowRay::new(&self.light, *point).blocked_by(*corners);
            let is_undecided = settled.undecided >> lane & 1 == 1;
            counts[usize::from(is_undecided)] += 1;
            let is_shadowed = settled.shadowed >> lane & 1 == 1;
            assert!(
                is_undecided || is_shadowed == weights.is_some(),
                "{weights:?} {is_shadowed}: {point:?} {corners:?} {:?}",
                self.light
            );
            if let Some(weights) = weights.filter(|_| is_shadowed) {
                for (weight, found) in weights.into_iter().zip(settled.barycentric) {
                    // The predicate rounds its weights to f32.
                    let wrong = (f64::from(weight) - found[lane]).abs() - f64::from(f32::EPSILON) / 4.0;
                    worst = worst.max(wrong / settled.weight_error[lane]);
                }
            }
        }
        (counts, worst)
    }
}

#[test]
fn what_is_settled_is_what_the_predicate_says() {
    let levels = SimdLevel::available();
    let of_seed = |seed: u32| Trial::new(Random::new(seed.into())).run(levels[seed as usize % levels.len()]);
    let all: Vec<_> = (0..TRIALS).into_par_iter().map(of_seed).collect();
    let counts = all.iter().fold([0; 2], |sum, (one, _)| [sum[0] + one[0], sum[1] + one[1]]);
    assert!(counts.iter().all(|&count| count > TRIALS / 2), "settled, left: {counts:?}");
    let worst = all.iter().fold(0.0, |most: f64, (_, worst)| most.max(*worst));
    assert!(worst <= 1.0, "weights are wrong by {worst} of what they may be");
}
