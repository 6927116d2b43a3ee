use super::PerspectiveGrid;
use super::bins::{Bins, Fragment};
use super::general::{General, Square, check_pixels};
use super::samples::SAMPLES;
use crate::predicate::crossing;
use crate::shot::{Shot, TileOrder};

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
                let indices = bin.fragments.iter().map(|fragment| fragment.index & !Fragment::UNDECIDED);
                fragments[tile].extend(bin.fragments.iter().map(|fragment| fragment.triangle).zip(indices));
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
            if let Some((id, index)) = fragments.iter().find(|(_, index)| *index as usize >= SAMPLES) {
                return Err(format!("a fragment of triangle {id} is at index {index} of tile {tile}"));
            }
        }
        (0..triangles.len() as u32).try_for_each(|id| {
            let Ok(corners) = triangles.usable_corners(id) else { return Ok(()) };
            check_pixels(space, &General::new(space, corners), Square::around_image(space), &|x, y| {
                let tile = (y / Bins::TILE * columns + x / Bins::TILE) as usize;
                let index = TileOrder::index_in_tile(x, y);
                if listed[tile].binary_search(&id).is_ok() || fragments[tile].binary_search(&(id, index)).is_ok() {
                    return Ok(());
                }
                match crossing(&shot.ray(x, y), corners) {
                    Some(crossing) if crossing.t > 0.0 && (crossing.front || sides.has_back(id)) => {
                        Err(format!("triangle {id} isn't listed at pixel ({x}, {y})"))
                    }
                    _ => Ok(()),
                }
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, Vec3};

    use super::*;
    use crate::random::Random;
    use crate::shot::Shifts;
    use crate::{Camera, Triangles, View};

    #[test]
    fn triangles_are_listed_where_they_have_a_tiles_corner_alone() {
        let mut random = Random::new(1);
        let mut point = || Vec3::from_array([(); 3].map(|()| random.signed() as f32));
        let mut positions = Vec::new();
        for step in 0..600 {
            let [middle, across, along] = [(); 3].map(|()| point());
            let width = [0.005, 0.1, 1.0][step % 3];
            positions.extend([middle, middle + across * 3.0, middle + across + along * width]);
        }
        let indices: Vec<[u32; 3]> = (0..600).map(|triangle| [0, 1, 2].map(|corner| 3 * triangle + corner)).collect();
        let triangles = Triangles { positions: &positions, indices: &indices };
        let camera = Camera::look_at(Vec3::new(0.3, 0.2, 4.0), Vec3::ZERO, Vec3::Y, 0.5);
        let shifts = [(-0.5, 0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, -0.5)].map(DVec2::from);
        for shifts in [Shifts::NONE, Shifts::new(shifts).expect("possible shifts")] {
            let shot = Shot { shifts, ..Shot::new(triangles, View { camera, width: 512, height: 448 }) };
            let mut grid = PerspectiveGrid::default();
            grid.build(&shot).expect("a small image");
            assert_eq!(grid.validate(&shot), Ok(()), "{shifts:?}");
        }
    }
}
