use umbrage_rays::camera_grid::homogeneous::{HomogeneousTriangle, Square, check_pixels};
use umbrage_rays::predicate::crossing;
use umbrage_rays::shot::{Shot, TileOrder};

use super::ListedGrid;

impl ListedGrid {
    /// Checks that no triangle is listed in a sorting tile twice, and that each triangle is listed in every sorting tile
    /// where it is hit, in a cell no farther than the hit.
    ///
    /// It asks the predicate about all samples that a triangle may hit, so it takes long for large images.
    ///
    /// # Errors
    /// Describes the first fault.
    pub(crate) fn validate(&self, shot: &Shot<'_>) -> Result<(), String> {
        let Shot { triangles, sides, .. } = *shot;
        let Some(space) = &self.space else { return Ok(()) };
        let (order, cells) = (self.order(), self.options.cells);
        if self.tiles.len() * TileOrder::TILE_PIXELS != order.slots() {
            return Err(format!("{} tiles for {} slots", self.tiles.len(), order.slots()));
        }
        let slices = cells.slices() as usize;
        // For each sorting tile, the triangles and their slices, in order of triangles.
        let mut listed = Vec::new();
        for (tile, in_tile) in self.tiles.iter().enumerate() {
            for first in (0..cells.in_tile()).step_by(slices) {
                let mut of_tile = Vec::new();
                for slice in 0..slices {
                    let cell = first + slice;
                    of_tile.extend(in_tile.of(cell..cell + 1).iter().map(|&id| (id, slice as u32)));
                }
                of_tile.sort_unstable();
                if let Some(pair) = of_tile.windows(2).find(|pair| pair[0].0 == pair[1].0) {
                    return Err(format!("triangle {} is in cells from {first} on in tile {tile} twice", pair[0].0));
                }
                if let Some((id, _)) = of_tile.iter().find(|(id, _)| triangles.usable_corners(*id).is_err()) {
                    return Err(format!("triangle {id} is in tile {tile}, but can't be hit"));
                }
                listed.push(of_tile);
            }
        }
        let (slices, columns) = (&self.slices, order.tiles().0);
        (0..triangles.len() as u32).try_for_each(|id| {
            let Ok(corners) = triangles.usable_corners(id) else { return Ok(()) };
            check_pixels(space, &HomogeneousTriangle::new(space, corners), Square::around_image(space), &|x, y| {
                let Some(crossing) = crossing(&shot.ray(x, y), corners) else { return Ok(()) };
                if crossing.t <= 0.0 || !(crossing.front || sides.has_back(id)) {
                    return Ok(());
                }
                let tile = (y / TileOrder::TILE * columns + x / TileOrder::TILE) as usize;
                let [column, row] = [x, y].map(|at| at % TileOrder::TILE / cells.sorting_tile());
                let sorting_tile =
                    (tile * cells.in_tile() + cells.first_in_tile(column, row) as usize) / cells.slices() as usize;
                let listed = &listed[sorting_tile];
                let Ok(index) = listed.binary_search_by_key(&id, |&(id, _)| id) else {
                    return Err(format!("triangle {id} isn't listed at pixel ({x}, {y})"));
                };
                let (slice, farthest) = (listed[index].1, slices.of((1.0 / crossing.t) as f32));
                if slice > farthest {
                    return Err(format!(
                        "triangle {id} is in slice {slice} at pixel ({x}, {y}), but hit in slice {farthest}"
                    ));
                }
                Ok(())
            })
        })
    }
}
