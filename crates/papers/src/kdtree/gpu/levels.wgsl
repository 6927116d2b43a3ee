// A bit for each level of a tree: low word, high word.

fn level_bit(level: u32) -> vec2<u32> {
    return select(vec2(0u, 1u << (level & 31u)), vec2(1u << (level & 31u), 0u), level < 32u);
}

// All bits of lower levels.
fn levels_below(level: u32) -> vec2<u32> {
    let within = (1u << (level & 31u)) - 1u;
    return select(vec2(0xffffffffu, within), vec2(within, 0u), level < 32u);
}

fn has_level(levels: vec2<u32>, level: u32) -> bool {
    return any((levels & level_bit(level)) != vec2(0u));
}

// The highest level whose bit is set, if any is.
fn highest_level(levels: vec2<u32>) -> u32 {
    return select(32u + firstLeadingBit(levels.y), firstLeadingBit(levels.x), levels.y == 0u);
}
