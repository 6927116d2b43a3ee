use super::presorted;
use super::sah::SplitCandidate;
use super::{Job, Reused};
use crate::kdtree::extent::Reference;

/// Working memory of one thread: the references of the current node, after those of the right children that wait.
#[derive(Default)]
pub(super) struct Space {
    pub(super) references: Vec<Reference>,
    /// The faces of the references' boxes, by axis, in order, if the builder keeps them.
    pub(super) events: [Vec<u64>; 3],
    /// References and events of the left child that is being made.
    left: Vec<Reference>,
    left_events: [Vec<u64>; 3],
    /// Events of the right child that is being made.
    right_events: Vec<u64>,
    /// Events of boxes that the plane cuts, by side and axis.
    fresh: [[Vec<u64>; 3]; 2],
    /// The place of each reference in the children.
    indices: Vec<u32>,
}

/// The starts of a node's references and events, which reach to the ends of the lists.
#[derive(Clone, Copy, Default)]
pub(super) struct Frame {
    pub(super) references: usize,
    pub(super) events: [usize; 3],
}

impl Reused for Space {
    fn clear(&mut self) {
        self.truncate(Frame::default());
    }

    fn bytes(&self) -> usize {
        let references = self.references.capacity() + self.left.capacity();
        let fresh = self.fresh.iter().flatten();
        let events = self.events.iter().chain(&self.left_events).chain(fresh).map(Vec::capacity).sum::<usize>();
        references * size_of::<Reference>()
            + (events + self.right_events.capacity()) * size_of::<u64>()
            + self.indices.capacity() * size_of::<u32>()
    }
}

impl Space {
    /// Returns the ends of the lists.
    pub(super) fn end(&self) -> Frame {
        Frame { references: self.references.len(), events: [0, 1, 2].map(|axis| self.events[axis].len()) }
    }

    pub(super) fn truncate(&mut self, frame: Frame) {
        self.references.truncate(frame.references);
        for axis in 0..3 {
            self.events[axis].truncate(frame.events[axis]);
        }
    }

    /// Splits the node at `at`, which becomes its right child; the left child is put aside. Returns the numbers of their
    /// references.
    pub(super) fn part(&mut self, job: &Job<'_>, at: Frame, best: &SplitCandidate, has_events: bool) -> [usize; 2] {
        self.left.clear();
        self.indices.clear();
        self.fresh.iter_mut().flatten().for_each(Vec::clear);
        let start = at.references;
        let mut right = start;
        for index in start..self.references.len() {
            let reference = self.references[index];
            let (sides, parts) = job.part(&reference, best);
            if has_events {
                let next = [self.left.len() as u32, (right - start) as u32];
                self.indices.push(presorted::place(sides, &parts, next, &mut self.fresh));
            }
            self.left.extend(parts[0]);
            if let Some(part) = parts[1] {
                self.references[right] = part;
                right += 1;
            }
        }
        self.references.truncate(right);
        if has_events {
            self.part_events(at);
        } else {
            self.left_events.iter_mut().for_each(Vec::clear);
        }
        [self.left.len(), right - start]
    }

    fn part_events(&mut self, at: Frame) {
        let Self { events, left_events, right_events, fresh, indices, .. } = self;
        for axis in 0..3 {
            for fresh in fresh.iter_mut() {
                fresh[axis].sort_unstable();
                // A sentinel, so that merging needn't check for the end.
                fresh[axis].push(u64::MAX);
            }
            let fresh = [&fresh[0][axis][..], &fresh[1][axis][..]];
            left_events[axis].clear();
            right_events.clear();
            presorted::part(&events[axis][at.events[axis]..], indices, fresh, &mut left_events[axis], right_events);
            events[axis].truncate(at.events[axis]);
            events[axis].extend_from_slice(right_events);
        }
    }

    /// Puts the left child, which was put aside, above everything else, and returns where it starts.
    pub(super) fn push_left(&mut self) -> Frame {
        let start = self.end();
        self.references.extend_from_slice(&self.left);
        for axis in 0..3 {
            self.events[axis].extend_from_slice(&self.left_events[axis]);
        }
        start
    }

    /// Moves the left child, which was put aside, to an empty space.
    pub(super) fn give_left(&mut self, to: &mut Self) {
        std::mem::swap(&mut self.left, &mut to.references);
        std::mem::swap(&mut self.left_events, &mut to.events);
    }
}
