//! Building from groups of triangles, each of which is taken as one box until cells are small (Hunt, Mark and Fussell,
//! *Fast and lazy build of acceleration structures from scene hierarchies*, 2007).
//!
//! Boxes of all groups are made anew, from the triangles up. Each node then looks at the groups in its cell that are no
//! larger than a certain part of it: their number doesn't depend on that of their triangles. So nodes above those of a few
//! hundred triangles take O(N / few hundred) in all instead of O(N log N), if groups are compact.
//!
//! **Why no hit is missed.** A group goes to the sides of a plane on which its box is, and to both if it is cut. So a
//! triangle's group is on each side on which the triangle must be listed (`kdtree`). When a group is opened, the triangle is
//! kept unless its box is outside of the cell, or only touches it without being flat: then a part of it is strictly beyond
//! that face, where its group has gone as well.

use rayon::prelude::*;
use umbrage_rays::parallel::both;

use super::groups::SceneHierarchy;
use crate::kdtree::{Branch, Cell, Extent, Job, Plane, Reference, Sides, SplitCandidate, Whole};
use crate::{Clipping, KdBuilder, KdTree};
use umbrage_rays::Triangles;

/// Nodes of fewer triangles are built as the options say.
const OPEN_BELOW: u64 = 512;

/// A group is opened if its part in the cell has more than 1 / `PARTS` of the cell's area. With 16 a tree of the Bunny
/// that is built from a bounding volume hierarchy costs 9 % more by the heuristic, and building takes hardly less time.
const PARTS: f64 = 64.0;

/// Number of triangles from which a node's children are built on two threads.
const PARALLEL: u64 = 1 << 12;

/// A group or a triangle in a cell.
#[derive(Clone, Copy)]
struct Unit {
    /// Bounds of the part in the cell, and the group's index or the triangle's id.
    reference: Reference,
    /// The number of triangles in a group; zero for a triangle.
    count: u32,
}

impl Unit {
    fn weight(&self) -> u32 {
        self.count.max(1)
    }
}

/// Data that all parts of a build share.
struct Hierarchical<'a> {
    job: &'a Job<'a>,
    hierarchy: &'a SceneHierarchy,
    /// The box around the triangles of each group that can be hit, and their number.
    groups: Vec<(Extent, u32)>,
    builder: KdBuilder,
    /// The cost of testing a triangle.
    test_cost: f64,
    whole: Whole,
}

/// As [`KdTree::build`], with a `hierarchy` of neighbouring triangles. The upper nodes are found in a time that hardly
/// depends on the number of triangles, the lower ones as the options say. Any hierarchy of as many triangles gives a correct
/// tree, and one that is as good as others' if groups are compact.
pub(super) fn build_from(tree: &mut KdTree, triangles: Triangles<'_>, hierarchy: &SceneHierarchy) {
    let options = tree.options();
    tree.build_by(triangles, |job, count, out| {
        let groups = boxes(triangles, hierarchy);
        let extent = groups.first().map_or(Extent::EMPTY, |root| root.0);
        if count == 0 {
            out.push_leaf(std::iter::empty());
            return extent;
        }
        let root = Unit { reference: Reference { extent, id: 0 }, count: count as u32 };
        let (builder, test_cost, whole) = (options.builder, options.costs.test, Whole::new(&extent, triangles));
        let all = Hierarchical { job, hierarchy, groups, builder, test_cost, whole };
        all.grow(vec![root], job.root_cell(extent, count), out);
        extent
    });
}

/// Returns the box around the triangles of each group that can be hit, and their number.
fn boxes(triangles: Triangles<'_>, hierarchy: &SceneHierarchy) -> Vec<(Extent, u32)> {
    let nothing = (Extent::EMPTY, 0);
    let both = |a: (Extent, u32), b: (Extent, u32)| (a.0.union(b.0), a.1 + b.1);
    let indices = (0..hierarchy.group_count()).into_par_iter().with_min_len(1 << 8);
    let of_leaf = |index: usize| {
        let usable = hierarchy.ids_in(index)?.iter().filter_map(|&id| triangles.usable_corners(id).ok());
        Some(usable.map(|corners| (Extent::around(corners), 1)).fold(nothing, both))
    };
    let mut groups: Vec<_> = indices.map(|index| of_leaf(index).unwrap_or(nothing)).collect();
    // Groups come before the groups inside of them.
    for index in (0..groups.len()).rev() {
        if hierarchy.ids_in(index).is_none() {
            groups[index] = hierarchy.groups_in(index).map(|inside| groups[inside]).fold(nothing, both);
        }
    }
    groups
}

impl Hierarchical<'_> {
    fn grow(&self, mut units: Vec<Unit>, cell: Cell, out: &mut Branch) {
        let count = units.iter().map(|unit| u64::from(unit.weight())).sum();
        let Some((best, cells)) = self.plane(&mut units, &cell, count) else {
            return self.finish(&mut units, cell, out);
        };
        let children = self.part(&units, &best);
        drop(units);
        let cells =
            Cell::share(cells, children.each_ref().map(|units| units.iter().map(|u| u.weight() as usize).sum()));
        let index = out.open(best.plane);
        let [left, right] = children;
        if count >= PARALLEL {
            let mut right_branch = Branch::default();
            both(|| self.grow(left, cells[0], out), || self.grow(right, cells[1], &mut right_branch));
            out.turn_right(index);
            out.append(&right_branch);
        } else {
            self.grow(left, cells[0], out);
            out.turn_right(index);
            self.grow(right, cells[1], out);
        }
    }

    /// Returns the plane that cuts a cell; `None` if that depends on single triangles. Opens groups until a plane pays.
    fn plane(&self, units: &mut Vec<Unit>, cell: &Cell, count: u64) -> Option<(SplitCandidate, [Cell; 2])> {
        if count < OPEN_BELOW {
            return None;
        }
        let mut parts = PARTS;
        loop {
            self.open(units, &cell.extent, cell.extent.half_area() / parts);
            if units.iter().all(|unit| unit.count == 0) {
                return None;
            }
            // Opened groups have lost their parts outside of the cell.
            let count = units.iter().map(|unit| unit.weight() as usize).sum();
            let boxes: Vec<_> = units.iter().map(|unit| (unit.reference.extent, unit.weight())).collect();
            let best = self.job.best_of_boxes(cell, &boxes);
            if let Some(best) = best.filter(|best| best.cost < self.test_cost * count as f64) {
                return self.job.split(cell, count, best).map(|cells| (best, cells));
            }
            parts *= 8.0;
        }
    }

    /// Opens groups whose part in the cell has more than an area.
    fn open(&self, units: &mut Vec<Unit>, cell: &Extent, area: f64) {
        let mut index = 0;
        while let Some(&unit) = units.get(index) {
            // In cells that are lines or points, any group may matter.
            if unit.count > 0 && (unit.reference.extent.half_area() > area || area == 0.0) {
                units.swap_remove(index);
                self.open_one(unit.reference.id as usize, cell, units);
            } else {
                index += 1;
            }
        }
    }

    fn open_one(&self, group: usize, cell: &Extent, units: &mut Vec<Unit>) {
        if let Some(ids) = self.hierarchy.ids_in(group) {
            let inside = ids.iter().filter_map(|&id| self.inside(id, cell));
            units.extend(inside.map(|reference| Unit { reference, count: 0 }));
            return;
        }
        for id in self.hierarchy.groups_in(group) {
            let (extent, count) = self.groups[id];
            if let Some(extent) = extent.intersection(*cell)
                && count > 0
            {
                units.push(Unit { reference: Reference { extent, id: id as u32 }, count });
            }
        }
    }

    /// Returns a triangle's part in a cell; `None` if it has none, or needn't be listed there.
    fn inside(&self, id: u32, cell: &Extent) -> Option<Reference> {
        let corners = self.job.triangles.usable_corners(id).ok()?;
        let mut reference = Reference { extent: Extent::around(corners), id };
        for axis in 0..3 {
            for (side, at) in [cell.max[axis], cell.min[axis]].into_iter().enumerate() {
                let (low, high) = (reference.extent.min[axis], reference.extent.max[axis]);
                let is_beyond = if side == 0 {
                    low > at || (low == at && low < high)
                } else {
                    high < at || (high == at && low < high)
                };
                if is_beyond {
                    return None;
                }
                if low < at && at < high {
                    let [below, above] = reference.cut(Plane { axis, at }, self.job.clipping, || corners);
                    reference = if side == 0 { below? } else { above? };
                }
            }
        }
        Some(reference)
    }

    fn part(&self, units: &[Unit], best: &SplitCandidate) -> [Vec<Unit>; 2] {
        let [mut left, mut right] = [Vec::with_capacity(units.len()), Vec::with_capacity(units.len())];
        for &unit in units {
            let Unit { reference, count } = unit;
            match reference.sides(best.plane, best.planar_left) {
                Sides::Left => left.push(unit),
                Sides::Right => right.push(unit),
                Sides::Both => {
                    let clipping = if count > 0 { Clipping::Boxes } else { self.job.clipping };
                    let parts = reference.cut(best.plane, clipping, || self.job.triangles.corners(reference.id));
                    let [below, above] = parts.map(|part| part.map(|reference| Unit { reference, count }));
                    left.extend(below);
                    right.extend(above);
                }
            }
        }
        [left, right]
    }

    /// Adds the subtree of all triangles.
    fn finish(&self, units: &mut Vec<Unit>, cell: Cell, out: &mut Branch) {
        let mut groups: Vec<_> = units.iter().filter(|unit| unit.count > 0).map(|unit| unit.reference.id).collect();
        units.retain(|unit| unit.count == 0);
        while let Some(group) = groups.pop() {
            let first = units.len();
            self.open_one(group as usize, &cell.extent, units);
            // A group holds either groups or triangles.
            if units.get(first).is_some_and(|unit| unit.count > 0) {
                groups.extend(units.drain(first..).map(|unit| unit.reference.id));
            }
        }
        let mut references: Vec<_> = units.iter().map(|unit| unit.reference).collect();
        references.sort_unstable_by_key(|reference| reference.id);
        self.job.grow_references(&references, self.whole, self.builder, cell, out);
    }
}
