use crate::grid::Space;
use crate::{Buffer, Gpu, Groups, Kernel};

/// The stage `balance`: blocks of bounded work for the camera's tiles.
#[derive(Debug)]
pub(super) struct Balance {
    balance: Kernel,
    size_blocks: Kernel,
    mapping: u32,
    tiles: u32,
}

impl Balance {
    const BLOCK_PAIRS: u64 = 2048;
    const BLOCK_WORDS: u64 = 4;

    pub(super) fn new(gpu: &Gpu, mapping: u32) -> Self {
        let constants = [("MAPPING", f64::from(mapping))];
        let [balance, size_blocks] = Kernel::all(gpu, "camera::balance", ["balance", "size_blocks"], &constants);
        Self { balance, size_blocks, mapping, tiles: 0 }
    }

    pub(super) fn prepare(&mut self, space: &Space) {
        let tiles = |sorting: u32| sorting.div_ceil(self.mapping);
        self.tiles = tiles(space.raster.tile_columns) * tiles(space.raster.tile_rows);
    }

    /// The most blocks that there can be for so many pairs.
    pub(super) fn most_blocks(space: &Space, pairs: u64) -> u64 {
        u64::from(space.raster.tile_columns * space.raster.tile_rows) + pairs / Self::BLOCK_PAIRS
    }

    /// Bytes of so many blocks and what precedes them.
    pub(super) fn block_bytes(blocks: u64) -> u64 {
        4 * Self::BLOCK_WORDS * (blocks + 1)
    }

    pub(super) fn record(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::ComputePass<'_>,
        space: &Buffer,
        cells: &Buffer,
        header: &Buffer,
    ) {
        let buffers = [space, cells, header];
        self.balance.dispatch(gpu, pass, &buffers, Groups::Flat(self.tiles.div_ceil(64)));
        self.size_blocks.dispatch(gpu, pass, &buffers, Groups::Flat(1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{module, other_constants};
    use crate::link::link;

    #[test]
    fn blocks_are_those_of_the_shader() {
        let constants = [("BLOCK_PAIRS", Balance::BLOCK_PAIRS as u32), ("BLOCK_WORDS", Balance::BLOCK_WORDS as u32)];
        assert_eq!(other_constants(&module(&link("camera::balance")), &constants), [""; 0]);
    }
}
