//! Lights that see through faces, as in the direct form: a single face, or the sides of a cube, each with its own cells.

mod covering;
mod project;
mod small;

use std::ops::Range as Ids;
use std::sync::Mutex;

use fearless_simd::{Simd, mask32x16};
use glam::Vec3;
use rayon::prelude::*;
use umbrage_rays::dispatch;
use umbrage_rays::light_grid::choose;
use umbrage_rays::light_grid::face::{Block, Face, HALF_ULP, VertexErrors};
use umbrage_rays::light_grid::pixel_map::PixelMap;
use umbrage_rays::light_grid::point_set::PointSet;
use umbrage_rays::light_grid::points::{GROUPS, TILE_BLOCKS, TileMap, block_of};
use umbrage_rays::light_grid::survey::Survey;
use umbrage_rays::shot::SeenImage;
use umbrage_rays::simd::SimdLevel;
use umbrage_rays::simd::lanes::bits_of;
use umbrage_rays::simd::vectors::LANES;
use umbrage_rays::{LightFace, LightSource, Triangles};

use super::ListedLightOptions;
use super::cells::Axis;
use super::list::{ListedRange, Listing};
use super::map::{LightMap, Place};
use super::pass::LightPass;
use super::trace::LARGE;
use covering::{CoveringTriangle, covering};
use small::{BATCH, Batch, Mapped};

/// The faces of a light, and the points and vertices on one of them.
#[derive(Default)]
pub(super) struct Faces {
    all: Vec<Face>,
    /// The current face; the rest belongs to it.
    face: Face,
    vertex_errors: VertexErrors,
    blocks: Vec<Block>,
    errors: Vec<BlockErrors>,
    vertices: Vec<[f32; 4]>,
    cells: Cells,
}

/// The cells of a face: X and Y in [−1, 1] are divided evenly into columns and rows.
#[derive(Clone, Copy, Debug, Default)]
struct Cells {
    side: usize,
    /// Largest distance between a point and its cell.
    margin: f32,
}

impl Cells {
    /// The bounds of a row in Y, to within 10⁻⁶, grown by the points' margin; the first and the last row also hold
    /// everything beyond the face.
    fn row_range(&self, row: usize) -> [f32; 2] {
        let edge = |row: usize| (row as f64 * 2.0 / self.side as f64 - 1.0) as f32;
        let low = if row == 0 { -2.0 } else { edge(row) };
        let high = if row + 1 == self.side { 2.0 } else { edge(row + 1) };
        [low - self.margin, high + self.margin]
    }
}

/// Points on a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct FacePoints {
    at: Block,
    errors: BlockErrors,
}

/// Error bounds of a block's points.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BlockErrors {
    /// Error of X and Y.
    pub(super) position: f32,
    /// Error of W.
    pub(super) nearness: f32,
}

impl Faces {
    fn mapped(&self) -> Mapped<'_> {
        Mapped { face: &self.face, vertex_errors: self.vertex_errors, side: self.cells.side, vertices: &self.vertices }
    }
}

impl LightMap for Faces {
    type Points = FacePoints;
    type Batch = Batch;
    type Large = CoveringTriangle;

    fn choose(&mut self, light: &LightSource, survey: &Survey, _: &ListedLightOptions) -> Option<usize> {
        choose::choose(light, survey.rays.step_x, &survey.tiles, &mut self.all)?;
        Some(self.all.len())
    }

    fn map(&mut self, face: usize, image: &SeenImage<'_>, pass: &mut LightPass) {
        let Self { all, face: chosen, vertex_errors, blocks, errors, .. } = self;
        let LightPass { survey, members, outliers, counts, level, .. } = pass;
        *chosen = all[face];
        let points = &PointSet::Seen(*image, survey.rays);
        chosen.choose_point_error(points, &survey.tiles);
        *vertex_errors = VertexErrors::new(chosen);
        blocks.resize(survey.slots / LANES, Block::EMPTY);
        errors.resize(blocks.len(), BlockErrors::default());
        let pixels = PixelMap::new(chosen, &survey.rays);
        let (level, tiles, face) = (level, &survey.tiles, &*chosen);
        let outliers = Mutex::new(outliers);
        let outputs = blocks
            .par_chunks_exact_mut(TILE_BLOCKS)
            .zip(errors.par_chunks_exact_mut(TILE_BLOCKS))
            .zip(members.par_chunks_exact_mut(TILE_BLOCKS));
        let refined = outputs.enumerate().map(|(number, ((blocks, errors), members))| {
            let (mut lost, mut refined) = (Vec::new(), 0);
            let Some(blocks) = blocks.first_chunk_mut() else { return 0 };
            if face.may_own(&tiles[number]) {
                let map = TileMap::new(points, face, &pixels, number, [0.0; 3]);
                for number in 0..GROUPS {
                    let group =
                        dispatch!(*level, simd => map.map_group(simd, number, &mut *blocks, &mut lost, &mut refined));
                    let Some(group) = group else { continue };
                    let [position, nearness] = group.errors;
                    for (index, of_block) in group.members.into_iter().enumerate() {
                        let block = block_of(number, index);
                        members[block] = of_block;
                        errors[block] = BlockErrors { position, nearness };
                    }
                }
            }
            if let (false, Ok(mut all)) = (lost.is_empty(), outliers.lock()) {
                all.append(&mut lost);
            }
            refined
        });
        counts.refined += refined.sum::<u64>();
    }

    fn divide(&mut self, pass: &LightPass, options: &ListedLightOptions) -> [Axis; 2] {
        let largest = |errors: f32, block: &BlockErrors| errors.max(block.position);
        let used = self.errors.iter().zip(&pass.members).filter(|(_, members)| **members != 0);
        let error = used.map(|(error, _)| error).fold(0.0, largest);
        let side = options.cells() as usize;
        // The margin includes the rounding of sums with it.
        self.cells = Cells { side, margin: error * 1.001 + 2.0 * f32::EPSILON };
        [Axis::new([-1.0, 1.0], side); 2]
    }

    fn project(&mut self, positions: &[Vec3], level: SimdLevel) {
        project::project(&self.face, positions, &mut self.vertices, level);
    }

    #[inline(always)]
    fn place(&self, index: u32) -> Place {
        let (block, lane) = (index as usize / LANES, index as usize % LANES);
        let points = &self.blocks[block];
        let nearness = points.nearness[lane];
        // The margin includes its own rounding.
        let margin = self.errors[block].nearness * 1.001 + nearness.abs() * (2.0 * HALF_ULP as f32);
        Place { at: [points.x[lane], points.y[lane]], distance: -nearness, farthest: margin - nearness }
    }

    #[inline(always)]
    fn gather(&self, indices: &[u32]) -> FacePoints {
        let mut gathered = FacePoints { at: Block::EMPTY, errors: BlockErrors::default() };
        for (lane, &index) in indices.iter().enumerate() {
            let (block, from) = (index as usize / LANES, index as usize % LANES);
            let (points, error) = (&self.blocks[block], self.errors[block]);
            gathered.at.x[lane] = points.x[from];
            gathered.at.y[lane] = points.y[from];
            gathered.at.nearness[lane] = points.nearness[from];
            gathered.errors.position = gathered.errors.position.max(error.position);
            gathered.errors.nearness = gathered.errors.nearness.max(error.nearness);
        }
        gathered
    }

    #[inline(always)]
    fn list<S: Simd>(simd: S, listing: &Listing<'_, Self>, range: &mut ListedRange<Self>, ids: Ids<usize>) {
        let end = ids.end;
        for first in ids.step_by(LANES) {
            let triangles = &listing.triangles.indices[first..end.min(first + LANES)];
            let survivors = range.batch.set_up(simd, &listing.map.mapped(), triangles, 0);
            for lane in bits_of(survivors.small) {
                let id = (first + lane) as u32;
                if listing.opacity.is_there(id) {
                    list_small(listing, range, lane, id);
                }
            }
            for lane in bits_of(survivors.large) {
                list_large(listing, range, (first + lane) as u32);
            }
        }
    }

    #[inline(always)]
    fn set_up<S: Simd>(&self, simd: S, triangles: Triangles<'_>, ids: &[u32], batch: &mut Batch) -> u64 {
        let mut corners = [[u32::MAX; 3]; LANES];
        for (corners, &id) in corners.iter_mut().zip(ids) {
            if let Some(&of_triangle) = triangles.indices.get(id as usize) {
                *corners = of_triangle;
            }
        }
        batch.set_up(simd, &self.mapped(), &corners[..ids.len()], 0).small
    }

    #[inline(always)]
    fn test<S: Simd>(simd: S, batch: &Batch, lane: usize, points: &FacePoints) -> (mask32x16<S>, mask32x16<S>) {
        batch.test(simd, lane, &points.at, points.errors)
    }

    #[inline(always)]
    fn test_large<S: Simd>(simd: S, large: &CoveringTriangle, points: &FacePoints) -> (mask32x16<S>, mask32x16<S>) {
        large.test(simd, &points.at, points.errors)
    }

    fn light_face(&self, cells: [usize; 2], distances: [f32; 2]) -> LightFace {
        self.face.light_face(cells, distances.map(|distance| -distance))
    }

    fn bytes(&self) -> usize {
        self.blocks.capacity() * size_of::<Block>()
            + self.errors.capacity() * size_of::<BlockErrors>()
            + self.vertices.capacity() * size_of::<[f32; 4]>()
    }
}

/// Lists the triangle in a lane of the batch in the cells that its bounds cover.
#[inline(always)]
fn list_small(listing: &Listing<'_, Faces>, range: &mut ListedRange<Faces>, lane: usize, id: u32) {
    let ListedRange { bins, batch, .. } = range;
    let margin = listing.map.cells.margin;
    let range = |[low, high]: &[[f32; BATCH]; 2]| [low[lane] - margin, high[lane] + margin];
    let [left, right] = range(&batch.x_range).map(|at| listing.across.cell(at));
    let [top, bottom] = range(&batch.y_range).map(|at| listing.down.cell(at));
    listing.list(bins, &(left..=right), top..=bottom, -batch.nearest[lane], id);
}

/// Lists a triangle, row by row, in the cells that it covers itself.
#[cold]
#[inline(never)]
fn list_large(listing: &Listing<'_, Faces>, range: &mut ListedRange<Faces>, id: u32) {
    let Ok(corners) = listing.triangles.usable_corners(id) else { return };
    if !listing.opacity.is_there(id) {
        return;
    }
    let Faces { face, cells, .. } = listing.map;
    let margin = cells.margin;
    for triangle in covering(face, corners, id).into_iter().flatten() {
        let item = LARGE | range.large.len() as u32;
        let before = range.bins.unsorted.len();
        let [low, high] = triangle.bounds[1];
        for row in listing.down.cell(low - margin)..=listing.down.cell(high + margin) {
            let Some(([left, right], nearest)) = triangle.span(cells, row) else { continue };
            let columns = listing.across.cell(left - margin)..=listing.across.cell(right + margin);
            listing.list(&mut range.bins, &columns, row..=row, -nearest, item);
        }
        if range.bins.unsorted.len() > before {
            range.large.push((id, triangle));
        }
    }
}
