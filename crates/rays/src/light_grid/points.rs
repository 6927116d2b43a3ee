use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8, mask32x16};
use glam::DVec3;

use super::face::{Block, Face, HALF_ULP, LARGEST_POINT_ERROR, POINT_LIMIT, ROUNDING};
use super::pixel_map::{COLUMN, DEPTH, ONE, PixelMap, ROW};
use super::point_set::{PointList, PointSet};
use super::refine::{Refined, refine_eight};
use super::set_up::Extent;
use crate::shot::{SeenImage, SeenPixels, TileOrder};
use crate::simd::lanes::{bits_of, load, of_each};
use crate::simd::vectors::{LANES, splat};
use crate::vectorized;

/// Blocks in a row of a tile.
const ROW_BLOCKS: usize = (TileOrder::TILE / TileOrder::BLOCK) as usize;

/// Blocks in a tile.
pub const TILE_BLOCKS: usize = ROW_BLOCKS * ROW_BLOCKS;

/// Groups in a tile: of 4×4 blocks, which are 16×16 pixels.
pub const GROUPS: usize = TILE_BLOCKS / LANES;

/// Error of s in relation to itself, with one more rounding where it is a quotient.
const OF_DEPTH: f32 = SeenPixels::RELATIVE_ERROR * 1.04;

/// The index in the tile of a group's block.
#[inline]
pub fn block_of(group: usize, block: usize) -> usize {
    (group / 4 * 4 + block / 4) * ROW_BLOCKS + group % 4 * 4 + block % 4
}

/// Maps the points of a tile to a face, in relation to an origin in the tile.
///
/// X less the origin's is as projective as X: with R₀ less X₀ R₃ for R₀ in [`PixelMap`], and so on for Y and W. So the
/// tile's common offset costs no bits.
pub struct TileMap<'a> {
    points: &'a PointSet<'a>,
    face: &'a Face,
    source: Source<'a>,
    /// The index of the tile's first pixel.
    first: usize,
    pub(crate) origin: [f32; 3],
    /// The factors of column and row in the tile, one and s.
    rows: [[f64; 4]; 4],
    /// For each R its constant at each pixel of a block, in relation to the first.
    offsets: [[f32; LANES]; 4],
    slopes: [f32; 4],
    /// For each R the largest magnitude that a point adds to its base.
    spreads: [f32; 4],
    /// The half ulps of its base and its spread by which rounding moves an R, with those of the division for R₃.
    rounded: [f32; 4],
    /// Errors of each R in f64.
    wide_errors: [[f32; 2]; 4],
    point_errors: [f32; 2],
    point_error: f32,
    /// Ranges of X and Y: of the points that the face owns, and of those that it can hold.
    owned: [[f32; 2]; 2],
    limits: [[f32; 2]; 2],
}

/// The source of a tile's points.
enum Source<'a> {
    /// Depths of all pixels; s is their inverse where `is_reciprocal`.
    Depths { all: &'a [f32], is_reciprocal: bool },
    /// Offsets from the middle of the tile, and their factors.
    Offsets { blocks: &'a [[[f32; LANES]; 3]], factors: [[f32; 3]; 4] },
}

/// The mapped points of a group's 16 blocks.
pub struct MappedGroup {
    /// The points of each block that are on the face.
    pub members: [u16; LANES],
    /// Lowest and highest X, Y and W of each block's, in relation to the origin.
    pub(crate) x: [[f32; LANES]; 2],
    pub(crate) y: [[f32; LANES]; 2],
    pub(crate) nearness: [[f32; LANES]; 2],
    /// Error of X and Y of any point, and of W.
    pub errors: [f32; 2],
}

/// The extremes of 16 blocks, a block to a lane.
struct Extremes<S: Simd> {
    x: [f32x16<S>; 2],
    y: [f32x16<S>; 2],
    nearness: [f32x16<S>; 2],
    /// The largest 1 / R₃.
    inverse: f32x16<S>,
    /// The largest s / R₃.
    depth: f32x16<S>,
}

/// Error bounds of the comparisons that tell faces' points apart, for each of 16 blocks: the constants, and the slopes in s.
struct Borders {
    /// The largest factor of R₃ in an edge of the face.
    most: f32,
    constants: [f32; LANES],
    slope: f32,
    /// The same for R₃.
    divisor_constants: [f32; LANES],
    divisor_slope: f32,
}

impl<'a> TileMap<'a> {
    pub fn new(points: &'a PointSet<'a>, face: &'a Face, pixels: &PixelMap, tile: usize, origin: [f32; 3]) -> Self {
        let (image, rays) = match points {
            PointSet::Seen(image, rays) => (image, rays),
            PointSet::Listed(list) => return Self::of_list(points, list, face, tile),
        };
        let first = tile * TileOrder::TILE_PIXELS;
        let (column, row) = image.seen.order().column_and_row(first);
        let (column, row) = (f64::from(column), f64::from(row));
        let [ox, oy, ow] = origin.map(f64::from);
        let mut rows = pixels.rows;
        for factors in &mut rows {
            factors[ONE] += factors[COLUMN] * column + factors[ROW] * row;
        }
        let of_divisor = rows[3];
        let mut wide_errors = pixels.errors;
        for (function, origin) in [ox, oy, ow].into_iter().enumerate() {
            for factor in 0..4 {
                rows[function][factor] -= origin * of_divisor[factor];
            }
            for (error, of_divisor) in wide_errors[function].iter_mut().zip(pixels.errors[3]) {
                *error += origin.abs() * of_divisor;
            }
        }
        let samples = rays.shifts.block();
        let offsets = rows.map(|row| {
            std::array::from_fn(|pixel| {
                let (column, line) = (f64::from(samples.columns[pixel]), f64::from(samples.rows[pixel]));
                (row[COLUMN] * column + row[ROW] * line) as f32
            })
        });
        let [owned, limits] = ranges(face, [ox, oy]);
        Self {
            points,
            face,
            source: Source::Depths { all: &image.seen.inverse_depth, is_reciprocal: pixels.is_reciprocal },
            first,
            origin,
            offsets,
            rounded: [3.02, 3.02, 3.02, 5.04],
            slopes: rows.map(|row| row[DEPTH] as f32),
            spreads: offsets
                .map(|offsets| offsets.into_iter().fold(0.0, |spread, offset: f32| offset.abs().max(spread))),
            // Half as much again for rounding the origin and the tile's corner.
            wide_errors: wide_errors.map(|errors| errors.map(|error| error as f32 * 1.5)),
            rows,
            point_errors: pixels.point_errors.map(|error| error as f32 * 1.001),
            point_error: face.point_error as f32,
            owned,
            limits,
        }
    }

    /// Maps listed points. A point is m + d, with m the middle of its tile's bounds and d an f32, so each R is the sum of a
    /// base, which all points of the tile have in common, and of three products.
    fn of_list(points: &'a PointSet<'a>, list: &'a PointList, face: &'a Face, tile: usize) -> Self {
        let (middle, half) = list.middle(tile);
        let v = middle - face.origin;
        let axes = [face.x, face.y, face.z];
        let [x, y, z] = axes.map(|axis| (axis, axis.dot(v)));
        let one = (DVec3::ZERO, 1.0);
        let rows = if face.is_parallel { [x, y, z, one] } else { [x, y, (DVec3::ZERO, face.near), z] };
        // Products and sums have less than twenty roundings.
        let size = middle.abs().max_element() + face.origin.abs().max_element() + half.max_element();
        let [x, y, z] = (face.norms() * (64.0 * ROUNDING * size)).to_array();
        let errors = if face.is_parallel { [x, y, z, 0.0] } else { [x, y, 0.0, z] };
        let at = rows.map(|(_, base)| base / rows[3].1);
        let is_on_face = rows[3].1 > 0.0 && at[0].abs().max(at[1].abs()) <= POINT_LIMIT && at[2].abs() < 1e15;
        let origin = if is_on_face { [at[0], at[1], at[2]].map(|value| value as f32) } else { [0.0; 3] };
        let of_divisor = (rows[3], errors[3]);
        let rows: [_; 4] = std::array::from_fn(|function| {
            let (axis, base) = rows[function];
            let origin = origin.get(function).map_or(0.0, |&origin| f64::from(origin));
            let ((divisor, divisor_base), divisor_error) = of_divisor;
            (axis - divisor * origin, base - divisor_base * origin, errors[function] + origin.abs() * divisor_error)
        });
        let [owned, limits] = ranges(face, [origin[0], origin[1]].map(f64::from));
        Self {
            points,
            face,
            source: Source::Offsets {
                blocks: &list.offsets[tile * TILE_BLOCKS..(tile + 1) * TILE_BLOCKS],
                factors: rows.map(|(axis, ..)| axis.as_vec3().to_array()),
            },
            first: tile * TileOrder::TILE_PIXELS,
            origin,
            rows: rows.map(|(_, base, _)| {
                let mut factors = [0.0; 4];
                factors[ONE] = base;
                factors
            }),
            offsets: [[0.0; LANES]; 4],
            slopes: [0.0; 4],
            spreads: rows.map(|(axis, ..)| axis.abs().dot(half) as f32 * 1.001),
            // Factors, offsets and base are rounded once each, and three products and sums.
            rounded: [9.1, 9.1, 9.1, 11.2],
            // Half as much again for rounding the origin.
            wide_errors: rows.map(|(.., error)| [error as f32 * 1.5, 0.0]),
            point_errors: [list.largest_error() as f32 * 1.001, 0.0],
            point_error: face.point_error as f32,
            owned,
            limits,
        }
    }

    /// Maps the points of a group of 16 blocks; `None` if none is on the face. Points of the face that can't be mapped are
    /// added to `outliers`, and the number mapped in f64 to `refined`.
    #[inline(always)]
    pub fn map_group<S: Simd>(
        &self,
        simd: S,
        group: usize,
        blocks: &mut [Block; TILE_BLOCKS],
        outliers: &mut Vec<u32>,
        refined: &mut u64,
    ) -> Option<MappedGroup> {
        let bases = self.bases(simd, group);
        let base_lanes = [bases[0].to_array(), bases[1].to_array(), bases[2].to_array(), bases[3].to_array()];
        let borders = if self.face.owned.is_some() { Some(self.borders(simd, &bases)) } else { None };
        let zero = splat(simd, 0.0);
        let (lowest, highest) = (splat(simd, f32::NEG_INFINITY), splat(simd, f32::INFINITY));
        let [mut low_x, mut low_y, mut farthest] = [[highest; LANES]; 3];
        let [mut high_x, mut high_y, mut nearest] = [[lowest; LANES]; 3];
        let [mut inverses, mut depths] = [[zero; LANES]; 2];
        // The points that belong to the face, and those of them that f32 couldn't map.
        let (mut members, mut lost) = ([0_u16; LANES], [0_u16; LANES]);
        let mut any_member = 0;
        for index in 0..LANES {
            let block = block_of(group, index);
            let bases: [f32; 4] = std::array::from_fn(|row| base_lanes[row][index]);
            let (known, s, [r0, r1, r2, r3]) = self.functions(simd, block, bases);
            let member = match &borders {
                Some(borders) => known & !self.is_foreign(simd, [r0, r1, r3], s, borders, index),
                None => known,
            };
            members[index] = member.to_bitmask() as u16;
            // Most blocks of a tile that several faces share are on one face alone.
            if members[index] == 0 {
                continue;
            }
            any_member |= members[index];
            let inverse = splat(simd, 1.0) / r3;
            let (x, y, nearness) = (r0 * inverse, r1 * inverse, r2 * inverse);
            let mapped = member
                & r3.simd_gt(zero)
                & x.simd_ge(splat(simd, self.limits[0][0]))
                & x.simd_le(splat(simd, self.limits[0][1]))
                & y.simd_ge(splat(simd, self.limits[1][0]))
                & y.simd_le(splat(simd, self.limits[1][1]))
                & nearness.abs().simd_lt(splat(simd, 1e15));
            let points = &mut blocks[block];
            x.store_slice(&mut points.x);
            y.store_slice(&mut points.y);
            nearness.store_slice(&mut points.nearness);
            low_x[index] = mapped.select(x, highest);
            high_x[index] = mapped.select(x, lowest);
            low_y[index] = mapped.select(y, highest);
            high_y[index] = mapped.select(y, lowest);
            farthest[index] = mapped.select(nearness, highest);
            nearest[index] = mapped.select(nearness, lowest);
            inverses[index] = mapped.select(inverse, zero);
            depths[index] = mapped.select(inverse * s, zero);
            lost[index] = (member & !mapped).to_bitmask() as u16;
        }
        if any_member == 0 {
            return None;
        }
        let (least, most) = (f32x16::min, f32x16::max);
        let extremes = Extremes {
            x: [of_each(&low_x, least), of_each(&high_x, most)],
            y: [of_each(&low_y, least), of_each(&high_y, most)],
            nearness: [of_each(&farthest, least), of_each(&nearest, most)],
            inverse: of_each(&inverses, most),
            depth: of_each(&depths, most),
        };
        let (position_error, nearness_error, is_exact) = self.errors(simd, &bases, &extremes);
        let Extremes { x, y, nearness, .. } = extremes;
        let is_lost = lost.iter().enumerate().fold(0, |all, (index, &lost)| all | u64::from(lost != 0) << index);
        let is_filled = x[0].simd_le(x[1]).to_bitmask();
        let good = is_filled & is_exact.to_bitmask() & !is_lost;
        let of_good = mask32x16::from_bitmask(simd, good);
        let mut found = MappedGroup {
            members,
            x: [x[0].to_array(), x[1].to_array()],
            y: [y[0].to_array(), y[1].to_array()],
            nearness: [nearness[0].to_array(), nearness[1].to_array()],
            errors: [
                of_good.select(position_error, zero).reduce_max(),
                of_good.select(nearness_error, zero).reduce_max(),
            ],
        };
        for index in bits_of((is_filled | is_lost) & !good) {
            *refined += self.refine_apart(simd, group, index, blocks, outliers, &mut found);
        }
        Some(found)
    }

    /// The constants of the R of a group's blocks, at the first pixel of each.
    #[inline(always)]
    fn bases<S: Simd>(&self, simd: S, group: usize) -> [f32x16<S>; 4] {
        let (column, row) = ((group % 4 * 16) as f64, (group / 4 * 16) as f64);
        let columns = f64x8::simd_from(simd, [0.0, 4.0, 8.0, 12.0, 0.0, 4.0, 8.0, 12.0]);
        let low_rows = f64x8::simd_from(simd, [0.0, 0.0, 0.0, 0.0, 4.0, 4.0, 4.0, 4.0]);
        let high_rows = low_rows + 8.0;
        let [(s0, t0, c0), (s1, t1, c1), (s2, t2, c2), (s3, t3, c3)] = self.rows.map(|factors| {
            (factors[COLUMN], factors[ROW], factors[COLUMN] * column + factors[ROW] * row + factors[ONE])
        });
        [
            (columns * s0 + low_rows * t0 + c0).narrow(columns * s0 + high_rows * t0 + c0),
            (columns * s1 + low_rows * t1 + c1).narrow(columns * s1 + high_rows * t1 + c1),
            (columns * s2 + low_rows * t2 + c2).narrow(columns * s2 + high_rows * t2 + c2),
            (columns * s3 + low_rows * t3 + c3).narrow(columns * s3 + high_rows * t3 + c3),
        ]
    }

    /// A block's known points, their s, and their R.
    #[inline(always)]
    fn functions<S: Simd>(&self, simd: S, block: usize, bases: [f32; 4]) -> (mask32x16<S>, f32x16<S>, [f32x16<S>; 4]) {
        match &self.source {
            Source::Depths { all, is_reciprocal } => {
                let first = self.first + block * LANES;
                let depth = f32x16::from_slice(simd, &all[first..first + LANES]);
                let s = if *is_reciprocal { splat(simd, 1.0) / depth } else { depth };
                let functions = [
                    self.linear(simd, 0, bases[0], s),
                    self.linear(simd, 1, bases[1], s),
                    self.linear(simd, 2, bases[2], s),
                    self.linear(simd, 3, bases[3], s),
                ];
                (depth.simd_eq(depth), s, functions)
            }
            Source::Offsets { blocks, factors } => {
                let [x, y, z] = &blocks[block];
                let offsets = [load(simd, x), load(simd, y), load(simd, z)];
                let functions = [
                    sum(simd, &factors[0], offsets, bases[0]),
                    sum(simd, &factors[1], offsets, bases[1]),
                    sum(simd, &factors[2], offsets, bases[2]),
                    sum(simd, &factors[3], offsets, bases[3]),
                ];
                (offsets[0].simd_eq(offsets[0]), splat(simd, 0.0), functions)
            }
        }
    }

    /// R number `function` at a block's pixels.
    #[inline(always)]
    fn linear<S: Simd>(&self, simd: S, function: usize, base: f32, s: f32x16<S>) -> f32x16<S> {
        let offsets = f32x16::simd_from(simd, self.offsets[function]);
        s.mul_add(splat(simd, self.slopes[function]), offsets + splat(simd, base))
    }

    /// Error of R number `function`: the first, plus s times the second.
    ///
    /// Base, offset in the block and slope are rounded, and so are their sum, the product and the last sum: with all
    /// magnitudes added up that makes three ε of each of the three. The depth's error is counted apart. Listed points have
    /// no s, and up to nine ε. R₃ has two more, in relation to itself, for the roundings of 1 / R₃ and of the products with
    /// it.
    #[inline(always)]
    fn linear_error<S: Simd>(&self, simd: S, function: usize, base: f32x16<S>) -> (f32x16<S>, f32) {
        let rounded = self.rounded[function] * HALF_ULP as f32;
        let [constant, slope] = self.wide_errors[function];
        let of_base =
            (base.abs() + splat(simd, self.spreads[function])).mul_add(splat(simd, rounded), splat(simd, constant));
        (of_base, self.slopes[function].abs() * rounded + slope)
    }

    /// The errors of X and Y, and of W, of 16 blocks, and the blocks whose errors are small enough.
    ///
    /// With R₃ wrong by at most a 512th of itself, X is wrong by (dR₀ − X dR₃) / R₃, times at most 512/511. The error of the
    /// depth moves R₀ and R₃ together: by ds (m₀ − X m₃), with m the slopes, which is largest for one of the extreme X.
    #[inline(always)]
    fn errors<S: Simd>(
        &self,
        simd: S,
        bases: &[f32x16<S>; 4],
        extremes: &Extremes<S>,
    ) -> (f32x16<S>, f32x16<S>, mask32x16<S>) {
        const GROWN: f32 = 1.0025;
        let Extremes { x, y, nearness, inverse, depth } = extremes;
        let (inverse, depth) = (*inverse, *depth);
        let [m0, m1, m2, m3] = self.slopes;
        let (c0, g0) = self.linear_error(simd, 0, bases[0]);
        let (c1, g1) = self.linear_error(simd, 1, bases[1]);
        let (c2, g2) = self.linear_error(simd, 2, bases[2]);
        let (c3, g3) = self.linear_error(simd, 3, bases[3]);
        let reach = x[0].abs().max(x[1].abs()).max(y[0].abs().max(y[1].abs()));
        let deepest = nearness[0].abs().max(nearness[1].abs());
        let along_x = along(simd, m0, m3, x);
        let along_y = along(simd, m1, m3, y);
        let along_w = along(simd, m2, m3, nearness);
        let position =
            (c0.max(c1) + c3 * reach) * inverse + depth * (along_x.max(along_y) * OF_DEPTH + (reach * g3 + g0.max(g1)));
        let nearness = (c2 + c3 * deepest) * inverse + depth * (along_w * OF_DEPTH + (deepest * g3 + g2));
        let (position, nearness) = (position * GROWN, nearness * GROWN);
        let of_divisor = c3 * inverse + depth * (m3.abs() * OF_DEPTH + g3);
        let of_predicate = inverse * self.point_errors[0] + depth * self.point_errors[1];
        // Written so that NaN isn't exact.
        let is_exact = position.simd_le(splat(simd, LARGEST_POINT_ERROR as f32))
            & nearness.simd_lt(splat(simd, 1e15))
            & of_divisor.simd_lt(splat(simd, 1.0 / 512.0))
            & of_predicate.simd_lt(splat(simd, self.point_error));
        (position, nearness, is_exact)
    }

    /// The distance from the face's edges beyond which points of 16 blocks certainly belong to other faces.
    #[inline(always)]
    fn borders<S: Simd>(&self, simd: S, bases: &[f32x16<S>; 4]) -> Borders {
        let [x, y] = self.owned;
        let most = x[0].abs().max(x[1].abs()).max(y[0].abs()).max(y[1].abs());
        let (c0, g0) = self.linear_error(simd, 0, bases[0]);
        let (c1, g1) = self.linear_error(simd, 1, bases[1]);
        let (c3, g3) = self.linear_error(simd, 3, bases[3]);
        let slope = g0.max(g1)
            + g3 * most
            + (self.slopes[0].abs().max(self.slopes[1].abs()) + self.slopes[3].abs() * most) * OF_DEPTH;
        // The factor covers the roundings of the comparisons' own left sides.
        Borders {
            most,
            constants: ((c0.max(c1) + c3 * most) * 2.0).to_array(),
            slope: slope * 2.0,
            divisor_constants: (c3 * 2.0).to_array(),
            divisor_slope: (g3 + self.slopes[3].abs() * OF_DEPTH) * 2.0,
        }
    }

    /// The points of a block that certainly belong to other faces: R₀ − high R₃ > 0 and so on, or R₃ < 0, by more than their
    /// errors.
    #[inline(always)]
    fn is_foreign<S: Simd>(
        &self,
        simd: S,
        [r0, r1, r3]: [f32x16<S>; 3],
        s: f32x16<S>,
        borders: &Borders,
        index: usize,
    ) -> mask32x16<S> {
        let [x, y] = self.owned;
        let size = s.abs();
        let error = size.mul_add(splat(simd, borders.slope), splat(simd, borders.constants[index]))
            + (r0.abs().max(r1.abs()) + r3.abs() * borders.most) * (4.0 * HALF_ULP as f32);
        let of_divisor =
            size.mul_add(splat(simd, borders.divisor_slope), splat(simd, borders.divisor_constants[index]));
        (r0 - r3 * x[1]).simd_gt(error)
            | (r3 * x[0] - r0).simd_gt(error)
            | (r1 - r3 * y[1]).simd_gt(error)
            | (r3 * y[0] - r1).simd_gt(error)
            | (-r3).simd_gt(of_divisor)
    }

    /// [`refine`](Self::refine), out of the way of the loop that seldom needs it.
    #[cold]
    #[inline(never)]
    fn refine_apart<S: Simd>(
        &self,
        simd: S,
        group: usize,
        index: usize,
        blocks: &mut [Block; TILE_BLOCKS],
        outliers: &mut Vec<u32>,
        found: &mut MappedGroup,
    ) -> u64 {
        vectorized!(simd => self.refine(simd, group, index, blocks, outliers, found))
    }

    /// Maps the points of a block from the planes of their triangles, in f64: for blocks whose depths aren't exact enough
    /// for the face. Returns how many were mapped; the face's other points are outliers.
    #[inline(always)]
    fn refine<S: Simd>(
        &self,
        simd: S,
        group: usize,
        index: usize,
        blocks: &mut [Block; TILE_BLOCKS],
        outliers: &mut Vec<u32>,
        found: &mut MappedGroup,
    ) -> u64 {
        let block = block_of(group, index);
        let first = (self.first + block * LANES) as u32;
        let [ox, oy, ow] = self.origin.map(f64::from);
        let points = &mut blocks[block];
        let mut mapped = 0_u16;
        let (mut x, mut y, mut nearness) = (
            [f32::INFINITY, f32::NEG_INFINITY],
            [f32::INFINITY, f32::NEG_INFINITY],
            [f32::INFINITY, f32::NEG_INFINITY],
        );
        let mut errors = [0.0_f64; 2];
        for half in [0, 8] {
            let indices = std::array::from_fn(|lane| first + half + lane as u32);
            let Refined { at, errors: of_eight, members, exact } = refine_eight(simd, self.points, self.face, indices);
            for lane in bits_of(members & !exact) {
                outliers.push(indices[lane]);
            }
            for lane in bits_of(members & exact) {
                let slot = half as usize + lane;
                let local = [at[0][lane] - ox, at[1][lane] - oy, at[2][lane] - ow].map(|value| value as f32);
                [points.x[slot], points.y[slot], points.nearness[slot]] = local;
                for (range, value) in [&mut x, &mut y, &mut nearness].into_iter().zip(local) {
                    *range = [range[0].min(value), range[1].max(value)];
                }
                mapped |= 1 << slot;
                let [x, y, w] = local.map(|value| f64::from(value.abs()) * (HALF_ULP * 1.01));
                for (error, (of_point, rounded)) in errors.iter_mut().zip(of_eight.into_iter().zip([x.max(y), w])) {
                    *error = error.max(of_point[lane] + rounded);
                }
            }
        }
        found.members[index] = mapped;
        for end in 0..2 {
            found.x[end][index] = x[end];
            found.y[end][index] = y[end];
            found.nearness[end][index] = nearness[end];
        }
        for (error, of_block) in found.errors.iter_mut().zip(errors) {
            // Rounded up.
            *error = error.max((of_block * 1.001) as f32);
        }
        u64::from(mapped.count_ones())
    }

    /// An extent without points.
    pub(crate) fn extent(&self) -> Extent {
        Extent { origin: self.origin, ..Extent::default() }
    }
}

/// Ranges of X and Y in relation to an origin: of the points that a face owns, and of those that it can hold.
fn ranges(face: &Face, origin: [f64; 2]) -> [[[f32; 2]; 2]; 2] {
    let everything = [[f64::NEG_INFINITY, f64::INFINITY]; 2];
    let limits = [[-POINT_LIMIT, POINT_LIMIT]; 2];
    [face.owned.unwrap_or(everything), limits]
        .map(|ranges| std::array::from_fn(|axis| ranges[axis].map(|end| (end - origin[axis]) as f32)))
}

/// A base and the products of offsets with their factors.
#[inline(always)]
fn sum<S: Simd>(simd: S, factors: &[f32; 3], [x, y, z]: [f32x16<S>; 3], base: f32) -> f32x16<S> {
    let sum = x.mul_add(splat(simd, factors[0]), splat(simd, base));
    z.mul_add(splat(simd, factors[2]), y.mul_add(splat(simd, factors[1]), sum))
}

/// X, Y and W of a point near the middle of a tile, or zero where none is known.
pub(crate) fn origin(image: &SeenImage<'_>, pixels: &PixelMap, tile: usize) -> [f32; 3] {
    let first = tile * TileOrder::TILE_PIXELS;
    // Pixels from all over the tile, first of all one in the middle.
    const STEP: usize = 97;
    const START: usize = 136;
    for k in 0..TILE_BLOCKS {
        let index = first + (START + k * STEP) % TILE_BLOCKS * LANES;
        let depth = f64::from(image.seen.inverse_depth[index]);
        if depth.is_nan() {
            continue;
        }
        let (column, row) = image.seen.order().column_and_row(index);
        let s = if pixels.is_reciprocal { 1.0 / depth } else { depth };
        let [x, y, w, divisor] = pixels.rows.map(|factors| {
            factors[COLUMN] * f64::from(column) + factors[ROW] * f64::from(row) + factors[ONE] + factors[DEPTH] * s
        });
        let at = [x / divisor, y / divisor, w / divisor];
        if divisor > 0.0 && at[0].abs() <= POINT_LIMIT && at[1].abs() <= POINT_LIMIT && at[2].abs() < 1e15 {
            return at.map(|value| value as f32);
        }
    }
    [0.0; 3]
}

/// The distance that a point moves along an axis when s grows by R₃.
#[inline(always)]
fn along<S: Simd>(simd: S, slope: f32, of_divisor: f32, [low, high]: &[f32x16<S>; 2]) -> f32x16<S> {
    let slope = splat(simd, slope);
    (slope - *low * of_divisor).abs().max((slope - *high * of_divisor).abs())
}

#[cfg(test)]
mod tests;
