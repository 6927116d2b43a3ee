use std::sync::atomic::Ordering::Relaxed;

use super::overlap::ExactTriangle;
use super::{Insertion, UniformGrid};
use crate::Triangles;

impl UniformGrid {
    /// Checks the grid against the triangles that it was built over.
    ///
    /// # Errors
    /// Names the first cell or triangle that breaks a rule: every usable triangle is in each cell that its grown box, or
    /// with [`Insertion::Exact`] it itself, overlaps, and nowhere else; ids ascend in each cell; macrocells are occupied
    /// if one of their cells is; and references are no more than the limit.
    pub fn validate(&self, triangles: Triangles<'_>) -> Result<(), String> {
        let Some(lattice) = self.lattice else { return Err("the grid wasn't built".to_owned()) };
        if triangles.len() != self.triangle_count {
            return Err(format!("built over {} triangles, not {}", self.triangle_count, triangles.len()));
        }
        if self.starts.len() != lattice.len() + 2 || self.starts[lattice.len()].load(Relaxed) as usize != self.ids.len()
        {
            return Err(format!("{} starts don't fit {} cells", self.starts.len(), lattice.len()));
        }
        let mut found = vec![0_u64; triangles.len()];
        let [columns, rows, layers] = lattice.cells.to_array();
        for (z, y) in (0..layers).flat_map(|z| (0..rows).map(move |y| (z, y))) {
            for x in 0..columns {
                self.validate_cell(triangles, [x, y, z], &mut found)?;
            }
        }
        for (id, &found) in found.iter().enumerate() {
            let expected = triangles.usable_corners(id as u32).map_or(0, |corners| {
                let cells = lattice.cells_around(corners);
                let triangle = ExactTriangle::new(&lattice, corners);
                let overlapped = |cell: [u32; 3]| {
                    self.options.insertion == Insertion::BoundingBox || cells.len() <= 2 || triangle.overlaps(cell)
                };
                let of_row = |z, y| cells.range(0).filter(|&x| overlapped([x, y, z])).count() as u64;
                cells.range(2).map(|z| cells.range(1).map(|y| of_row(z, y)).sum::<u64>()).sum()
            });
            if found != expected {
                return Err(format!("triangle {id} is in {found} cells instead of {expected}"));
            }
        }
        let limit = Self::MOST_REFERENCES * triangles.len() as u64 + Self::LEAST_LIMIT;
        if self.ids.len() as u64 > limit {
            return Err(format!("{} references are more than {limit}", self.ids.len()));
        }
        Ok(())
    }

    /// Checks one cell, and counts the references to each triangle.
    fn validate_cell(&self, triangles: Triangles<'_>, cell: [u32; 3], found: &mut [u64]) -> Result<(), String> {
        let Some(lattice) = self.lattice else { return Ok(()) };
        let [x, y, z] = cell;
        let place = lattice.place(x, y, z);
        let mut last = None;
        for id in self.listed(place, place).iter().map(|id| id.load(Relaxed)) {
            if last.is_some_and(|last| last >= id) {
                return Err(format!("triangle {id} follows {last:?} in cell {cell:?}"));
            }
            last = Some(id);
            let usable = triangles.indices.get(id as usize).and_then(|_| triangles.usable_corners(id).ok());
            let corners = usable.ok_or_else(|| format!("cell {cell:?} lists {id}, which can't be hit"))?;
            let cells = lattice.cells_around(corners);
            if !(0..3).all(|axis| cells.range(axis).contains(&cell[axis])) {
                return Err(format!("triangle {id} is in cell {cell:?}, away from its box"));
            }
            found[id as usize] += 1;
        }
        let [x, y, z] = cell.map(|at| at / self.macrocells.side);
        if last.is_some() && !self.macrocells.is_occupied(x, y, z) {
            return Err(format!("the macrocell of cell {cell:?} isn't occupied"));
        }
        Ok(())
    }
}
