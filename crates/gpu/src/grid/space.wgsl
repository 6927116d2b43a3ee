// Pixel space: where a camera's image, or a face of a light's grid, sees a vertex.
//
// Coordinates are fixed-point numbers with `fraction_bits` bits, from the first pixel's sample (of a light's face, from
// its corner) to the right and downwards. So differences between neighbours are exact, wherever in the image they are.

struct Space {
    // F64, two in each vec4: the origin (3), rows of the matrix to (x, y, depth) (9), added to x and y (2).
    projection: array<vec4<u32>, 7>,
    raster: Raster,
}

// How the space is cut into cells.
struct Raster {
    // Pixels, or bins of a light's face, on each axis.
    columns: i32,
    rows: i32,
    fraction_bits: u32,
    // Log2 of the pixels a side of a tile.
    tile_bits: u32,
    tile_columns: u32,
    tile_rows: u32,
    // Depth slices of a tile.
    slices: u32,
    // Where the cells of this space start among those of all faces.
    first_cell: u32,
    is_orthographic: u32,
    // Whether only positions with integer coordinates are asked about.
    has_samples: u32,
    // Whether counterclockwise corners make a positive area.
    is_mirrored: u32,
    // How many units positions that are asked about may be wrong by.
    position_error: u32,
    // The largest number in the rows for x and y.
    row_reach: f32,
    // Whether what is behind each pixel's triangle is asked for.
    sees_behind: u32,
    // How much keys of parallel rays may be wrong by, wherever they are, besides their rounding.
    depth_error: f32,
    // Log2 of how many times as far on some axis as deep regular vertices of perspective spaces are at most.
    depth_bits: u32,
}

// A vertex in pixel space.
//
// Regular: x and y are fixed-point, z is the key, both wrong by at most one unit and one rounding. In an orthographic
// space, x and y may be wrong by 2⁻⁴⁹ of the depth besides, times `row_reach`, and the key by `depth_error`.
// Homogeneous: x, y and depth in pixels and world units, not yet divided, each wrong by at most one rounding.
const VERTEX_REGULAR: u32 = 0u;
const VERTEX_HOMOGENEOUS: u32 = 1u;
// A coordinate isn't finite: no ray meets its triangles.
const VERTEX_NOWHERE: u32 = 2u;

// 2 to an integer from −126 to 127, from its bits: `exp2` may be wrong by 3 + 2 · |exponent| units in the last place (WGSL,
// accuracy of built-in functions).
fn power_of_two(exponent: i32) -> f32 {
    return bitcast<f32>(u32(exponent + 127) << 23u);
}

// Floats as integers in the same order.
fn ordered_bits(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    return select(bits | 0x80000000u, ~bits, (bits & 0x80000000u) != 0u);
}

fn from_ordered_bits(bits: u32) -> f32 {
    return bitcast<f32>(select(~bits, bits & 0x7fffffffu, (bits & 0x80000000u) != 0u));
}

// The slice of a key between the first and the last, all in order: about equal parts of the keys' logarithm.
fn slice_between(key: u32, first: u32, last: u32, slices: u32) -> u32 {
    if slices <= 1u || key >= first || first <= last {
        return 0u;
    }
    return min((first - key) / slice_depth(first, last, slices), slices - 1u);
}

// How much of the keys' range, in order, a depth slice takes; the last one takes what is left.
fn slice_depth(first: u32, last: u32, slices: u32) -> u32 {
    return max((first - last) / slices, 1u);
}
