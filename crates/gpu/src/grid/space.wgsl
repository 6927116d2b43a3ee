// Pixel space: coordinates of vertices in a camera's image, or in a face of a light's grid.
//
// Coordinates are fixed-point numbers with `fraction_bits` bits, from the first pixel's sample (for a light's face,
// from its corner) to the right and downwards. So differences between neighbours are exact anywhere in the image.

struct Space {
    // F64, two in each vec4: the origin (3), rows of the matrix to (x, y, depth) (9), terms added to x and y (2).
    projection: array<vec4<u32>, 7>,
    raster: Raster,
}

// How the space is cut into cells.
struct Raster {
    // Pixels, or bins of a light's face, on each axis.
    columns: i32,
    rows: i32,
    fraction_bits: u32,
    // Log2 of a tile's side in pixels.
    tile_bits: u32,
    tile_columns: u32,
    tile_rows: u32,
    // Depth slices of a tile.
    slices: u32,
    // Index of this space's first cell among those of all faces.
    first_cell: u32,
    is_orthographic: u32,
    // Whether tested positions all have integer coordinates.
    has_samples: u32,
    // Whether counterclockwise corners make a positive area.
    is_mirrored: u32,
    // Error bound of tested positions, in units.
    position_error: u32,
    // The largest number in the rows for x and y.
    row_reach: f32,
    // Whether pixels look behind the triangles that they have.
    sees_behind: u32,
    // Error bound of parallel rays' keys at any depth, besides their rounding.
    depth_error: f32,
    // Log2 of the largest ratio of a coordinate to the depth, for regular vertices of perspective spaces.
    depth_bits: u32,
}

// A vertex in pixel space.
//
// Regular: x and y are fixed-point, z is the key, each with an error of at most one unit and one rounding. In an
// orthographic space, x and y may have an error of 2⁻⁴⁹ of the depth besides, times `row_reach`, and the key of
// `depth_error`. Homogeneous: x, y and depth in pixels and world units, not yet divided, each with an error of at most
// one rounding.
const VERTEX_REGULAR: u32 = 0u;
const VERTEX_HOMOGENEOUS: u32 = 1u;
// A coordinate isn't finite: no ray meets its triangles.
const VERTEX_NOWHERE: u32 = 2u;

// 2 to an integer from −126 to 127, from its bits: `exp2` may be wrong by 3 + 2 · |exponent| units in the last place (WGSL,
// accuracy of built-in functions).
fn power_of_two(exponent: i32) -> f32 {
    return bitcast<f32>(u32(exponent + 127) << 23u);
}

// Bits of a float as an integer in the same order.
fn ordered_bits(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    return select(bits | 0x80000000u, ~bits, (bits & 0x80000000u) != 0u);
}

fn from_ordered_bits(bits: u32) -> f32 {
    return bitcast<f32>(select(~bits, bits & 0x7fffffffu, (bits & 0x80000000u) != 0u));
}

// The slice of a key between the first and the last, all as ordered bits: about equal parts of the keys' logarithm.
fn slice_between(key: u32, first: u32, last: u32, slices: u32) -> u32 {
    if slices <= 1u || key >= first || first <= last {
        return 0u;
    }
    return min((first - key) / slice_depth(first, last, slices), slices - 1u);
}

// Range of a depth slice in ordered bits; the last slice takes the remainder.
fn slice_depth(first: u32, last: u32, slices: u32) -> u32 {
    return max((first - last) / slices, 1u);
}
