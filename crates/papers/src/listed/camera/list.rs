use glam::DVec3;
use umbrage_rays::Triangles;
use umbrage_rays::camera_grid::ImageTooLarge;
use umbrage_rays::camera_grid::homogeneous::{Depth, HomogeneousTriangle, Square};
use umbrage_rays::camera_grid::pixel_space::PixelSpace;
use umbrage_rays::shot::TileOrder;

use super::Cells;
use super::drop::Kept;
use super::slices::Slices;

/// A triangle and a cell in which it may be hit. 8 bytes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pair {
    /// The tile's index in the [`TileOrder`] × 2¹², plus the cell's index in the tile.
    cell: u32,
    pub(super) triangle: u32,
}

impl Pair {
    /// At most 64 × 64 cells: [`Cells::MOST_SLICES`] for each of 8×8 sorting tiles.
    const CELL_BITS: u32 = 12;

    pub(super) fn tile(&self) -> usize {
        (self.cell >> Self::CELL_BITS) as usize
    }

    pub(super) fn cell_in_tile(&self) -> usize {
        (self.cell % (1 << Self::CELL_BITS)) as usize
    }
}

/// The listing of one range of triangles.
pub(super) struct List<'a> {
    pub(super) space: &'a PixelSpace,
    pub(super) triangles: Triangles<'a>,
    pub(super) cells: Cells,
    pub(super) slices: &'a Slices,
    pub(super) tile_columns: u32,
    pub(super) pairs: &'a mut Vec<Pair>,
}

/// A triangle on its way to the sorting tiles that it covers.
struct Listed<'a> {
    id: u32,
    general: &'a HomogeneousTriangle,
    /// First and last column, and first and last row, of the samples that it may hit.
    bounds: [[i32; 2]; 2],
    /// Upper bound of its inverse depth.
    nearest: f32,
}

impl List<'_> {
    /// Pairs each triangle of a range with the nearest cell that it reaches in each sorting tile.
    ///
    /// The paper pairs it with every cell that it reaches. Since a hit counts in any cell, the later cells of the tile would
    /// only repeat the same test.
    pub(super) fn run(&mut self, kept: &[Kept], general: &[u32]) {
        for triangle in kept {
            let tile = |[first, last]: [u16; 2]| [first, last].map(|at| u32::from(at) >> self.cells.sorting_bits);
            let ([x0, x1], [y0, y1]) = (tile(triangle.columns), tile(triangle.rows));
            // Of more tiles within its bounds, a triangle often misses most.
            const MOST_UNTESTED: u32 = 4;
            if (x1 - x0 + 1) * (y1 - y0 + 1) <= MOST_UNTESTED {
                let slice = self.slices.of(triangle.nearest);
                for y in y0..=y1 {
                    for x in x0..=x1 {
                        self.push(triangle.triangle, [x, y], slice);
                    }
                }
            } else {
                self.list_large(triangle);
            }
        }
        let [width, height] = <[u32; 2]>::from(self.space.size()).map(|side| [0, side as i32 - 1]);
        for &id in general {
            let general = &HomogeneousTriangle::new(self.space, self.triangles.corners(id));
            let listed = Listed { id, general, bounds: [width, height], nearest: f32::INFINITY };
            self.list_square(&listed, Square::around_image(self.space));
        }
    }

    fn list_large(&mut self, triangle: &Kept) {
        let Kept { triangle: id, columns, rows, nearest } = *triangle;
        let general = &HomogeneousTriangle::new(self.space, self.triangles.corners(id));
        let bounds = [columns, rows].map(|side| side.map(i32::from));
        // The smallest square of tiles that holds the bounds, aligned to its own side.
        let spread = (columns[0] ^ columns[1]) | (rows[0] ^ rows[1]);
        let bits = (u16::BITS - spread.leading_zeros()).max(self.cells.sorting_bits);
        let corner = [bounds[0][0], bounds[1][0]].map(|first| first >> bits << bits);
        let middle = self.space.middle;
        let square = Square { x: corner[0] - middle.x, y: corner[1] - middle.y, side: 1 << bits };
        self.list_square(&Listed { id, general, bounds, nearest }, square);
    }

    /// Lists a triangle in the sorting tiles of a square whose samples it doesn't certainly miss.
    fn list_square(&mut self, listed: &Listed<'_>, square: Square) {
        let at = [square.x + self.space.middle.x, square.y + self.space.middle.y];
        let beyond =
            |axis: usize| at[axis] > listed.bounds[axis][1] || at[axis] + square.side <= listed.bounds[axis][0];
        if beyond(0) || beyond(1) || listed.general.misses(square) {
            return;
        }
        if square.side > self.cells.sorting_tile() as i32 {
            square.quarters().into_iter().for_each(|quarter| self.list_square(listed, quarter));
        } else if let Some(nearest) = nearest_in(listed.general, square) {
            let slice = self.slices.of(nearest.min(listed.nearest));
            self.push(listed.id, at.map(|at| at as u32 >> self.cells.sorting_bits), slice);
        }
    }

    /// Pairs a triangle with a cell of the sorting tile in column `x` and row `y`.
    #[inline(always)]
    fn push(&mut self, triangle: u32, [x, y]: [u32; 2], slice: u32) {
        let bits = self.cells.bits_in_tile();
        let tile = (y >> bits) * self.tile_columns + (x >> bits);
        let in_tile = (1 << bits) - 1;
        let cell = self.cells.first_in_tile(x & in_tile, y & in_tile) + slice;
        self.pairs.push(Pair { cell: (tile << Pair::CELL_BITS) + cell, triangle });
    }
}

/// Upper bound of the inverse depth of a triangle's hits in a square; `None` if all are behind the eye.
fn nearest_in(triangle: &HomogeneousTriangle, square: Square) -> Option<f32> {
    let half = 0.5 * f64::from(square.side - 1);
    let center = DVec3::new(f64::from(square.x) + half, f64::from(square.y) + half, 1.0);
    let half = half + triangle.shift;
    // Twice the error covers the roundings here; the error has them once for any sample.
    let bounds = |plane: DVec3, error: f64| {
        let (middle, reach) = (plane.dot(center), half * (plane.x.abs() + plane.y.abs()) + 2.0 * error);
        (middle + reach).is_finite().then_some([middle - reach, middle + reach])
    };
    let nearest = match triangle.depth {
        Depth::Unknown => f64::INFINITY,
        Depth::Inverse { plane, error } => bounds(plane, error).map_or(f64::INFINITY, |[_, high]| high),
        Depth::Direct { plane, error } => match bounds(plane, error) {
            Some([_, high]) if high < 0.0 => return None,
            Some([low, _]) if low > 0.0 => 1.0 / low,
            _ => f64::INFINITY,
        },
    };
    // The next f32 covers the f64 roundings and the one to f32.
    (nearest >= 0.0).then_some((nearest as f32).next_up())
}

/// The number of addressable pixels: the indices of a tile and of a cell in it fill 32 bits.
const _: () = assert!((ImageTooLarge::LARGEST_SIDE / TileOrder::TILE).ilog2() * 2 + Pair::CELL_BITS == u32::BITS);
