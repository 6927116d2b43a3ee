use super::PerspectiveGrid;
use super::bins::{Bins, Fragment};
use super::general::{General, Square};
use super::pixel_space::PixelSpace;
use super::tile::SAMPLES;
use crate::Triangles;
use crate::predicate::crossing;
use crate::shot::{Shot, Sides, TileOrder};

impl PerspectiveGrid {
    /// Checks that the lists are in order and that every triangle is listed wherever it is hit.
    ///
    /// It asks the predicate about all samples that a triangle may hit, so it takes long for large images.
    ///
    /// # Errors
    /// With what is wrong first.
    pub(super) fn validate(&self, shot: &Shot<'_>) -> Result<(), String> {
        let Some(space) = &self.space else { return Ok(()) };
        let Shot { triangles, sides, .. } = *shot;
        let (columns, rows) = self.tiles();
        let tiles = columns as usize * rows as usize;
        let mut listed: Vec<Vec<u32>> = vec![Vec::new(); tiles];
        let mut fragments: Vec<Vec<(u32, u32)>> = vec![Vec::new(); tiles];
        for range in &self.ranges {
            if range.bins.len() != tiles {
                return Err(format!("{} bins instead of {tiles}", range.bins.len()));
            }
            for (tile, bin) in range.bins.iter().enumerate() {
                listed[tile].extend(bin.lists().flatten().map(|listed| listed.triangle));
                let places =
                    bin.fragments.iter().map(|fragment| (fragment.triangle, fragment.place & !Fragment::DOUBTFUL));
                fragments[tile].extend(places);
            }
        }
        for (tile, (listed, fragments)) in listed.iter_mut().zip(&mut fragments).enumerate() {
            listed.sort_unstable();
            fragments.sort_unstable();
            let twice = listed.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0]);
            let twice = twice.or_else(|| fragments.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0].0));
            if let Some(id) = twice {
                return Err(format!("triangle {id} is in tile {tile} twice"));
            }
            let wrong = listed.iter().copied().find(|&id| triangles.usable_corners(id).is_err());
            if let Some(id) = wrong {
                return Err(format!("triangle {id} is in tile {tile}, but can't be hit"));
            }
            if let Some((id, place)) = fragments.iter().find(|(_, place)| *place as usize >= SAMPLES) {
                return Err(format!("a fragment of triangle {id} is at place {place} of tile {tile}"));
            }
        }
        let lists =
            Lists { space, columns, culls: sides == Sides::Front, triangles, listed: &listed, fragments: &fragments };
        (0..triangles.len() as u32).try_for_each(|id| lists.check(id))
    }
}

struct Lists<'a> {
    space: &'a PixelSpace,
    columns: u32,
    /// Whether back faces aren't there.
    culls: bool,
    triangles: Triangles<'a>,
    /// Sorted ids for each tile.
    listed: &'a [Vec<u32>],
    /// Sorted ids and places for each tile.
    fragments: &'a [Vec<(u32, u32)>],
}

impl Lists<'_> {
    fn check(&self, id: u32) -> Result<(), String> {
        let Ok(corners) = self.triangles.usable_corners(id) else { return Ok(()) };
        let (width, height) = self.space.size();
        let side = width.max(height).next_power_of_two() as i32;
        let whole = Square { x: -self.space.middle.x, y: -self.space.middle.y, side };
        self.check_square(id, &General::new(self.space, corners), whole)
    }

    fn check_square(&self, id: u32, triangle: &General, square: Square) -> Result<(), String> {
        let (x, y) = ((square.x + self.space.middle.x) as u32, (square.y + self.space.middle.y) as u32);
        let (width, height) = self.space.size();
        if x >= width || y >= height || triangle.misses(square) {
            return Ok(());
        }
        if square.side > 1 {
            return square.quarters().into_iter().try_for_each(|quarter| self.check_square(id, triangle, quarter));
        }
        let tile = (y / Bins::TILE * self.columns + x / Bins::TILE) as usize;
        let place = TileOrder::index_in_tile(x, y);
        if self.listed[tile].binary_search(&id).is_ok() || self.fragments[tile].binary_search(&(id, place)).is_ok() {
            return Ok(());
        }
        match crossing(&self.space.ray(x, y), self.triangles.corners(id)) {
            Some(crossing) if crossing.t > 0.0 && (crossing.front || !self.culls) => {
                Err(format!("triangle {id} isn't listed at pixel ({x}, {y})"))
            }
            _ => Ok(()),
        }
    }
}
