use crate::grid::Space;
use crate::link::shared_constants;
use crate::{Buffer, Gpu, Groups, Kernel};

/// The stage `balance`: blocks of bounded work for the camera's tiles.
#[derive(Debug)]
pub(super) struct Balance {
    balance: Kernel,
    size_blocks: Kernel,
    mapping: u32,
    tiles: u32,
}

shared_constants! { "camera::balance":
    /// Pairs that a block takes from each of its sorting tiles.
    BLOCK_PAIRS: u64 = 2048;
    /// Words of a block.
    BLOCK_WORDS: u64 = 4;
}

impl Balance {
    pub(super) fn new(gpu: &Gpu, mapping: u32) -> Self {
        let constants = [("MAPPING", f64::from(mapping))];
        let [balance, size_blocks] = Kernel::all(gpu, "camera::balance", ["balance", "size_blocks"], &constants);
        Self { balance, size_blocks, mapping, tiles: 0 }
    }

    pub(super) fn prepare(&mut self, space: &Space) {
        let tiles = |sorting: u32| sorting.div_ceil(self.mapping);
        self.tiles = tiles(space.raster.tile_columns) * tiles(space.raster.tile_rows);
    }

    /// Maximum number of blocks for this number of pairs.
    pub(super) fn most_blocks(space: &Space, pairs: u64) -> u64 {
        u64::from(space.raster.tile_columns * space.raster.tile_rows) + pairs / BLOCK_PAIRS
    }

    /// Bytes of `blocks` blocks and of the words before them.
    pub(super) fn block_bytes(blocks: u64) -> u64 {
        4 * BLOCK_WORDS * (blocks + 1)
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
