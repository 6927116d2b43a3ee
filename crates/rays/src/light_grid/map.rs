use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f32x16, f64x8};
use rayon::prelude::*;

use super::block::{Block, BlockErrors, Cluster};
use super::cells::{Cells, REACH};
use super::face::{Face, HALF_ULP, LARGEST_POINT_ERROR, POINT_LIMIT};
use super::pass::LightPass;
use super::pixel_map::{COLUMN, DEPTH, ONE, PixelMap, ROW};
use super::survey::Survey;
use crate::shot::{SeenImage, SeenPixels, TileOrder};
use crate::simd::lanes::of_each;
use crate::simd::vectors::{LANES, splat};

/// Blocks in a tile.
const TILE_BLOCKS: usize = TileOrder::TILE_PIXELS / LANES;

/// Blocks in a row of a tile: as many as there are lanes, so that what is known of each fills a vector.
const ROW_BLOCKS: usize = (TileOrder::TILE / TileOrder::BLOCK) as usize;

/// What a slab of the image's tiles shows on a face.
#[derive(Default)]
pub(crate) struct Slab {
    /// For each row of cells its clusters.
    pub(crate) rows: Vec<Vec<Cluster>>,
    /// Pixels whose points belong to the face and can't be mapped.
    pub(crate) outliers: Vec<u32>,
    pub(crate) points: u32,
    /// Points that were mapped in f64.
    pub(crate) refined: u32,
}

impl Slab {
    pub(crate) fn bytes(&self) -> usize {
        let clusters: usize = self.rows.iter().map(Vec::capacity).sum();
        clusters * size_of::<Cluster>() + self.outliers.capacity() * size_of::<u32>()
    }

    /// Adds a cluster to the rows from the first to the last; memory grows by little, since there are many lists.
    #[inline(always)]
    fn push(&mut self, [first, last]: [u16; 2], cluster: Cluster) {
        for row in first..=last {
            let row = &mut self.rows[usize::from(row)];
            if row.len() == row.capacity() {
                row.reserve_exact(128);
            }
            row.push(cluster);
        }
    }
}

impl LightPass {
    /// Maps all points of `self.face`.
    ///
    /// Slabs are the same from frame to frame, so that their lists' memory can be kept.
    pub(crate) fn map(&mut self, image: &SeenImage<'_>) {
        const SLABS_PER_THREAD: usize = 4;
        let Self { slabs, survey, face, cells, blocks, errors, members, level, .. } = self;
        blocks.resize(survey.slots / LANES, Block::EMPTY);
        errors.resize(blocks.len(), BlockErrors::default());
        members.resize(blocks.len(), 0);
        let mapper = Mapper::new(image, survey, face, cells);
        let count = SLABS_PER_THREAD * rayon::current_num_threads();
        slabs.resize_with(count, Slab::default);
        let per_slab = survey.tiles.len().div_ceil(count).max(1);
        let outputs = blocks
            .par_chunks_mut(per_slab * TILE_BLOCKS)
            .zip(errors.par_chunks_mut(per_slab * TILE_BLOCKS))
            .zip(members.par_chunks_mut(per_slab * TILE_BLOCKS));
        slabs.iter_mut().for_each(|slab| slab.clear(cells.rows().len()));
        slabs.par_iter_mut().zip(outputs).enumerate().for_each(|(index, (slab, ((blocks, errors), members)))| {
            let tiles = blocks
                .chunks_exact_mut(TILE_BLOCKS)
                .zip(errors.chunks_exact_mut(TILE_BLOCKS))
                .zip(members.chunks_exact_mut(TILE_BLOCKS));
            for (tile, ((blocks, errors), members)) in tiles.enumerate() {
                let tile = index * per_slab + tile;
                members.fill(0);
                if face.may_own(&survey.tiles[tile]) {
                    let output = Output { blocks, errors, members, slab: &mut *slab };
                    dispatch!(level.0, simd => mapper.map_tile(simd, tile, output));
                }
            }
        });
    }
}

impl Slab {
    fn clear(&mut self, rows: usize) {
        if self.rows.len() < rows {
            self.rows.resize_with(rows, Vec::new);
        }
        self.rows.iter_mut().for_each(Vec::clear);
        self.outliers.clear();
        (self.points, self.refined) = (0, 0);
    }
}

/// Where a tile's points go.
struct Output<'a> {
    blocks: &'a mut [Block],
    errors: &'a mut [BlockErrors],
    members: &'a mut [u16],
    slab: &'a mut Slab,
}

/// Maps pixels to a face in f32.
pub(crate) struct Mapper<'a> {
    pub(crate) image: &'a SeenImage<'a>,
    pub(crate) survey: &'a Survey,
    pub(crate) face: &'a Face,
    cells: &'a Cells,
    pixels: PixelMap,
    /// For each R its constant at each pixel of a block, in relation to the first.
    offsets: [[f32; LANES]; 4],
    /// The factor of s in each R.
    slopes: [f32; 4],
    /// The largest magnitudes of `offsets`.
    spreads: [f32; 4],
    /// What f64 loses of each R.
    wide_errors: [[f32; 2]; 4],
    point_errors: [f32; 2],
    point_error: f32,
    owned: [[f32; 2]; 2],
}

/// The smallest and largest of what 16 blocks hold, a block to a lane.
struct Extremes<S: Simd> {
    x: [f32x16<S>; 2],
    y: [f32x16<S>; 2],
    nearness: [f32x16<S>; 2],
    /// The largest 1 / R₃.
    inverse: f32x16<S>,
    /// The largest s / R₃.
    depth: f32x16<S>,
}

/// Rows of vectors, one for each of 16 blocks.
struct Rows<S: Simd> {
    x: [[f32x16<S>; ROW_BLOCKS]; 2],
    y: [[f32x16<S>; ROW_BLOCKS]; 2],
    nearness: [[f32x16<S>; ROW_BLOCKS]; 2],
    inverse: [f32x16<S>; ROW_BLOCKS],
    depth: [f32x16<S>; ROW_BLOCKS],
}

impl<'a> Mapper<'a> {
    fn new(image: &'a SeenImage<'a>, survey: &'a Survey, face: &'a Face, cells: &'a Cells) -> Self {
        let pixels = PixelMap::new(face, &survey.rays);
        let offsets = pixels.rows.map(|row| {
            std::array::from_fn(|pixel| (row[COLUMN] * (pixel % 4) as f64 + row[ROW] * (pixel / 4) as f64) as f32)
        });
        let everything = [[f64::NEG_INFINITY, f64::INFINITY]; 2];
        Self {
            image,
            survey,
            face,
            cells,
            pixels,
            offsets,
            slopes: pixels.rows.map(|row| row[DEPTH] as f32),
            spreads: offsets
                .map(|offsets| offsets.into_iter().fold(0.0, |spread, offset: f32| offset.abs().max(spread))),
            wide_errors: pixels.errors.map(|errors| errors.map(|error| error as f32 * 1.001)),
            point_errors: pixels.point_errors.map(|error| error as f32 * 1.001),
            point_error: face.point_error as f32,
            owned: face.owned.unwrap_or(everything).map(|range| range.map(|end| end as f32)),
        }
    }

    /// Maps the points of a tile.
    #[inline(always)]
    fn map_tile<S: Simd>(&self, simd: S, tile: usize, output: Output<'_>) {
        let Output { blocks, errors, members, slab } = output;
        let rows = blocks
            .chunks_exact_mut(ROW_BLOCKS)
            .zip(errors.chunks_exact_mut(ROW_BLOCKS))
            .zip(members.chunks_exact_mut(ROW_BLOCKS));
        for (row, ((blocks, errors), members)) in rows.enumerate() {
            let first = tile * TILE_BLOCKS + row * ROW_BLOCKS;
            self.map_row(simd, first, Output { blocks, errors, members, slab: &mut *slab });
        }
    }

    /// Maps the points of a row of blocks from `first`.
    #[inline(always)]
    fn map_row<S: Simd>(&self, simd: S, first: usize, output: Output<'_>) {
        let Output { blocks, errors, members, slab } = output;
        let bases = self.bases(simd, first);
        let base_lanes = [bases[0].to_array(), bases[1].to_array(), bases[2].to_array(), bases[3].to_array()];
        let depths = &self.image.seen.inverse_depth[first * LANES..(first + ROW_BLOCKS) * LANES];
        let zero = splat(simd, 0.0);
        let mut rows = Rows {
            x: [[zero; ROW_BLOCKS]; 2],
            y: [[zero; ROW_BLOCKS]; 2],
            nearness: [[zero; ROW_BLOCKS]; 2],
            inverse: [zero; ROW_BLOCKS],
            depth: [zero; ROW_BLOCKS],
        };
        // Which points belong to the face, and which of those this couldn't map.
        let (mut all, mut lost) = ([0_u16; ROW_BLOCKS], [0_u16; ROW_BLOCKS]);
        let mut any_member = 0;
        for (index, block) in blocks.iter_mut().enumerate() {
            let depth = f32x16::from_slice(simd, &depths[index * LANES..(index + 1) * LANES]);
            let known = depth.simd_eq(depth);
            let s = if self.pixels.is_reciprocal { splat(simd, 1.0) / depth } else { depth };
            let r0 = self.linear(simd, 0, base_lanes[0][index], s);
            let r1 = self.linear(simd, 1, base_lanes[1][index], s);
            let r2 = self.linear(simd, 2, base_lanes[2][index], s);
            let r3 = self.linear(simd, 3, base_lanes[3][index], s);
            let inverse = splat(simd, 1.0) / r3;
            let (x, y, nearness) = (r0 * inverse, r1 * inverse, r2 * inverse);
            let limit = splat(simd, POINT_LIMIT as f32);
            let mut member = known;
            if self.face.owned.is_some() {
                member &= !self.is_foreign(simd, [r0, r1, r3], s, std::array::from_fn(|row| base_lanes[row][index]));
            }
            let mapped = member
                & r3.simd_gt(zero)
                & x.abs().simd_le(limit)
                & y.abs().simd_le(limit)
                & nearness.abs().simd_lt(splat(simd, 1e15));
            block.x = x.to_array();
            block.y = y.to_array();
            block.nearness = nearness.to_array();
            let (lowest, highest) = (splat(simd, f32::NEG_INFINITY), splat(simd, f32::INFINITY));
            rows.x[0][index] = mapped.select(x, highest);
            rows.x[1][index] = mapped.select(x, lowest);
            rows.y[0][index] = mapped.select(y, highest);
            rows.y[1][index] = mapped.select(y, lowest);
            rows.nearness[0][index] = mapped.select(nearness, highest);
            rows.nearness[1][index] = mapped.select(nearness, lowest);
            rows.inverse[index] = mapped.select(inverse, zero);
            rows.depth[index] = mapped.select(inverse * s, zero);
            all[index] = member.to_bitmask() as u16;
            lost[index] = (member & !mapped).to_bitmask() as u16;
            any_member |= all[index];
        }
        if any_member == 0 {
            return;
        }
        let extremes = rows.extremes();
        let (position_error, nearness_error, is_exact) = self.errors(simd, &bases, &extremes);
        let filed = Filed::new(simd, self.cells, &extremes, position_error, nearness_error);
        let is_exact = is_exact.to_bitmask();
        let (position_errors, nearness_errors) = (position_error.to_array(), nearness_error.to_array());
        for index in 0..ROW_BLOCKS {
            let mut mask = all[index];
            if mask == 0 {
                continue;
            }
            let block = (first + index) as u32;
            if lost[index] == 0 && is_exact >> index & 1 == 1 {
                errors[index] = BlockErrors { position: position_errors[index], nearness: nearness_errors[index] };
                if filed.fits >> index & 1 == 1 {
                    slab.push([filed.rows[0][index], filed.rows[1][index]], filed.cluster(index, block));
                } else {
                    self.divide(simd, slab, block, &blocks[index], errors[index], mask);
                }
            } else {
                let (mapped, error) = self.refine(simd, block, &mut blocks[index], slab);
                errors[index] = error;
                mask = mapped;
                self.divide(simd, slab, block, &blocks[index], error, mask);
            }
            members[index] = mask;
            slab.points += mask.count_ones();
        }
    }

    /// The constants of the R of 16 blocks from `first`, at the first pixel of each.
    #[inline(always)]
    fn bases<S: Simd>(&self, simd: S, first: usize) -> [f32x16<S>; 4] {
        let (column, row) = self.survey.rays.order.column_and_row(first * LANES);
        let (column, row) = (f64::from(column), f64::from(row));
        let low = f64x8::simd_from(simd, [0.0, 4.0, 8.0, 12.0, 16.0, 20.0, 24.0, 28.0]);
        let high = low + 32.0;
        let of = |function: usize| {
            let factors = &self.pixels.rows[function];
            (factors[COLUMN], factors[COLUMN] * column + (factors[ROW] * row + factors[ONE]))
        };
        let [(s0, c0), (s1, c1), (s2, c2), (s3, c3)] = [of(0), of(1), of(2), of(3)];
        [
            (low * s0 + c0).narrow(high * s0 + c0),
            (low * s1 + c1).narrow(high * s1 + c1),
            (low * s2 + c2).narrow(high * s2 + c2),
            (low * s3 + c3).narrow(high * s3 + c3),
        ]
    }

    /// R number `function` at a block's pixels.
    #[inline(always)]
    fn linear<S: Simd>(&self, simd: S, function: usize, base: f32, s: f32x16<S>) -> f32x16<S> {
        let offsets = f32x16::simd_from(simd, self.offsets[function]);
        s.mul_add(splat(simd, self.slopes[function]), offsets + splat(simd, base))
    }

    /// How wrong R number `function` may be: the first, plus s times the second.
    ///
    /// Base, offset in the block and slope are rounded, and so are their sum, the product and the last sum: with all
    /// magnitudes added up that makes three ε of each of the three. An error of the depth is counted apart.
    #[inline(always)]
    fn linear_error<S: Simd>(&self, simd: S, function: usize, base: f32x16<S>) -> (f32x16<S>, f32) {
        const ROUNDED: f32 = 3.01 * HALF_ULP as f32;
        let [constant, slope] = self.wide_errors[function];
        let of_base =
            (base.abs() + splat(simd, self.spreads[function])).mul_add(splat(simd, ROUNDED), splat(simd, constant));
        (of_base, self.slopes[function].abs() * ROUNDED + slope)
    }

    /// The error of X and Y, and of W, of 16 blocks, and which are small enough.
    ///
    /// With R₃ wrong by at most a sixteenth of itself, X is wrong by (dR₀ − X dR₃) / R₃, times at most 16/15, and by the
    /// roundings of 1 / R₃ and the product. The error of the depth moves R₀ and R₃ together: by ds (m₀ − X m₃), with m
    /// the slopes, which is largest for one of the extreme X.
    #[inline(always)]
    fn errors<S: Simd>(
        &self,
        simd: S,
        bases: &[f32x16<S>; 4],
        extremes: &Extremes<S>,
    ) -> (f32x16<S>, f32x16<S>, fearless_simd::mask32x16<S>) {
        // One more rounding where s is a quotient.
        const OF_DEPTH: f32 = SeenPixels::RELATIVE_ERROR * 1.04;
        const GROWN: f32 = 1.1;
        let Extremes { x, y, nearness, inverse, depth } = extremes;
        let (inverse, depth) = (*inverse, *depth);
        let [m0, m1, m2, m3] = self.slopes;
        let (c0, g0) = self.linear_error(simd, 0, bases[0]);
        let (c1, g1) = self.linear_error(simd, 1, bases[1]);
        let (c2, g2) = self.linear_error(simd, 2, bases[2]);
        let (c3, g3) = self.linear_error(simd, 3, bases[3]);
        let nearest = nearness[0].abs().max(nearness[1].abs());
        let along_x = along(simd, m0, m3, x);
        let along_y = along(simd, m1, m3, y);
        let along_w = along(simd, m2, m3, nearness);
        // |X| is at most 1.001.
        let of_position =
            (c0.max(c1) + c3 * 1.001) * inverse + depth * (along_x.max(along_y) * OF_DEPTH + (g0.max(g1) + g3 * 1.001));
        let position = of_position * GROWN + 3.0 * HALF_ULP as f32;
        let of_nearness = (c2 + c3 * nearest) * inverse + depth * (along_w * OF_DEPTH + (nearest * g3 + g2));
        let nearness = of_nearness * GROWN + nearest * (3.0 * HALF_ULP as f32);
        let of_divisor = c3 * inverse + depth * (m3.abs() * OF_DEPTH + g3);
        let of_predicate = inverse * self.point_errors[0] + depth * self.point_errors[1];
        // Written so that NaN isn't exact.
        let is_exact = position.simd_le(splat(simd, LARGEST_POINT_ERROR as f32))
            & nearness.simd_lt(splat(simd, 1e15))
            & of_divisor.simd_lt(splat(simd, 1.0 / 16.0))
            & of_predicate.simd_lt(splat(simd, self.point_error));
        (position, nearness, is_exact)
    }

    /// Which points certainly belong to other faces: R₀ − high R₃ > 0 and so on, or R₃ < 0, by more than they may be
    /// wrong.
    #[inline(always)]
    fn is_foreign<S: Simd>(
        &self,
        simd: S,
        [r0, r1, r3]: [f32x16<S>; 3],
        s: f32x16<S>,
        bases: [f32; 4],
    ) -> fearless_simd::mask32x16<S> {
        const OF_DEPTH: f32 = SeenPixels::RELATIVE_ERROR * 1.04;
        let [x, y] = self.owned;
        // How much an edge of the face is an edge of R₃.
        let most = x[0].abs().max(x[1].abs()).max(y[0].abs()).max(y[1].abs());
        let (c0, g0) = self.linear_error(simd, 0, splat(simd, bases[0]));
        let (c1, g1) = self.linear_error(simd, 1, splat(simd, bases[1]));
        let (c3, g3) = self.linear_error(simd, 3, splat(simd, bases[3]));
        let slope = g0.max(g1)
            + g3 * most
            + (self.slopes[0].abs().max(self.slopes[1].abs()) + self.slopes[3].abs() * most) * OF_DEPTH;
        // The factor covers the roundings of the comparisons' own left sides.
        let error = (c0.max(c1) + c3 * most + s.abs() * slope) * 2.0
            + (r0.abs().max(r1.abs()) + r3.abs() * most) * (4.0 * HALF_ULP as f32);
        let of_divisor = c3 * 2.0 + s.abs() * (g3 + self.slopes[3].abs() * OF_DEPTH) * 2.0;
        (r0 - r3 * x[1]).simd_gt(error)
            | (r3 * x[0] - r0).simd_gt(error)
            | (r1 - r3 * y[1]).simd_gt(error)
            | (r3 * y[0] - r1).simd_gt(error)
            | (-r3).simd_gt(of_divisor)
    }

    /// Lists a block's points in clusters that are small enough.
    #[inline(always)]
    pub(crate) fn divide<S: Simd>(
        &self,
        simd: S,
        slab: &mut Slab,
        block: u32,
        points: &Block,
        error: BlockErrors,
        mut mask: u16,
    ) {
        let (x, y) = (f32x16::simd_from(simd, points.x), f32x16::simd_from(simd, points.y));
        let nearness = f32x16::simd_from(simd, points.nearness);
        let infinity = splat(simd, f32::INFINITY);
        let Cells { across, down, .. } = self.cells;
        let (columns, rows) = (across.cells_at(simd, x), down.cells_at(simd, y));
        while mask != 0 {
            // The upper border of the cluster is that of the points not yet in one, so that it fills its rows.
            let rest = (0..LANES).filter(|lane| mask >> lane & 1 == 1);
            let anchor = rest.clone().min_by_key(|&lane| rows[lane]).unwrap_or_default();
            let (column, row) = (columns[anchor], rows[anchor]);
            let is_near =
                |&lane: &usize| columns[lane].abs_diff(column) <= REACH[0] / 2 && rows[lane].abs_diff(row) <= REACH[1];
            let near = rest.filter(is_near).fold(1 << anchor, |near, lane| near | 1_u16 << lane);
            mask &= !near;
            let near = fearless_simd::mask32x16::from_bitmask(simd, u64::from(near));
            let low = [near.select(x, infinity).reduce_min(), near.select(y, infinity).reduce_min()];
            let high = [near.select(x, -infinity).reduce_max(), near.select(y, -infinity).reduce_max()];
            let farthest = near.select(nearness, infinity).reduce_min();
            let cluster = Cluster {
                x: grown([low[0], high[0]], error.position),
                y: grown([low[1], high[1]], error.position),
                farthest: grown([farthest; 2], error.nearness)[0],
                block,
                columns: [0; 2],
            };
            let columns = cluster.x.map(|at| across.cell(at) as u16);
            slab.push(cluster.y.map(|at| down.cell(at) as u16), Cluster { columns, ..cluster });
        }
    }
}

/// A range grown by an error, and by its own rounding.
fn grown([low, high]: [f32; 2], error: f32) -> [f32; 2] {
    const ROUNDED: f32 = 2.0 * HALF_ULP as f32;
    let error = |end: f32| error * 1.001 + end.abs() * ROUNDED;
    [low - error(low), high + error(high)]
}

/// How far a point moves along an axis when s grows by R₃.
#[inline(always)]
fn along<S: Simd>(simd: S, slope: f32, of_divisor: f32, [low, high]: &[f32x16<S>; 2]) -> f32x16<S> {
    let slope = splat(simd, slope);
    (slope - *low * of_divisor).abs().max((slope - *high * of_divisor).abs())
}

/// Where the clusters of 16 blocks are filed, should they fit in one each.
struct Filed {
    x: [[f32; ROW_BLOCKS]; 2],
    y: [[f32; ROW_BLOCKS]; 2],
    farthest: [f32; ROW_BLOCKS],
    columns: [[u16; ROW_BLOCKS]; 2],
    rows: [[u16; ROW_BLOCKS]; 2],
    /// Which blocks are small enough to be one cluster.
    fits: u64,
}

impl Filed {
    #[inline(always)]
    fn new<S: Simd>(
        simd: S,
        cells: &Cells,
        extremes: &Extremes<S>,
        position_error: f32x16<S>,
        nearness_error: f32x16<S>,
    ) -> Self {
        let Extremes { x, y, nearness, .. } = extremes;
        // As `grown`, for |X| of about one.
        let error = position_error * 1.001 + 3.0 * HALF_ULP as f32;
        let (x, y) = ([x[0] - error, x[1] + error], [y[0] - error, y[1] + error]);
        let farthest = nearness[0] - (nearness_error * 1.001 + nearness[0].abs() * (2.0 * HALF_ULP as f32));
        let columns = [cells.across.cells_at(simd, x[0]), cells.across.cells_at(simd, x[1])];
        let rows = [cells.down.cells_at(simd, y[0]), cells.down.cells_at(simd, y[1])];
        let fit = |index: usize| {
            columns[1][index].wrapping_sub(columns[0][index]) <= REACH[0]
                && rows[1][index].wrapping_sub(rows[0][index]) <= REACH[1]
        };
        let fits = (0..ROW_BLOCKS).fold(0, |fits, index| fits | u64::from(fit(index)) << index);
        Self {
            x: [x[0].to_array(), x[1].to_array()],
            y: [y[0].to_array(), y[1].to_array()],
            farthest: farthest.to_array(),
            columns,
            rows,
            fits,
        }
    }

    #[inline(always)]
    fn cluster(&self, index: usize, block: u32) -> Cluster {
        Cluster {
            x: [self.x[0][index], self.x[1][index]],
            y: [self.y[0][index], self.y[1][index]],
            farthest: self.farthest[index],
            block,
            columns: [self.columns[0][index], self.columns[1][index]],
        }
    }
}

impl<S: Simd> Rows<S> {
    #[inline(always)]
    fn extremes(&self) -> Extremes<S> {
        let (least, most) = (f32x16::min, f32x16::max);
        Extremes {
            x: [of_each(&self.x[0], least), of_each(&self.x[1], most)],
            y: [of_each(&self.y[0], least), of_each(&self.y[1], most)],
            nearness: [of_each(&self.nearness[0], least), of_each(&self.nearness[1], most)],
            inverse: of_each(&self.inverse, most),
            depth: of_each(&self.depth, most),
        }
    }
}
