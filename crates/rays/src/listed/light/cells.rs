/// The cells of an axis, all of the same size; the first and the last one also hold what is beyond.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Axis {
    pub(super) count: usize,
    /// Where the first cell begins.
    low: f32,
    /// Cells in a length of one.
    scale: f32,
}

impl Axis {
    /// The range from `low` to `high` divided into `count` cells.
    pub(super) fn new([low, high]: [f32; 2], count: usize) -> Self {
        let length = high - low;
        Self { count, low, scale: if length > 0.0 { count as f32 / length } else { 0.0 } }
    }

    /// The cell of a coordinate: for points and triangles alike, which keeps their order.
    #[inline(always)]
    pub(super) fn cell(self, at: f32) -> usize {
        // What isn't a number is in the first one.
        (((at - self.low) * self.scale) as usize).min(self.count - 1)
    }
}
