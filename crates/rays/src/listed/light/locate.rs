use super::ListedLightGrid;
use crate::LightSource;
use crate::light_grid::LightCells;
use crate::shot::{SeenImage, SeenPixels, Shot};
use crate::simd::vectors::LANES;

impl ListedLightGrid {
    /// Finds in which cell of the grid for `light` each point is that the pixels of `shot` have `seen`: the one that
    /// [`shadow`](Self::shadow) sorts it to.
    ///
    /// # Panics
    /// If `survey` wasn't called for `seen`.
    pub(crate) fn locate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource, located: &mut LightCells) {
        for face in self.grid.start_locating(seen, light, located) {
            self.grid.map_face(face, &SeenImage { shot, seen });
            self.sort_points();
            let Self { grid, cells, point_rows, .. } = &*self;
            let points = point_rows.iter().enumerate().flat_map(|(row, points)| {
                (0..cells.across.count).flat_map(move |column| {
                    points.places_of(column).iter().map(move |&place| {
                        let place = place as usize;
                        (place, [column, row], grid.blocks[place / LANES].nearness[place % LANES])
                    })
                })
            });
            located.add_face(&grid.face, [cells.across.count, cells.down.count], points);
        }
    }
}
