use umbrage_rays::light_grid::settle::Settler;

use super::Lists;
use super::map::LightMap;
use super::trace::LARGE;

impl<M: LightMap> Lists<M> {
    /// Checks the cells of a face built for the settler's light and image. Each of its points, the `members` of the blocks,
    /// is in one cell, and each triangle that shadows a point is listed there, in its slice or an earlier one.
    ///
    /// It asks the predicate about every triangle and point, so it takes long for large images.
    ///
    /// # Errors
    /// Describes the first fault.
    pub(super) fn validate(&self, members: &[u16], settler: &Settler<'_>) -> Result<(), String> {
        let mut members = members.to_vec();
        for (row, (points, triangles)) in self.point_rows.iter().zip(&self.triangle_rows).enumerate() {
            for column in 0..self.axes[0].count {
                let first = column * self.slices.count;
                for group in &points.groups[points.of_cell(column)] {
                    let before_points = triangles.of(first..first + group.slice as usize + 1);
                    let mut listed: Vec<u32> = before_points.iter().map(|&item| self.id(item)).collect();
                    listed.sort_unstable();
                    for &index in &group.indices[..group.count as usize] {
                        let (block, bit) = (index as usize / 16, index as usize % 16);
                        if members[block] >> bit & 1 == 0 {
                            return Err(format!("pixel {index} is in a second cell, or shows no point of the face"));
                        }
                        members[block] &= !(1 << bit);
                        if let Some(id) = missing(settler, index, &listed) {
                            return Err(format!(
                                "triangle {id} shadows pixel {index}, but isn't in column {column} of row {row}"
                            ));
                        }
                    }
                }
            }
        }
        match members.iter().position(|&left| left != 0) {
            Some(block) => Err(format!("points {:016b} of block {block} are in no cell", members[block])),
            None => Ok(()),
        }
    }

    /// The triangle of an item.
    fn id(&self, item: u32) -> u32 {
        if item & LARGE == 0 { item } else { self.large[(item & !LARGE) as usize].0 }
    }
}

/// A triangle that shadows the point of the pixel at `index` and isn't `listed`.
fn missing(settler: &Settler<'_>, index: u32, listed: &[u32]) -> Option<u32> {
    let Settler { points, light, opacity, .. } = settler;
    let own = points.own()[index as usize];
    let ray = points.shadow_ray(index as usize, light)?;
    let blocks = |id: u32| opacity.triangles.usable_corners(id).is_ok_and(|corners| ray.blocked_by(corners).is_some());
    let shadows = |id: u32| blocks(id) && opacity.is_there(id);
    (0..opacity.triangles.len() as u32).find(|&id| id != own && listed.binary_search(&id).is_err() && shadows(id))
}
