use rayon::prelude::*;

use super::LightGrid;

impl LightGrid {
    /// Sorts the clusters into cells: a counting sort for each row.
    pub(crate) fn sort(&mut self) {
        let Self { slabs, cells, .. } = self;
        let (across, down, rows, minima) = cells.parts();
        let minima = minima.par_chunks_mut(across.count);
        rows.par_iter_mut().zip(minima).enumerate().for_each(|(place, (row, minima))| {
            row.range = down.range(place);
            row.sort(minima, slabs.iter().flat_map(|slab| &slab.rows[place]));
        });
    }
}
