use std::ops::RangeInclusive;

use glam::{DVec3, UVec3, Vec3};

use umbrage_rays::Bounds;

/// The layout of a grid's cells: adjacent cubes, along x first, then y, then z.
///
/// A world position p has the *cell coordinates* g = (p − `corner`) / `side`, used in this comment: cell i of an axis holds
/// the coordinates from i to i + 1.
///
/// **Why the grid is conservative.** The predicate accepts a hit only where the ray's line meets the triangle in real
/// numbers, at a point h inside the triangle's box. Three roundings give a computed coordinate an error of 3 · 2⁻⁵³ of its
/// size, which is below 2⁻³⁹ for [`MOST_ON_A_SIDE`](Self::MOST_ON_A_SIDE) cells. Triangles are listed in each cell that
/// their box, grown by [`MARGIN`](Self::MARGIN), touches. So the triangle is listed in each cell no farther than
/// `MARGIN` − 2⁻³⁹ from h on every axis, and a ray finds it if it visits one of those. Traversals need the ray's position
/// only to within [`DOUBT`](Self::DOUBT), which is half the margin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// World position of the lowest corner.
    pub corner: DVec3,
    /// Edge of a cell in world units.
    pub side: f64,
    /// Cells along each axis.
    pub cells: UVec3,
}

/// The cells that a box overlaps, from `low` to `high`, both included; none where `low` is above `high`. 12 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct CellBox {
    pub(super) low: [u16; 3],
    pub(super) high: [u16; 3],
}

/// The cells that a vertex touches, one or two on each axis, as the sum of the first and the last one. The fourth number is
/// padding. 8 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(align(8))]
pub(super) struct VertexCells([i16; 4]);

impl CellBox {
    /// A box that overlaps nothing.
    pub(super) const EMPTY: Self = Self { low: [1; 3], high: [0; 3] };

    /// The cells that a triangle's box overlaps. Rounding keeps the order of coordinates, so the lowest and the highest of
    /// the corners' cells are those of the box.
    #[inline(always)]
    pub(super) fn around([a, b, c]: [VertexCells; 3]) -> Self {
        let sums = std::array::from_fn::<_, 4, _>(|axis| {
            let [a, b, c] = [a.0[axis], b.0[axis], c.0[axis]];
            (a.min(b).min(c), a.max(b).max(c))
        });
        Self {
            low: [0, 1, 2].map(|axis| (sums[axis].0 >> 1) as u16),
            high: [0, 1, 2].map(|axis| ((sums[axis].1 + 1) >> 1) as u16),
        }
    }

    pub(super) fn range(&self, axis: usize) -> RangeInclusive<u32> {
        u32::from(self.low[axis])..=u32::from(self.high[axis])
    }

    /// The number of cells.
    pub(super) fn len(&self) -> u64 {
        (0..3).map(|axis| (u64::from(self.high[axis]) + 1).saturating_sub(self.low[axis].into())).product()
    }
}

impl Lattice {
    /// The growth of triangles' boxes, in cells.
    pub const MARGIN: f64 = 1.0 / (1 << 12) as f64;
    /// The largest error of a traversal's cell coordinates.
    pub const DOUBT: f64 = 0.5 * Self::MARGIN;
    /// The largest number of cells along an axis.
    pub const MOST_ON_A_SIDE: u32 = 1 << 12;
    /// The largest number of cells in all, before each side is rounded up.
    pub(super) const MOST_CELLS: f64 = (1 << 26) as f64;
    /// Least distance of the bounds from the lattice's faces, in cells.
    const RIM: f64 = 1.0 / 64.0;

    /// About `wanted` cells around `bounds` (Wald et al. 2006, §3): the number along an axis is the size along it times
    /// ∛(wanted / V).
    ///
    /// An axis along which the bounds are thinner than a cell gets one cell, and the formula is used for the others.
    pub(super) fn around(bounds: Bounds, wanted: f64) -> Self {
        if bounds.is_empty() {
            return Self { corner: DVec3::ZERO, side: 1.0, cells: UVec3::ONE };
        }
        let size = bounds.max.as_dvec3() - bounds.min.as_dvec3();
        let wanted = wanted.clamp(1.0, Self::MOST_CELLS);
        let mut sizes = size.to_array();
        sizes.sort_by(f64::total_cmp);
        let side = (0..3).map(|thin| {
            let thick = &sizes[thin..];
            let side = (thick.iter().product::<f64>() / wanted).powf(1.0 / thick.len() as f64);
            (thick[0] >= side && side > 0.0).then_some(side)
        });
        let side = side.flatten().next().unwrap_or(1.0);
        Self::with_side(bounds, side)
    }

    /// The lattice around `bounds`, which aren't empty, with cells of edge `side`, or larger ones if these would be too
    /// many.
    pub(super) fn with_side(bounds: Bounds, side: f64) -> Self {
        let size = bounds.max.as_dvec3() - bounds.min.as_dvec3();
        let side = side.max(size.max_element() / f64::from(Self::MOST_ON_A_SIDE - 1));
        let cells =
            (size / side + 2.0 * Self::RIM).ceil().as_uvec3().clamp(UVec3::ONE, UVec3::splat(Self::MOST_ON_A_SIDE));
        Self { corner: bounds.min.as_dvec3() - side * Self::RIM, side, cells }
    }

    /// The number of cells.
    pub(super) fn len(&self) -> usize {
        self.cells.x as usize * self.cells.y as usize * self.cells.z as usize
    }

    /// The index of a cell, in the order of cells.
    #[inline(always)]
    pub(super) fn index(&self, x: u32, y: u32, z: u32) -> usize {
        (z as usize * self.cells.y as usize + y as usize) * self.cells.x as usize + x as usize
    }

    /// Calls `visit` with each cell of a box and its index.
    #[inline(always)]
    pub(super) fn for_each_of(&self, cells: &CellBox, mut visit: impl FnMut([u32; 3], usize)) {
        for z in cells.range(2) {
            for y in cells.range(1) {
                let row = self.index(0, y, z);
                cells.range(0).for_each(|x| visit([x, y, z], row + x as usize));
            }
        }
    }

    /// The cell coordinates of a world position, with an error of three roundings of their size.
    #[inline(always)]
    pub fn coordinates(&self, position: DVec3) -> DVec3 {
        (position - self.corner) * (1.0 / self.side)
    }

    /// The cells that a vertex, grown by the margin, touches; any cells if it isn't finite or is outside of the lattice.
    #[inline(always)]
    pub(super) fn cells_at(&self, vertex: Vec3) -> VertexCells {
        let at = self.coordinates(vertex.as_dvec3());
        let last = self.cells.as_dvec3() - 1.0;
        let sum = |axis: usize| {
            // Conversions to integers truncate.
            let [low, high] = [at[axis] - Self::MARGIN, at[axis] + Self::MARGIN];
            low.clamp(0.0, last[axis]) as i32 + high.clamp(0.0, last[axis]) as i32
        };
        VertexCells([sum(0) as i16, sum(1) as i16, sum(2) as i16, 0])
    }

    /// The cells that the grown box of finite `corners` overlaps.
    #[inline(always)]
    pub(super) fn cells_around(&self, [a, b, c]: [Vec3; 3]) -> CellBox {
        let (low, high) = (self.cells_at(a.min(b).min(c)), self.cells_at(a.max(b).max(c)));
        CellBox::around([low, low, high])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice(size: [f32; 3], wanted: f64) -> Lattice {
        Lattice::around(Bounds { min: Vec3::ZERO, max: Vec3::from(size) }, wanted)
    }

    #[test]
    fn cells_follow_the_paper() {
        // 2 × 1 × 4 with 8 · 1000 cells: 10 cells a unit of length, plus the rim.
        assert_eq!(lattice([2.0, 1.0, 4.0], 8000.0).cells, UVec3::new(21, 11, 41));
    }

    #[test]
    fn flat_bounds_have_one_layer() {
        assert_eq!(lattice([2.0, 0.0, 4.0], 800.0).cells, UVec3::new(21, 1, 41));
        assert_eq!(lattice([0.0, 0.0, 4.0], 40.0).cells, UVec3::new(1, 1, 41));
        assert_eq!(lattice([0.0, 0.0, 0.0], 40.0).cells, UVec3::ONE);
        assert_eq!(lattice([1.0, 1e-30, 1.0], 100.0).cells, UVec3::new(11, 1, 11));
    }

    #[test]
    fn sides_and_cells_are_capped() {
        let long = lattice([1e30, 1e-3, 1e-3], 1e12);
        assert!(long.cells.max_element() <= Lattice::MOST_ON_A_SIDE && long.cells.x > 4000, "{long:?}");
        assert!(lattice([1.0; 3], 1e30).len() < 1 << 27);
        let huge = Bounds { min: Vec3::splat(-3e38), max: Vec3::splat(3e38) };
        assert_eq!(Lattice::around(huge, 1000.0).cells, UVec3::splat(11));
        assert_eq!(Lattice::around(Bounds::EMPTY, 1000.0).len(), 1);
    }

    #[test]
    fn bounds_lie_inside() {
        for offset in [0.0_f32, 1e6, -3e20] {
            let size = Vec3::new(3.0, 1.0, 0.1) * (1.0 + offset.abs() * 1e-3);
            let bounds = Bounds { min: Vec3::splat(offset), max: size + offset };
            let lattice = Lattice::around(bounds, 5000.0);
            let (low, high) = (lattice.coordinates(bounds.min.as_dvec3()), lattice.coordinates(bounds.max.as_dvec3()));
            assert!(low.min_element() >= 2.0 * Lattice::MARGIN, "{low}");
            assert!((lattice.cells.as_dvec3() - high).min_element() >= 2.0 * Lattice::MARGIN, "{high}");
        }
    }
}
