//! Where a structure's counters are, as in `header.wgsl`.

use crate::link::shared_constants;

/// Words of a header.
pub(crate) const HEADER_WORDS: u64 = 36;

shared_constants! { "grid::header":
    /// How many chunks of large triangles there are.
    HEADER_LARGE: usize = 0;
    /// The groups that take them.
    HEADER_LARGE_GROUPS: u32 = 1;
    /// How many blocks of work there are.
    HEADER_BLOCKS: usize = 5;
    /// The groups that take blocks.
    HEADER_BLOCK_GROUPS: u32 = 6;
    /// The groups that merge cut tiles.
    HEADER_SPLIT_GROUPS: u32 = 10;
    /// How many faces a light has.
    HEADER_FACES: usize = 14;
    /// The groups that take a light's vertices.
    HEADER_VERTEX_GROUPS: u32 = 28;
    /// The groups that take a light's triangles.
    HEADER_TRIANGLE_GROUPS: u32 = 31;
}
