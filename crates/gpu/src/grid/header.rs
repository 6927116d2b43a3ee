//! Where a structure's counters are, as in `header.wgsl`.

/// Words of a header.
pub(crate) const HEADER_WORDS: u64 = 36;

/// How many chunks of large triangles there are.
pub(crate) const LARGE: usize = 0;
/// The groups that take them.
pub(crate) const LARGE_GROUPS: u32 = 1;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{module, other_constants};
    use crate::link::link;

    #[test]
    fn words_are_those_of_the_shaders() {
        let constants = [
            ("HEADER_LARGE", LARGE as u32),
            ("HEADER_LARGE_GROUPS", LARGE_GROUPS),
            ("HEADER_BLOCKS", BLOCKS as u32),
            ("HEADER_BLOCK_GROUPS", BLOCK_GROUPS),
            ("HEADER_SPLIT_GROUPS", SPLIT_GROUPS),
            ("HEADER_FACES", FACES as u32),
            ("HEADER_VERTEX_GROUPS", VERTEX_GROUPS),
            ("HEADER_TRIANGLE_GROUPS", TRIANGLE_GROUPS),
        ];
        assert_eq!(other_constants(&module(&link("grid::header")), &constants), [""; 0]);
    }
}
