//! Word offsets of a structure's counters, as in `header.wgsl`.

use crate::link::shared_constants;

/// Words of a header.
pub(crate) const HEADER_WORDS: u64 = 36;

shared_constants! { "grid::header":
    /// Number of chunks of large triangles.
    HEADER_LARGE: usize = 0;
    /// Workgroups for these chunks.
    HEADER_LARGE_GROUPS: u32 = 1;
    /// Number of blocks of work.
    HEADER_BLOCKS: usize = 5;
    /// Workgroups for blocks.
    HEADER_BLOCK_GROUPS: u32 = 6;
    /// Workgroups that merge cut tiles.
    HEADER_SPLIT_GROUPS: u32 = 10;
    /// Number of a light's faces.
    HEADER_FACES: usize = 14;
    /// Workgroups for a light's vertices.
    HEADER_VERTEX_GROUPS: u32 = 28;
    /// Workgroups for a light's triangles.
    HEADER_TRIANGLE_GROUPS: u32 = 31;
}
