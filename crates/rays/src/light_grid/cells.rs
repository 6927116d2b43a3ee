//! The cell of a light's grid that each point is in, for pictures of the grid and of how full it is.

use glam::{DMat3, DVec3, Vec3};

use crate::dispatch;

use super::LightGrid;
use super::face::{Block, Face};
use super::pixel_map::PixelMap;
use super::points::{GROUPS, TILE_BLOCKS, TileMap, block_of};
use super::settle::Settler;
use crate::LightSource;
use crate::patches::Patches;
use crate::shot::{SeenImage, TileOrder};
use crate::simd::lanes::{LANES, bits_of};

/// The cell of a light's grid for the point that each pixel shows, in [`TileOrder`].
///
/// A point on several faces is in a cell of the first. 8 bytes a pixel, 4 for each cell.
#[derive(Clone, Debug, Default)]
pub struct LightCells {
    order: TileOrder,
    of_pixels: Vec<Option<LightCell>>,
    faces: Vec<LightFace>,
    /// For each face its first cell among `points`.
    firsts: Vec<usize>,
    /// The number of points in each cell, face by face, row by row.
    points: Vec<u32>,
}

/// A cell of a light's grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LightCell {
    /// Its index in [`LightCells::faces`].
    pub face: u16,
    /// Counted from the face's lowest X.
    pub column: u16,
    /// Counted from its lowest Y.
    pub row: u16,
}

/// A rectangle through which a light sees points.
///
/// These points are between two parallel rectangles, of the same size where the light is parallel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightFace {
    /// Number of columns of cells.
    pub columns: u32,
    /// Number of rows of cells.
    pub rows: u32,
    /// Its corners at the depth of the point nearest to the light: in world units, one after the other round the rectangle.
    /// A face without points has its corners at the farthest depth here.
    pub near: [Vec3; 4],
    /// Its corners at the depth of the farthest point, in the same order.
    pub far: [Vec3; 4],
}

impl LightCells {
    /// The cell of the point that the pixel in column `x` and row `y` shows; `None` where it shows none, or one that no face
    /// could hold.
    ///
    /// # Panics
    /// If the pixel is outside of the image's tiles.
    #[must_use]
    pub fn at(&self, x: u32, y: u32) -> Option<LightCell> {
        self.of_pixels[self.order.index(x, y)]
    }

    /// Number of points in a cell: of the pixels for which [`at`](Self::at) returns it.
    ///
    /// # Panics
    /// If the grid has no such cell.
    #[must_use]
    pub fn points_of(&self, cell: LightCell) -> u32 {
        self.points[self.index_of(cell)]
    }

    /// Number of points, the pixel's own included, in the cell of the point that a pixel shows; 0 where [`at`](Self::at) is
    /// `None`.
    ///
    /// # Panics
    /// If the pixel is outside of the image's tiles.
    #[must_use]
    pub fn points_at(&self, x: u32, y: u32) -> u32 {
        self.at(x, y).map_or(0, |cell| self.points_of(cell))
    }

    /// The faces through which the light sees the points that the camera sees; none where the light is no light at all.
    #[must_use]
    pub fn faces(&self) -> &[LightFace] {
        &self.faces
    }

    fn index_of(&self, LightCell { face, column, row }: LightCell) -> usize {
        let columns = self.faces[usize::from(face)].columns as usize;
        self.firsts[usize::from(face)] + usize::from(row) * columns + usize::from(column)
    }

    /// Starts anew for an image.
    pub fn start(&mut self, order: TileOrder) {
        self.order = order;
        self.of_pixels.clear();
        self.of_pixels.resize(order.slots(), None);
        self.faces.clear();
        self.firsts.clear();
        self.points.clear();
    }

    /// Adds a face with columns and rows of cells, made from its points' least and largest distances. `located` has the
    /// pixel index of each of its points, its column and row, and its distance.
    pub fn add_face(
        &mut self,
        [columns, rows]: [usize; 2],
        face: impl FnOnce([f32; 2]) -> LightFace,
        located: impl Iterator<Item = (usize, [usize; 2], f32)>,
    ) {
        let number = self.faces.len() as u16;
        let first = self.points.len();
        self.points.resize(first + columns * rows, 0);
        let mut distances = [f32::INFINITY, f32::NEG_INFINITY];
        for (index, [column, row], at) in located {
            distances = [distances[0].min(at), distances[1].max(at)];
            // Slots beyond the image's border are no pixels, and a point of an earlier face is counted there.
            if self.order.pixel(index).is_some() && self.of_pixels[index].is_none() {
                self.of_pixels[index] = Some(LightCell { face: number, column: column as u16, row: row as u16 });
                self.points[first + row * columns + column] += 1;
            }
        }
        self.firsts.push(first);
        self.faces.push(face(if distances[0] <= distances[1] { distances } else { [-1.0; 2] }));
    }
}

impl Face {
    /// The face with this number of columns and rows, and with its points' highest and lowest nearness.
    pub fn light_face(&self, [columns, rows]: [usize; 2], [near, far]: [f32; 2]) -> LightFace {
        LightFace {
            columns: columns as u32,
            rows: rows as u32,
            near: self.corners_at(f64::from(near)),
            far: self.corners_at(f64::from(far)),
        }
    }

    /// The world positions of the face's corners at a nearness.
    fn corners_at(&self, nearness: f64) -> [Vec3; 4] {
        let world_from_face = DMat3::from_cols(self.x, self.y, self.z).transpose().inverse();
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| {
            let depth = self.near / nearness;
            let homogeneous = if self.is_parallel { DVec3::new(x, y, nearness) } else { DVec3::new(x, y, 1.0) * depth };
            (self.origin + world_from_face * homogeneous).as_vec3()
        })
    }
}

impl LightGrid {
    /// Finds the cells of the points that the pixels of `shot` have `seen`, on the light's faces. A face has about as many
    /// cells, in rows and columns of the same number, as full blocks of points. The grid itself has no cells.
    ///
    /// # Panics
    /// If `survey` wasn't called for `seen`.
    pub(crate) fn locate(
        &mut self,
        image: SeenImage<'_>,
        patches: &Patches,
        light: &LightSource,
        located: &mut LightCells,
    ) {
        located.start(image.seen.order());
        let survey = std::mem::take(&mut self.survey);
        let (settler, tiles) = (Settler::of_image(image, survey.rays, light, self.level), &survey.tiles);
        // Without light there are no faces.
        self.visit_faces(patches, &settler, tiles, |grid, face| {
            let expected: usize = tiles.iter().filter(|tile| face.may_own(tile)).map(|tile| tile.points as usize).sum();
            let side = ((expected / LANES) as f64).sqrt().clamp(4.0, 1024.0) as usize;
            let cell = |at: f32| (((at + 1.0) * (0.5 * side as f32)) as usize).min(side - 1);
            let pixels = PixelMap::new(face, &survey.rays);
            let mut blocks = Box::new([Block::EMPTY; TILE_BLOCKS]);
            let mut points = Vec::with_capacity(expected);
            for tile in (0..tiles.len()).filter(|&tile| face.may_own(&tiles[tile])) {
                let map = TileMap::new(&settler.points, face, &pixels, tile, [0.0; 3]);
                for number in 0..GROUPS {
                    let (mut lost, mut refined) = (Vec::new(), 0);
                    let group = dispatch!(grid.level, simd => map.map_group(simd, number, &mut blocks, &mut lost, &mut refined));
                    for (index, members) in group.into_iter().flat_map(|group| group.members).enumerate() {
                        let block = block_of(number, index);
                        points.extend(bits_of(members).map(|lane| {
                            let of_block = &blocks[block];
                            let index = (tile * TILE_BLOCKS + block) * LANES + lane;
                            (index, [cell(of_block.x[lane]), cell(of_block.y[lane])], -of_block.nearness[lane])
                        }));
                    }
                }
            }
            let as_light_face = |distances: [f32; 2]| face.light_face([side; 2], distances.map(|distance| -distance));
            located.add_face([side; 2], as_light_face, points.into_iter());
        });
        self.survey = survey;
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::shot::{SeenPixels, Shot};
    use crate::{Camera, DirectGrids, Specialised as _, Structure as _, Triangles, View};

    #[test]
    fn every_point_that_is_seen_is_somewhere() {
        // A sheet of waves.
        const SIDE: u32 = 40;
        let at = |step: u32| step as f32 / SIDE as f32 * 2.0 - 1.0;
        let vertices = (0..=SIDE).flat_map(|z| (0..=SIDE).map(move |x| (at(x), at(z))));
        let positions: Vec<Vec3> = vertices.map(|(x, z)| Vec3::new(x, 0.2 * (5.0 * x).sin(), z)).collect();
        let squares = (0..SIDE).flat_map(|z| (0..SIDE).map(move |x| z * (SIDE + 1) + x));
        let indices: Vec<[u32; 3]> =
            squares.flat_map(|a| [[a, a + 1, a + SIDE + 1], [a + 1, a + SIDE + 2, a + SIDE + 1]]).collect();
        let triangles = Triangles { positions: &positions, indices: &indices };
        let camera = Camera::look_at(Vec3::new(1.0, 2.0, 2.5), Vec3::ZERO, Vec3::Y, 0.8);
        let (view, offset_pixels) = (View { camera, width: 100, height: 90 }, DVec2::splat(0.5));
        let mut seen = SeenPixels::default();
        let shot = Shot { offset_pixels, ..Shot::new(triangles, view) };
        let mut grids = DirectGrids::default();
        grids.build(triangles);
        grids.see(&shot, &mut seen).expect("a small image");
        let mut located = LightCells::default();
        grids.locate(&shot, &seen, &LightSource::Point { position: Vec3::new(2.0, 3.0, 0.0) }, &mut located);
        assert_eq!(located.faces.len(), 1);
        let mut points = 0;
        for (index, cell) in located.of_pixels.iter().enumerate() {
            let is_shown = seen.triangle[index] != SeenPixels::NONE && located.order.pixel(index).is_some();
            assert_eq!(cell.is_some(), is_shown, "{index}");
            points += u32::from(cell.is_some());
        }
        assert!(points > 1000, "{points}");
        // Neighbours in the image are neighbours on the face.
        let [a, b] = [50, 51].map(|x| located.at(x, 45).expect("the sheet"));
        assert!(a.column.abs_diff(b.column) <= 2 && a.row.abs_diff(b.row) <= 2, "{a:?} {b:?}");
    }
}
