//! Grids inside of cells, for scenes of very uneven density, such as a teapot in a stadium: a cell that lists many
//! triangles holds a grid over their parts inside of it, and so may that grid's cells.
//!
//! **Why no hit is missed.** Such a grid is like the scene's: a lattice of its own, with the same margins in its own cells,
//! around the triangles' box, cut at the cell grown by twice the margin. A traversal visits a cell no farther than
//! [`Lattice::DOUBT`] from the hit that it has to find there (see [`Lattice`]), so the hit is inside of the box. There the
//! lattice's own argument holds, for traversals that know the ray's position to within [`Lattice::DOUBT`] in *its* cells. If
//! a single ray starts too far away for that precision, it is tested against all triangles of the outer cell instead;
//! packets grow by their error.
//!
//! `build` chooses the cells and makes their grids.

mod build;

use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::Relaxed;

use glam::UVec3;

use super::cells::Cells;
use super::lattice::Lattice;
use super::macrocells::Blocks;
use build::Building;

/// The grids inside of cells, in the order of those cells, those inside of the scene's first.
#[derive(Default)]
pub(super) struct Nested {
    grids: Vec<NestedGrid>,
    /// The start of each cell's ids, grid after grid; the first [`cell_count`](Self::cell_count) and one more are valid.
    starts: Vec<AtomicU32>,
    /// Triangle ids, cell after cell, ascending in each; the first [`references`](Self::references) are valid.
    ids: Vec<AtomicU32>,
    occupied: Vec<bool>,
    /// The grid that a cell holds, for every [`interval`](Self::interval) references: at most one cell with more references
    /// starts in each interval. Those of the scene's references come first.
    held: Vec<Option<u32>>,
    scene_intervals: usize,
    /// Consecutive references per slot of `held`; zero where no cell holds a grid.
    interval: u32,
    cell_count: usize,
    references: usize,
    macrocell: u32,
    building: Building,
}

/// A grid inside of a cell. 72 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct NestedGrid {
    lattice: Lattice,
    /// Macrocells along each axis.
    macrocells: UVec3,
    /// Indices of the first cell and the first macrocell.
    first: u32,
    first_macrocell: u32,
}

/// The grids inside of the cells of one lattice.
#[derive(Clone, Copy)]
pub(super) struct Inside<'a> {
    nested: &'a Nested,
    held: &'a [Option<u32>],
}

impl<'a> Inside<'a> {
    /// The grid inside of the cell whose references start at `start`, if they are more than [`Nested::most`].
    #[inline(never)]
    pub(super) fn at(&self, start: u32) -> Option<Cells<'a>> {
        let grid = self.held[(start / self.nested.interval) as usize]?;
        Some(self.nested.cells(&self.nested.grids[grid as usize]))
    }
}

impl Nested {
    /// The number of grids.
    pub(super) fn len(&self) -> usize {
        self.grids.len()
    }

    pub(super) fn references(&self) -> usize {
        self.references
    }

    /// The largest number of references of a cell that certainly holds no grid.
    #[inline(always)]
    pub(super) fn most(&self) -> usize {
        if self.grids.is_empty() { usize::MAX } else { self.interval as usize }
    }

    #[inline(always)]
    pub(super) fn in_scene(&self) -> Inside<'_> {
        Inside { nested: self, held: &self.held[..self.scene_intervals] }
    }

    fn cells(&self, grid: &NestedGrid) -> Cells<'_> {
        let NestedGrid { lattice, macrocells, first, first_macrocell } = *grid;
        let occupied = &self.occupied[first_macrocell as usize..][..macrocells.element_product() as usize];
        Cells {
            lattice,
            macrocells: Blocks { side: self.macrocell, count: macrocells, occupied },
            starts: &self.starts[first as usize..=first as usize + lattice.len()],
            ids: &self.ids[..self.references],
            inside: Inside { nested: self, held: &self.held[self.scene_intervals..] },
            most: self.interval as usize,
        }
    }

    pub(super) fn bytes(&self) -> usize {
        (self.starts.capacity() + self.ids.capacity()) * size_of::<AtomicU32>()
            + self.grids.capacity() * size_of::<NestedGrid>()
            + self.occupied.capacity()
            + self.held.capacity() * size_of::<Option<u32>>()
            + self.building.bytes()
    }

    pub(super) fn is_same_as(&self, other: &Self) -> bool {
        let starts = |nested: &Self| nested.grids.last().map_or(0, |_| nested.cell_count + 1);
        let same = |a: &[AtomicU32], b: &[AtomicU32]| a.iter().map(load).eq(b.iter().map(load));
        self.grids == other.grids
            && same(&self.starts[..starts(self)], &other.starts[..starts(other)])
            && same(&self.ids[..self.references], &other.ids[..other.references])
            && (self.scene_intervals, &self.held) == (other.scene_intervals, &other.held)
    }
}

fn load(number: &AtomicU32) -> u32 {
    number.load(Relaxed)
}
