use super::LightGrid;
use super::cells::cell_at;
use super::lanes::LANES;

impl LightGrid {
    /// Checks the cells of the last face that was built.
    ///
    /// # Errors
    /// Names the first point or cluster that breaks a rule: every point is in a cluster of its block, which knows its
    /// bounds and its farthest point, isn't too large and is in the cell that its bounds begin in; counts add up.
    pub fn validate(&self) -> Result<(), String> {
        let cells = &self.cells;
        let [scale_x, scale_y] = cells.scale();
        let mut clustered = vec![0_u16; self.members.len()];
        for (place, row) in cells.rows().iter().enumerate() {
            for (column, ends) in row.ends.windows(2).enumerate() {
                for cluster in ends[0] as usize..ends[1] as usize {
                    let (x, y) = (row.x.each_ref().map(|x| x[cluster]), row.y.each_ref().map(|y| y[cluster]));
                    let name = format!("cluster {cluster} of row {place}");
                    if cell_at(x[0], scale_x, cells.columns) != column
                        || cell_at(y[0], scale_y, cells.rows().len()) != place
                    {
                        return Err(format!("{name} is in a cell that it doesn't begin in"));
                    }
                    let size = cells.reach_back();
                    if x[1] - x[0] > size || y[1] - y[0] > size {
                        return Err(format!("{name} is larger than triangles look for"));
                    }
                    let block = row.block[cluster] as usize;
                    let points = self.blocks.get(block).ok_or_else(|| format!("{name} has no block"))?;
                    let error = self.errors[block];
                    for lane in 0..LANES {
                        let inside =
                            |at: f32, [low, high]: [f32; 2]| low <= at - error.place && at + error.place <= high;
                        let is_inside = inside(points.x[lane], x)
                            && inside(points.y[lane], y)
                            && row.farthest[cluster] <= points.nearness[lane] - error.nearness;
                        clustered[block] |= u16::from(is_inside) << lane;
                    }
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
