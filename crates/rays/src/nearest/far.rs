//! Points so far away that all triangles are about as near.
//!
//! Let c be any corner, g its position relative to the point, and y that of another point x relative to c. Then the squared
//! distance of x is g² + F with F = y² + 2 g · y, whose rounding errors are as small as the scene, not as the distance. So F
//! tells triangles apart that distances from the point don't.

use glam::{DVec3, Vec3};

use super::Job;
use super::block::{BlockWorker, Candidate};
use crate::patches::Patches;
use crate::simd::lanes::LANES;

/// More than the rounding errors of F, of the sum of its terms' magnitudes: y and g are wrong by one, and there are at most
/// five more on the way.
const ERROR: f64 = 16.0 * f64::EPSILON / 2.0;

/// Points beyond this many sizes of the scene are far.
const FAR: f32 = (1 << 15) as f32;

/// The part of space that most triangles are in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    middle: Vec3,
    /// The distance on an axis beyond which points are far.
    far: f32,
    /// A corner of a triangle.
    corner: Vec3,
}

impl Place {
    /// The part around the `middle` of this size; `None` without a patch of finite corners.
    pub(super) fn new(patches: &Patches, middle: Vec3, size: f32) -> Option<Self> {
        let is_finite = |number: &usize| !patches.bounds.sixteens[number / LANES].get(*number)[0][0].is_nan();
        let number = (0..patches.len()).find(is_finite)?;
        let [x, y, z] = patches.positions(number)[0];
        Some(Self { middle, far: size * FAR, corner: Vec3::new(x[0], y[0], z[0]) })
    }

    pub(super) fn is_far(&self, point: Vec3) -> bool {
        (point - self.middle).abs().max_element() > self.far
    }
}

/// F for one point.
struct Difference {
    corner: DVec3,
    /// g.
    offset: DVec3,
}

impl Difference {
    /// F at y on one axis, and the sum of its terms' magnitudes.
    fn on_axis(&self, axis: usize, y: f64) -> (f64, f64) {
        let g = self.offset[axis];
        (y * (y + 2.0 * g), y.abs() * (y.abs() + 2.0 * g.abs()))
    }

    /// Lower bound of F in a box; of all space for one of NaN.
    fn least_in(&self, [low, high]: [[f32; 3]; 2]) -> f64 {
        let (mut sum, mut size) = (0.0, 0.0);
        for axis in [0, 1, 2] {
            let [low, high] = [low[axis], high[axis]].map(|end| f64::from(end) - self.corner[axis]);
            if low.is_nan() || high.is_nan() {
                return f64::NEG_INFINITY;
            }
            // The nearest to the point.
            let (of_axis, terms) = self.on_axis(axis, (-self.offset[axis]).max(low).min(high));
            sum += of_axis;
            size += terms;
        }
        sum - ERROR * size
    }

    /// Lower bound of F on a triangle: in its box, and of its linear part.
    fn least_of(&self, corners: [Vec3; 3]) -> f64 {
        let [a, b, c] = corners;
        let in_box = self.least_in([a.min(b).min(c).to_array(), a.max(b).max(c).to_array()]);
        let linear = corners.map(|corner| {
            let y = corner.as_dvec3() - self.corner;
            2.0 * (self.offset.dot(y) - ERROR * self.offset.abs().dot(y.abs()))
        });
        in_box.max(linear[0].min(linear[1]).min(linear[2]))
    }

    /// Upper bound of F at a corner.
    fn most_at(&self, corner: Vec3) -> f64 {
        let y = corner.as_dvec3() - self.corner;
        let axes = [self.on_axis(0, y.x), self.on_axis(1, y.y), self.on_axis(2, y.z)];
        axes.iter().map(|(of_axis, _)| of_axis).sum::<f64>() + ERROR * axes.iter().map(|(_, size)| size).sum::<f64>()
    }
}

impl BlockWorker {
    /// Finds the candidates of a far point.
    pub(super) fn find_far(&mut self, job: &Job<'_>, place: &Place, slot: usize) {
        let corner = place.corner.as_dvec3();
        let difference = Difference { corner, offset: corner - self.positions[slot].as_dvec3() };
        let mut most = f64::INFINITY;
        let mut found = std::mem::take(&mut self.far_found);
        found.clear();
        descend(job, &difference, (job.boxes.top(), 0), &mut most, &mut found);
        let left = found.iter().filter(|(least, _)| *least <= most);
        self.candidates.extend(left.map(|&(_, id)| Candidate { slot: slot as u32, id, least: 0.0 }));
        self.far_found = found;
    }
}

/// Visits the triangles below a node of the tree, from the nearest box to the farthest, and notes those that may be the
/// nearest with lower bounds of F. The upper bound of its least value is `most`.
fn descend(
    job: &Job<'_>,
    difference: &Difference,
    (level, number): (usize, usize),
    most: &mut f64,
    found: &mut Vec<(f64, u32)>,
) {
    let (boxes, count) = job.boxes.node(job.patches, level, number);
    let mut order = [(0.0, 0); LANES];
    for (lane, to) in order.iter_mut().enumerate().take(count) {
        *to = (difference.least_in(boxes.get(lane)), number * LANES + lane);
    }
    let order = &mut order[..count];
    order.sort_unstable_by(|(a, _), (b, _)| a.total_cmp(b));
    for &mut (least, below) in order {
        if least > *most {
            break;
        }
        if level > 0 {
            descend(job, difference, (level - 1, below), most, found);
            continue;
        }
        let patch = job.patches.get(below);
        for &id in &patch.ids[..patch.count] {
            let corners = job.triangles.corners(id);
            if !corners.iter().all(|corner| corner.is_finite()) {
                continue;
            }
            let least = difference.least_of(corners);
            if least <= *most {
                found.push((least, id));
                *most = corners.iter().fold(*most, |most, &corner| most.min(difference.most_at(corner)));
            }
        }
    }
}
