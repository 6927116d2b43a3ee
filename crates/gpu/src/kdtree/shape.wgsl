// The tree's bounds, and the power of two that brings them within one.
struct KdShape {
    // Bits of f32.
    min: vec3<u32>,
    // Of the power of two as an f32.
    scale: u32,
    max: vec3<u32>,
    // The same power of two as an F64, high word.
    scale_high: u32,
    // All ones where a node's left child follows it.
    left_follows: u32,
    // Whether coordinates are too small or too large to be scaled: then all rays take everything.
    is_lost: u32,
    is_empty: u32,
    unused: u32,
}
