//! Finding planes from few samples of the cost: Hunt et al. 2006, §3.

use super::sah::{AxisMeasure, Measure, SplitCandidate};
use crate::kdtree::extent::Reference;

/// The largest number of references of a node that is split exactly.
pub(super) const EXACT_FROM: usize = 36;

/// The number of uniform samples along each axis, q in the paper. As many more are placed where counts change.
const SAMPLES: usize = 8;

/// The number of samples along an axis of a cell, with those at its two faces.
const ALL: usize = 2 * SAMPLES + 2;

/// A coordinate at which the cost was sampled, and the numbers of triangles left and right of it.
#[derive(Clone, Copy, Default)]
struct Sample {
    at: f32,
    left: f64,
    right: f64,
}

/// Returns the plane of least cost; between samples the cost is taken as quadratic.
pub(super) fn best(mut measure: Measure<'_>, references: &[Reference]) -> Option<SplitCandidate> {
    let along = [0, 1, 2].map(|axis| measure.axis(axis));
    let uniform = along.map(|along| {
        let (low, high) = (f64::from(along.low), f64::from(along.high));
        std::array::from_fn(|index| (low + (high - low) * ((index + 1) as f64 / (SAMPLES + 1) as f64)) as f32)
    });
    let first = count(references, uniform);
    let adaptive = [0, 1, 2].map(|axis| adapt(&along[axis], &first[axis], references.len()));
    let second = count(references, adaptive);
    for axis in 0..3 {
        let mut samples = [Sample::default(); ALL];
        let all = references.len() as f64;
        samples[0] = Sample { at: along[axis].low, left: 0.0, right: all };
        samples[1] = Sample { at: along[axis].high, left: all, right: 0.0 };
        samples[2..][..SAMPLES].copy_from_slice(&first[axis]);
        samples[2 + SAMPLES..].copy_from_slice(&second[axis]);
        samples.sort_by(|a, b| a.at.total_cmp(&b.at));
        for pair in samples.windows(2) {
            look_between(&mut measure, &along[axis], pair[0], pair[1]);
        }
    }
    measure.best
}

/// Counts the triangles left and right of planes, which are sorted along each axis.
fn count(references: &[Reference], planes: [[f32; SAMPLES]; 3]) -> [[Sample; SAMPLES]; 3] {
    let mut counts = [[[0_u32; 2]; SAMPLES]; 3];
    for Reference { extent, .. } in references {
        for axis in 0..3 {
            for (counts, &at) in counts[axis].iter_mut().zip(&planes[axis]) {
                counts[0] += u32::from(extent.min[axis] < at);
                counts[1] += u32::from(extent.max[axis] > at);
            }
        }
    }
    let sample = |at: f32, [left, right]: [u32; 2]| Sample { at, left: f64::from(left), right: f64::from(right) };
    [0, 1, 2].map(|axis| std::array::from_fn(|index| sample(planes[axis][index], counts[axis][index])))
}

/// Places the further samples. Of q evenly spaced values between −N and N, each segment between uniform samples gets one
/// sample for each value that the left count minus the right count crosses there.
fn adapt(along: &AxisMeasure, uniform: &[Sample; SAMPLES], count: usize) -> [f32; SAMPLES] {
    let all = count as f64;
    let step = 2.0 * all / (SAMPLES + 1) as f64;
    let mut planes = [along.low; SAMPLES];
    let mut placed = 0;
    let (mut from, mut crossed) = (along.low, 0);
    for segment in 0..=SAMPLES {
        let end = uniform.get(segment).copied().unwrap_or(Sample { at: along.high, left: all, right: 0.0 });
        let crosses = (((end.left - end.right + all) / step) as usize).clamp(crossed, SAMPLES);
        let here = crosses - crossed;
        for index in 1..=here {
            let weight = index as f64 / (here + 1) as f64;
            planes[placed] = (f64::from(from) + (f64::from(end.at) - f64::from(from)) * weight) as f32;
            placed += 1;
        }
        (from, crossed) = (end.at, crosses);
    }
    planes
}

/// Considers the plane of the second sample, and that of least cost between both. Counts are interpolated linearly, so the
/// cost is quadratic.
fn look_between(measure: &mut Measure<'_>, along: &AxisMeasure, from: Sample, to: Sample) {
    let all = measure.count as f64;
    measure.consider(along, to.at + 0.0, [to.left, 0.0, to.right]);
    let ([left_from, right_from], [left_to, right_to]) = (along.shares(from.at), along.shares(to.at));
    // (pl + x Δpl)(cl + x Δcl) + (pr + x Δpr)(cr + x Δcr) for x from 0 to 1.
    let [left, right] = [(left_to - left_from, to.left - from.left), (right_to - right_from, to.right - from.right)];
    let square = left.0 * left.1 + right.0 * right.1;
    let linear = left_from * left.1 + from.left * left.0 + right_from * right.1 + from.right * right.0;
    let x = -linear / (2.0 * square);
    if square > 0.0 && x > 0.0 && x < 1.0 {
        let at = f64::from(from.at) + (f64::from(to.at) - f64::from(from.at)) * x;
        let (left, right) = (from.left + left.1 * x, from.right + right.1 * x);
        // Interpolated counts may add up to less than all triangles.
        let missing = 0.5 * (all - left - right).max(0.0);
        measure.consider(along, at as f32 + 0.0, [left + missing, 0.0, right + missing]);
    }
}
