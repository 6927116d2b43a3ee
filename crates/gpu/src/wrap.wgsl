// Wrapping of coordinates beyond a texture's edges, on each axis.

const WRAP_REPEAT: u32 = 0u;
const WRAP_MIRRORED_REPEAT: u32 = 1u;
const WRAP_CLAMP_TO_EDGE: u32 = 2u;

// Texel for position `at` on a side of `side` texels.
fn wrapped(at: i32, side: u32, wrap: u32) -> u32 {
    let size = i32(side);
    if wrap == WRAP_CLAMP_TO_EDGE {
        return u32(clamp(at, 0, size - 1));
    }
    let period = select(size, 2 * size, wrap == WRAP_MIRRORED_REPEAT);
    let rest = ((at % period) + period) % period;
    return u32(select(rest, period - 1 - rest, rest >= size));
}
