use std::collections::HashMap;

use super::PerspectiveGrid;
use super::bins::{Bins, Fragment, Listed};
use super::cull::PixelBox;
use super::homogeneous::{HomogeneousTriangle, Square, check_pixels};
use super::samples::SAMPLES;
use crate::patches::Patches;
use crate::predicate::crossing;
use crate::shot::{Shot, TileOrder};

impl PerspectiveGrid {
    /// Checks that the lists are in order and that every triangle is listed in each tile where it is hit.
    ///
    /// It asks the predicate about all samples that a triangle may hit, so it takes long for large images.
    ///
    /// # Errors
    /// Describes the first fault.
    pub(crate) fn validate(&self, shot: &Shot<'_>, patches: &Patches) -> Result<(), String> {
        let Some(space) = &self.space else { return Ok(()) };
        let Shot { triangles, sides, .. } = *shot;
        let (columns, rows) = self.tiles();
        let tiles = columns as usize * rows as usize;
        let mut listed: Vec<Vec<u32>> = vec![Vec::new(); tiles];
        let mut fragments: Vec<Vec<(u32, u32)>> = vec![Vec::new(); tiles];
        // For each triangle of a listed patch, the pixels at which it may be hit, and the bound of its inverse depth.
        let mut of_patches = HashMap::new();
        for range in &self.ranges {
            if range.bins.len() != tiles {
                return Err(format!("{} bins instead of {tiles}", range.bins.len()));
            }
            for (tile, bin) in range.bins.iter().enumerate() {
                listed[tile].extend(bin.lists().flatten().map(|listed| patches.triangle(listed.slot).0));
                for &Listed { slot, nearest } in &bin.patches {
                    let number = (slot & !Listed::PATCH) as usize;
                    let patch = patches.get(number);
                    let usable = |id: &u32| triangles.usable_corners(*id).is_ok();
                    let ids = patch.ids[..patch.count].iter().copied().filter(usable);
                    of_patches.extend(ids.clone().map(|id| (id, (self.boxes[number], nearest))));
                    listed[tile].extend(ids);
                }
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
            check_pixels(space, &HomogeneousTriangle::new(space, corners), Square::around_image(space), &|x, y| {
                let tile = (y / Bins::TILE * columns + x / Bins::TILE) as usize;
                let index = TileOrder::index_in_tile(x, y);
                let is_listed = listed[tile].binary_search(&id).is_ok();
                let of_patch = of_patches.get(&id);
                if of_patch.is_none() && (is_listed || fragments[tile].binary_search(&(id, index)).is_ok()) {
                    return Ok(());
                }
                match crossing(&shot.ray(x, y), corners) {
                    Some(crossing) if crossing.t > 0.0 && (crossing.front || sides.has_back(id)) => {
                        let is_within = |&(pixels, nearest): &(PixelBox, f32)| {
                            pixels.contains(x, y) && crossing.t.recip() <= f64::from(nearest)
                        };
                        match of_patch {
                            _ if !is_listed => Err(format!("triangle {id} isn't listed at pixel ({x}, {y})")),
                            Some(of_patch) if !is_within(of_patch) => {
                                Err(format!("triangle {id} is hit at ({x}, {y}), where its patch isn't"))
                            }
                            _ => Ok(()),
                        }
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
    use crate::{Camera, SimdLevel, Triangles, View};

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
        let mut patches = Patches::default();
        patches.update(triangles, SimdLevel::default());
        let camera = Camera::look_at(Vec3::new(0.3, 0.2, 4.0), Vec3::ZERO, Vec3::Y, 0.5);
        let shifts = [(-0.5, 0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, -0.5)].map(DVec2::from);
        for shifts in [Shifts::NONE, Shifts::new(shifts).expect("possible shifts")] {
            let shot = Shot { shifts, ..Shot::new(triangles, View { camera, width: 512, height: 448 }) };
            let mut grid = PerspectiveGrid::default();
            grid.build(&shot, &patches).expect("a small image");
            assert_eq!(grid.validate(&shot, &patches), Ok(()), "{shifts:?}");
        }
    }
}
