use glam::swizzles::Vec4Swizzles;
use glam::{DVec3, Vec3, Vec4};

/// A filter for one ray that rules out, in f32, triangles that its line certainly misses.
///
/// Along the ray the scene falls into a plane, in which the ray is the origin: with k the axis of the direction's largest
/// component and i another one, xᵢ = (pᵢ − oᵢ) − r (pₖ − oₖ) for a point p, where r = dᵢ / dₖ. The edge functions of the
/// predicate are, up to a common factor, x₁ y₂ − x₂ y₁ in that plane. A triangle is left out if two of them have certain and
/// different signs.
///
/// **Error bounds.** Let ε = 2⁻²⁴, P the largest coordinate of corners and O that of the origin. Of xᵢ = (pᵢ − r pₖ) − c,
/// where c = oᵢ − r oₖ comes from f64, the roundings of r and of its product are each at most ε P, that of the first
/// difference 2 ε P, that of c 2 ε O and that of the last difference 2 ε (P + O): together less than e = 8 ε (P + O). An
/// edge function of (x₁, y₁) and (x₂, y₂) is then wrong by at most e (m₁ + m₂), where m = |x| + |y| + e, and by 2 ε m₁ m₂ of
/// its own roundings. The bound is twice both, which covers its own roundings; underflow loses less than `SMALLEST`.
///
/// P is first that of the scene, the same for all triangles. If that doesn't rule a triangle out, P is the triangle's own:
/// in a scene with one far vertex, the scene's would rule out none.
pub(crate) struct Filter {
    /// The two axes of the plane, and the axis projected away.
    axes: [usize; 3],
    /// Movement in the plane per unit along the axis projected away.
    slopes: [Vec4; 2],
    /// The ray's origin in the plane.
    origin: [Vec4; 2],
    /// e above, doubled.
    error: Vec4,
    /// The largest magnitude of the origin's coordinates.
    origin_reach: f32,
}

/// The corners of a triangle along an axis.
type Coordinates = Vec4;

impl Filter {
    /// Factor for the roundings of products: 2 ε, doubled.
    const ROUNDINGS: f32 = 4.0 / (1 << 24) as f32;
    /// 16 ε.
    const ERROR: f64 = 16.0 / (1 << 24) as f64;
    /// The same, plus more than the roundings of its own products and sums in f32.
    const OWN_ERROR: f32 = 17.0 / (1 << 24) as f32;
    const SMALLEST: f32 = 1e-36;

    /// A filter for triangles with coordinates of magnitude up to `reach`.
    #[inline(always)]
    pub(crate) fn new(origin: DVec3, direction: DVec3, reach: f32) -> Self {
        let [x, y, z] = direction.abs().to_array();
        let largest = if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        };
        let axes = [(largest + 1) % 3, (largest + 2) % 3, largest];
        let inverse = direction[largest].recip();
        let slopes = [direction[axes[0]] * inverse, direction[axes[1]] * inverse];
        let start = |at: usize| origin[axes[at]] - slopes[at] * origin[largest];
        let origin_reach = origin.abs().max_element();
        let error = (origin_reach + f64::from(reach)) * Self::ERROR;
        Self {
            axes,
            slopes: [Vec4::splat(slopes[0] as f32), Vec4::splat(slopes[1] as f32)],
            origin: [Vec4::splat(start(0) as f32), Vec4::splat(start(1) as f32)],
            error: Vec4::splat(error as f32),
            origin_reach: origin_reach as f32,
        }
    }

    /// Whether the ray's line certainly misses a triangle.
    #[inline(always)]
    pub(crate) fn misses(&self, corners: [Vec3; 3]) -> bool {
        let reach = || corners[0].abs().max(corners[1].abs()).max(corners[2].abs()).max_element();
        self.misses_by(self.error, corners)
            || self.misses_by(Vec4::splat((self.origin_reach + reach()) * Self::OWN_ERROR), corners)
    }

    #[inline(always)]
    fn misses_by(&self, error: Vec4, [a, b, c]: [Vec3; 3]) -> bool {
        let along = |axis: usize| -> Coordinates {
            let [a, b, c] = [a.to_array()[axis], b.to_array()[axis], c.to_array()[axis]];
            Vec4::new(a, b, c, c)
        };
        let [i, j, k] = self.axes;
        let depth = along(k);
        let x = (along(i) - self.slopes[0] * depth) - self.origin[0];
        let y = (along(j) - self.slopes[1] * depth) - self.origin[1];
        let size = x.abs() + y.abs() + error;
        let (next_x, next_y, next_size) = (x.yzxw(), y.yzxw(), size.yzxw());
        let edges = x * next_y - next_x * y;
        let bound = error * (size + next_size)
            + (size * next_size) * Vec4::splat(Self::ROUNDINGS)
            + Vec4::splat(Self::SMALLEST);
        // The fourth lane is no edge.
        const EDGES: u32 = 0b111;
        (edges.cmplt(-bound).bitmask() & EDGES) != 0 && (edges.cmpgt(bound).bitmask() & EDGES) != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ray;
    use crate::predicate::crossing;

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
            let reach = corners.map(|corner| corner.abs().max_element()).into_iter().fold(0.0, f32::max);
            let is_left_out = Filter::new(ray.origin, ray.direction, reach).misses(corners);
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
    fn what_one_triangle_reaches_does_others_no_harm() {
        let mut numbers = Numbers(8);
        let mut kept = [0; 2];
        for _ in 0..10_000 {
            let corners = [0; 3].map(|_| numbers.point().as_vec3());
            let ray = Ray::new(numbers.point() * 3.0, numbers.point());
            for (kept, reach) in kept.iter_mut().zip([1.0, 1e30]) {
                let is_kept = !Filter::new(ray.origin, ray.direction, reach).misses(corners);
                assert!(is_kept || crossing(&ray, corners).is_none());
                *kept += usize::from(is_kept);
            }
        }
        assert!(kept[0] > 100 && kept[1] == kept[0], "{kept:?}");
    }

    #[test]
    fn what_is_not_a_number_is_left_to_the_predicate() {
        let corners = [Vec3::X, Vec3::Y, Vec3::Z];
        for bad in [f32::NAN, f32::INFINITY, f32::MAX] {
            let [a, b, _] = corners;
            let filter = Filter::new(DVec3::ZERO, DVec3::ONE, 1.0);
            assert!(!filter.misses([a, b, Vec3::splat(bad)]), "{bad}");
        }
        let beyond = Filter::new(DVec3::splat(1e300), DVec3::X, 1.0);
        assert!(!beyond.misses(corners));
    }
}
