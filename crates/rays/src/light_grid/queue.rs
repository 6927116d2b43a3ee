use fearless_simd::prelude::*;
use fearless_simd::{Simd, mask32x16, u32x16};

use super::cells::Row;
use crate::simd::vectors::LANES;

/// Pairs of a triangle of a batch and a block that are to be tested against each other. 8 bytes each.
pub(crate) struct Queue {
    /// Each has room for 16 more than [`Queue::MOST`], which adding may write to.
    blocks: Vec<u32>,
    triangles: Vec<u32>,
    len: usize,
}

impl Default for Queue {
    fn default() -> Self {
        let room = vec![0; Self::MOST + LANES];
        Self { blocks: room.clone(), triangles: room, len: 0 }
    }
}

impl Queue {
    const MOST: usize = 4096;

    pub(crate) fn bytes(&self) -> usize {
        (self.blocks.capacity() + self.triangles.capacity()) * size_of::<u32>()
    }

    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    pub(crate) fn is_full(&self) -> bool {
        self.len > Self::MOST - LANES
    }

    /// Adds pairs of a triangle and the blocks of some of the 16 clusters of `row` from `first`; the queue mustn't be
    /// full.
    #[inline(always)]
    pub(crate) fn add<S: Simd>(&mut self, simd: S, triangle: u32, row: &Row, first: usize, clusters: mask32x16<S>) {
        let blocks = u32x16::from_slice(simd, &row.block[first..first + LANES]);
        // Without a loop over the bits, the end of which is hard to foresee.
        blocks.compress(clusters).store_slice(&mut self.blocks[self.len..self.len + LANES]);
        u32x16::splat(simd, triangle).store_slice(&mut self.triangles[self.len..self.len + LANES]);
        self.len += clusters.to_bitmask().count_ones() as usize;
    }

    /// Blocks and triangles.
    pub(crate) fn pairs(&self) -> impl ExactSizeIterator<Item = (usize, usize)> {
        let pairs = self.blocks[..self.len].iter().zip(&self.triangles[..self.len]);
        pairs.map(|(&block, &triangle)| (block as usize, triangle as usize))
    }
}
