use std::cmp::Ordering;

use glam::{DVec3, Vec3};

use super::Job;
use super::answers::ClosestPoints;
use super::block::Candidate;
use super::exact::{compare, is_within};
use super::measure::{Measured, is_shared, measure, position};
use crate::Triangles;

/// The nearest point for one of many.
#[derive(Clone, Copy, Debug)]
pub(super) struct Answer {
    pub(super) triangle: u32,
    pub(super) barycentric: [f32; 2],
    pub(super) distance: f64,
    pub(super) position: DVec3,
}

impl Answer {
    pub(super) const NONE: Self = Self {
        triangle: ClosestPoints::NONE,
        barycentric: [f32::NAN; 2],
        distance: f64::INFINITY,
        position: DVec3::NAN,
    };
}

/// Memory for choosing the nearest of each point's candidates.
#[derive(Debug, Default)]
pub(super) struct Settle {
    /// A candidate's slot in the upper half, its id in the lower.
    keys: Vec<u64>,
    /// The candidates of one point.
    measured: Vec<Measurement>,
    /// The nearest triangle of each slot that has candidates.
    chosen: Vec<(u32, Measurement)>,
    /// A corner of a triangle that was chosen.
    pub(super) hint: Option<Vec3>,
}

#[derive(Clone, Copy, Debug)]
struct Measurement {
    id: u32,
    corners: [Vec3; 3],
    measured: Measured,
}

impl Settle {
    /// Chooses the nearest triangle for each slot with candidates, of equally near ones the lowest id.
    pub(super) fn choose(&mut self, triangles: Triangles<'_>, points: &[Vec3], candidates: &[Candidate]) {
        let Self { keys, measured, chosen, .. } = self;
        keys.clear();
        keys.extend(candidates.iter().map(|of| u64::from(of.slot) << 32 | u64::from(of.id)));
        keys.sort_unstable();
        chosen.clear();
        for of_slot in keys.chunk_by(|a, b| a >> 32 == b >> 32) {
            let slot = (of_slot[0] >> 32) as u32;
            let point = points[slot as usize];
            measured.clear();
            measured.extend(of_slot.iter().map(|&key| {
                let corners = triangles.corners(key as u32);
                Measurement { id: key as u32, corners, measured: measure(point, corners) }
            }));
            chosen.push((slot, nearest(point, measured)));
        }
    }

    /// The triangles chosen last, as candidates.
    pub(super) fn chosen(&self) -> impl Iterator<Item = Candidate> {
        self.chosen.iter().map(|(slot, of)| Candidate { slot: *slot, id: of.id, least: 0.0 })
    }

    /// Writes the answers of a block's points, those without a chosen triangle as well.
    pub(super) fn write(&mut self, job: &Job<'_>, points: &[Vec3], answers: &mut [Answer]) {
        answers.fill(Answer::NONE);
        for (slot, Measurement { id, corners, measured }) in &self.chosen {
            let slot = *slot as usize;
            if is_nearer_than(job.max, points[slot], *corners, measured) {
                answers[slot] = Answer {
                    triangle: *id,
                    barycentric: [measured.weights[1] as f32, measured.weights[2] as f32],
                    distance: measured.distance,
                    position: position(*corners, measured.weights),
                };
            }
        }
        self.hint = self.chosen.last().map(|(_, of)| of.corners[0]).or(self.hint);
    }

    pub(super) fn bytes(&self) -> usize {
        self.keys.capacity() * size_of::<u64>()
            + self.measured.capacity() * size_of::<Measurement>()
            + self.chosen.capacity() * size_of::<(u32, Measurement)>()
    }
}

/// Whether a triangle is nearer than a distance, in real numbers.
pub(super) fn is_nearer_than(max: f64, point: Vec3, corners: [Vec3; 3], measured: &Measured) -> bool {
    measured.most < max || (measured.least < max && is_within(point, corners, max))
}

/// The nearest of a point's candidates, which are sorted by id; the first of equally near ones.
fn nearest(point: Vec3, measured: &[Measurement]) -> Measurement {
    let most = measured.iter().fold(f64::INFINITY, |most, of| most.min(of.measured.most));
    let mut left = measured.iter().filter(|of| of.measured.least <= most);
    let first = *left.next().expect("the nearest one");
    left.fold(first, |best, other| if is_nearer(point, other, &best) { *other } else { best })
}

/// Whether a triangle is nearer than another one with a lower id.
fn is_nearer(point: Vec3, this: &Measurement, other: &Measurement) -> bool {
    let [a, b, c] = other.corners;
    let is_copy = [[a, b, c], [b, c, a], [c, a, b], [c, b, a], [b, a, c], [a, c, b]].contains(&this.corners);
    if is_copy || this.measured.least > other.measured.most {
        return false;
    }
    if this.measured.most < other.measured.least {
        return true;
    }
    let both = [(&this.corners, &this.measured), (&other.corners, &other.measured)];
    !is_shared(point, both) && compare(point, [this.corners, other.corners]) == Ordering::Less
}
