use super::LightGrid;
use super::lanes::LANES;

impl LightGrid {
    /// Checks the cells of the last face that was built.
    ///
    /// # Errors
    /// Names the first point or cluster that breaks a rule: every point is in a cluster of its block, which knows its
    /// bounds and its farthest point, isn't too large and is in the cell that its bounds begin in; counts add up.
    pub fn validate(&self) -> Result<(), String> {
        let cells = &self.cells;
        let mut clustered = vec![0_u16; self.members.len()];
        for (place, row) in cells.rows().iter().enumerate() {
            for cluster in 0..row.len() {
                let (x, y) = (row.x.each_ref().map(|x| x[cluster]), row.y.each_ref().map(|y| y[cluster]));
                let name = format!("cluster {cluster} of row {place}");
                if !(cells.down.cell(y[0])..=cells.down.cell(y[1])).contains(&place) {
                    return Err(format!("{name} is not in it"));
                }
                for column in cells.across.cell(x[0])..=cells.across.cell(x[1]) {
                    if !row.reaching(column, column).contains(&cluster) {
                        return Err(format!("{name} is not found in column {column}"));
                    }
                }
                let block = row.block[cluster] as usize;
                let points = self.blocks.get(block).ok_or_else(|| format!("{name} has no block"))?;
                let error = self.errors[block];
                for lane in 0..LANES {
                    let inside = |at: f32, [low, high]: [f32; 2]| low <= at - error.place && at + error.place <= high;
                    let is_inside = inside(points.x[lane], x)
                        && inside(points.y[lane], y)
                        && row.farthest[cluster] <= points.nearness[lane] - error.nearness;
                    clustered[block] |= u16::from(is_inside) << lane;
                }
            }
        }
        for (block, (members, clustered)) in self.members.iter().zip(&clustered).enumerate() {
            if members & !clustered != 0 {
                return Err(format!("points {:016b} of block {block} are in no cluster", members & !clustered));
            }
        }
        Ok(())
    }
}
