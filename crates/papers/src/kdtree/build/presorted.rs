//! Finding planes among faces of boxes that are sorted once: Wald and Havran 2006, §4.3.

use std::ops::Range;
use umbrage_rays::parallel::both;

use super::sah::{AxisMeasure, Measure, SplitCandidate};
use super::space::{Frame, Space};
use crate::kdtree::extent::{Extent, Reference, Sides};

// An event is a face of a reference's box: a u64 with the coordinate in the upper half, in the order of coordinates, then
// two bits for its kind, and the reference's index. Sorted as numbers, events are in the order of the paper.
const END: u64 = 0;
const PLANAR: u64 = 1;
const START: u64 = 2;
const KIND_SHIFT: u32 = 30;
const INDEX_MASK: u64 = (1 << KIND_SHIFT) - 1;

/// Flag of a reference's place: it goes to the right child, …
pub(super) const RIGHT: u32 = 1 << 30;
/// … or in parts to both; else to the left one.
pub(super) const CUT: u32 = 1 << 31;

#[inline(always)]
fn event(coordinate: f32, kind: u64, index: u32) -> u64 {
    let bits = coordinate.to_bits();
    let ordered = if bits >> 31 == 0 { bits | 1 << 31 } else { !bits };
    u64::from(ordered) << 32 | kind << KIND_SHIFT | u64::from(index)
}

/// Returns the coordinate whose event has this upper half.
#[inline(always)]
fn coordinate(ordered: u32) -> f32 {
    f32::from_bits(if ordered >> 31 == 1 { ordered & !(1 << 31) } else { !ordered })
}

/// Adds the events of a box across one axis.
#[inline(always)]
pub(super) fn push_axis(events: &mut Vec<u64>, low: f32, high: f32, index: u32) {
    if low == high {
        events.push(event(low, PLANAR, index));
    } else {
        events.extend([event(low, START, index), event(high, END, index)]);
    }
}

/// Adds the events of a box across all axes.
#[inline(always)]
pub(super) fn push_events(events: &mut [Vec<u64>; 3], extent: &Extent, index: u32) {
    for (axis, events) in events.iter_mut().enumerate() {
        push_axis(events, extent.min[axis], extent.max[axis], index);
    }
}

/// Returns the place of a reference with these parts: its index in the child, and a flag. `next` holds the next index of
/// each child. Lists the events of parts that the plane cut in `fresh`.
pub(super) fn place(
    sides: Sides,
    parts: &[Option<Reference>; 2],
    next: [u32; 2],
    fresh: &mut [[Vec<u64>; 3]; 2],
) -> u32 {
    match sides {
        Sides::Left => next[0],
        Sides::Right => RIGHT | next[1],
        Sides::Both => {
            for ((part, events), index) in parts.iter().zip(fresh).zip(next) {
                part.iter().for_each(|part| push_events(events, &part.extent, index));
            }
            CUT
        }
    }
}

impl Space {
    /// Lists the events of all references from `at` on, in order.
    pub(super) fn list_events(&mut self, at: Frame) {
        let Self { references, events, .. } = self;
        let references = &references[at.references..];
        let list = |axis: usize, events: &mut Vec<u64>| {
            for (reference, index) in references.iter().zip(0..) {
                push_axis(events, reference.extent.min[axis], reference.extent.max[axis], index);
            }
            events[at.events[axis]..].sort_unstable();
        };
        const PARALLEL: usize = 1 << 12;
        let [x, y, z] = events;
        if references.len() >= PARALLEL {
            both(|| list(0, x), || both(|| list(1, y), || list(2, z)));
        } else {
            [x, y, z].into_iter().enumerate().for_each(|(axis, events)| list(axis, events));
        }
    }

    /// Returns the best plane for the references from `at` on, whose events are listed.
    pub(super) fn sweep(&self, mut measure: Measure<'_>, at: Frame) -> Option<SplitCandidate> {
        for axis in 0..3 {
            let before = [0.0, measure.count as f64];
            measure = sweep(measure, axis, &self.events[axis][at.events[axis]..], before, |_| 1);
        }
        measure.best
    }
}

/// Considers the planes of all events, which are in order across an axis. `before` holds the numbers of triangles that have
/// begun, and that haven't ended, before them. `weight` returns the number of triangles that the reference at an index
/// counts as.
#[inline]
pub(super) fn sweep<'a>(
    measure: Measure<'a>,
    axis: usize,
    events: &[u64],
    before: [f64; 2],
    weight: impl Fn(usize) -> u32,
) -> Measure<'a> {
    let mut sweep = Sweep::new(measure, axis, before);
    events.iter().for_each(|&event| sweep.pass(event, weight(index(event))));
    sweep.end()
}

/// A [`sweep`] with events that come one at a time.
pub(super) struct Sweep<'a> {
    measure: Measure<'a>,
    along: AxisMeasure,
    left: f64,
    right: f64,
    /// The coordinate of the last events, and their number of each kind.
    ordered: u64,
    counts: [u32; 4],
}

impl<'a> Sweep<'a> {
    pub(super) fn new(measure: Measure<'a>, axis: usize, [left, right]: [f64; 2]) -> Self {
        Self { along: measure.axis(axis), measure, left, right, ordered: 0, counts: [0; 4] }
    }

    #[inline(always)]
    pub(super) fn pass(&mut self, event: u64, weight: u32) {
        if event >> 32 != self.ordered {
            self.close();
            self.ordered = event >> 32;
        }
        self.counts[kind(event)] += weight;
    }

    /// Considers the plane of the last events.
    #[inline(always)]
    fn close(&mut self) {
        let counts = std::mem::take(&mut self.counts);
        let [ends, planar, starts] = [END, PLANAR, START].map(|kind| f64::from(counts[kind as usize]));
        if ends + planar + starts > 0.0 {
            self.right -= ends + planar;
            self.measure.consider(&self.along, coordinate(self.ordered as u32), [self.left, planar, self.right]);
            self.left += starts + planar;
        }
    }

    pub(super) fn end(mut self) -> Measure<'a> {
        self.close();
        self.measure
    }
}

#[inline(always)]
fn kind(event: u64) -> usize {
    (event >> KIND_SHIFT & 3) as usize
}

/// The index of an event's reference.
#[inline(always)]
pub(super) fn index(event: u64) -> usize {
    (event & INDEX_MASK) as usize
}

/// Returns the event, for a reference that has moved to `index`.
#[inline(always)]
pub(super) fn with_index(event: u64, index: u32) -> u64 {
    event & !INDEX_MASK | u64::from(index)
}

/// Splits events into ranges of about `size`; events of one coordinate stay together.
pub(super) fn chunks(events: &[u64], size: usize) -> impl Iterator<Item = Range<usize>> {
    let mut start = 0;
    std::iter::from_fn(move || {
        let from = start;
        let end = (from + size).min(events.len());
        let last = events.get(end.checked_sub(1)?)? >> 32;
        let end = end + events[end..].partition_point(|event| event >> 32 == last);
        start = end;
        (from < end).then_some(from..end)
    })
}

/// Returns the numbers of references that begin and that end with these events.
pub(super) fn count(events: &[u64]) -> [usize; 2] {
    let mut counts = [0; 4];
    events.iter().for_each(|&event| counts[kind(event)] += 1);
    let [ends, planar, starts] = [END, PLANAR, START].map(|kind| counts[kind as usize]);
    [starts + planar, ends + planar]
}

/// Returns the events of references that aren't cut, for both children.
pub(super) fn part_kept(events: &[u64], indices: &[u32]) -> [Vec<u64>; 2] {
    let mut parts = [Vec::with_capacity(events.len()), Vec::with_capacity(events.len())];
    for &event in events {
        match indices[index(event)] {
            CUT.. => {}
            right @ RIGHT.. => parts[1].push(with_index(event, right - RIGHT)),
            left => parts[0].push(with_index(event, left)),
        }
    }
    parts
}

/// Merges events in parts with fresh ones, both in order, into `all`.
pub(super) fn merge<'a>(parts: impl Iterator<Item = &'a [u64]>, fresh: &[u64], all: &mut Vec<u64>) {
    let mut next = 0;
    for part in parts {
        all.reserve(part.len());
        for &event in part {
            while let Some(&first) = fresh.get(next)
                && first < event
            {
                all.push(first);
                next += 1;
            }
            all.push(event);
        }
    }
    all.extend_from_slice(&fresh[next..]);
}

/// Gives events across one axis, in order, to the children of a node. The fresh events are those of references that were
/// cut, by side; the last one of each side is a sentinel above all others.
pub(super) fn part(
    events: &[u64],
    indices: &[u32],
    [fresh_left, fresh_right]: [&[u64]; 2],
    left: &mut Vec<u64>,
    right: &mut Vec<u64>,
) {
    let (mut next_left, mut next_right) = (0, 0);
    for &event in events {
        let index = indices[(event & INDEX_MASK) as usize];
        let kept = event & !INDEX_MASK;
        if index < RIGHT {
            let event = kept | u64::from(index);
            while fresh_left[next_left] < event {
                left.push(fresh_left[next_left]);
                next_left += 1;
            }
            left.push(event);
        } else if index < CUT {
            let event = kept | u64::from(index - RIGHT);
            while fresh_right[next_right] < event {
                right.push(fresh_right[next_right]);
                next_right += 1;
            }
            right.push(event);
        }
    }
    left.extend_from_slice(&fresh_left[next_left..fresh_left.len() - 1]);
    right.extend_from_slice(&fresh_right[next_right..fresh_right.len() - 1]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_sort_by_coordinate_then_kind() {
        let coordinates = [f32::NEG_INFINITY, -2.5, -1e-40, 0.0, 1e-40, 3.0, f32::MAX];
        let events: Vec<_> = coordinates
            .iter()
            .flat_map(|&at| [END, PLANAR, START].map(|kind| event(at, kind, (INDEX_MASK - kind) as u32)))
            .collect();
        assert!(events.is_sorted() && events.windows(2).all(|pair| pair[0] != pair[1]));
        let back: Vec<_> = events.iter().step_by(3).map(|&event| coordinate((event >> 32) as u32)).collect();
        assert_eq!(back, coordinates);
    }
}
