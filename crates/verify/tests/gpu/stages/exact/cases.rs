//! Rays, triangles and lights that are hard to decide.

use glam::{DVec3, Vec3};
use umbrage_rays::Ray;
use umbrage_rays::predicate::crossing;

use super::Random;

/// A ray and a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    pub(crate) ray: Ray,
    pub(crate) corners: [Vec3; 3],
}

/// Number of kinds of pairs.
pub(crate) const KINDS: u64 = 17;

impl Pair {
    /// A random pair of the kind of `index`; two of three are at a scale from 2⁻⁶⁰ to 2⁶⁰.
    pub(crate) fn random(random: &mut Random, index: u64) -> Self {
        let mut pair = Self::of_kind(random, index % KINDS);
        if !(index / KINDS).is_multiple_of(3) {
            let scale = 2.0_f32.powi(random.below(121) as i32 - 60);
            pair.corners = pair.corners.map(|corner| corner * scale);
            pair.ray.origin *= f64::from(scale);
            pair.ray.direction *= 2.0_f64.powi(random.below(121) as i32 - 60);
        }
        if random.below(16) == 0 {
            // So short that error bounds with it underflow.
            pair.ray.direction *= 2.0_f64.powi(-700);
        }
        if random.below(4) == 0 {
            pair.corners.rotate_left(1);
        }
        if random.below(4) == 0 {
            pair.corners.swap(0, 2);
        }
        pair
    }

    pub(crate) fn of_kind(random: &mut Random, kind: u64) -> Self {
        let corners = [(); 3].map(|()| random.point());
        let whole = [(); 3].map(|()| random.whole_point(8));
        let [a, b, c] = whole.map(Vec3::as_dvec3);
        let origin = random.point().as_dvec3() * 4.0;
        let whole_origin = random.whole_point(8).as_dvec3();
        let ray = |origin: DVec3, target: DVec3| Ray::new(origin, target - origin);
        let (v, w) = (random.unit() * 0.5, random.unit() * 0.5);
        let inside = |corners: [Vec3; 3]| {
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            a * (1.0 - v - w) + b * v + c * w
        };
        match kind {
            0 => Self { ray: ray(origin, random.point().as_dvec3()), corners },
            1 | 2 => Self { ray: ray(origin, inside(corners)), corners },
            // Exactly through a corner, and through an edge.
            3 => Self { ray: ray(whole_origin, a), corners: whole },
            4 => Self { ray: Ray::new(whole_origin, a + b - 2.0 * whole_origin), corners: whole },
            // Nearly through a corner or an edge.
            5 => Self { ray: ray(origin, corners[random.below(3) as usize].as_dvec3()), corners },
            6 => {
                let [a, b, _] = corners.map(Vec3::as_dvec3);
                Self { ray: ray(origin, a.lerp(b, random.unit())), corners }
            }
            // In the triangle's plane, from anywhere in it or along an edge.
            7 => {
                let [i, j, k, l] = [(); 4].map(|()| random.below(7) as f64 - 3.0);
                let origin = a + (b - a) * i + (c - a) * j;
                Self { ray: Ray::new(origin, (b - a) * k + (c - a) * l), corners: whole }
            }
            // From a point of the triangle.
            8 => {
                let (i, j) = (random.below(3) as f64, random.below(3) as f64);
                Self { ray: ray((a * (4.0 - i - j) + b * i + c * j) * 0.25, whole_origin), corners: whole }
            }
            9 => Self { ray: ray(inside(corners), origin), corners },
            // A sliver, and one without any area.
            10 => {
                let thin = a.lerp(b, random.unit()).as_vec3() + random.point() * 1e-6;
                let corners = [whole[0], whole[1], thin];
                Self { ray: ray(origin, inside(corners)), corners }
            }
            11 => {
                let corners = [whole[0], whole[1], whole[0] + (whole[1] - whole[0]) * random.below(3) as f32];
                Self { ray: ray(whole_origin, a), corners }
            }
            // Far from the origin, where f32 is coarse.
            12 => {
                let far = random.whole_point(1 << 20);
                let corners = corners.map(|corner| corner + far);
                Self { ray: ray(origin + far.as_dvec3(), inside(corners)), corners }
            }
            // Exactly in the plane, for corners whose products have more bits than double-double numbers.
            13 => {
                let uneven = |point: Vec3, random: &mut Random| {
                    Vec3::from_array(point.to_array().map(|number| number * 2.0_f32.powi(random.below(25) as i32 - 12)))
                };
                let corners = corners.map(|corner| uneven(corner, random));
                let [a, b, c] = corners.map(Vec3::as_dvec3);
                let along = if random.below(2) == 0 { b - a } else { c - b };
                Self { ray: Ray::new(b + c - a, along), corners }
            }
            // With common coordinates, so that the next ones order the corners.
            14 | 15 => {
                let zeros = [0.0, -0.0];
                let mut corners = corners.map(|corner| corner.with_x(zeros[random.below(2) as usize]));
                if kind == 15 {
                    corners[1].y = corners[0].y;
                }
                Self { ray: ray(origin, inside(corners)), corners }
            }
            // Coordinates of any size, or NaN.
            _ => {
                let corners = [(); 3].map(|()| Vec3::from_array([(); 3].map(|()| random.any_f32())));
                Self { ray: ray(origin, inside(corners).clamp(DVec3::splat(-1e40), DVec3::splat(1e40))), corners }
            }
        }
    }
}

/// A point on a ray, a light, and a triangle that may be between them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shadowing {
    pub(crate) ray: Ray,
    pub(crate) t: f64,
    pub(crate) is_directional: bool,
    /// Its position, or the direction of its light.
    pub(crate) light: Vec3,
    pub(crate) corners: [Vec3; 3],
}

impl Shadowing {
    /// A random case of the kind of `index`.
    pub(crate) fn random(random: &mut Random, index: u64) -> Self {
        let Pair { ray, corners } = Pair::random(random, index);
        let t = crossing(&ray, corners).map_or(1.0, |crossing| crossing.t);
        // Half of the points aren't on the triangle but well in front of or behind it.
        let t = match random.below(4) {
            0 | 1 => t * (random.unit() * 2.0),
            // Off by about a rounding error.
            2 => t * (1.0 + (random.below(65) as f64 - 32.0) * f64::EPSILON),
            _ => t,
        };
        let point = (ray.origin + ray.direction * t).as_vec3();
        let [a, b, c] = corners;
        let is_directional = random.below(2) == 0;
        let (v, w) = (random.unit() as f32 * 0.5, random.unit() as f32 * 0.5);
        let beyond = |at: Vec3| at * 2.0 - point;
        let light = match random.below(8) {
            0 => random.point() * (b - a).abs().max_element(),
            // On the triangle, in its plane, and at the point.
            1 => a,
            2 => b + (c - a) * random.below(3) as f32,
            3 => point,
            // So that a corner, an edge or a point inside is midway between light and point.
            4 => beyond(a),
            5 => a + b - point,
            _ => beyond(a * (1.0 - v - w) + b * v + c * w),
        };
        let light = if is_directional { (point - light).normalize_or(Vec3::X) } else { light };
        Self { ray, t, is_directional, light, corners }
    }
}

impl Random {
    /// From 0 to below 1.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * 2.0_f64.powi(-53)
    }

    /// In the cube from −1 to 1.
    pub(crate) fn point(&mut self) -> Vec3 {
        Vec3::from_array([(); 3].map(|()| (self.unit() * 2.0 - 1.0) as f32))
    }

    /// Integers of magnitude below `end`, of both signs.
    pub(crate) fn whole_point(&mut self, end: u64) -> Vec3 {
        Vec3::from_array([(); 3].map(|()| (self.below(2 * end - 1) as f32) - (end - 1) as f32))
    }

    /// Any bits once in 32 times, else zero or a number between 2⁻⁴⁰ and 2⁴⁰ in magnitude.
    pub(crate) fn any_f32(&mut self) -> f32 {
        let bits = self.bits() as u32;
        match self.below(32) {
            0 => f32::from_bits(bits),
            1 => f32::from_bits(bits & 0x8000_0000),
            2 => f32::from_bits(bits & 0x807f_ffff),
            _ => f32::from_bits((bits & 0x807f_ffff) | ((87 + self.below(81) as u32) << 23)),
        }
    }
}
