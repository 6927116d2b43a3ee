use glam::{DVec3, Vec3};

use umbrage_rays::shear::Sheared;

/// A filter for one ray that rules out, in f32, triangles that its line certainly misses: [`Sheared`] along the axis of the
/// direction's largest component, so that H is one.
pub(crate) struct Filter {
    /// The two axes across, and the axis of the direction's largest component.
    axes: [usize; 3],
    /// Movement along the two axes, negated, per unit along the third.
    slopes: [f32; 2],
    /// The ray's origin.
    origin: Vec3,
    /// The origin's largest coordinate if f32 can't hold the origin, else zero.
    blur: f32,
}

impl Filter {
    /// With errors up to this, coordinates are up to 10¹⁸: products don't overflow.
    const LARGEST_ERROR: f32 = 1e12;

    #[inline(always)]
    pub(crate) fn new(origin: DVec3, direction: DVec3) -> Self {
        let [x, y, z] = direction.abs().to_array();
        let largest = if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        };
        let axes = [(largest + 1) % 3, (largest + 2) % 3, largest];
        let slope = |at: usize| (-direction[axes[at]] / direction[largest]) as f32;
        let rounded = origin.as_vec3();
        let blur = if rounded.as_dvec3() == origin { 0.0 } else { rounded.abs().max_element() };
        Self { axes, slopes: [slope(0), slope(1)], origin: rounded, blur }
    }

    /// Whether the ray's line certainly misses a triangle.
    #[inline(always)]
    pub(crate) fn misses(&self, corners: [Vec3; 3]) -> bool {
        let [a, b, c] = corners.map(|corner| (corner - self.origin).to_array());
        let offsets = self.axes.map(|axis| [a[axis], b[axis], c[axis]]);
        let sheared = Sheared::new(offsets, self.slopes, 1.0, self.blur);
        sheared.is_missed() && sheared.error < Self::LARGEST_ERROR
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_rays::Ray;
    use umbrage_rays::predicate::crossing;

    /// Numbers from −1 to 1.
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }

        fn point(&mut self) -> DVec3 {
            DVec3::new(self.next(), self.next(), self.next())
        }
    }

    #[test]
    fn no_triangle_is_left_out_that_the_line_meets() {
        let mut numbers = Numbers(7);
        let (mut met, mut missed, mut left_out) = (0, 0, 0);
        for round in 0..200_000 {
            // Scenes and triangles of all sizes, and triangles far from the middle of their scene.
            let world = f64::exp2(30.0 * numbers.next());
            let middle = numbers.point() * world;
            let size = world * f64::exp2(-10.0 * numbers.next().abs());
            let corners = [0; 3].map(|_| (middle + numbers.point() * size).as_vec3());
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            // Targets: on an edge, at a corner, or near the triangle.
            let (u, v) = (numbers.next().abs(), numbers.next());
            let target = match round % 3 {
                0 => a.lerp(b, u),
                1 => c,
                _ => a + (b - a) * u + (c - a) * v,
            };
            let origin = numbers.point() * world;
            let ray = Ray::new(origin, (target - origin) * f64::exp2(20.0 * numbers.next()));
            let is_left_out = Filter::new(ray.origin, ray.direction).misses(corners);
            if crossing(&ray, corners).is_some() {
                met += 1;
                assert!(!is_left_out, "{ray:?} meets {corners:?}");
            } else {
                missed += 1;
                left_out += u32::from(is_left_out);
            }
        }
        assert!(met > 50_000 && missed > 50_000, "{met} met, {missed} missed");
        // Half of the misses are within rounding of an edge.
        assert!(left_out > missed / 3, "{left_out} left out of {missed}");
    }

    #[test]
    fn large_coordinates_leave_nothing_out_that_the_line_meets() {
        let mut numbers = Numbers(8);
        for round in 0..20_000 {
            // Products of coordinates about 2⁶⁴ are about the largest f32.
            let size = f64::exp2(64.0 + 2.0 * numbers.next());
            let corners = [0; 3].map(|_| (numbers.point() * size).as_vec3());
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            let (u, v) = (numbers.next().abs(), numbers.next().abs());
            let target = if round % 2 == 0 { a.lerp(b, u) } else { a + (b - a) * (u * v) + (c - a) * (v - u * v) };
            let origin = (numbers.point() * size).as_vec3().as_dvec3();
            let ray = Ray::new(origin, target - origin);
            let is_left_out = Filter::new(ray.origin, ray.direction).misses(corners);
            assert!(!is_left_out || crossing(&ray, corners).is_none(), "{ray:?} meets {corners:?}");
        }
    }

    #[test]
    fn what_is_not_a_number_is_left_to_the_predicate() {
        let corners = [Vec3::X, Vec3::Y, Vec3::Z].map(|corner| corner + Vec3::X * 5.0);
        let filter = Filter::new(DVec3::ZERO, DVec3::ONE);
        assert!(filter.misses(corners));
        for bad in [f32::NAN, f32::INFINITY, f32::MAX] {
            for (corner, axis) in (0..9).map(|at| (at / 3, at % 3)) {
                let mut corners = corners;
                corners[corner][axis] = bad;
                assert!(!filter.misses(corners), "{bad} for coordinate {axis} of corner {corner}");
            }
        }
        let beyond = Filter::new(DVec3::splat(1e300), DVec3::X);
        assert!(!beyond.misses(corners));
    }
}
