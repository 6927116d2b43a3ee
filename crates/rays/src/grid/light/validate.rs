use super::LightGrid;
use super::block::Block;
use super::lanes::LANES;

impl LightGrid {
    /// Checks the cells of the last layer that was built.
    ///
    /// # Errors
    /// Names the first point or cell that breaks a rule: every mapped point is in exactly one place, in the cell that
    /// holds its coordinates; every block knows its farthest point and its padding; counts add up.
    pub fn validate(&self) -> Result<(), String> {
        let cells = &self.cells;
        let seen = self.points.t.iter().filter(|t| !t.is_nan()).count() as u64;
        let counted = self.counts.points + self.counts.outliers;
        if self.counts.layers > 0 && seen != counted {
            return Err(format!("{counted} of {seen} points were tested"));
        }
        if self.blocks.len() != cells.farthest.len() || self.blocks.len() != cells.padding.len() {
            return Err("blocks were lost".into());
        }
        let mut found = vec![false; self.points.t.len()];
        let [scale_x, scale_y] = cells.scale();
        for (cell, ends) in cells.ends.windows(2).enumerate() {
            let (first, end) = (ends[0] as usize, ends[1] as usize);
            if first > end || end > self.blocks.len() * LANES {
                return Err(format!("cell {cell} holds points {first} to {end}"));
            }
            for place in first..end {
                let (block, lane) = (&self.blocks[place / LANES], place % LANES);
                let pixel = block.pixel[lane];
                let is_padding = cells.padding[place / LANES] >> lane & 1 == 1;
                if is_padding != (pixel == Block::PADDING) {
                    return Err(format!("point {place} is half padding"));
                }
                if is_padding {
                    continue;
                }
                let column = ((block.x[lane] * scale_x + scale_x) as usize).min(cells.columns - 1);
                let row = ((block.y[lane] * scale_y + scale_y) as usize).min(cells.rows - 1);
                if row * cells.columns + column != cell {
                    return Err(format!("the point of pixel {pixel} is in cell {cell} but not of it"));
                }
                if cells.farthest[place / LANES] > block.nearness[lane] || block.nearness[lane].is_nan() {
                    return Err(format!("the point of pixel {pixel} is farther than its block's farthest"));
                }
                let known = found.get_mut(pixel as usize).ok_or_else(|| format!("there is no pixel {pixel}"))?;
                if std::mem::replace(known, true) {
                    return Err(format!("the point of pixel {pixel} is in two places"));
                }
            }
        }
        let listed = found.iter().filter(|&&found| found).count();
        let mapped: usize = self.slabs.iter().flat_map(|slab| &slab.bands[..cells.bands()]).map(Vec::len).sum();
        if self.counts.layers > 0 && listed != mapped {
            return Err(format!("{listed} of {mapped} mapped points are in cells"));
        }
        Ok(())
    }
}
