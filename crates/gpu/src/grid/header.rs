//! Where a structure's counters are, as in `header.wgsl`.

/// Words of a header.
pub(crate) const HEADER_WORDS: u64 = 36;

/// How many chunks of large triangles there are.
pub(crate) const LARGE: usize = 0;
/// How many blocks of work there are.
pub(crate) const BLOCKS: usize = 5;
/// The groups that take blocks.
pub(crate) const BLOCK_GROUPS: u32 = 6;
/// The groups that merge cut tiles.
pub(crate) const SPLIT_GROUPS: u32 = 10;
/// How many faces a light has.
pub(crate) const FACES: usize = 14;
/// The groups that take a light's vertices.
pub(crate) const VERTEX_GROUPS: u32 = 28;
/// The groups that take a light's triangles.
pub(crate) const TRIANGLE_GROUPS: u32 = 31;
