use glam::Vec3;

use crate::Triangles;
use crate::curve_order::CurveOrder;

/// The middle of a triangle's corners; the origin if they don't exist or aren't finite.
pub(super) fn centre(triangles: Triangles<'_>, id: u32) -> Vec3 {
    let corners = triangles.indices[id as usize].map(|vertex| triangles.positions.get(vertex as usize));
    let sum = corners.into_iter().map(|corner| corner.copied().unwrap_or(Vec3::NAN)).sum::<Vec3>();
    if sum.is_finite() { sum / 3.0 } else { Vec3::ZERO }
}

/// A Morton curve through a frame. (Morton, *A computer oriented geodetic data base*, 1966)
///
/// Half of its steps on each axis are in a cube that holds most triangles. Steps beyond it grow, up to infinity: so a few
/// far triangles don't make the cells of others larger, and are still told apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Curve {
    middle: Vec3,
    /// Two over the cube's size.
    scale: f32,
}

impl Curve {
    /// Bits of the steps on each axis.
    const BITS: u32 = 10;
    /// Number of triangles or points sampled to find the cube.
    const SAMPLES: usize = 1 << 10;

    pub(crate) fn through_triangles(triangles: Triangles<'_>) -> Self {
        Self::through(triangles.len(), |id| centre(triangles, id))
    }

    /// The curve through some of so many points.
    fn through(points: usize, point: impl Fn(u32) -> Vec3) -> Self {
        let mut axes = [[0.0; Self::SAMPLES]; 3];
        let mut count = 0;
        let every = points.div_ceil(Self::SAMPLES).max(1);
        for id in (0..points).step_by(every) {
            let point = point(id as u32);
            if !point.is_finite() {
                continue;
            }
            for (axis, coordinate) in axes.iter_mut().zip(point.to_array()) {
                axis[count] = coordinate;
            }
            count += 1;
        }
        let mut quantile = |share: f32| {
            let index = (share * count as f32) as usize;
            let of = |axis: &mut [f32; Self::SAMPLES]| {
                if count == 0 { 0.0 } else { *axis[..count].select_nth_unstable_by(index, f32::total_cmp).1 }
            };
            // Half of the value, since a sum may overflow.
            0.5 * Vec3::from_array(axes.each_mut().map(of))
        };
        let (low, high) = (quantile(0.05), quantile(0.95));
        let size = high - low;
        let half = 1.3 * size.max_element();
        // A flat frame is at the cube's lower side, away from the boundaries of large cells, which would divide it.
        Self { middle: 2.0 * low - 0.3 * size + half, scale: 1.0 / half }
    }

    /// The ids of all triangles, in the lower halves of the numbers, along the curve: triangles near each other are mostly
    /// near in this order.
    pub(crate) fn sort_triangles<'a>(triangles: Triangles<'_>, order: &'a mut CurveOrder) -> &'a [u64] {
        let curve = Self::through_triangles(triangles);
        order.sort(triangles.len(), |id| curve.code(centre(triangles, id)))
    }

    /// The same for points.
    pub(crate) fn sort_points<'a>(points: &[Vec3], order: &'a mut CurveOrder) -> &'a [u64] {
        let curve = Self::through(points.len(), |index| points[index as usize]);
        order.sort(points.len(), |index| curve.code(points[index as usize]))
    }

    /// The middle of the cube that holds most triangles.
    pub(crate) fn middle(&self) -> Vec3 {
        self.middle
    }

    /// The size of the cube that holds most triangles.
    pub(crate) fn size(&self) -> f32 {
        2.0 / self.scale
    }

    /// The position of a point along the curve: any if the cube has no size.
    fn code(&self, point: Vec3) -> u32 {
        const QUARTER: f32 = (1 << (Curve::BITS - 2)) as f32;
        const LAST: u32 = (1 << Curve::BITS) - 1;
        /// The lowest bits of a sum with it are the other number, rounded: faster than a conversion.
        const TO_BITS: f32 = (1 << 23) as f32;
        let [x, y, z] = ((point - self.middle) * self.scale).to_array().map(|across| {
            let size = across.abs();
            let bent = if size <= 1.0 { size } else { 2.0 - 1.0 / size };
            let step = 2.0 * QUARTER + QUARTER * bent.copysign(across);
            (step.max(0.0).min(LAST as f32) + TO_BITS).to_bits() & LAST
        });
        spread(x) | spread(y) << 1 | spread(z) << 2
    }
}

/// A step's bits with two zeros between them.
fn spread(step: u32) -> u32 {
    let step = (step | step << 16) & 0x0300_00ff;
    let step = (step | step << 8) & 0x0300_f00f;
    let step = (step | step << 4) & 0x030c_30c3;
    (step | step << 2) & 0x0924_9249
}
