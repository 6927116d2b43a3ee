use std::ops::Range;

use super::Job;
use super::cull::Frustum;
use super::lines::Face;
use super::spread::LineTile;
use crate::simd::lanes::LANES;

/// The largest number of cells along a side of a tile.
const MOST_CELLS: usize = 32;

/// Average number of lines in a cell.
const CELL_LINES: usize = 2;

/// The lines of a tile, sorted into cells, row by row. Sixteen more follow as padding, which nothing meets.
#[derive(Debug, Default)]
pub(super) struct Slots {
    /// Slopes, relative to the middle ones.
    pub(super) u: Vec<f32>,
    pub(super) v: Vec<f32>,
    /// Depths of the lines' start and end.
    pub(super) near: Vec<f32>,
    pub(super) end: Vec<f32>,
    /// Hits behind this depth don't matter any more.
    pub(super) far: Vec<f32>,
    /// The index of the line.
    pub(super) line: Vec<u32>,
    /// The H of [`LineTests`](super::test::LineTests).
    pub(super) wide: f32,
    /// The slopes in the middle.
    pub(super) slope: [f64; 2],
    pub(super) low: [f32; 2],
    pub(super) high: [f32; 2],
    /// Cells along each side.
    pub(super) cells: usize,
    cell_scale: [f32; 2],
    starts: Vec<u32>,
    unsorted: Vec<Unsorted>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Unsorted {
    at: [f64; 2],
    ends: [f64; 2],
    line: u32,
    cell: u32,
}

impl Slots {
    pub(super) fn len(&self) -> usize {
        self.line.len()
    }

    /// Replaces the lines by those of a tile; returns their frustum.
    pub(super) fn fill(&mut self, job: &Job<'_>, tile: &LineTile, order: &[u32]) -> Frustum {
        let face = &tile.face;
        let around = self.find(job, face, &order[tile.lines.clone()]);
        let ends = self
            .unsorted
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], of| [low.min(of.ends[0]), high.max(of.ends[1])]);
        let [low, high] = around;
        let middle = [0, 1].map(|axis| 0.5 * (low[axis] + high[axis]));
        self.slope = middle;
        let half = (0..2).map(|axis| (high[axis] - low[axis]) * 0.5).fold(0.0, f64::max);
        self.wide = (half * 1.001 + 1.0 / f64::from(1 << 20)) as f32;
        self.sort(middle, job.scale);
        Frustum::new(face, job.lines.origin, around, ends)
    }

    /// Finds the slopes of lines on the face; returns their bounds.
    fn find(&mut self, job: &Job<'_>, face: &Face, lines: &[u32]) -> [[f64; 2]; 2] {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        self.unsorted.clear();
        self.unsorted.extend(lines.iter().map(|&line| {
            let of = job.lines.get(line as usize);
            let at = face.across(of);
            for axis in [0, 1] {
                low[axis] = low[axis].min(at[axis]);
                high[axis] = high[axis].max(at[axis]);
            }
            Unsorted { at, ends: job.lines.ends(face, of), line, cell: 0 }
        }));
        [low, high]
    }

    fn sort(&mut self, middle: [f64; 2], scale: f64) {
        let Self { u, v, near, end, far, line, low, high, cells, cell_scale, starts, unsorted, .. } = self;
        let count = unsorted.len();
        let local = |of: &Unsorted| [0, 1].map(|axis| (of.at[axis] - middle[axis]) as f32);
        (*low, *high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        for of in &*unsorted {
            let at = local(of);
            for axis in [0, 1] {
                low[axis] = low[axis].min(at[axis]);
                high[axis] = high[axis].max(at[axis]);
            }
        }
        *cells = ((count / CELL_LINES) as f32).sqrt().clamp(1.0, MOST_CELLS as f32) as usize;
        *cell_scale = [0, 1].map(|axis| {
            let scale = *cells as f32 / (high[axis] - low[axis]);
            if scale.is_finite() { scale } else { 0.0 }
        });
        let all = *cells * *cells;
        starts.clear();
        starts.resize(all + 2, 0);
        for of in unsorted.iter_mut() {
            let [u, v] = local(of);
            let [column, row] = [cell(u, low[0], cell_scale[0], *cells), cell(v, low[1], cell_scale[1], *cells)];
            of.cell = (row * *cells + column) as u32;
            starts[of.cell as usize + 2] += 1;
        }
        let mut sum = 0;
        for start in starts.iter_mut() {
            sum += *start;
            *start = sum;
        }
        for values in [&mut *u, &mut *v, &mut *near, &mut *end, &mut *far] {
            values.clear();
            // NaN is between no two numbers.
            values.resize(count + LANES, f32::NAN);
        }
        line.resize(count, 0);
        for of in &*unsorted {
            let next = &mut starts[of.cell as usize + 1];
            let slot = *next as usize;
            *next += 1;
            [u[slot], v[slot]] = local(of);
            let [first, last] = of.ends.map(|end| ((end * scale) as f32).clamp(f32::MIN, f32::MAX));
            (near[slot], end[slot], far[slot]) = (first, last, f32::INFINITY);
            line[slot] = of.line;
        }
    }

    /// The column, or row, of a slope; clamped to the tile's cells.
    #[inline(always)]
    pub(super) fn cell(&self, at: f32, axis: usize) -> usize {
        cell(at, self.low[axis], self.cell_scale[axis], self.cells)
    }

    /// The lines of some consecutive cells.
    #[inline(always)]
    pub(super) fn of_cells(&self, cells: Range<usize>) -> Range<usize> {
        self.starts[cells.start] as usize..self.starts[cells.end] as usize
    }

    pub(super) fn bytes(&self) -> usize {
        (self.u.capacity() * 5 + self.line.capacity() + self.starts.capacity()) * size_of::<u32>()
            + self.unsorted.capacity() * size_of::<Unsorted>()
    }
}

/// A cell's index; it never decreases as `at` grows, in spite of rounding.
#[inline(always)]
fn cell(at: f32, low: f32, scale: f32, cells: usize) -> usize {
    (((at - low) * scale) as usize).min(cells - 1)
}
