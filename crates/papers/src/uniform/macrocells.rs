use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::Relaxed;

use glam::UVec3;
use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;

use super::lattice::Lattice;

/// The macrocells, of M × M × M cells, that hold a triangle (Wald et al. 2006, §2.4). One byte each.
#[derive(Default)]
pub(super) struct Macrocells {
    /// M.
    pub(super) side: u32,
    /// Macrocells along each axis.
    pub(super) count: UVec3,
    occupied: Vec<bool>,
}

impl Macrocells {
    pub(super) fn bytes(&self) -> usize {
        self.occupied.capacity()
    }

    /// Marks the macrocells with a cell that lists a triangle.
    pub(super) fn mark(&mut self, lattice: &Lattice, side: u32, starts: &[AtomicU32]) {
        self.side = side;
        self.count = count(lattice, side);
        self.occupied.resize(self.count.element_product() as usize, false);
        mark(lattice, side, starts, &mut self.occupied);
    }

    #[inline(always)]
    pub(super) fn blocks(&self) -> Blocks<'_> {
        Blocks { side: self.side, count: self.count, occupied: &self.occupied }
    }
}

/// The macrocells of one lattice.
#[derive(Clone, Copy)]
pub(super) struct Blocks<'a> {
    /// M.
    pub(super) side: u32,
    /// Macrocells along each axis.
    pub(super) count: UVec3,
    pub(super) occupied: &'a [bool],
}

impl Blocks<'_> {
    /// Whether a cell of the macrocell holds a triangle.
    #[inline(always)]
    pub(super) fn is_occupied(&self, x: u32, y: u32, z: u32) -> bool {
        // Macrocells of one cell don't exist, and nothing is skipped.
        self.side == 1 || self.occupied[((z * self.count.y + y) * self.count.x + x) as usize]
    }
}

/// The number of macrocells of `side`³ cells along each axis of a lattice.
pub(super) fn count(lattice: &Lattice, side: u32) -> UVec3 {
    lattice.cells.map(|cells| cells.div_ceil(side))
}

/// Marks in `occupied`, a byte for each macrocell, those with a cell that lists a triangle: its ids don't end at their
/// start.
pub(super) fn mark(lattice: &Lattice, side: u32, starts: &[AtomicU32], occupied: &mut [bool]) {
    let UVec3 { x: columns, y: rows, .. } = count(lattice, side);
    occupied.par_chunks_mut(columns as usize).enumerate().with_min_len(16).each(|(index, occupied)| {
        let (row, layer) = (index as u32 % rows, index as u32 / rows);
        occupied.fill(false);
        for z in layer * side..lattice.cells.z.min((layer + 1) * side) {
            for y in row * side..lattice.cells.y.min((row + 1) * side) {
                mark_row(occupied, lattice, side, &starts[lattice.index(0, y, z)..]);
            }
        }
    });
}

/// Marks the macrocells of one row that a row of cells occupies.
fn mark_row(occupied: &mut [bool], lattice: &Lattice, side: u32, starts: &[AtomicU32]) {
    for (column, occupied) in occupied.iter_mut().enumerate() {
        let first = column as u32 * side;
        let end = lattice.cells.x.min(first + side);
        *occupied |= starts[first as usize].load(Relaxed) != starts[end as usize].load(Relaxed);
    }
}
