use rayon::prelude::*;

use super::LightGrid;

impl LightGrid {
    /// Sorts the clusters into cells: a counting sort for each row.
    pub(super) fn sort(&mut self) {
        let Self { slabs, cells, .. } = self;
        let columns = cells.columns;
        cells.rows_mut().par_iter_mut().enumerate().for_each(|(place, row)| {
            row.sort(columns, slabs.iter().flat_map(|slab| &slab.rows[place]));
        });
    }
}
