// Sets up a triangle in pixel space: the pixels that it may touch, and its edge functions and key near a position.
//
// A filter: all numbers carry error bounds, and the predicate settles the cases that these leave undecided. u is half
// the distance from one to the next f32; WGSL may contract products and sums, which loses less, not more. Bounds are
// therefore sums over the magnitudes of terms, and hold for any order of operations.

import package::grid::space::{Raster, VERTEX_HOMOGENEOUS, VERTEX_NOWHERE, VERTEX_REGULAR, power_of_two};

// Half the distance from one to the next f32.
const U: f32 = 5.9604645e-8;
const INFINITE: f32 = 3.0e38;
const SMALLEST_KEY: f32 = 1.0e-37;
// 2⁻⁴⁹: relative error of F64 in the product of a matrix row and a position.
const ORTHOGRAPHIC_ROUNDING: f32 = 1.7763568e-15;

// Whether a number isn't negative and is neither infinite nor NaN; other numbers decide nothing. Tests the bits, since
// compilers may assume that there are no infinities and NaNs.
fn is_finite(number: f32) -> bool {
    return bitcast<u32>(number) < 0x7f000000u;
}

struct Corners {
    a: vec4<u32>,
    b: vec4<u32>,
    c: vec4<u32>,
    kind: u32,
}

// Inclusive, empty where the last is before the first.
struct Rect {
    first: vec2<i32>,
    last: vec2<i32>,
}

const RECT_EMPTY: Rect = Rect(vec2<i32>(0), vec2<i32>(-1));

// A triangle near a position: for p in pixels from there, edge functions a·x + b·y + c and the key kx·x + ky·y + k.
//
// It is hit where the three edge functions are positive, or zero: certainly where they are above `edge_error`,
// certainly not where one is below −`edge_error` and, unless `is_oriented`, another above `edge_error`. The key is wrong
// by at most `key_error`; nearer hits have larger keys.
struct Edges {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    key: vec3<f32>,
    edge_error: f32,
    key_error: f32,
    // Upper bound on the key at any position.
    nearest: f32,
    is_oriented: bool,
    // Whether its signed area is negative, if `is_oriented`.
    is_negative: bool,
}

fn corners_of(a: vec4<u32>, b: vec4<u32>, c: vec4<u32>) -> Corners {
    // 0 if all are regular; otherwise the regular ones have to be made homogeneous as well.
    let any_kind = a.w | b.w | c.w;
    let kind = select(min(any_kind, VERTEX_HOMOGENEOUS), VERTEX_NOWHERE, any_kind >= VERTEX_NOWHERE);
    return Corners(a, b, c, kind);
}

// The pixels (or cells) that a triangle may touch.
fn rect_of(corners: Corners, raster: Raster) -> Rect {
    if corners.kind == VERTEX_NOWHERE {
        return RECT_EMPTY;
    }
    let whole = Rect(vec2<i32>(0), vec2<i32>(raster.columns - 1, raster.rows - 1));
    var rect = whole;
    if corners.kind == VERTEX_REGULAR {
        let a = bitcast<vec2<i32>>(corners.a.xy);
        let b = bitcast<vec2<i32>>(corners.b.xy);
        let c = bitcast<vec2<i32>>(corners.c.xy);
        let margin = i32(corner_error(corners, raster));
        let low = min(min(a, b), c) - margin;
        let high = max(max(a, b), c) + margin;
        let up = select(0, (1 << raster.fraction_bits) - 1, raster.has_samples == 1u);
        rect = Rect((low + up) >> vec2<u32>(raster.fraction_bits), high >> vec2<u32>(raster.fraction_bits));
    } else {
        let a = homogeneous(corners.a, raster);
        let b = homogeneous(corners.b, raster);
        let c = homogeneous(corners.c, raster);
        let depths = vec3<f32>(a.z, b.z, c.z);
        // Bounds reach beyond the image by a pixel, so that the roundings of x, y and depth don't matter.
        let size = vec2<f32>(f32(raster.columns), f32(raster.rows));
        let before = max(max(a.xy + 1.01 * a.z, b.xy + 1.01 * b.z), c.xy + 1.01 * c.z);
        let behind = min(
            min(a.xy - (size + 1.01) * a.z, b.xy - (size + 1.01) * b.z), c.xy - (size + 1.01) * c.z);
        if all(depths <= vec3<f32>(0.0)) || any(before < vec2<f32>(0.0)) || any(behind > vec2<f32>(0.0)) {
            return RECT_EMPTY;
        }
        // Numbers beyond f32's range have no valid quotients.
        if all(depths > vec3<f32>(1e-30)) && all(depths < vec3<f32>(1e30)) {
            let low = min(min(a.xy / a.z, b.xy / b.z), c.xy / c.z);
            let high = max(max(a.xy / a.z, b.xy / b.z), c.xy / c.z);
            // A quotient up to 2¹⁵ is wrong by less than a hundredth; larger ones are clamped.
            rect = Rect(
                vec2<i32>(floor(clamp(low - 1.0, vec2<f32>(-4.0), size))),
                vec2<i32>(ceil(clamp(high + 1.0, vec2<f32>(-4.0), size))));
        }
    }
    return Rect(max(rect.first, whole.first), min(rect.last, whole.last));
}

// Error bound, in units, of regular corners relative to tested positions.
fn corner_error(corners: Corners, raster: Raster) -> f32 {
    let error = 1.0 + f32(raster.position_error);
    if raster.is_orthographic == 0u {
        return error;
    }
    // For parallel rays, coordinates of far corners are differences of large numbers.
    let keys = abs(bitcast<vec3<f32>>(vec3<u32>(corners.a.z, corners.b.z, corners.c.z)));
    let of_depth = ORTHOGRAPHIC_ROUNDING * raster.row_reach * max(max(keys.x, keys.y), keys.z);
    return min(error + ceil(of_depth), 536870912.0);
}

// Homogeneous x and y in pixels, and depth (1 in an orthographic space).
fn homogeneous(vertex: vec4<u32>, raster: Raster) -> vec3<f32> {
    if vertex.w == VERTEX_HOMOGENEOUS {
        let position = bitcast<vec3<f32>>(vertex.xyz);
        return select(position, vec3<f32>(position.xy, 1.0), raster.is_orthographic == 1u);
    }
    let position = vec2<f32>(bitcast<vec2<i32>>(vertex.xy)) * power_of_two(-i32(raster.fraction_bits));
    let depth = select(1.0 / bitcast<f32>(vertex.z), 1.0, raster.is_orthographic == 1u);
    return vec3<f32>(position * depth, depth);
}

fn largest_of(vertex: vec4<u32>, raster: Raster) -> f32 {
    let position = abs(homogeneous(vertex, raster));
    return max(max(position.x, position.y), position.z);
}

// The power of two that scales a positive number to between one and two.
fn inverse_power_of_two(number: f32) -> f32 {
    let exponent = clamp((bitcast<u32>(number) >> 23u) & 0xffu, 1u, 253u);
    return bitcast<f32>((254u - exponent) << 23u);
}

// Edges of a triangle near the fixed-point position `origin`, for p within `reach` pixels of it on each axis.
fn edges_near(corners: Corners, origin: vec2<i32>, reach: f32, raster: Raster) -> Edges {
    let unit = power_of_two(-i32(raster.fraction_bits));
    if corners.kind == VERTEX_REGULAR {
        let a = bitcast<vec2<i32>>(corners.a.xy);
        let b = bitcast<vec2<i32>>(corners.b.xy);
        let c = bitcast<vec2<i32>>(corners.c.xy);
        // Differences in integers are exact: f32 rounds each once.
        let sides = Sides(
            vec2<f32>(a - origin) * unit, vec2<f32>(b - origin) * unit, vec2<f32>(c - origin) * unit,
            vec2<f32>(c - b) * unit, vec2<f32>(a - c) * unit, vec2<f32>(b - a) * unit);
        let keys = bitcast<vec3<f32>>(vec3<u32>(corners.a.z, corners.b.z, corners.c.z));
        return flat_edges(sides, unit * corner_error(corners, raster), keys, raster.depth_error, reach);
    }
    if raster.is_orthographic == 1u {
        // Far beside the image; an orthographic space needs no division.
        let middle = vec2<f32>(origin) * unit;
        let a = homogeneous(corners.a, raster).xy - middle;
        let b = homogeneous(corners.b, raster).xy - middle;
        let c = homogeneous(corners.c, raster).xy - middle;
        let largest = max(max(abs(a), abs(b)), max(abs(c), abs(middle)));
        let error = unit * corner_error(corners, raster) + 8.0 * U * max(largest.x, largest.y);
        // `depth_error` is for positions below 2³⁰ units.
        let depth_error = raster.depth_error * (1.0 + max(largest.x, largest.y) * power_of_two(i32(raster.fraction_bits) - 30));
        let keys = bitcast<vec3<f32>>(vec3<u32>(corners.a.z, corners.b.z, corners.c.z));
        return flat_edges(Sides(a, b, c, c - b, a - c, b - a), error, keys, depth_error, reach);
    }
    return homogeneous_edges(corners, origin, reach, raster);
}

// Whether a triangle's corners are certainly seen clockwise.
fn shows_back(edges: Edges, raster: Raster) -> bool {
    // Pixel rows go down, so counterclockwise corners make a negative area.
    return edges.is_oriented && edges.is_negative == (raster.is_mirrored == 1u);
}

// Edges that decide nothing.
fn undecided_edges() -> Edges {
    return Edges(
        vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0), INFINITE, INFINITE, INFINITE, false, false);
}

// Corners relative to the origin, and edges.
struct Sides {
    a: vec2<f32>,
    b: vec2<f32>,
    c: vec2<f32>,
    bc: vec2<f32>,
    ca: vec2<f32>,
    ab: vec2<f32>,
}

// Edges of a triangle whose corners are points of the image, with an error of `error` relative to positions on each
// axis. Keys have an error of `depth_error` besides their rounding.
fn flat_edges(sides: Sides, error: f32, keys: vec3<f32>, depth_error: f32, reach: f32) -> Edges {
    let a = sides.a;
    let b = sides.b;
    let c = sides.c;
    let bc = sides.bc;
    let ca = sides.ca;
    let ab = sides.ab;
    let farthest = max(max(max(abs(a.x), abs(a.y)), max(abs(b.x), abs(b.y))), max(abs(c.x), abs(c.y)));
    // An edge function is the cross product of two corners relative to p. Each component is at most `span`, with an
    // error of `error`: 4 · error · span. Its three terms, with the parts that cancel, are at most 2 · span², each with
    // four roundings on its path, doubled once more.
    let span = farthest + reach;
    let edge_error = 4.0 * error * (span + error) + 32.0 * U * span * span;

    // Twice the signed area is the sum of the edge functions, and doesn't depend on p.
    let area = ab.x * -ca.y - ab.y * -ca.x;
    let longest = max(max(max(abs(bc.x), abs(bc.y)), max(abs(ca.x), abs(ca.y))), max(abs(ab.x), abs(ab.y)));
    let area_error = 8.0 * error * (longest + error) + 16.0 * U * longest * longest;
    let is_oriented = abs(area) > area_error;
    let sign = select(-1.0, 1.0, area > 0.0);

    let nearest = max(max(keys.x, keys.y), keys.z);
    let farthest_key = min(min(keys.x, keys.y), keys.z);
    let largest_key = max(abs(nearest), abs(farthest_key));
    let range = nearest - farthest_key;

    if !is_finite(edge_error) || !is_finite(largest_key) {
        return undecided_edges();
    }
    var edges: Edges;
    edges.a = sign * vec3<f32>(-bc.y, -ca.y, -ab.y);
    edges.b = sign * vec3<f32>(bc.x, ca.x, ab.x);
    edges.c = sign * vec3<f32>(b.x * c.y - b.y * c.x, c.x * a.y - c.y * a.x, a.x * b.y - a.y * b.x);
    edges.edge_error = edge_error;
    edges.is_oriented = is_oriented;
    edges.is_negative = area < 0.0;
    // Each key has a relative error of one rounding and of the projection. The sum below has four more, in any order.
    let key_rounding = 8.0 * U * largest_key + depth_error;
    edges.nearest = nearest + key_rounding;

    // key = A + (wb · (B − A) + wc · (C − A)) / area, with weights that have an error of `edge_error` and are at most
    // the area inside the triangle.
    let inverse_area = sign / area;
    let plane_error = range * (4.0 * edge_error + 2.0 * area_error) * abs(inverse_area) * 1.25 + key_rounding;
    if is_oriented && plane_error < 0.5 * range + key_rounding {
        let b_step = (keys.y - keys.x) * inverse_area;
        let c_step = (keys.z - keys.x) * inverse_area;
        edges.key = vec3<f32>(
            edges.a.y * b_step + edges.a.z * c_step,
            edges.b.y * b_step + edges.b.z * c_step,
            keys.x + (edges.c.y * b_step + edges.c.z * c_step));
        edges.key_error = plane_error;
    } else {
        // Between the corners' keys in any case.
        edges.key = vec3<f32>(0.0, 0.0, 0.5 * nearest + 0.5 * farthest_key);
        edges.key_error = 0.5 * range + 2.0 * key_rounding;
    }
    return edges;
}

fn homogeneous_edges(corners: Corners, origin: vec2<i32>, reach: f32, raster: Raster) -> Edges {
    // Origins are whole pixels, which f32 represents exactly.
    let unit = power_of_two(-i32(raster.fraction_bits));
    let middle = vec2<f32>(origin) * unit;
    // Weights don't depend on a common factor; this one keeps products of three coordinates in f32's range.
    let largest = max(largest_of(corners.a, raster), max(largest_of(corners.b, raster), largest_of(corners.c, raster)));
    let factor = inverse_power_of_two(largest);
    let of_a = homogeneous(corners.a, raster) * factor;
    let of_b = homogeneous(corners.b, raster) * factor;
    let of_c = homogeneous(corners.c, raster) * factor;
    let a = vec3<f32>(of_a.xy - middle * of_a.z, of_a.z);
    let b = vec3<f32>(of_b.xy - middle * of_b.z, of_b.z);
    let c = vec3<f32>(of_c.xy - middle * of_c.z, of_c.z);

    let aside = max(max(max(abs(of_a.x), abs(of_a.y)), max(abs(of_b.x), abs(of_b.y))), max(abs(of_c.x), abs(of_c.y)));
    let from_middle = max(max(max(abs(a.x), abs(a.y)), max(abs(b.x), abs(b.y))), max(abs(c.x), abs(c.y)));
    let depth = max(max(abs(a.z), abs(b.z)), abs(c.z));
    let middle_reach = max(abs(middle.x), abs(middle.y));
    // A quotient has an error of 2.5 units in the last place, fixed-point coordinates one of their own.
    let depth_error = 10.0 * U * depth;
    let aside_error = 12.0 * U * (aside + middle_reach * depth) + (2.0 + f32(raster.position_error)) * unit * depth;
    // a·x + b·y + c with a, b products of an aside and a depth, c of two asides.
    let slope_error = 2.0 * (from_middle * depth_error + depth * aside_error) + 8.0 * U * from_middle * depth;
    let constant_error = 4.0 * from_middle * aside_error + 8.0 * U * from_middle * from_middle;
    let edge_error = 1.25 * (2.0 * reach * slope_error + constant_error
        + 8.0 * U * (4.0 * reach * from_middle * depth + 2.0 * from_middle * from_middle));

    let of_bc = cross(b, c);
    let of_ca = cross(c, a);
    let of_ab = cross(a, b);
    // Wherever a ray meets the triangle, the determinant is the depth times the sum of the edge functions.
    let volume = dot(a, of_bc);
    // Errors of corners change the determinant by their products with the cross products, and by products of two or
    // three errors. A component of a cross product has four roundings of two products of an aside and a depth, or of
    // two asides.
    let crosses = abs(of_bc) + abs(of_ca) + abs(of_ab);
    let of_corners = aside_error * (crosses.x + crosses.y) + depth_error * crosses.z
        + 24.0 * U * from_middle * (2.0 * aside_error * depth + depth_error * from_middle)
        + 6.0 * aside_error * (aside_error * (depth + depth_error) + 2.0 * depth_error * from_middle);
    let volume_error = 1.25 * (of_corners + 24.0 * U * from_middle * from_middle * depth + 4.0 * U * dot(abs(a), abs(of_bc)));
    if !is_finite(edge_error) {
        return undecided_edges();
    }
    let sign = select(-1.0, 1.0, volume > 0.0);
    var edges: Edges;
    edges.a = sign * vec3<f32>(of_bc.x, of_ca.x, of_ab.x);
    edges.b = sign * vec3<f32>(of_bc.y, of_ca.y, of_ab.y);
    edges.c = sign * vec3<f32>(of_bc.z, of_ca.z, of_ab.z);
    edges.edge_error = edge_error;
    edges.is_oriented = abs(volume) > volume_error;
    edges.is_negative = volume < 0.0;
    edges.nearest = INFINITE;
    edges.key_error = INFINITE;
    if !edges.is_oriented {
        return edges;
    }
    let inverse = factor / abs(volume);
    let slope = vec3<f32>(
        edges.a.x + edges.a.y + edges.a.z, edges.b.x + edges.b.y + edges.b.z, edges.c.x + edges.c.y + edges.c.z);
    edges.key = slope * inverse;
    let largest_slope = (abs(slope.x) + abs(slope.y)) * reach + abs(slope.z);
    // Keys below f32's normal numbers may be flushed to zero.
    edges.key_error = SMALLEST_KEY
        + 1.25 * inverse * (4.0 * edge_error + largest_slope * (2.0 * volume_error / abs(volume) + 8.0 * U));
    return edges;
}

// Whether a triangle certainly misses all positions within `half` pixels of the origin.
fn misses_box(edges: Edges, half: vec2<f32>) -> bool {
    let range = half.x * abs(edges.a) + half.y * abs(edges.b);
    let is_below = any(edges.c + range < vec3<f32>(-edges.edge_error));
    return is_below && (edges.is_oriented || any(edges.c - range > vec3<f32>(edges.edge_error)));
}
