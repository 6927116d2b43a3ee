use super::drop::whole_image;
use super::slices::Slices;
use super::{Cells, ListedGrid};
use crate::Triangles;
use crate::camera_grid::general::{General, Square};
use crate::camera_grid::pixel_space::PixelSpace;
use crate::predicate::crossing;
use crate::shot::TileOrder;

impl ListedGrid {
    /// Checks that no triangle is listed in a sorting tile twice, and that each is listed in every sorting tile that it
    /// is hit in, in a cell no farther than the hit.
    ///
    /// It asks the predicate about all samples that a triangle may hit, so it takes long for large images.
    ///
    /// # Errors
    /// With what is wrong first.
    pub(super) fn validate(&self, triangles: Triangles<'_>) -> Result<(), String> {
        let Some(space) = &self.space else { return Ok(()) };
        let (order, cells) = (self.order(), self.options.cells);
        if self.tiles.len() * TileOrder::TILE_PIXELS != order.slots() {
            return Err(format!("{} tiles for {} places", self.tiles.len(), order.slots()));
        }
        let slices = cells.slices() as usize;
        // For each sorting tile the triangles and their slices, in order of triangles.
        let mut listed = Vec::new();
        for (tile, in_tile) in self.tiles.iter().enumerate() {
            for first in (0..cells.in_tile()).step_by(slices) {
                let mut of_tile = Vec::new();
                for slice in 0..slices {
                    let cell = first + slice;
                    of_tile.extend(in_tile.cells(cell..cell + 1).iter().map(|&id| (id, slice as u32)));
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
        let check = Check {
            space,
            triangles,
            cells,
            slices: &self.slices,
            culls: self.facing != 0.0,
            tile_columns: order.tiles().0,
            listed: &listed,
        };
        (0..triangles.len() as u32).try_for_each(|id| match triangles.usable_corners(id) {
            Ok(corners) => check.square(id, &General::new(space, corners), whole_image(space)),
            Err(_) => Ok(()),
        })
    }
}

/// What every triangle is held against.
struct Check<'a> {
    space: &'a PixelSpace,
    triangles: Triangles<'a>,
    cells: Cells,
    slices: &'a Slices,
    culls: bool,
    tile_columns: u32,
    /// For each sorting tile the triangles and their slices, in order of triangles.
    listed: &'a [Vec<(u32, u32)>],
}

impl Check<'_> {
    /// Checks a triangle at all samples of a square that it may hit.
    fn square(&self, id: u32, triangle: &General, square: Square) -> Result<(), String> {
        let (x, y) = ((square.x + self.space.middle.x) as u32, (square.y + self.space.middle.y) as u32);
        let (width, height) = self.space.size();
        if x >= width || y >= height || triangle.misses(square) {
            Ok(())
        } else if square.side > 1 {
            square.quarters().into_iter().try_for_each(|quarter| self.square(id, triangle, quarter))
        } else {
            self.sample(id, x, y)
        }
    }

    fn sample(&self, id: u32, x: u32, y: u32) -> Result<(), String> {
        let Some(crossing) = crossing(&self.space.ray(x, y), self.triangles.corners(id)) else { return Ok(()) };
        if crossing.t <= 0.0 || (self.culls && !crossing.front) {
            return Ok(());
        }
        let tile = (y / TileOrder::TILE * self.tile_columns + x / TileOrder::TILE) as usize;
        let side = self.cells.sorting_tile();
        let [column, row] = [x, y].map(|at| at % TileOrder::TILE / side);
        let in_tile = (self.cells.first_in_tile(column, row) / self.cells.slices()) as usize;
        let listed = &self.listed[tile * (self.cells.in_tile() / self.cells.slices() as usize) + in_tile];
        let Ok(place) = listed.binary_search_by_key(&id, |&(id, _)| id) else {
            return Err(format!("triangle {id} isn't listed at pixel ({x}, {y})"));
        };
        let farthest = self.slices.of((1.0 / crossing.t) as f32);
        if listed[place].1 > farthest {
            let slice = listed[place].1;
            return Err(format!("triangle {id} is in slice {slice} at pixel ({x}, {y}), but hit in slice {farthest}"));
        }
        Ok(())
    }
}
