//! Grids inside of cells, for scenes of very uneven density, such as a teapot in a stadium: a cell that lists many
//! triangles holds a grid over their parts inside of it, and so may that grid's cells.
//!
//! **Why nothing is missed.** Such a grid is one like the scene's: a lattice of its own, with the same margins in cells of
//! its own, around the triangles' box, cut where the cell, grown by twice the margin, ends. A traversal visits a cell
//! that is no farther than [`Lattice::DOUBT`] from the hit that it has to find there (see [`Lattice`]), so that the hit is
//! inside of the box. There the lattice's own argument holds, for traversals that know where the ray is to within
//! [`Lattice::DOUBT`] in *its* cells. A single ray from too far away to be known that well is tested against all
//! triangles that the outer cell lists instead; packets grow by what they may be wrong by.
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
    /// Where each cell's ids start, grid after grid; the first [`cell_count`](Self::cell_count) and one further.
    starts: Vec<AtomicU32>,
    /// Triangle ids, cell after cell, ascending in each; the first [`references`](Self::references).
    ids: Vec<AtomicU32>,
    occupied: Vec<bool>,
    /// Which grid a cell holds, for every [`interval`](Self::interval) references: at most one cell with more of them
    /// starts in each. Those of the scene's references come first.
    held: Vec<Option<u32>>,
    scene_intervals: usize,
    /// References in a row for which there is one slot in `held`; zero where no cell holds a grid.
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
    /// The grid inside of the cell whose references start at `start`, and are more than [`Nested::most`].
    #[inline(never)]
    pub(super) fn at(&self, start: u32) -> Option<Cells<'a>> {
        let grid = self.held[(start / self.nested.interval) as usize]?;
        Some(self.nested.cells(&self.nested.grids[grid as usize]))
    }
}

impl Nested {
    /// How many grids there are.
    pub(super) fn len(&self) -> usize {
        self.grids.len()
    }

    pub(super) fn references(&self) -> usize {
        self.references
    }

    /// Most references of a cell that certainly holds no grid.
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
