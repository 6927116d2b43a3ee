// The space of a structure: its bounds, and the power of two that scales them to at most one.
struct RaySpace {
    // Bits of f32.
    min: vec3<u32>,
    // Bits of the power of two as an f32.
    scale: u32,
    max: vec3<u32>,
    // High word of the power of two as an F64.
    scale_high: u32,
    // Of a kd-tree: all ones if a node's left child follows it, else zero.
    left_follows: u32,
    // Whether coordinates are too small or too large to be scaled: then all rays test everything.
    is_lost: u32,
    is_empty: u32,
    // Whether another part of the structure was walked before, and has written results.
    continues: u32,
}
