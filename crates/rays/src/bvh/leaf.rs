use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};
use glam::{Vec3, Vec4};

use super::line::Line;
use crate::shear::Sheared;
use crate::simd::each;

/// Up to eight triangles: 320 bytes.
///
/// `Sheared` rules out triangles, with H = 1: z is along the axis of the direction's largest component. Offsets from the
/// line's origin are rounded once, and the origin by its blur.
#[derive(Clone, Copy)]
#[repr(align(32))]
pub struct Leaf {
    /// For each axis the scaled coordinates of all first corners, then of all second and of all third ones.
    corners: [[[f32; Leaf::LANES]; 3]; 3],
    /// The triangles' ids.
    pub ids: [u32; Leaf::LANES],
}

/// Triangles of a leaf that a ray may hit.
pub struct LeafHits {
    /// Triangles that may be hit, a bit for each.
    pub possible: u32,
    /// Those that the line certainly meets after the ray's start.
    pub certain: u32,
    /// Lower bound of a hit's t.
    pub earliest: [f32; Leaf::LANES],
    /// Upper bound of a hit's t.
    pub latest: [f32; Leaf::LANES],
}

impl LeafHits {
    /// Whether a line certainly hits the triangle in a lane, within its ray's interval.
    #[inline(always)]
    pub(super) fn is_hit(&self, line: &Line, lane: usize) -> bool {
        self.certain >> lane & 1 == 1 && self.latest[lane] < line.before
    }
}

impl Leaf {
    /// The largest number of triangles in a leaf.
    pub const LANES: usize = 8;

    pub(super) const EMPTY: Self = Self { corners: [[[0.0; Self::LANES]; 3]; 3], ids: [u32::MAX; Self::LANES] };

    /// Replaces the triangles, with scaled corners.
    pub(super) fn fill(&mut self, ids: impl Iterator<Item = u32>, corners: impl Fn(u32) -> [Vec3; 3]) {
        for (lane, id) in ids.enumerate() {
            self.set(lane, id, corners(id).map(|corner| corner.extend(0.0)));
        }
    }

    /// Replaces one triangle, with scaled corners.
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, id: u32, corners: [Vec4; 3]) {
        self.ids[lane] = id;
        for (number, corner) in corners.into_iter().enumerate() {
            for axis in 0..3 {
                self.corners[axis][number][lane] = corner[axis];
            }
        }
    }

    /// A part of the way from each corner to that of another leaf.
    #[inline(always)]
    pub(super) fn towards<S: Simd>(&self, simd: S, other: &Self, part: f32) -> Self {
        let mut leaf = Self { ids: self.ids, ..Self::EMPTY };
        for ((into, from), to) in leaf
            .corners
            .iter_mut()
            .zip(&self.corners)
            .flat_map(|(into, from)| into.iter_mut().zip(from))
            .zip(other.corners.iter().flatten())
        {
            let (from, to) = (f32x8::from_slice(simd, from), f32x8::from_slice(simd, to));
            (to - from).mul_add(part, from).store_slice(into);
        }
        leaf
    }

    /// The scaled corners in a lane.
    #[inline(always)]
    pub(super) fn corners(&self, lane: usize) -> [Vec3; 3] {
        let at = |axis: usize, number: usize| self.corners[axis][number][lane];
        let corner = |number: usize| Vec3::new(at(0, number), at(1, number), at(2, number));
        [corner(0), corner(1), corner(2)]
    }

    /// The triangles in some lanes that a ray may hit before `far`.
    #[inline(always)]
    pub fn find<S: Simd>(&self, simd: S, line: &Line, lanes: u32, far: f32) -> Option<LeafHits> {
        self.find_blurred(simd, line, line.blur, lanes, far)
    }

    /// As [`find`](Self::find), for corners or a line that are wrong by 2⁻²⁴ of `blur`.
    #[inline(always)]
    pub(super) fn find_blurred<S: Simd>(
        &self,
        simd: S,
        line: &Line,
        blur: f32,
        lanes: u32,
        far: f32,
    ) -> Option<LeafHits> {
        let [i, j, k] = line.axes;
        let z = self.offsets(simd, line, k);
        let offsets = [self.offsets(simd, line, i), self.offsets(simd, line, j), z];
        let slopes = [f32x8::splat(simd, line.slopes[0]), f32x8::splat(simd, line.slopes[1])];
        let sheared = Sheared::new(offsets, slopes, 1.0, blur);
        let mut possible = !(sheared.is_missed().to_bitmask() as u32) & lanes;
        if possible == 0 {
            return None;
        }
        // e has z and the blur in it, so it is the bound for depths too.
        let [earliest, latest] = sheared.depth(each!(z in z => z * line.sign), sheared.error);
        let outside = earliest.simd_gt(far) | latest.simd_lt(line.near);
        possible &= !(outside.to_bitmask() as u32);
        // After the ray's start; `near` may be slightly before it.
        let certain = (sheared.is_met() & earliest.simd_gt(line.after)).to_bitmask() as u32 & possible;
        if possible == 0 {
            return None;
        }
        Some(LeafHits { possible, certain, earliest: earliest.into(), latest: latest.into() })
    }

    /// The offsets of all corners from the line's origin along an axis.
    #[inline(always)]
    fn offsets<S: Simd>(&self, simd: S, line: &Line, axis: usize) -> [f32x8<S>; 3] {
        each!(corner in &self.corners[axis] => f32x8::from_slice(simd, corner) - line.origin[axis])
    }
}

#[cfg(test)]
mod tests {
    use crate::dispatch;
    use glam::DVec3;

    use super::*;
    use crate::predicate::crossing;
    use crate::random::Random;
    use crate::{Ray, SimdLevel};

    fn point(random: &mut Random) -> DVec3 {
        DVec3::new(random.signed(), random.signed(), random.signed())
    }

    #[test]
    fn verdicts_and_distances_are_the_predicates() {
        let mut random = Random::new(7);
        let levels = SimdLevel::available();
        let (mut met, mut missed, mut left_out, mut certain) = (0, 0, 0, 0);
        for round in 0..40_000 {
            // Scenes and triangles of all sizes, and triangles far from the middle of their scene.
            let world = f64::exp2(30.0 * random.signed());
            let middle = point(&mut random) * world;
            let size = world * f64::exp2(-16.0 * random.unit());
            let corners: Vec<[Vec3; 3]> = (0..Leaf::LANES)
                .map(|_| {
                    // Triangles of all shapes; some are slivers.
                    let [a, b, c] = [0; 3].map(|_| middle + point(&mut random) * size);
                    let thin = f64::exp2(-20.0 * random.unit());
                    [a, b, if round % 2 == 0 { c } else { a.lerp(b, random.signed()) + (c - a) * thin }]
                        .map(DVec3::as_vec3)
                })
                .collect();
            let [a, b, c] = corners[round % Leaf::LANES].map(Vec3::as_dvec3);
            // Targets: on an edge, at a corner, or near the triangle.
            let (u, v) = (random.unit(), random.signed());
            let target = [a.lerp(b, u), c, a + (b - a) * u + (c - a) * v][round % 3];
            let mut origin = point(&mut random) * world;
            if round % 5 == 0 {
                origin = origin.as_vec3().as_dvec3();
            }
            let ray = Ray::new(origin, (target - origin) * f64::exp2(20.0 * random.signed()));
            let ray = Ray { t_min: if round % 4 == 0 { f64::NEG_INFINITY } else { 0.0 }, ..ray };
            let line = Line::new(&ray, 1.0).expect("a line");
            let mut leaf = Leaf::EMPTY;
            leaf.fill(0..Leaf::LANES as u32, |id| corners[id as usize]);
            for &level in &levels {
                let found = dispatch!(level, simd => leaf.find(simd, &line, 0xff, f32::INFINITY));
                for (lane, &corners) in corners.iter().enumerate() {
                    let found = found.as_ref().filter(|found| found.possible >> lane & 1 == 1);
                    let is_certain = found.is_some_and(|found| found.certain >> lane & 1 == 1);
                    let hit = crossing(&ray, corners).filter(|crossing| crossing.t > ray.t_min);
                    certain += u32::from(is_certain);
                    let Some(hit) = hit else {
                        assert!(!is_certain, "{ray:?} misses {corners:?}");
                        missed += 1;
                        left_out += u32::from(found.is_none());
                        continue;
                    };
                    met += 1;
                    let found = found.unwrap_or_else(|| panic!("{ray:?} meets {corners:?} at {level}"));
                    let t = hit.t * line.scale();
                    let range = f64::from(found.earliest[lane])..=f64::from(found.latest[lane]);
                    assert!(range.contains(&t), "{ray:?} meets {corners:?} at {t}, not in {range:?}");
                }
            }
        }
        let many = 20_000 * levels.len() as u32;
        assert!(met > many && missed > many, "{met} met, {missed} missed");
        assert!(left_out > missed / 2 && certain > met / 4, "{left_out} left out, {certain} certain");
    }
}
