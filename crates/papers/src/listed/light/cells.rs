/// The cells of an axis, all of the same size; the first and the last one also hold everything beyond.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Axis {
    pub(super) count: usize,
    /// The start of the first cell.
    low: f32,
    /// Cells per unit of length.
    scale: f32,
}

impl Axis {
    /// The range from `low` to `high` divided into `count` cells.
    pub(super) fn new([low, high]: [f32; 2], count: usize) -> Self {
        let length = high - low;
        Self { count, low, scale: if length > 0.0 { count as f32 / length } else { 0.0 } }
    }

    /// The cell of a coordinate. The same function serves points and triangles, which keeps their order.
    #[inline(always)]
    pub(super) fn cell(self, at: f32) -> usize {
        // NaN is in the first cell.
        (((at - self.low) * self.scale) as usize).min(self.count - 1)
    }
}
