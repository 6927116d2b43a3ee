use std::ops::ControlFlow;
use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::Relaxed;

use glam::{DVec3, IVec3};

use super::UniformGrid;
use super::cells::Cells;
use super::lattice::Lattice;
use super::macrocells::Blocks;
use crate::single::{Visit, answers_single_rays};
use crate::statistics::Steps;
use umbrage_rays::{Ray, Triangles};

answers_single_rays!(UniformGrid);

impl Visit for UniformGrid {
    /// Calls `test` with every triangle in a cell that `ray` visits before `t_max`, nearer cells first. `test` may lower
    /// `t_max` or break off. Some triangles are tested more than once.
    fn visit(
        &self,
        _: Triangles<'_>,
        ray: &Ray,
        test: impl FnMut(u32, &mut f64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let Some(cells) = self.scene_cells() else { return ControlFlow::Continue(()) };
        let mut steps = Steps::new(&self.visits);
        steps.note(|counts| counts.rays += 1);
        let mut search = Search { ray, t_max: ray.t_max, mailbox: [u32::MAX; MAILBOX], steps, test };
        search.visit(&cells, &self.ids)
    }
}

/// A ray's search.
struct Search<'a, F> {
    ray: &'a Ray,
    /// Hits behind this t don't matter.
    t_max: f64,
    mailbox: [u32; MAILBOX],
    steps: Steps<'a>,
    test: F,
}

impl<F: FnMut(u32, &mut f64) -> ControlFlow<()>> Search<'_, F> {
    /// Tests the triangles in the cells that the ray visits, or all of `all` if its start is too far away to know these
    /// cells.
    #[inline(always)]
    fn visit(&mut self, cells: &Cells<'_>, all: &[AtomicU32]) -> ControlFlow<()> {
        let line = CellRay::new(&cells.lattice, self.ray);
        if !line.is_exact_enough() {
            return self.test(all);
        }
        let Some((t_enter, t_leave)) = line.clip(self.ray.t_min, self.t_max) else {
            return ControlFlow::Continue(());
        };
        let mut walk = Walk::start(&line, t_enter);
        loop {
            let skipped = skip_empty(cells.macrocells, &line, &mut walk, t_leave.min(self.t_max));
            if skipped.is_break() {
                return ControlFlow::Continue(());
            }
            let [x, y, z] = walk.cell.to_array().map(|at| at as u32);
            let index = cells.lattice.index(x, y, z);
            self.steps.note(|counts| counts.cells += 1);
            let listed = cells.listed(index, index);
            if listed.len() <= cells.most {
                self.test(listed)?;
            } else {
                self.visit_crowd(cells, index, listed)?;
            }
            if walk.step(&line, t_leave.min(self.t_max)).is_break() {
                return ControlFlow::Continue(());
            }
        }
    }

    /// Visits the grid inside of a cell, if there is one. Not inlined, since it is recursive.
    #[cold]
    #[inline(never)]
    fn visit_crowd(&mut self, cells: &Cells<'_>, index: usize, listed: &[AtomicU32]) -> ControlFlow<()> {
        match cells.inside(index) {
            Some(inside) => self.visit(&inside, listed),
            None => self.test(listed),
        }
    }

    #[inline(always)]
    fn test(&mut self, ids: &[AtomicU32]) -> ControlFlow<()> {
        for id in ids.iter().map(|id| id.load(Relaxed)) {
            // Neighbouring cells mostly share triangles.
            if std::mem::replace(&mut self.mailbox[id as usize % MAILBOX], id) == id {
                self.steps.note(|counts| counts.mailbox_hits += 1);
            } else {
                self.steps.note(|counts| counts.tests += 1);
                (self.test)(id, &mut self.t_max)?;
            }
        }
        ControlFlow::Continue(())
    }
}

/// Walks out of empty macrocells; breaks at the end of the walk.
#[inline(always)]
fn skip_empty(macrocells: Blocks<'_>, line: &CellRay, walk: &mut Walk, t_max: f64) -> ControlFlow<()> {
    let side = macrocells.side as i32;
    loop {
        let macrocell = walk.cell / side;
        let [x, y, z] = macrocell.to_array().map(|at| at as u32);
        if macrocells.is_occupied(x, y, z) {
            return ControlFlow::Continue(());
        }
        walk.leave(line, macrocell * side, side, t_max)?;
    }
}

/// Slots for triangles that a ray has tested (Kirk and Arvo, *Improved Ray Tagging for Voxel-Based Ray Tracing*, 1991).
const MAILBOX: usize = 16;

/// A ray in cell coordinates; t is the ray's own.
///
/// Computed crossings with the cells' faces, and distances along the ray inside the lattice, have a few roundings of the
/// origin's coordinates and the number of cells. So their error is less than [`CellRay::ROUNDINGS`] of the sum of these, in
/// cells, and rays for which that is at most [`Lattice::DOUBT`] find their hits (see [`Lattice`]). Between two computed
/// crossings the ray is in the current cell to within that doubt, on every axis; and so are hits with the same t as the one
/// that ends the walk.
struct CellRay {
    origin: DVec3,
    direction: DVec3,
    inverse: DVec3,
    /// Number of cells along each axis.
    cells: IVec3,
}

impl CellRay {
    const ROUNDINGS: f64 = 1.0 / (1_u64 << 48) as f64;

    /// The largest distance outside of the lattice, in cells, at which a ray is still followed.
    const SLACK: f64 = Lattice::MARGIN;

    fn new(lattice: &Lattice, ray: &Ray) -> Self {
        let direction = ray.direction * (1.0 / lattice.side);
        let origin = lattice.coordinates(ray.origin);
        Self { origin, direction, inverse: direction.recip(), cells: lattice.cells.as_ivec3() }
    }

    fn is_exact_enough(&self) -> bool {
        let reach = self.origin.abs().max_element() + f64::from(self.cells.max_element());
        reach * Self::ROUNDINGS <= Lattice::DOUBT
    }

    /// Whether the ray never leaves a cell along an axis.
    #[inline(always)]
    fn is_along(&self, axis: usize) -> bool {
        !self.inverse[axis].is_finite()
    }

    /// The t at which the ray reaches a coordinate; infinite if it runs along it.
    #[inline(always)]
    fn t_at(&self, axis: usize, coordinate: f64) -> f64 {
        if self.is_along(axis) { f64::INFINITY } else { (coordinate - self.origin[axis]) * self.inverse[axis] }
    }

    /// The interval of t in which the ray is inside the lattice, grown by the slack; `None` if there is no such t.
    fn clip(&self, t_min: f64, t_max: f64) -> Option<(f64, f64)> {
        let (mut enter, mut leave) = (t_min, t_max);
        for axis in 0..3 {
            let (low, high) = (-Self::SLACK, f64::from(self.cells[axis]) + Self::SLACK);
            if self.is_along(axis) {
                if !(low..=high).contains(&self.origin[axis]) {
                    return None;
                }
                continue;
            }
            let (a, b) = (self.t_at(axis, low), self.t_at(axis, high));
            (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
        }
        (enter <= leave).then_some((enter, leave))
    }

    /// The cell on an axis that the ray is in at t.
    #[inline(always)]
    fn cell_at(&self, axis: usize, t: f64) -> i32 {
        let along = if self.is_along(axis) { 0.0 } else { self.direction[axis] * t };
        // Conversions to integers truncate, and turn NaN into zero.
        ((self.origin[axis] + along) as i32).clamp(0, self.cells[axis] - 1)
    }
}

/// A ray's position on its way from cell to cell (Amanatides and Woo, *A Fast Voxel Traversal Algorithm for Ray Tracing*,
/// 1987).
struct Walk {
    cell: IVec3,
    step: IVec3,
    /// The t at which the ray leaves its cell on each axis.
    t_next: DVec3,
}

impl Walk {
    fn start(line: &CellRay, t: f64) -> Self {
        let step = IVec3::from_array(line.direction.to_array().map(|component| if component < 0.0 { -1 } else { 1 }));
        let cell = IVec3::from_array([0, 1, 2].map(|axis| line.cell_at(axis, t)));
        let mut walk = Self { cell, step, t_next: DVec3::INFINITY };
        (0..3).for_each(|axis| walk.look_ahead(line, axis));
        walk
    }

    /// Finds the t at which the ray leaves its cell along an axis.
    #[inline(always)]
    fn look_ahead(&mut self, line: &CellRay, axis: usize) {
        let face = self.cell[axis] + self.step[axis].max(0);
        self.t_next[axis] = line.t_at(axis, f64::from(face));
    }

    /// Moves to the next cell; breaks if it is outside of the lattice or behind `t_max`.
    #[inline(always)]
    fn step(&mut self, line: &CellRay, t_max: f64) -> ControlFlow<()> {
        let axis = smallest(self.t_next);
        let is_over = self.t_next[axis] > t_max;
        self.cell[axis] += self.step[axis];
        if is_over || !(0..line.cells[axis]).contains(&self.cell[axis]) {
            return ControlFlow::Break(());
        }
        self.look_ahead(line, axis);
        ControlFlow::Continue(())
    }

    /// Moves to the cell behind the block of `side`³ cells that starts at `low`; breaks as [`step`](Self::step) does.
    #[inline(always)]
    fn leave(&mut self, line: &CellRay, low: IVec3, side: i32, t_max: f64) -> ControlFlow<()> {
        let high = (low + side).min(line.cells);
        let face = |axis: usize| if self.step[axis] > 0 { high[axis] } else { low[axis] };
        let t_leave = DVec3::from_array([0, 1, 2].map(|axis| line.t_at(axis, f64::from(face(axis)))));
        let leaves = smallest(t_leave);
        let t = t_leave[leaves];
        if t > t_max {
            return ControlFlow::Break(());
        }
        for axis in 0..3 {
            self.cell[axis] = if axis == leaves {
                if self.step[axis] > 0 { high[axis] } else { low[axis] - 1 }
            } else {
                line.cell_at(axis, t).clamp(low[axis], high[axis] - 1)
            };
        }
        if !(0..line.cells[leaves]).contains(&self.cell[leaves]) {
            return ControlFlow::Break(());
        }
        (0..3).for_each(|axis| self.look_ahead(line, axis));
        ControlFlow::Continue(())
    }
}

/// The axis of the smallest component.
#[inline(always)]
fn smallest(t: DVec3) -> usize {
    if t.x <= t.y {
        if t.x <= t.z { 0 } else { 2 }
    } else if t.y <= t.z {
        1
    } else {
        2
    }
}
