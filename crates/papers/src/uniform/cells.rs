use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::Relaxed;

use super::UniformGrid;
use super::lattice::Lattice;
use super::macrocells::Blocks;
use super::nested::Inside;

/// The cells of one lattice and the triangles that they list: those of the scene, or those inside of a cell of another
/// lattice.
#[derive(Clone, Copy)]
pub(super) struct Cells<'a> {
    pub(super) lattice: Lattice,
    pub(super) macrocells: Blocks<'a>,
    /// The start of each cell's ids, and finally the end of the last cell's.
    pub(super) starts: &'a [AtomicU32],
    pub(super) ids: &'a [AtomicU32],
    /// The grids inside of cells that list more triangles than `most`.
    pub(super) inside: Inside<'a>,
    pub(super) most: usize,
}

impl<'a> Cells<'a> {
    /// The references of the cells from one index to another, both included.
    #[inline(always)]
    pub(super) fn listed(&self, first: usize, last: usize) -> &'a [AtomicU32] {
        &self.ids[self.starts[first].load(Relaxed) as usize..self.starts[last + 1].load(Relaxed) as usize]
    }

    /// The cells inside of the cell at an index; `None` if it only lists triangles.
    pub(super) fn inside(&self, index: usize) -> Option<Self> {
        if self.listed(index, index).len() <= self.most {
            return None;
        }
        self.inside.at(self.starts[index].load(Relaxed))
    }
}

impl UniformGrid {
    /// The cells of the scene; `None` before the first build.
    #[inline(always)]
    pub(super) fn scene_cells(&self) -> Option<Cells<'_>> {
        Some(Cells {
            lattice: self.lattice?,
            macrocells: self.macrocells.blocks(),
            starts: &self.starts,
            ids: &self.ids,
            inside: self.nested.in_scene(),
            most: self.nested.most(),
        })
    }
}
