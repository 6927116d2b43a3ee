/// The cells of a face: X and Y are divided evenly into columns and rows.
#[derive(Debug, Default)]
pub(crate) struct Cells {
    pub(crate) across: Axis,
    pub(crate) down: Axis,
    /// By how much rows are grown: how far a point may be from its cell.
    pub(crate) margin: f32,
}

/// X or Y in [−1, 1], divided into cells; the first and the last one also hold what is beyond.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Axis {
    pub(crate) count: usize,
}

impl Axis {
    /// The cell of a coordinate: for points and triangles alike, which keeps their order.
    pub(crate) fn cell(self, at: f32) -> usize {
        (((at.clamp(-2.0, 2.0) + 1.0) * (0.5 * self.count as f32)) as usize).min(self.count - 1)
    }

    /// Where a cell begins and ends, give or take 10⁻⁶; the first and the last one also hold what is beyond.
    pub(crate) fn range(self, cell: usize) -> [f32; 2] {
        let edge = |cell: usize| (cell as f64 * 2.0 / self.count as f64 - 1.0) as f32;
        [if cell == 0 { -2.0 } else { edge(cell) }, if cell + 1 == self.count { 2.0 } else { edge(cell + 1) }]
    }
}

impl Cells {
    /// Where a row begins and ends in Y, grown by what points may be beyond.
    pub(crate) fn row_range(&self, row: usize) -> [f32; 2] {
        let [low, high] = self.down.range(row);
        [low - self.margin, high + self.margin]
    }
}
