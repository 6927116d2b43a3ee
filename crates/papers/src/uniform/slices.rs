use std::ops::ControlFlow;
use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::Relaxed;

use fearless_simd::Simd;

use super::UniformGrid;
use super::cells::Cells;
use super::frustum::Frustum;
use super::lattice::Lattice;
use crate::packet::{Common, LANES, Mailbox, Planes, Query, Space};
use crate::statistics::Statistics;
use umbrage_rays::Triangles;
use umbrage_rays::simd::lanes::bits_of;
use umbrage_rays::vectorized;

/// Tests the triangles that a packet comes across.
pub(super) trait Visitor {
    /// Whether nothing matters that rays reach at `way` cells along the major axis, or later.
    fn is_done(&self, way: f64) -> bool;

    /// Tests up to 16 triangles.
    fn test<S: Simd>(&mut self, simd: S, ids: &[u32], planes: &mut Planes, statistics: &mut Statistics);
}

/// The visitor for rays with a common origin or direction.
struct Coherent<'a, Q> {
    space: &'a Space,
    triangles: Triangles<'a>,
    /// Units of the space per cell.
    scale: f64,
    query: &'a mut Q,
}

impl<Q: Query> Visitor for Coherent<'_, Q> {
    #[inline(always)]
    fn is_done(&self, way: f64) -> bool {
        let (w, least) = (way * self.scale, f64::from(self.query.least_nearness()));
        match self.space.common {
            Common::Origin => w > 0.0 && least * w > 1.0 + 1e-6,
            Common::Direction => least > -w + 1e-9 * w.abs(),
        }
    }

    /// Rules out triangles that all rays miss on the same edge, and those behind the hits.
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, ids: &[u32], planes: &mut Planes, statistics: &mut Statistics) {
        planes.set_up(simd, self.space, self.triangles, ids);
        let all = (1_u64 << ids.len()) - 1;
        let inside = all & !planes.missed;
        let lanes = planes.reaching(simd, inside, self.query.least_nearness());
        statistics.note(|counts| {
            counts.frustum_culls += u64::from((all & !inside).count_ones());
            counts.depth_culls += u64::from((inside & !lanes).count_ones());
            counts.tests += u64::from(lanes.count_ones());
        });
        for lane in bits_of(lanes) {
            self.query.test(simd, planes, lane, ids[lane]);
        }
    }
}

/// Memory for tracing packets, one after the other.
#[derive(Default)]
pub(super) struct Scratch {
    mailbox: Mailbox,
    planes: Planes,
    /// Listed triangles, waiting for a common test against the frustum.
    listed: Queue<LANES>,
    /// Triangles that may be inside, waiting for a common test.
    inside: Queue<{ 2 * LANES }>,
    pub(super) statistics: Statistics,
}

/// Waiting triangles.
struct Queue<const N: usize> {
    ids: [u32; N],
    count: usize,
}

impl<const N: usize> Default for Queue<N> {
    fn default() -> Self {
        Self { ids: [0; N], count: 0 }
    }
}

impl<const N: usize> Queue<N> {
    /// Whether there are enough triangles for a common test, though more would fit.
    fn is_half_full(&self) -> bool {
        self.count >= LANES / 2
    }

    #[inline(always)]
    fn push(&mut self, id: u32) {
        self.ids[self.count] = id;
        self.count += 1;
    }
}

/// A packet's bounds in cell coordinates, as linear functions of w, the distance along the major axis in cells.
///
/// A box is (lowest u, −highest u, lowest v, −highest v), so that one addition moves it to the next slice, and the minimum
/// of two boxes holds both (Wald et al. 2006, §2.2).
#[derive(Clone, Copy, Debug)]
pub(super) struct Beam {
    /// The box at w = 0.
    pub(super) base: [f64; 4],
    /// Its change per cell of w.
    pub(super) rate: [f64; 4],
    /// The world axes of u, v and w.
    pub(super) axes: [usize; 3],
    /// −1 where w falls along its axis, else 1.
    pub(super) sign: f64,
    /// The coordinate of w = 0 on the major axis.
    pub(super) start: f64,
    /// The growth of the box, and the error bound of the slices' w.
    ///
    /// Cell coordinates of the origin, products with slopes and up to 2¹² additions have an error of 2⁻⁴⁰ of the largest
    /// number involved; the lattice's doubt is added. Slopes and coordinates of all rays are inside the packet's extent,
    /// which includes their own errors.
    pub(super) slack: f64,
}

impl Beam {
    fn new(lattice: &Lattice, space: &Space) -> Self {
        let origin = lattice.coordinates(space.origin);
        let scale = 1.0 / (space.unit * lattice.side);
        let mut beam = Self {
            base: [0.0; 4],
            rate: [0.0; 4],
            axes: space.axes,
            sign: space.sign,
            start: origin[space.axes[2]],
            slack: 0.0,
        };
        for axis in 0..2 {
            let (at, slope, half) = (origin[space.axes[axis]], space.slope[axis], space.half[axis]);
            let ([low, high], [low_rate, high_rate]) = match space.common {
                Common::Origin => ([at, at], [slope - half, slope + half]),
                Common::Direction => {
                    let at = at + space.shift[axis] * scale;
                    ([at - half * scale, at + half * scale], [slope, slope])
                }
            };
            (beam.base[2 * axis], beam.base[2 * axis + 1]) = (low, -high);
            (beam.rate[2 * axis], beam.rate[2 * axis + 1]) = (low_rate, -high_rate);
        }
        const ROUNDINGS: f64 = 1.0 / (1_u64 << 40) as f64;
        let most = |values: [f64; 4]| values.into_iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let way = origin.abs().max_element() + f64::from(lattice.cells.max_element());
        beam.slack = Lattice::DOUBT + ROUNDINGS * (most(beam.base) + (1.0 + most(beam.rate)) * way);
        beam
    }

    /// The box at w, without growth.
    #[inline(always)]
    fn at(&self, w: f64) -> [f64; 4] {
        std::array::from_fn(|bound| self.base[bound] + self.rate[bound] * w)
    }

    /// The same beam in the cell coordinates of a lattice inside of a cell of `outer`.
    ///
    /// The zero of w stays. An error in cells of the outer lattice is larger in the smaller ones, and the roundings on the
    /// way there are relative to the same numbers: twice the error covers both.
    fn inside(&self, outer: &Lattice, inner: &Lattice) -> Self {
        let scale = outer.side / inner.side;
        let corner = (inner.corner - outer.corner) * (1.0 / outer.side);
        let [u, v, w] = self.axes;
        let shift = [-corner[u], corner[u], -corner[v], corner[v]];
        Self {
            base: std::array::from_fn(|bound| (self.base[bound] + shift[bound]) * scale),
            start: (self.start - corner[w]) * scale,
            slack: Lattice::DOUBT + 2.0 * scale * (self.slack - Lattice::DOUBT),
            ..*self
        }
    }

    /// The w at which a ray enters the first slice in the order of travel.
    pub(super) fn first(&self, cells: u32) -> f64 {
        if self.sign > 0.0 { -self.start } else { self.start - f64::from(cells) }
    }
}

/// The first and last cells along u and v that a box overlaps; `None` if it is beside the lattice.
#[inline(always)]
fn overlapped(bounds: [f64; 4], slack: f64, cells: [u32; 2]) -> Option<[[u32; 2]; 2]> {
    let [low_u, high_u, low_v, high_v] = [bounds[0] - slack, slack - bounds[1], bounds[2] - slack, slack - bounds[3]];
    let [columns, rows] = cells.map(f64::from);
    if high_u < 0.0 || low_u > columns || high_v < 0.0 || low_v > rows {
        return None;
    }
    // Conversions to integers truncate, and clamp negative numbers to zero.
    let [last_u, last_v] = cells.map(|cells| cells - 1);
    let range = |low: f64, high: f64, last: u32| [(low as u32).min(last), (high as u32).min(last)];
    Some([range(low_u, high_u, last_u), range(low_v, high_v, last_v)])
}

#[inline(always)]
fn union(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    std::array::from_fn(|bound| a[bound].min(b[bound]))
}

#[inline(always)]
fn sum(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    std::array::from_fn(|bound| a[bound] + b[bound])
}

/// A packet on its way through the grid.
struct Walk<'a> {
    cells: Cells<'a>,
    triangles: Triangles<'a>,
    frustum: &'a Frustum,
    beam: Beam,
    /// Cells along u, v and w.
    counts: [u32; 3],
    /// The first and the last w of the rays, in cells.
    within: [f64; 2],
    /// The w at which slice 0 begins.
    first: f64,
    /// Edge of a cell, in cells of the scene.
    side: f64,
}

impl UniformGrid {
    /// Tests a packet's rays against the triangles in all cells that the packet overlaps from one w of its space to another,
    /// slice by slice, until nothing can change the answers any more (Wald et al. 2006, §2.2).
    #[inline(always)]
    pub(super) fn visit_slices<S: Simd, Q: Query>(
        &self,
        simd: S,
        triangles: Triangles<'_>,
        space: &Space,
        within: [f64; 2],
        scratch: &mut Scratch,
        query: &mut Q,
    ) {
        let Some(lattice) = self.lattice else { return };
        let beam = Beam::new(&lattice, space);
        let scale = space.unit * lattice.side;
        let within = within.map(|w| w * (1.0 / scale));
        self.visit_beam(simd, triangles, beam, within, scratch, &mut Coherent { space, triangles, scale, query });
    }

    /// Lets `visitor` test the triangles in all cells that a beam overlaps from one w to another, in cells.
    #[inline(always)]
    pub(super) fn visit_beam<S: Simd, V: Visitor>(
        &self,
        simd: S,
        triangles: Triangles<'_>,
        beam: Beam,
        within: [f64; 2],
        scratch: &mut Scratch,
        visitor: &mut V,
    ) {
        let Some(cells) = self.scene_cells() else { return };
        let frustum = Frustum::new(&cells.lattice, &beam, &self.bounds);
        let walk = Walk::new(cells, triangles, &frustum, beam, within, 1.0);
        scratch.mailbox.clear();
        (scratch.listed.count, scratch.inside.count) = (0, 0);
        scratch.statistics.note(|counts| counts.packets += 1);
        let _ = walk.run(simd, scratch, visitor);
        walk.cull(simd, scratch, visitor);
        walk.test(simd, scratch, visitor);
    }
}

impl<'a> Walk<'a> {
    #[inline(always)]
    fn new(
        cells: Cells<'a>,
        triangles: Triangles<'a>,
        frustum: &'a Frustum,
        beam: Beam,
        within: [f64; 2],
        side: f64,
    ) -> Self {
        let counts = beam.axes.map(|axis| cells.lattice.cells[axis]);
        Self { cells, triangles, frustum, beam, counts, within, first: beam.first(counts[2]), side }
    }

    /// The first and the last slice, in order of travel. From very far away all have the same w in f64, and the slack covers
    /// the difference.
    fn slices(&self) -> Option<[u32; 2]> {
        let slack = self.beam.slack;
        let [enter, leave] = self.within.map(|w| w - self.first);
        let is_beside = enter - slack > f64::from(self.counts[2]) + slack || leave + slack < -slack;
        // Conversions to integers truncate, and clamp negative numbers to zero.
        let slice = |at: f64| (at as u32).min(self.counts[2] - 1);
        let [first, last] = [slice(enter - slack), slice(leave + slack)];
        (!is_beside && first <= last).then_some([first, last])
    }

    /// The cell on the major axis of a slice in order of travel, and the number of slices left of its macrocell.
    #[inline(always)]
    fn layer(&self, slice: u32) -> (u32, u32) {
        let side = self.cells.macrocells.side;
        if self.beam.sign > 0.0 {
            (slice, side - slice % side)
        } else {
            let layer = self.counts[2] - 1 - slice;
            (layer, layer % side + 1)
        }
    }

    /// The w at which a slice begins.
    #[inline(always)]
    fn enter(&self, slice: u32) -> f64 {
        self.first + f64::from(slice)
    }

    #[inline(always)]
    fn run<S: Simd, V: Visitor>(&self, simd: S, scratch: &mut Scratch, visitor: &mut V) -> ControlFlow<()> {
        let Some([mut slice, last]) = self.slices() else { return ControlFlow::Continue(()) };
        while slice <= last {
            let (_, left) = self.layer(slice);
            let end = (slice + left).min(last + 1);
            let mut near = self.beam.at(self.enter(slice).max(self.within[0]));
            let far = self.beam.at(self.enter(end));
            if self.is_occupied(union(near, far), slice) {
                let mut next = self.beam.at(self.enter(slice + 1));
                for slice in slice..end {
                    if visitor.is_done((self.enter(slice) - 2.0 * self.beam.slack) * self.side) {
                        return ControlFlow::Break(());
                    }
                    self.visit_slice(simd, union(near, next), slice, scratch, visitor);
                    near = next;
                    next = sum(next, self.beam.rate);
                }
            }
            slice = end;
        }
        ControlFlow::Continue(())
    }

    /// Whether a macrocell of a slice's layer that a box overlaps holds triangles.
    #[inline(always)]
    fn is_occupied(&self, bounds: [f64; 4], slice: u32) -> bool {
        let cells = [self.counts[0], self.counts[1]];
        let Some([columns, rows]) = overlapped(bounds, self.beam.slack, cells) else { return false };
        let macrocells = self.cells.macrocells;
        let side = macrocells.side;
        let [u, v, w] = self.beam.axes;
        let mut cell = [0; 3];
        cell[w] = self.layer(slice).0 / side;
        (rows[0] / side..=rows[1] / side).any(|row| {
            (columns[0] / side..=columns[1] / side).any(|column| {
                (cell[u], cell[v]) = (column, row);
                macrocells.is_occupied(cell[0], cell[1], cell[2])
            })
        })
    }

    /// Tests the triangles in the cells of a slice that a box overlaps.
    #[inline(always)]
    fn visit_slice<S: Simd, V: Visitor>(
        &self,
        simd: S,
        bounds: [f64; 4],
        slice: u32,
        scratch: &mut Scratch,
        visitor: &mut V,
    ) {
        let cells = [self.counts[0], self.counts[1]];
        let Some([columns, rows]) = overlapped(bounds, self.beam.slack, cells) else { return };
        let [u, v, w] = self.beam.axes;
        let mut cell = [0; 3];
        cell[w] = self.layer(slice).0;
        for row in rows[0]..=rows[1] {
            cell[v] = row;
            cell[u] = columns[0];
            let first = self.cells.lattice.index(cell[0], cell[1], cell[2]);
            scratch.statistics.note(|counts| counts.cells += u64::from(columns[1] - columns[0] + 1));
            if u == 0 {
                // Adjacent in memory.
                self.list(simd, first, first + (columns[1] - columns[0]) as usize, scratch, visitor);
            } else {
                let stride = self.cells.lattice.cells.x as usize;
                for column in 0..=(columns[1] - columns[0]) as usize {
                    self.list(simd, first + column * stride, first + column * stride, scratch, visitor);
                }
            }
        }
        // The next slice may add a few more, but hits end the walk early.
        if scratch.listed.is_half_full() {
            self.cull(simd, scratch, visitor);
        }
        if scratch.inside.is_half_full() {
            self.test(simd, scratch, visitor);
        }
    }

    /// Queues the triangles of some consecutive cells.
    #[inline(always)]
    fn list<S: Simd, V: Visitor>(&self, simd: S, first: usize, last: usize, scratch: &mut Scratch, visitor: &mut V) {
        let ids = self.cells.listed(first, last);
        if ids.len() > self.cells.most {
            return self.visit_crowds(simd, first, last, scratch, visitor);
        }
        self.wait(simd, ids, scratch, visitor);
    }

    /// Visits some consecutive cells, some of which may hold grids. Not inlined, since it is recursive.
    #[cold]
    #[inline(never)]
    fn visit_crowds<S: Simd, V: Visitor>(
        &self,
        simd: S,
        first: usize,
        last: usize,
        scratch: &mut Scratch,
        visitor: &mut V,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                for index in first..=last {
                    let ids = self.cells.listed(index, index);
                    match self.cells.inside(index).map(|inside| self.inside(inside)) {
                        Some(walk) if walk.is_shorter_than(ids.len()) => {
                            let _ = walk.run(simd, scratch, visitor);
                        }
                        _ => self.wait(simd, ids, scratch, visitor),
                    }
                }
            },
        );
    }

    /// The packet's walk through the cells inside of a cell.
    fn inside(&self, inside: Cells<'a>) -> Self {
        let (outer, inner) = (&self.cells.lattice, &inside.lattice);
        let scale = outer.side / inner.side;
        let within = self.within.map(|w| w * scale);
        let beam = self.beam.inside(outer, inner);
        Walk::new(inside, self.triangles, self.frustum, beam, within, self.side / scale)
    }

    /// Whether the packet would visit fewer cells than there are triangles: for packets much wider than cells, testing the
    /// triangles is faster.
    fn is_shorter_than(&self, triangles: usize) -> bool {
        let Some([first, last]) = self.slices() else { return true };
        // Before the rays start, the box may be inverted.
        let near = self.enter(first).max(self.within[0]);
        let far = self.enter(last + 1).min(self.within[1]).max(near);
        let middle = self.beam.at(0.5 * (near + far));
        let width = overlapped(middle, self.beam.slack, [self.counts[0], self.counts[1]]);
        let visited = width.map_or(0, |[[left, right], [low, high]]| (right - left + 1) * (high - low + 1));
        u64::from(visited) * u64::from(last - first + 1) < triangles as u64
    }

    /// Queues triangles for their test, except those tested before.
    #[inline(always)]
    fn wait<S: Simd, V: Visitor>(&self, simd: S, ids: &[AtomicU32], scratch: &mut Scratch, visitor: &mut V) {
        for id in ids {
            let id = id.load(Relaxed);
            if !scratch.mailbox.is_new(id) {
                scratch.statistics.note(|counts| counts.mailbox_hits += 1);
                continue;
            }
            scratch.listed.push(id);
            if scratch.listed.count == LANES {
                self.cull(simd, scratch, visitor);
            }
        }
    }

    /// Queues the listed triangles that may be inside the frustum. Not inlined, since it is long and called from several
    /// places.
    #[inline(never)]
    fn cull<S: Simd, V: Visitor>(&self, simd: S, scratch: &mut Scratch, visitor: &mut V) {
        let Scratch { listed, inside, statistics, .. } = scratch;
        let ids = &listed.ids[..std::mem::take(&mut listed.count)];
        let all = (1_u64 << ids.len()) - 1;
        let missed = vectorized!(simd => self.frustum.missed(simd, self.triangles, ids));
        statistics.note(|counts| counts.frustum_culls += u64::from((all & missed).count_ones()));
        bits_of(all & !missed).for_each(|lane| inside.push(ids[lane]));
        if inside.count >= LANES {
            self.test(simd, scratch, visitor);
        }
    }

    /// Tests the first queued triangles. Not inlined, since it is long and called from several places.
    #[inline(never)]
    fn test<S: Simd, V: Visitor>(&self, simd: S, scratch: &mut Scratch, visitor: &mut V) {
        let Scratch { planes, inside, statistics, .. } = scratch;
        let count = inside.count.min(LANES);
        if count > 0 {
            vectorized!(simd => visitor.test(simd, &inside.ids[..count], planes, statistics));
            inside.ids.copy_within(count..inside.count, 0);
            inside.count -= count;
        }
    }
}
