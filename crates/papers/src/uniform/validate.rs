use std::sync::atomic::Ordering::Relaxed;

use glam::{DVec3, Vec3};

use super::UniformGrid;
use super::build::for_each_cell;
use super::cells::Cells;
use super::lattice::Lattice;
use umbrage_rays::Triangles;

impl UniformGrid {
    /// Checks the grid, and those inside of cells, against the triangles that it was built over.
    ///
    /// # Errors
    /// Names the first cell or triangle that breaks a rule: every usable triangle is in each cell that its grown box (or
    /// with [`Insertion::Exact`](super::Insertion::Exact) the triangle itself) overlaps, and nowhere else; ids ascend in
    /// each cell; macrocells are occupied if one of their cells is; references are within the limit, and so are those of
    /// grids inside of cells; and such a grid is inside of one cell, holds the parts of the cell's triangles inside of it,
    /// and lists all of these triangles.
    pub fn check(&self, triangles: Triangles<'_>) -> Result<(), String> {
        let Some(cells) = self.scene_cells() else { return Err("the grid wasn't built".to_owned()) };
        if triangles.len() != self.triangle_count {
            return Err(format!("built over {} triangles, not {}", self.triangle_count, triangles.len()));
        }
        let count = cells.lattice.len();
        if self.starts.len() != count + 2 || self.starts[count].load(Relaxed) as usize != self.ids.len() {
            return Err(format!("{} starts don't fit {count} cells", self.starts.len()));
        }
        let ids = 0..triangles.len() as u32;
        let usable: Vec<u32> = ids.filter(|&id| triangles.usable_corners(id).is_ok()).collect();
        let mut nested = 0;
        self.validate_cells(triangles, &cells, &usable, &mut nested)?;
        if nested != self.nested_grids() {
            return Err(format!("{nested} grids are inside of cells, not {}", self.nested_grids()));
        }
        let limit = Self::MOST_REFERENCES * triangles.len() as u64 + Self::LEAST_LIMIT;
        for references in [self.ids.len(), self.nested_references()] {
            if references as u64 > limit {
                return Err(format!("{references} references are more than {limit}"));
            }
        }
        Ok(())
    }

    /// Checks the cells of one lattice and all grids inside of them, and counts these. `listed` are the lattice's triangles,
    /// in ascending order.
    fn validate_cells(
        &self,
        triangles: Triangles<'_>,
        cells: &Cells<'_>,
        listed: &[u32],
        nested: &mut usize,
    ) -> Result<(), String> {
        let lattice = &cells.lattice;
        let mut found = vec![0; listed.len()];
        let [columns, rows, layers] = lattice.cells.to_array();
        for (z, y) in (0..layers).flat_map(|z| (0..rows).map(move |y| (z, y))) {
            for x in 0..columns {
                let own = validate_cell(triangles, cells, [x, y, z], listed, &mut found)?;
                if let Some(inside) = cells.inside(lattice.index(x, y, z)) {
                    *nested += 1;
                    validate_room(triangles, lattice, [x, y, z], &inside.lattice, &own)?;
                    self.validate_cells(triangles, &inside, &own, nested)
                        .map_err(|broken| format!("inside of cell {:?}: {broken}", [x, y, z]))?;
                }
            }
        }
        for (&id, &found) in listed.iter().zip(&found) {
            let mut expected = 0;
            let around = lattice.cells_around(triangles.corners(id));
            for_each_cell(triangles, lattice, (id, &around), self.options.insertion, |_| expected += 1);
            if found != expected {
                return Err(format!("triangle {id} is in {found} cells instead of {expected}"));
            }
        }
        Ok(())
    }
}

/// Checks one cell, counts the references to each triangle of `listed`, and returns the cell's triangles.
fn validate_cell(
    triangles: Triangles<'_>,
    cells: &Cells<'_>,
    cell: [u32; 3],
    listed: &[u32],
    found: &mut [u64],
) -> Result<Vec<u32>, String> {
    let [x, y, z] = cell;
    let index = cells.lattice.index(x, y, z);
    let own: Vec<u32> = cells.listed(index, index).iter().map(|id| id.load(Relaxed)).collect();
    if let Some(pair) = own.windows(2).find(|pair| pair[0] >= pair[1]) {
        return Err(format!("triangle {} follows {} in cell {cell:?}", pair[1], pair[0]));
    }
    for &id in &own {
        let index = listed.binary_search(&id).map_err(|_| format!("cell {cell:?} lists {id}, which it can't hold"))?;
        let around = cells.lattice.cells_around(triangles.corners(id));
        if !(0..3).all(|axis| around.range(axis).contains(&cell[axis])) {
            return Err(format!("triangle {id} is in cell {cell:?}, away from its box"));
        }
        found[index] += 1;
    }
    let [x, y, z] = cell.map(|at| at / cells.macrocells.side);
    if !own.is_empty() && !cells.macrocells.is_occupied(x, y, z) {
        return Err(format!("the macrocell of cell {cell:?} isn't occupied"));
    }
    Ok(own)
}

/// Checks that the lattice `inner` holds the boxes of the triangles `own`, cut at a cell of `outer` grown by the margin.
fn validate_room(
    triangles: Triangles<'_>,
    outer: &Lattice,
    cell: [u32; 3],
    inner: &Lattice,
    own: &[u32],
) -> Result<(), String> {
    let corner = DVec3::from_array(cell.map(f64::from));
    let [first, last] = [corner - Lattice::MARGIN, corner + 1.0 + Lattice::MARGIN];
    let [first, last] = [first, last].map(|at| outer.corner + at * outer.side);
    for &id in own {
        let [a, b, c] = triangles.corners(id).map(Vec3::as_dvec3);
        let (low, high) = (a.min(b).min(c).max(first), a.max(b).max(c).min(last));
        let (low_at, high_at) = (inner.coordinates(low), inner.coordinates(high));
        let is_inside = low_at.min_element() >= 2.0 * Lattice::MARGIN
            && (inner.cells.as_dvec3() - high_at).min_element() >= 2.0 * Lattice::MARGIN;
        if low.cmple(high).all() && !is_inside {
            return Err(format!("triangle {id} sticks out of what is inside of cell {cell:?}"));
        }
    }
    Ok(())
}
