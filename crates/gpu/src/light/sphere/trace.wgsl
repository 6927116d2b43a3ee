// Stage `trace` of a light that sees by angles: finds points that triangles shadow, by signs of triple products of
// offsets from the light.
//
// With a, b and c a triangle's corners from the light, a point v is behind it, as the light sees it, if the edge
// functions v · (b × c), v · (c × a) and v · (a × b) and v · n − a · n, n = (b − a) × (c − a), all have the sign of a ·
// n: then v = λa + μb + νc with no negative factor, and a sum of factors above one. The crosses are taken with sides, a
// × b = a × (b − a), so that the common part of the corners doesn't cost bits.
//
// Let A, L and V be the largest computed coordinates of corners, sides and points, and e the error of points'
// coordinates. A corner's coordinate is f32's nearest to an exact difference: error ε A. A side's has one rounding and
// the loss of f32 in subnormal positions, 2⁻¹²⁵ times the scale (2⁵⁰ at most), less than ε L: together 2 ε L. So a
// component of a cross of a corner and a side, two products of at most A L, has an error of 2 · (1 + 2 + 1) ε A L and
// its own rounding of 2 A L: 10.1 ε A L. Its dot product with a point has three times V (10.1 ε A L + 2 ε A L), 10 ε A
// L V for sums and 6 A L e for the point: less than A L (56 ε V + 6.1 e). n has an error of 12.1 ε L², so that of v · n
// is less than L² (56 ε V + 6.1 e), and that of a · n 3 · (12.1 + 2 + 2) ε A L² and 10 ε A L² for sums: 64 ε A L². Sums
// over magnitudes hold for any order.
//
// The predicate requires v · n − a · n above zero for a whole box around v, which e includes; the difference has one
// more rounding, of 6 L² (V + A). Twice the bound covers both.

import package::grid::set_up::{U};
import package::grid::space::{Space};
import package::light::batches::{BATCH, trace_block};
import package::light::light::{Light};
import package::light::points::{POINT_ERROR};
import package::light::sphere::largest::{largest_bits};
import package::light::undecided::{write_settle_groups};
import package::mask::filter::{RoughPoint};
import package::mask::flags::{TRIANGLE_ONE_SIDED};

@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var<uniform> spaces: array<Space, 6>;
@group(0) @binding(2) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> vertices: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> sorted: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> pairs: array<u32>;
@group(0) @binding(6) var<storage, read> blocks: array<u32>;
@group(0) @binding(7) var<storage, read_write> lit: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> undecided: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read> masks: array<u32>;

// Limit for corners and sides, so that products of three of them stay finite: 2⁴⁰.
const LARGEST_BITS: u32 = 0x53800000u;
// Limit for the longest side, so that underflow in products of sides and corners is far below their roundings: 2⁻⁴⁸.
const SMALLEST_SIDE_BITS: u32 = 0x27800000u;
// Above the underflow in products with points.
const UNDERFLOW: f32 = 1e-36;
// As in `angles`, with a point's own rounding.
const POINT_ROUNDING: f32 = 1.01 * U + 4.0 * POINT_ERROR;
const UNKNOWN_SIGN: f32 = -1.0;
const NEVER: f32 = 3.0e38;

// In w: A L, L², and the error of a · n, or `UNKNOWN_SIGN` if its sign isn't known; a · n. In xyz: factors of the edge
// functions of a, b and c; n. All have the signs that make them positive behind the triangle.
var<workgroup> record_a: array<vec4<f32>, BATCH>;
var<workgroup> record_b: array<vec4<f32>, BATCH>;
var<workgroup> record_c: array<vec4<f32>, BATCH>;
var<workgroup> record_n: array<vec4<f32>, BATCH>;

struct Cell {
    scale: f32,
    point_error: f32,
}

struct Point {
    offset: vec3<f32>,
    // Error of products with crosses, relative to these.
    error: f32,
    own: u32,
}

fn cell_of_block(entry: u32) -> Cell {
    return Cell(spaces[0].raster.row_reach, spaces[0].raster.depth_error);
}

fn point_at(number: u32, own: u32, cell: Cell) -> Point {
    let bits = sorted[number].xyz;
    let reach = bitcast<f32>(largest_bits(bits));
    let error = 56.0 * U * reach + 6.1 * (cell.point_error + POINT_ROUNDING * reach);
    return Point(bitcast<vec3<f32>>(bits), error, own);
}

fn record(slot: u32, id: u32, cell: Cell) {
    let triangle = 2u * triangles[id].xyz;
    let a = bitcast<vec3<f32>>(vertices[triangle.x + 1u].xyz);
    let b = bitcast<vec3<f32>>(vertices[triangle.y + 1u].xyz);
    let c = bitcast<vec3<f32>>(vertices[triangle.z + 1u].xyz);
    let of_a = bitcast<vec3<f32>>(vertices[triangle.x].xyz);
    let of_b = bitcast<vec3<f32>>(vertices[triangle.y].xyz);
    let of_c = bitcast<vec3<f32>>(vertices[triangle.z].xyz);
    let ab = (of_b - of_a) * cell.scale;
    let bc = (of_c - of_b) * cell.scale;
    let ca = (of_a - of_c) * cell.scale;
    let reach_bits = largest_of_three(a, b, c);
    let length_bits = largest_of_three(ab, bc, ca);
    // Zero edge functions decide nothing and exclude no point.
    record_a[slot] = vec4<f32>(0.0);
    record_b[slot] = vec4<f32>(0.0);
    record_c[slot] = vec4<f32>(vec3<f32>(0.0), UNKNOWN_SIGN);
    record_n[slot] = vec4<f32>(0.0);
    if reach_bits >= LARGEST_BITS || length_bits >= LARGEST_BITS || length_bits <= SMALLEST_SIDE_BITS {
        return;
    }
    let reach = bitcast<f32>(reach_bits);
    let length = bitcast<f32>(length_bits);
    let normal = cross(ca, ab);
    let at_light = dot(a, normal);
    let error = 64.0 * U * reach * length * length + UNDERFLOW;
    let is_certain = abs(at_light) > error;
    // The light sees the triangle's back.
    if is_certain && at_light > 0.0 && (triangles[id].w & TRIANGLE_ONE_SIDED) != 0u {
        record_c[slot] = vec4<f32>(0.0);
        record_n[slot] = vec4<f32>(vec3<f32>(0.0), NEVER);
        return;
    }
    let sign = select(-1.0, 1.0, at_light > 0.0);
    record_a[slot] = vec4<f32>(sign * cross(b, bc), reach * length);
    record_b[slot] = vec4<f32>(sign * cross(c, ca), length * length);
    record_c[slot] = vec4<f32>(sign * cross(a, ab), select(UNKNOWN_SIGN, error, is_certain));
    record_n[slot] = vec4<f32>(normal, at_light) * sign;
}

fn largest_of_three(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> u32 {
    let of_a = largest_bits(bitcast<vec3<u32>>(a));
    return max(max(of_a, largest_bits(bitcast<vec3<u32>>(b))), largest_bits(bitcast<vec3<u32>>(c)));
}

fn edges_at(slot: u32, point: Point) -> vec3<f32> {
    return vec3<f32>(
        dot(record_a[slot].xyz, point.offset), dot(record_b[slot].xyz, point.offset), dot(record_c[slot].xyz, point.offset));
}

fn edge_error(slot: u32, point: Point) -> f32 {
    return record_a[slot].w * point.error + UNDERFLOW;
}

// Height of a point behind the triangle's plane.
fn height_at(slot: u32, point: Point) -> f32 {
    return dot(record_n[slot].xyz, point.offset) - record_n[slot].w;
}

fn height_error(slot: u32, point: Point) -> f32 {
    return 2.0 * (record_b[slot].w * point.error + record_c[slot].w);
}

// Whether a triangle may shadow a point.
fn may_shadow(slot: u32, point: Point) -> bool {
    let edges = edges_at(slot, point);
    let error = edge_error(slot, point);
    let is_inside = min(min(edges.x, edges.y), edges.z) >= -error;
    // If the light may be in the triangle's plane, signs may be reversed.
    if record_c[slot].w < 0.0 {
        return is_inside || max(max(edges.x, edges.y), edges.z) <= error;
    }
    return is_inside && height_at(slot, point) >= -height_error(slot, point);
}

fn does_shadow(slot: u32, point: Point) -> bool {
    let edges = edges_at(slot, point);
    return record_c[slot].w >= 0.0 && min(min(edges.x, edges.y), edges.z) > edge_error(slot, point)
        && height_at(slot, point) > height_error(slot, point);
}

// The point where the shadow ray meets the triangle: edge functions are weights.
fn point_on(slot: u32, id: u32, point: Point, cell: Cell) -> RoughPoint {
    let edges = edges_at(slot, point);
    let sum = edges.x + edges.y + edges.z;
    return RoughPoint(edges.yz / sum, 4.0 * edge_error(slot, point) / sum + 32.0 * U);
}

@compute @workgroup_size(64)
fn trace(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    trace_block(group, lane);
}

// Writes the size of the dispatch that settles undecided pairs.
@compute @workgroup_size(1)
fn size_settle() {
    write_settle_groups();
}
