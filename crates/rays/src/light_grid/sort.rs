use rayon::prelude::*;

use super::pass::LightPass;

impl LightPass {
    /// Sorts the clusters into cells: a counting sort for each row.
    pub(crate) fn sort_clusters(&mut self) {
        let Self { slabs, cells, .. } = self;
        let (across, down, rows, minima) = cells.parts();
        let minima = minima.par_chunks_mut(across.count);
        rows.par_iter_mut().zip(minima).enumerate().for_each(|(index, (row, minima))| {
            row.range = down.range(index);
            row.sort(minima, slabs.iter().flat_map(|slab| &slab.rows[index]));
        });
    }
}
