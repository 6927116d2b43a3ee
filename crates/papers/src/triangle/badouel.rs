//! Badouel, *An efficient ray–polygon intersection*, 1990, in Wald's form.

use glam::Vec3;

use super::lanes::{Axis, LaneMask, Lanes};
use super::{Bundle, BundleTest, Hits, Rays, TriangleTest};

/// Wald, *Realtime ray tracing and interactive global illumination*, 2004 (Rahikainen 2013, equations 2.6 and 2.7): the
/// hit on the plane, then two linear functions in a projection along an axis. 40 bytes.
///
/// t is first: a division, then three multiplications for each of plane, point and weights. The test of a triangle that
/// is behind or too far ends after t.
#[derive(Clone, Copy, Debug)]
pub struct Badouel {
    /// The plane: the normal's components along the two kept axes, scaled to a third component of one, and its distance.
    plane: [f32; 3],
    /// Weights of the second and third corner: factors of the two coordinates, and constants.
    weights: [[f32; 3]; 2],
    /// The axis of projection.
    axis: Axis,
}

impl Badouel {
    #[inline(always)]
    fn prepare([a, b, c]: [Vec3; 3]) -> Self {
        let (first, second) = (b - a, c - a);
        let normal = first.cross(second);
        let axis = Axis::largest(normal);
        let [p, q, r] = axis.order();
        let plane = [normal[p] / normal[r], normal[q] / normal[r]];
        let distance = a[r] + plane[0] * a[p] + plane[1] * a[q];
        // The weight of one end of an edge pair: zero along the other edge through the first corner.
        let weight = |edge: Vec3, side: f32| {
            let (along_p, along_q) = (side * edge[q] / normal[r], -side * edge[p] / normal[r]);
            [along_p, along_q, -(along_p * a[p] + along_q * a[q])]
        };
        Self { plane: [plane[0], plane[1], distance], weights: [weight(second, 1.0), weight(first, -1.0)], axis }
    }

    /// t of the rays on the plane.
    #[inline(always)]
    fn plane_of<L: Lanes>(&self, rays: &Rays<L>) -> L {
        let [p, q, r] = self.axis.order();
        let (origin, direction) = (&rays.origin, &rays.direction);
        let slope = direction[p] * self.plane[0] + direction[q] * self.plane[1] + direction[r];
        let height = -(origin[p] * self.plane[0] + origin[q] * self.plane[1] + origin[r] - self.plane[2]);
        height / slope
    }

    /// Whether points of the plane, given by two coordinates, are in the triangle, and their weights; `None` if no
    /// point is.
    #[inline(always)]
    fn weights<L: Lanes>(&self, mask: L::Mask, p: L, q: L) -> Option<(L::Mask, [L; 2])> {
        let [first, second] = self.weights;
        let v = p * first[0] + q * first[1] + first[2];
        let mask = mask & v.is_at_least_zero();
        if !mask.any() {
            return None;
        }
        let w = p * second[0] + q * second[1] + second[2];
        Some((mask & w.is_at_least_zero() & (v + w).is_at_most(v.splat(1.0)), [v, w]))
    }
}

impl TriangleTest for Badouel {
    const NAME: &'static str = "Badouel (Wald)";

    #[inline(always)]
    fn new(corners: [Vec3; 3]) -> Self {
        Self::prepare(corners)
    }

    #[inline(always)]
    fn hit<L: Lanes>(&self, rays: &Rays<L>) -> Option<Hits<L>> {
        let [p, q, _] = self.axis.order();
        let (origin, direction) = (&rays.origin, &rays.direction);
        let t = self.plane_of(rays);
        let mask = rays.t_min.is_below(t) & t.is_below(rays.t_max);
        if !mask.any() {
            return None;
        }
        let (mask, barycentric) = self.weights(mask, origin[p] + t * direction[p], origin[q] + t * direction[q])?;
        mask.any().then_some(Hits { mask, t, barycentric })
    }
}

/// Badouel's test with comparisons of integers (Wächter, *Realtime Ray Tracing*, 2004; Rahikainen 2013, §2.1). As
/// unsigned numbers, the bits of negative numbers and of NaN are larger than all others. So one comparison tells
/// whether t is in its interval, and one each whether weights and their sum are from zero to one. 40 bytes.
///
/// The ray's interval isn't empty and begins at a finite t. A weight of −0 is outside.
#[derive(Clone, Copy, Debug)]
pub struct Wachter(Badouel);

impl TriangleTest for Wachter {
    const NAME: &'static str = "Wächter";

    #[inline(always)]
    fn new(corners: [Vec3; 3]) -> Self {
        Self(Badouel::prepare(corners))
    }

    #[inline(always)]
    fn hit<L: Lanes>(&self, rays: &Rays<L>) -> Option<Hits<L>> {
        let (Self(triangle), origin, direction) = (self, &rays.origin, &rays.direction);
        let t = triangle.plane_of(rays);
        let mask = (t - rays.t_min).is_within(rays.t_max - rays.t_min);
        if !mask.any() {
            return None;
        }
        let [p, q, _] = triangle.axis.order();
        let [p, q] = [origin[p] + t * direction[p], origin[q] + t * direction[q]];
        let [first, second] = triangle.weights;
        let v = p * first[0] + q * first[1] + first[2];
        let w = p * second[0] + q * second[1] + second[2];
        let one = v.splat(1.0);
        let mask = mask & v.is_up_to(one) & w.is_up_to(one) & (v + w).is_up_to(one);
        mask.any().then_some(Hits { mask, t, barycentric: [v, w] })
    }
}

/// Badouel's test for rays that share an origin (Rahikainen 2013, Algorithm 2.1.1, in Wald's form): the triangle is
/// prepared relative to the origin. 40 bytes.
///
/// A division and five multiplications for t and the point, two for each weight.
#[derive(Clone, Copy, Debug)]
pub struct BadouelBundle(Badouel);

impl BundleTest for BadouelBundle {
    const NAME: &'static str = "Badouel (Wald)";

    #[inline(always)]
    fn new([a, b, c]: [Vec3; 3], origin: Vec3) -> Self {
        Self(Badouel::prepare([a - origin, b - origin, c - origin]))
    }

    #[inline(always)]
    fn hit<L: Lanes>(&self, rays: &Bundle<L>) -> Option<Hits<L>> {
        let Self(triangle) = self;
        let ([p, q, r], direction) = (triangle.axis.order(), &rays.direction);
        let slope = direction[p] * triangle.plane[0] + direction[q] * triangle.plane[1] + direction[r];
        let t = slope.splat(triangle.plane[2]) / slope;
        let mask = rays.t_min.is_below(t) & t.is_below(rays.t_max);
        if !mask.any() {
            return None;
        }
        let (mask, barycentric) = triangle.weights(mask, t * direction[p], t * direction[q])?;
        mask.any().then_some(Hits { mask, t, barycentric })
    }
}
