use super::{ListedLightGrid, SeenImage};
use crate::LightSource;
use crate::light_grid::LightCells;
use crate::simd::vectors::LANES;

impl ListedLightGrid {
    /// Finds in which cell of the grid for `light` each point that `image` shows is: the one that
    /// [`shadow`](Self::shadow) sorts it to.
    ///
    /// # Panics
    /// If [`survey`](Self::survey) wasn't called for `image`.
    pub fn locate(&mut self, image: &SeenImage<'_>, light: &LightSource, located: &mut LightCells) {
        for face in self.grid.start_locating(image, light, located) {
            self.grid.map_face(face, image);
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
